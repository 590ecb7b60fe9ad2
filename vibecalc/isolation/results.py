"""Results of the body on its mounts, under shaking forces or the torque of its cylinders."""

from vibecalc.core.results.record import (
    CANCELS,
    DIFFERENCE,
    ORDERS,
    PEAK,
    RESONANCE,
    Headline,
    entry,
)
from vibecalc.isolation.efficiency_results import AXES as EFFICIENCY_AXES
from vibecalc.isolation.efficiency_results import EFFICIENCY_ENTRIES
from vibecalc.isolation.mount_results import MOUNT_ENTRIES

# ----------------------------------------------------------------------------
# Results of the body on its mounts.
# ----------------------------------------------------------------------------

CAUSES = "isolation/support_force/by_cause"
#: of those that are of the torque of the cylinders, where it reaches the mounts
OF_TORQUE = (
    CAUSES,
    "isolation/support_force/mean",
    *(f"isolation/torque_reaction/{name}" for name in ("couple", "mean_couple", "roll_peak")),
)
NEAREST = ("isolation/torque_reaction/nearest_order", "isolation/torque_reaction/margin")
#: of the operating speed, computed on the foundation of the case where that moves
STEADY = (
    "isolation/body/translation_harmonics",
    "isolation/body/rotation_harmonics",
    *(
        f"isolation/support_{what}"
        for what in (
            "force/steady_harmonics", "force/steady_peak", "force/largest_load",
            "force/minimum_load", "displacement/steady_harmonics", "displacement/vertical_peak",
            "displacement/excursion",
        )
    ),
)  # fmt: skip

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
        "isolation/pitch/force_left_out",
        "",
        "N",
        "largest shaking force over a turn: a body that only pitches does not follow it",
        PEAK,
        headline=Headline("shaking force that pitch leaves out, peak", "N"),
    ),
    entry(
        "isolation/pitch/couple_left_out",
        "",
        "N*m",
        "the same of the couple across the axis of pitch, about the mass centre",
        PEAK,
        headline=Headline("shaking couple that pitch leaves out, peak", "N*m"),
    ),
    entry(
        "isolation/modes/natural_frequency",
        "mode",
        "rad/s",
        "undamped natural frequency",
        headline=Headline(
            "natural frequency",
            "Hz",
            pick="ends",
            unless="foundation/coupled/modes/natural_frequency",
        ),
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
        headline=Headline("force on a support at speed, peak", "N"),
    ),
    entry(
        "isolation/support_force/largest_load",
        "mount",
        "N",
        "largest load on a support over the cycle: weight, mean torque and dynamic force",
    ),
    entry(
        "isolation/support_force/minimum_load",
        "mount",
        "N",
        "least load over the cycle; negative: the support is pulled",
        exempt=DIFFERENCE,
        headline=Headline("minimum load on a support", "N", pick="least"),
    ),
    entry(
        CAUSES,
        "mount cause",
        "N",
        "largest dynamic force of one support by one cause alone",
        PEAK,
    ),
    entry(
        "isolation/support_force/mean",
        "mount direction",
        "N",
        "force of one support on the ground by the mean torque",
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
        "largest deflection over the cycle: sag, mean torque and vertical displacement",
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
# What the torque of the cylinders is for the body; its part in the forces of the supports is above.
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
        f"{TORQUE_REACTION_ROOT}/roll_peak",
        "",
        "rad",
        "largest angle about the crankshaft over the cycle, without the mean",
        PEAK,
        headline=Headline("roll of the body by torque, peak", "mrad"),
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
    "cause": ("", "what acts on the body"),
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
