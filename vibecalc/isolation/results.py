"""Results of the body on its mounts, under shaking forces or the torque of its cylinders."""

from vibecalc.core.results.record import CANCELS, ORDERS, PEAK, RESONANCE, Headline, entry
from vibecalc.isolation.efficiency_results import AXES as EFFICIENCY_AXES
from vibecalc.isolation.efficiency_results import EFFICIENCY_ENTRIES
from vibecalc.isolation.mount_results import MOUNT_ENTRIES

# ----------------------------------------------------------------------------
# Results of the body on its mounts.
# ----------------------------------------------------------------------------

ISOLATION_ENTRIES = (
    entry(
        "isolation/pitch/inertia",
        "",
        "kg*m^2",
        "moment of inertia in pitch",
        name="moment of inertia, pitch",
    ),
    entry(
        "isolation/pitch/stiffness",
        "",
        "N*m/rad",
        "stiffness of the mounts in pitch",
        name="stiffness of the mounts, pitch",
    ),
    entry(
        "isolation/pitch/damping",
        "",
        "N*m*s/rad",
        "viscous damping of the mounts in pitch",
        name="damping of the mounts, pitch",
    ),
    entry(
        "isolation/pitch/natural_frequency",
        "",
        "rad/s",
        "undamped natural frequency in pitch",
        headline=Headline("natural frequency, pitch", "Hz"),
    ),
    entry(
        "isolation/pitch/damping_ratio",
        "",
        "",
        "damping ratio in pitch",
        headline=Headline("damping ratio, pitch"),
    ),
    entry("isolation/pitch/transmissibility", "order", "", "couple on the ground over couple"),
    entry(
        "isolation/pitch/transmissibility_curve",
        "frequency_ratio",
        "",
        "couple on the ground over couple against frequency",
    ),
    entry("isolation/pitch/angle_harmonics", "order", "rad", "pitch angle", PEAK),
    entry(
        "isolation/pitch/angle_peak",
        "",
        "rad",
        "largest pitch angle over a turn",
        PEAK,
        name="pitch angle at speed, peak",
    ),
    entry(
        "isolation/modes/natural_frequency",
        "mode",
        "rad/s",
        "undamped natural frequency",
        headline=Headline("natural frequency", "Hz", pick="ends"),
    ),
    entry("isolation/modes/damping_ratio", "mode", "", "modal damping ratio"),
    entry(
        "isolation/modes/shape",
        "mode coordinate",
        "",
        "mode shape at the reference point, metres and radians, of unit modal mass",
    ),
    entry(
        "isolation/modes/energy_fraction",
        "mode coordinate",
        "",
        "share of the kinetic energy of a mode, about the mass centre",
    ),
    entry(
        "isolation/body/translation_harmonics",
        "order direction",
        "m",
        "displacement of the reference point",
        PEAK,
    ),
    entry("isolation/body/rotation_harmonics", "order direction", "rad", "rotation", PEAK),
    entry(
        "isolation/lever_force/rigid_harmonics",
        "order",
        "N",
        "couple over lever, body held still",
        PEAK,
    ),
    entry(
        "isolation/lever_force/rigid_peak",
        "",
        "N",
        "largest couple over lever over a turn, body held still",
        PEAK,
        name="couple over the lever, body held still, peak",
    ),
    entry(
        "isolation/lever_force/steady_harmonics",
        "order",
        "N",
        "couple through the mounts over lever",
        PEAK,
    ),
    entry(
        "isolation/lever_force/steady_peak",
        "",
        "N",
        "largest couple through the mounts over lever",
        PEAK,
        headline=Headline("couple over the lever at speed, peak", "N"),
    ),
    entry(
        "isolation/lever_force/run_up",
        "speed",
        "N",
        "largest couple through the mounts over lever at each speed",
        PEAK,
    ),
    entry(
        "isolation/lever_force/run_up_peak",
        "",
        "N",
        "largest of the run-up",
        PEAK,
        headline=Headline(
            "couple over the lever in the run-up, peak",
            "N",
            at="isolation/lever_force/run_up_peak_speed",
        ),
    ),
    entry("isolation/lever_force/run_up_peak_speed", "", "rad/s", "crank speed of the largest"),
    entry("isolation/support_force/static", "mount", "N", "share of the weight on one support"),
    entry(
        "isolation/support_force/rigid_peak",
        "mount",
        "N",
        "largest dynamic force of one support over a turn, body held still",
        PEAK,
    ),
    entry(
        "isolation/support_force/steady_harmonics",
        "mount direction order",
        "N",
        "dynamic force of one support on the ground",
        PEAK,
    ),
    entry(
        "isolation/support_force/steady_peak",
        "mount",
        "N",
        "largest dynamic force of one support over a turn",
        PEAK,
        headline=Headline(
            "force on a support at speed, peak",
            "N",
            unless="isolation/torque_reaction/support_force_peak",
        ),
    ),
    entry(
        "isolation/support_force/run_up",
        "mount speed",
        "N",
        "largest dynamic force of one support at each speed",
        PEAK,
    ),
    entry(
        "isolation/support_force/run_up_peak",
        "mount",
        "N",
        "largest of the run-up",
        PEAK,
        headline=Headline(
            "force on a support in the run-up, peak",
            "N",
            at="isolation/support_force/run_up_peak_speed",
        ),
    ),
    entry(
        "isolation/support_force/run_up_peak_speed", "mount", "rad/s", "crank speed of the largest"
    ),
    entry(
        "isolation/support_displacement/sag",
        "mount",
        "m",
        "deflection under its own weight",
        headline=Headline("static deflection of a mount", "mm"),
    ),
    entry(
        "isolation/support_displacement/steady_harmonics",
        "mount direction order",
        "m",
        "displacement of the body at a support",
        PEAK,
    ),
    entry(
        "isolation/support_displacement/vertical_peak",
        "mount",
        "m",
        "largest vertical displacement at a support over a turn",
        PEAK,
        headline=Headline("vertical motion at a mount at speed, peak", "mm"),
    ),
    entry(
        "isolation/support_displacement/excursion",
        "mount",
        "m",
        "sag plus largest vertical displacement",
        PEAK,
        headline=Headline("deflection of a mount with its sag, peak", "mm"),
    ),
    entry("isolation/masked/low", "masked", "rad/s", "last speed computed below"),
    entry("isolation/masked/centre", "masked", "rad/s", "speed of the undamped resonance"),
    entry("isolation/masked/high", "masked", "rad/s", "first speed computed above"),
    entry("isolation/masked/order", "masked", "", "order in resonance"),
    entry("isolation/masked/mode", "masked", "", "mode in resonance"),
)

# ----------------------------------------------------------------------------
# Every local maximum of the run-up.
# ----------------------------------------------------------------------------

MAXIMA_ROOT = "isolation/run_up/maxima"

MAXIMA_ENTRIES = (
    entry(f"{MAXIMA_ROOT}/mount", "maximum", "", "place of the support among the mounts, from 1"),
    entry(f"{MAXIMA_ROOT}/force", "maximum", "N", "local maximum of the force of a support", PEAK),
    entry(f"{MAXIMA_ROOT}/speed", "maximum", "rad/s", "crank speed of the maximum"),
    entry(f"{MAXIMA_ROOT}/order", "maximum", "", "order that is largest there"),
    entry(f"{MAXIMA_ROOT}/order_share", "maximum", "", "size of that order over the peak of all"),
    entry(
        f"{MAXIMA_ROOT}/bending_order",
        "maximum",
        "",
        "order that bends the curve downwards most: that in resonance",
    ),
    entry(f"{MAXIMA_ROOT}/mode", "maximum", "", "mode nearest to the frequency of that order"),
    entry(f"{MAXIMA_ROOT}/frequency_ratio", "maximum", "", "that frequency over that of the mode"),
    entry(f"{MAXIMA_ROOT}/at_end", "maximum", "", "1 at an end of the range of speeds, else 0"),
)

# ----------------------------------------------------------------------------
# Results of an engine on its mounts under the torque of its cylinders, with what shakes it.
# ----------------------------------------------------------------------------

TORQUE_REACTION_ROOT = "isolation/torque_reaction"

TORQUE_REACTION_ENTRIES = (
    entry(
        f"{TORQUE_REACTION_ROOT}/couple",
        "half_order",
        "N*m",
        "couple on the body about the crankshaft by gas and inertia torque",
        PEAK,
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/mean_couple",
        "",
        "N*m",
        "its mean; 0 where the driven machine is on the body",
        headline=Headline("torque reaction, mean", "N*m"),
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/translation",
        "half_order direction",
        "m",
        "displacement of the reference point, with the shaking",
        PEAK,
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/rotation",
        "half_order direction",
        "rad",
        "rotation, with the shaking",
        PEAK,
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/roll_peak",
        "",
        "rad",
        "largest angle about the crankshaft over the cycle, without the mean",
        PEAK,
        headline=Headline("roll of the body by torque, peak", "mrad"),
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/support_force",
        "mount direction half_order",
        "N",
        "dynamic force of one support on the ground, with the shaking",
        PEAK,
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/support_force_peak",
        "mount",
        "N",
        "largest dynamic force of one support over the cycle, with the shaking",
        PEAK,
        headline=Headline("force on a support with torque, peak", "N"),
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/support_force_of_torque",
        "mount",
        "N",
        "the same by the couple of the torque alone",
        PEAK,
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/mean_support_force",
        "mount direction",
        "N",
        "force of one support on the ground by the mean torque",
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/largest_load",
        "mount",
        "N",
        "largest load on a support over the cycle: weight, mean torque and dynamic force",
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/minimum_load",
        "mount",
        "N",
        "least load over the cycle; negative: the support is pulled",
        headline=Headline("minimum load on a support", "N", pick="least"),
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/nearest_order",
        "mode",
        "",
        "half order nearest to a mode of the body of those that drive it; 0: none does",
    ),
    entry(
        f"{TORQUE_REACTION_ROOT}/margin",
        "mode",
        "",
        "frequency of that order over the natural frequency, less 1",
    ),
)

#: axis name -> (unit, long name)
AXES = {
    "mount": ("", "mount"),
    "maximum": ("", "local maximum, by support and speed"),
    **EFFICIENCY_AXES,
    "deflection": ("m", "compression of a mount along its axis"),
}
ENTRIES = (
    *ISOLATION_ENTRIES,
    *MAXIMA_ENTRIES,
    *MOUNT_ENTRIES,
    *TORQUE_REACTION_ENTRIES,
    *EFFICIENCY_ENTRIES,
)
HELPS = {
    "isolation/": (ORDERS, RESONANCE),
    "isolation/modes/": (CANCELS,),
    "isolation/support_force/static": (CANCELS,),
}
