"""Results of the body on its mounts, under all that acts on it."""

from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, paths_of, q
from vibecalc.core.results.record import (
    CANCELS,
    DIFFERENCE,
    ORDERS,
    PEAK,
    RESONANCE,
    Headline,
)
from vibecalc.isolation.efficiency_results import AXES as EFFICIENCY_AXES
from vibecalc.isolation.efficiency_results import ByDirection, OfCouples, OfForces
from vibecalc.isolation.mount_results import OfMounts
from vibecalc.response.results import LeftOut, Modes, Motion

# ----------------------------------------------------------------------------
# The model: one angle, or the modes of the body; and how the body moves.
# ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Pitch:
    """Of a body that only turns about the axis across its crankshaft."""

    ROOT: ClassVar[str] = "isolation/pitch"
    inertia: Any = q("", "kg*m^2", "moment of inertia in pitch", name="moment of inertia, pitch")
    stiffness: Any = q(
        "", "N*m/rad", "stiffness of the mounts in pitch", name="stiffness of the mounts, pitch"
    )
    damping: Any = q(
        "", "N*m*s/rad", "viscous damping of the mounts in pitch",
        name="damping of the mounts, pitch",
    )  # fmt: skip
    natural_frequency: Any = q(
        "", "rad/s", "undamped natural frequency in pitch",
        headline=Headline("natural frequency, pitch", "Hz"),
    )  # fmt: skip
    damping_ratio: Any = q(
        "", "", "damping ratio in pitch", headline=Headline("damping ratio, pitch")
    )
    transmissibility: Any = q("order", "", "couple on the ground over couple")
    transmissibility_curve: Any = q(
        "frequency_ratio", "", "couple on the ground over couple against frequency"
    )
    angle_harmonics: Any = q("order", "rad", "pitch angle", PEAK)
    angle_peak: Any = q(
        "", "rad", "largest pitch angle over a turn", PEAK, name="pitch angle at speed, peak"
    )
    force_left_out: Any = q(
        "", "N", "largest shaking force over a turn: a body that only pitches does not follow it",
        PEAK, headline=Headline("shaking force that pitch leaves out, peak", "N"),
    )  # fmt: skip
    couple_left_out: Any = q(
        "", "N*m", "the same of the couple across the axis of pitch, about the mass centre",
        PEAK, headline=Headline("shaking couple that pitch leaves out, peak", "N*m"),
    )  # fmt: skip


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


@dataclass(frozen=True)
class LeverForce:
    """Couple of the pitch model over a lever."""

    ROOT: ClassVar[str] = "isolation/lever_force"
    rigid_harmonics: Any = q("order", "N", "couple over lever, body held still", PEAK)
    rigid_peak: Any = q(
        "", "N", "largest couple over lever over a turn, body held still", PEAK,
        name="couple over the lever, body held still, peak",
    )  # fmt: skip
    steady_harmonics: Any = q("order", "N", "couple through the mounts over lever", PEAK)
    steady_peak: Any = q(
        "", "N", "largest couple through the mounts over lever", PEAK,
        headline=Headline("couple over the lever at speed, peak", "N"),
    )  # fmt: skip
    run_up: Any = q(
        "speed", "N", "largest couple through the mounts over lever at each speed", PEAK
    )
    run_up_peak: Any = q(
        "", "N", "largest of the run-up", PEAK,
        headline=Headline(
            "couple over the lever in the run-up, peak", "N",
            at="isolation/lever_force/run_up_peak_speed",
        ),
    )  # fmt: skip
    run_up_peak_speed: Any = q("", "rad/s", "crank speed of the largest")


@dataclass(frozen=True)
class SupportForce:
    """Force of each support on what it stands on."""

    ROOT: ClassVar[str] = "isolation/support_force"
    static: Any = q("mount", "N", "share of the weight on one support")
    rigid_peak: Any = q(
        "mount", "N", "largest dynamic force of one support over a turn, body held still", PEAK
    )
    steady_harmonics: Any = q(
        "mount direction order", "N", "dynamic force of one support on the ground", PEAK
    )
    steady_peak: Any = q(
        "mount", "N", "largest dynamic force of one support over a turn", PEAK,
        headline=Headline("force on a support at speed, peak", "N"),
    )  # fmt: skip
    largest_load: Any = q(
        "mount", "N",
        "largest load on a support over the cycle: weight, mean torque and dynamic force",
    )  # fmt: skip
    minimum_load: Any = q(
        "mount", "N", "least load over the cycle; negative: the support is pulled",
        exempt=DIFFERENCE, headline=Headline("minimum load on a support", "N", pick="least"),
    )  # fmt: skip
    by_cause: Any = q(
        "mount cause", "N", "largest dynamic force of one support by one cause alone", PEAK
    )
    mean: Any = q("mount direction", "N", "force of one support on the ground by the mean torque")
    run_up: Any = q("mount speed", "N", "largest dynamic force of one support at each speed", PEAK)
    run_up_peak: Any = q(
        "mount", "N", "largest of the run-up", PEAK,
        headline=Headline(
            "force on a support in the run-up, peak", "N",
            at="isolation/support_force/run_up_peak_speed",
        ),
    )  # fmt: skip
    run_up_peak_speed: Any = q("mount", "rad/s", "crank speed of the largest")


@dataclass(frozen=True)
class SupportDisplacement:
    """Displacement of the body at each support."""

    ROOT: ClassVar[str] = "isolation/support_displacement"
    sag: Any = q(
        "mount", "m", "deflection under its own weight",
        headline=Headline("static deflection of a mount", "mm"),
    )  # fmt: skip
    steady_harmonics: Any = q(
        "mount direction order", "m", "displacement of the body at a support", PEAK
    )
    vertical_peak: Any = q(
        "mount", "m", "largest vertical displacement at a support over a turn", PEAK,
        headline=Headline("vertical motion at a mount at speed, peak", "mm"),
    )  # fmt: skip
    excursion: Any = q(
        "mount", "m",
        "largest deflection over the cycle: sag, mean torque and vertical displacement",
        PEAK, headline=Headline("deflection of a mount with its sag, peak", "mm"),
    )  # fmt: skip


# ----------------------------------------------------------------------------
# The run-up: speeds left out of it, and every local maximum.
# ----------------------------------------------------------------------------


class Masked(LeftOut):
    """Of the run-up of forces."""

    ROOT = "isolation/masked"


@dataclass(frozen=True)
class RunUpMaxima:
    """Local maxima of the forces of supports, by support and speed."""

    ROOT: ClassVar[str] = "isolation/run_up/maxima"
    mount: Any = q("maximum", "", "place of the support among the mounts, from 1")
    force: Any = q("maximum", "N", "local maximum of the force of a support", PEAK)
    speed: Any = q("maximum", "rad/s", "crank speed of the maximum")
    order: Any = q("maximum", "", "order that is largest there")
    order_share: Any = q("maximum", "", "size of that order over the peak of all")
    bending_order: Any = q(
        "maximum", "", "order that bends the curve downwards most: that in resonance"
    )
    mode: Any = q("maximum", "", "mode nearest to the frequency of that order")
    frequency_ratio: Any = q("maximum", "", "that frequency over that of the mode")
    at_end: Any = q("maximum", "", "1 at an end of the range of speeds, else 0")


# ----------------------------------------------------------------------------
# What the torque of the cylinders is for the body; its part in the forces of the supports is above.
# ----------------------------------------------------------------------------


@dataclass(frozen=True)
class TorqueReaction:
    """The torque of the cylinders on the body."""

    ROOT: ClassVar[str] = "isolation/torque_reaction"
    couple: Any = q(
        "half_order", "N*m", "couple on the body about the crankshaft by gas and inertia torque",
        PEAK,
    )  # fmt: skip
    mean_couple: Any = q(
        "", "N*m", "its mean; 0 where the driven machine is on the body",
        headline=Headline("torque reaction, mean", "N*m"),
    )  # fmt: skip
    roll_peak: Any = q(
        "", "rad", "largest angle about the crankshaft over the cycle, without the mean", PEAK,
        headline=Headline("roll of the body by torque, peak", "mrad"),
    )  # fmt: skip
    nearest_order: Any = q(
        "mode", "",
        "half order nearest to a mode of the body of those that drive it; 0: none does",
    )  # fmt: skip
    margin: Any = q("mode", "", "frequency of that order over the natural frequency, less 1")


#: of those that are of the torque of the cylinders, where it reaches the mounts
OF_TORQUE = (
    *paths_of(SupportForce, "by_cause", "mean"),
    *paths_of(TorqueReaction, "couple", "mean_couple", "roll_peak"),
)
NEAREST = paths_of(TorqueReaction, "nearest_order", "margin")
#: of supports at the operating speed, computed on the foundation of the case where that moves
STEADY_AT_SUPPORTS = (
    *paths_of(SupportForce, "steady_harmonics", "steady_peak", "largest_load", "minimum_load"),
    *paths_of(SupportDisplacement, "steady_harmonics", "vertical_peak", "excursion"),
)
#: the same of the body and its supports
STEADY = (*paths_of(BodyMotion), *STEADY_AT_SUPPORTS)

#: axis name -> (unit, long name)
AXES = {
    "mount": ("", "mount"),
    "cause": ("", "what acts on the body"),
    "maximum": ("", "local maximum, by support and speed"),
    **EFFICIENCY_AXES,
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
