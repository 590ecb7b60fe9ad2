"""Results of the body on its mounts, under all that acts on it."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, named, paths_of, q
from vibecalc.core.results.record import CANCELS, DIFFERENCE, ORDERS, PEAK, RESONANCE, RMS, SPECTRUM
from vibecalc.response.results import LeftOut, Modes, Motion

#: of what is left of a difference, the least stands in the first table
LEAST = {"pick": "least", "exempt": DIFFERENCE}

# ----------------------------------------------------------------------------
# The model: one angle, or the modes of the body; and how the body moves.
# ----------------------------------------------------------------------------


class Pitch(Group):
    """Of a body that only turns about the axis across its crankshaft."""

    ROOT: ClassVar[str] = "isolation/pitch"
    inertia: Any = named("", "kg*m^2", "moment of inertia, pitch")
    stiffness: Any = named("", "N*m/rad", "stiffness of the mounts, pitch")
    damping: Any = named("", "N*m*s/rad", "damping of the mounts, pitch")
    natural_frequency: Any = lead("", "rad/s", "natural frequency, pitch")
    damping_ratio: Any = lead("", "", "damping ratio, pitch")
    transmissibility: Any = q("order", "", "couple on the ground / exciting couple")
    transmissibility_curve: Any = q("frequency_ratio", "", "couple on the ground / exciting couple")
    angle_harmonics: Any = q("order", "rad", "pitch angle", PEAK)
    angle_peak: Any = named("", "rad", "pitch angle at speed, peak", PEAK)
    force_left_out: Any = lead("", "N", "shaking force outside the pitch model, peak", PEAK)
    couple_left_out: Any = lead(
        "",
        "N*m",
        "shaking couple outside the pitch model, peak",
        PEAK,
        about="about the mass centre",
    )


class BodyModes(Modes):
    """Modes of a body on mounts that stand on rigid ground."""

    ROOT = "isolation/modes"
    WORDS: ClassVar = {"elsewhere": "foundation/coupled/modes/natural_frequency"}


class BodyMotion(Motion):
    """Motion of the body at the operating speed."""

    ROOT = "isolation/body"


# ----------------------------------------------------------------------------
# What the mounts bear, at rest, at speed and in the run-up.
# ----------------------------------------------------------------------------


class LeverForce(Group):
    """Couple of the pitch model over a lever."""

    ROOT: ClassVar[str] = "isolation/couple_over_lever"
    blocked_harmonics: Any = q("order", "N", "pitch couple / lever, rigidly mounted", PEAK)
    blocked_peak: Any = named("", "N", "pitch couple / lever, rigidly mounted, peak", PEAK)
    steady_harmonics: Any = q("order", "N", "couple through the mounts / lever", PEAK)
    steady_peak: Any = lead("", "N", "pitch couple / lever at speed, peak", PEAK)
    run_up: Any = q("speed", "N", "pitch couple / lever at each speed, peak", PEAK)
    run_up_peak: Any = lead("", "N", "pitch couple / lever in the run-up, peak", PEAK)
    run_up_peak_speed: Any = q("", "rad/s", "crank speed at the maximum")


class SupportForce(Group):
    """Force of each support on what it stands on, dynamic; a load is with weight and mean torque.

    A negative load pulls the support.
    """

    ROOT: ClassVar[str] = "isolation/support_force"
    static: Any = q("mount", "N", "static load of a mount")
    blocked_peak: Any = q("mount", "N", "mount force, rigidly mounted, peak", PEAK)
    steady_harmonics: Any = q("mount direction order", "N", "dynamic mount force", PEAK)
    steady_peak: Any = lead("mount", "N", "mount force at speed, peak", PEAK)
    largest_load: Any = q("mount", "N", "largest load: weight, mean torque and dynamic force")
    minimum_load: Any = lead("mount", "N", "minimum load on a mount", **LEAST)
    by_cause: Any = q("mount cause", "N", "mount force by one cause alone, peak", PEAK)
    mean: Any = q("mount direction", "N", "mount force due to the mean torque")
    run_up: Any = q("mount speed", "N", "mount force at each speed, peak", PEAK)
    run_up_peak: Any = lead("mount", "N", "mount force in the run-up, peak", PEAK)
    run_up_peak_speed: Any = q("mount", "rad/s", "crank speed at the maximum")


class SupportDisplacement(Group):
    """Displacement of the body at each support; the total, along the vertical, is with that by
    weight and mean torque."""

    ROOT: ClassVar[str] = "isolation/support_displacement"
    static: Any = lead("mount", "m", "static deflection of a mount")
    steady_harmonics: Any = q("mount direction order", "m", "displacement at a mount", PEAK)
    vertical_peak: Any = lead("mount", "m", "vertical displacement at a mount, peak", PEAK)
    total: Any = lead("mount", "m", "total deflection of a mount, vertical", PEAK)


# ----------------------------------------------------------------------------
# Mounts that depend on what they carry, on the frequency, or that have stops.
# ----------------------------------------------------------------------------


class OfMounts(Group):
    """Along the axis of each: at rest, over the frequency, and how near it comes to its stops.

    A clearance is negative where the mount stands on a stop or meets it, and infinite without one;
    in the run-up it is that under weight and mean torque less the largest motion.
    """

    ROOT: ClassVar[str] = "isolation/mounts"
    load: Any = q("mount", "N", "compression load of a mount at rest along its axis")
    deflection: Any = q("mount", "m", "compression of a mount at rest along its axis")
    static_stiffness: Any = q("mount", "N/m", "static tangent stiffness at rest")
    stiffness: Any = q("mount", "N/m", "dynamic stiffness along its axis at rest, nominal")
    load_curve: Any = q("mount deflection", "N", "static load of a mount against compression")
    clearance_at_rest: Any = q("mount", "m", "distance to the nearer stop", exempt=DIFFERENCE)
    travel: Any = q("mount", "m", "largest motion of a mount along its axis", PEAK)
    clearance: Any = lead("mount", "m", "clearance to a stop at speed", **LEAST)
    run_up_travel: Any = q("mount", "m", "largest motion along its axis in the run-up", PEAK)
    run_up_travel_speed: Any = q("mount", "rad/s", "crank speed at that motion")
    run_up_clearance: Any = lead("mount", "m", "clearance to a stop in the run-up", **LEAST)
    order_stiffness: Any = q("mount order", "N/m", "stiffness along its axis at an order")
    order_loss_factor: Any = q("mount order", "", "loss factor at the frequency of an order")


#: of mounts with static or over_load
AT_REST = paths_of(OfMounts, "load", "deflection", "static_stiffness", "stiffness", "load_curve")
#: of mounts with stops
OF_STOPS = paths_of(OfMounts, "clearance_at_rest")
MOVING = paths_of(OfMounts, "travel", "clearance")
OF_RUN_UP = paths_of(OfMounts, "run_up_travel", "run_up_travel_speed", "run_up_clearance")
#: of mounts with over_frequency
BY_ORDER = paths_of(OfMounts, "order_stiffness", "order_loss_factor")


# ----------------------------------------------------------------------------
# The run-up: speeds left out of it, and every local maximum.
# ----------------------------------------------------------------------------


class Masked(LeftOut):
    """Of the run-up of forces."""

    ROOT = "isolation/resonances_skipped"


class RunUpMaxima(Group):
    """Local maxima of the forces of supports, by support and speed."""

    ROOT: ClassVar[str] = "isolation/run_up/maxima"
    mount: Any = q("maximum", "", "number of the mount")
    force: Any = q("maximum", "N", "local maximum of a mount force", PEAK)
    speed: Any = q("maximum", "rad/s", "crank speed of the maximum")
    order: Any = q("maximum", "", "dominant order at the maximum")
    order_share: Any = q("maximum", "", "amplitude of that order / peak of all orders")
    bending_order: Any = q("maximum", "", "order in resonance, of the largest downward curvature")
    mode: Any = q("maximum", "", "mode nearest to the frequency of that order")
    frequency_ratio: Any = q("maximum", "", "frequency of that order / natural frequency")
    at_end: Any = q("maximum", "", "1 at an end of the speed range, else 0")


# ----------------------------------------------------------------------------
# What the torque of the cylinders is for the body; its part in the forces of the supports is above.
# ----------------------------------------------------------------------------


class TorqueReaction(Group):
    """The torque of the cylinders on the body, without mean where what is driven is on the body."""

    ROOT: ClassVar[str] = "isolation/torque_reaction"
    couple: Any = q("order", "N*m", "reaction couple about the crankshaft, gas and inertia", PEAK)
    mean_couple: Any = lead("", "N*m", "torque reaction, mean")
    roll_peak: Any = lead("", "rad", "body roll, all loads, peak", PEAK, read="mrad")
    nearest_order: Any = q("mode", "", "nearest order that excites the mode; 0: none")
    margin: Any = q("mode", "", "frequency of that order / natural frequency - 1")


# ----------------------------------------------------------------------------
# Isolation efficiency: what acts on the body, what reaches the ground, their ratio.
# ----------------------------------------------------------------------------

_ORDERS = "order coordinate"
_HELD = "{what}{about} on the ground, rigidly mounted"
_GROUND = "{what}{about} on the ground, on mounts"


class OfVector(Group):
    """Of the length of a vector."""

    held: Any = q(_ORDERS, "{unit}", _HELD, PEAK)
    held_rms: Any = q("", "{unit}", f"{_HELD}, over the cycle", RMS)
    held_peak: Any = q("", "{unit}", f"{_HELD}, largest over the cycle", PEAK)
    ground: Any = q(_ORDERS, "{unit}", _GROUND, PEAK)
    ground_rms: Any = q("", "{unit}", f"{_GROUND}, over the cycle", RMS)
    ground_peak: Any = q("", "{unit}", f"{_GROUND}, largest over the cycle", PEAK)
    by_order: Any = q("order component", "", "1 - {what} on the ground / rigidly mounted")
    rms: Any = lead("", "", "isolation efficiency, {what}, r.m.s.", share=True)
    rms_level: Any = q("", "dB", "rigidly mounted / on mounts, r.m.s.", exempt=SPECTRUM)
    peak: Any = q("", "", "isolation efficiency, {what}, peak of all orders")
    peak_level: Any = q("", "dB", "rigidly mounted / on mounts, peak", exempt=SPECTRUM)


class OfForces(OfVector):
    """Of the resultant force."""

    ROOT = "isolation/efficiency/force"
    WORDS: ClassVar = {"what": "force", "unit": "N", "about": ""}


class OfCouples(OfVector):
    """Of the resultant couple about the mass centre."""

    ROOT = "isolation/efficiency/couple"
    WORDS: ClassVar = {"what": "couple", "unit": "N*m", "about": " about the mass centre"}


class ByDirection(Group):
    """Of each direction alone."""

    ROOT: ClassVar[str] = "isolation/efficiency"
    by_direction: Any = q("coordinate", "", "efficiency of the r.m.s. in each direction")
    transmissibility: Any = q("coordinate frequency", "", "load on the ground / load on the body")


#: of those that are of the torque of the cylinders, where it reaches the mounts
OF_TORQUE = (
    *paths_of(SupportForce, "by_cause", "mean"),
    *paths_of(TorqueReaction, "couple", "mean_couple", "roll_peak"),
)
NEAREST = paths_of(TorqueReaction, "nearest_order", "margin")
#: of supports at the operating speed, computed on the foundation of the case where that moves
STEADY_AT_SUPPORTS = (
    *paths_of(SupportForce, "steady_harmonics", "steady_peak", "largest_load", "minimum_load"),
    *paths_of(SupportDisplacement, "steady_harmonics", "vertical_peak", "total"),
)
#: the same of the body and its supports
STEADY = (*paths_of(BodyMotion), *STEADY_AT_SUPPORTS)

#: axis name -> (unit, long name)
AXES = {
    "mount": ("", "mount"),
    "cause": ("", "excitation of the body"),
    "maximum": ("", "local maximum, by support and speed"),
    "component": ("", "component, or the length of the vector"),
    "frequency": ("Hz", "frequency"),
    "deflection": ("m", "compression of a mount along its axis"),
}
ENTRIES = tuple(
    entries_of(
        Pitch, BodyModes, BodyMotion, LeverForce, SupportForce, SupportDisplacement, Masked,
        RunUpMaxima, OfMounts, TorqueReaction, OfForces, OfCouples, ByDirection,
    )
)  # fmt: skip
JUDGE = "vibecalc.isolation.mount_report:stop_verdicts"
HELPS = {
    "isolation/": (ORDERS, RESONANCE),
    "isolation/modes/": (CANCELS,),
    "isolation/support_force/static": (CANCELS,),
}
