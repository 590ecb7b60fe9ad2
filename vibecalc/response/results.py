"""Results of the body on its suspension, and of the change between two operations."""

from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, q
from vibecalc.core.results.record import (
    CANCELS,
    ORDERS,
    PEAK,
    PLACE,
    RESONANCE,
    TURN,
    Headline,
)

# ----------------------------------------------------------------------------
# Results of the body on its suspension: modes, motion, energies.
# ----------------------------------------------------------------------------

_ORDERS = "order direction"
#: with mounts at known places the force on each says more than the sum
_SUPPORTS = "isolation/support_force/steady_peak"


@dataclass(frozen=True)
class Modes:
    """Of a body on its suspension; its natural frequencies stand `elsewhere` in the first table."""

    ROOT: ClassVar[str]
    natural_frequency: Any = q(
        "mode", "rad/s", "undamped natural frequency",
        headline=Headline("natural frequency", "Hz", pick="ends", unless="{elsewhere}"),
    )  # fmt: skip
    damping_ratio: Any = q("mode", "", "modal damping ratio")
    shape: Any = q(
        "mode coordinate", "",
        "mode shape at the reference point, metres and radians, of unit modal mass",
    )  # fmt: skip
    energy_fraction: Any = q(
        "mode coordinate", "", "share of the kinetic energy of a mode, about the mass centre"
    )


@dataclass(frozen=True)
class ModesOfBody(Modes):
    """How alike they are, too, and how near the orders are."""

    ROOT: ClassVar[str] = "response/modes"
    WORDS: ClassVar = {"elsewhere": "isolation/modes/natural_frequency"}
    assurance: Any = q(
        "mode other_mode",
        "",
        "modal assurance criterion at the reference point, rotations times their radius of inertia",
    )
    nearest_order: Any = q("mode", "", "excited order nearest to a mode at operating speed")
    distance: Any = q("mode", "", "frequency of that order over the natural frequency, less 1")


@dataclass(frozen=True)
class Motion:
    """Of a body at the operating speed."""

    ROOT: ClassVar[str]
    translation_harmonics: Any = q(_ORDERS, "m", "displacement of the reference point", PEAK)
    rotation_harmonics: Any = q(_ORDERS, "rad", "rotation", PEAK)


@dataclass(frozen=True)
class MotionOfBody(Motion):
    """Its largest values, too, and what its suspension sends into the ground."""

    ROOT: ClassVar[str] = "response"
    translation_peak: Any = q(
        "direction", "m", "largest of the reference point over a turn", PEAK,
        headline=Headline("motion of the body, peak", "mm"),
    )  # fmt: skip
    rotation_peak: Any = q(
        "direction", "rad", "largest over a turn", PEAK,
        headline=Headline("rotation of the body, peak", "mrad"),
    )  # fmt: skip
    ground_force: Any = q(_ORDERS, "N", "force on the ground", PEAK)
    ground_couple: Any = q(_ORDERS, "N*m", "couple on the ground about the reference point", PEAK)
    ground_force_peak: Any = q(
        "direction", "N", "largest over a turn", PEAK,
        headline=Headline("force on the ground, peak", "N", unless=_SUPPORTS),
    )  # fmt: skip
    ground_couple_peak: Any = q(
        "direction", "N*m", "largest about the reference point over a turn", PEAK,
        headline=Headline("couple on the ground, peak", "N*m", unless=_SUPPORTS),
    )  # fmt: skip


@dataclass(frozen=True)
class Energy:
    """Of one kind, at the operating speed."""

    ROOT: ClassVar[str]
    mean_by_order: Any = q("order", "J", "mean {kind} energy of one order over its cycle")
    peak_by_order: Any = q("order", "J", "largest {kind} energy of one order alone")
    mean: Any = q("", "J", "mean {kind} energy over a turn")
    peak: Any = q("", "J", "largest {kind} energy over a turn")


@dataclass(frozen=True)
class KineticEnergy(Energy):
    """The one that stands in the first table."""

    ROOT: ClassVar[str] = "response/kinetic_energy"
    WORDS: ClassVar = {"kind": "kinetic"}
    mean: Any = q(
        "", "J", "mean kinetic energy over a turn", headline=Headline("kinetic energy, mean", "J")
    )
    peak: Any = q(
        "", "J", "largest kinetic energy over a turn",
        headline=Headline("kinetic energy, peak", "J"),
    )  # fmt: skip


class PotentialEnergy(Energy):
    """That of the suspension."""

    ROOT = "response/potential_energy"
    WORDS: ClassVar = {"kind": "potential"}


_WAYS = "operation balance"
_ALONE = "of throws and balance weights, without pistons, counterweights and shafts"


@dataclass(frozen=True)
class OperationsEnergy:
    """Of one kind, of all operations with all balances."""

    ROOT: ClassVar[str]
    mean: Any = q(_WAYS, "J", "mean {kind} energy over a turn")
    peak: Any = q(_WAYS, "J", "largest {kind} energy over a turn")
    mean_low: Any = q(_WAYS, "J", "mean {kind} energy, weights at the best angle to the pistons")
    mean_high: Any = q(_WAYS, "J", "mean {kind} energy, weights at the worst angle to the pistons")
    peak_low: Any = q(_WAYS, "J", "largest {kind} energy, weights at the best angle to the pistons")
    peak_high: Any = q(
        _WAYS, "J", "largest {kind} energy, weights at the worst angle to the pistons"
    )
    rotating_mean: Any = q(_WAYS, "J", f"mean {{kind}} energy {_ALONE}")
    rotating_peak: Any = q(_WAYS, "J", f"largest {{kind}} energy {_ALONE}")
    difference: Any = q(
        "balance", "J", "largest less smallest mean {kind} energy of the operations"
    )
    weighted: Any = q("balance", "J", "mean {kind} energy, weighted over the operations")


class OperationsKinetic(OperationsEnergy):
    """That of the motion."""

    ROOT = "response/operations/kinetic_energy"
    WORDS: ClassVar = {"kind": "kinetic"}


class OperationsPotential(OperationsEnergy):
    """That of the suspension."""

    ROOT = "response/operations/potential_energy"
    WORDS: ClassVar = {"kind": "potential"}


@dataclass(frozen=True)
class OverSpeed:
    """Over the range of speeds."""

    ROOT: ClassVar[str] = "response/run_up"
    kinetic_energy: Any = q("speed", "J", "mean kinetic energy over a turn at each speed")
    potential_energy: Any = q("speed", "J", "mean potential energy over a turn at each speed")


@dataclass(frozen=True)
class LeftOut:
    """Intervals of speed about undamped resonances."""

    ROOT: ClassVar[str] = "response/masked"
    low: Any = q("masked", "rad/s", "last speed computed below")
    centre: Any = q("masked", "rad/s", "speed of the undamped resonance")
    high: Any = q("masked", "rad/s", "first speed computed above")
    order: Any = q("masked", "", "order in resonance")
    mode: Any = q("masked", "", "mode in resonance")


# ----------------------------------------------------------------------------
# Results of the change between two operations.
# ----------------------------------------------------------------------------


_CHANGE = "change direction"


@dataclass(frozen=True)
class Change:
    """Of one way of changing."""

    ROOT: ClassVar[str]
    translation_peak: Any = q(
        _CHANGE, "m", "largest displacement of the reference point on the way", PEAK,
        headline=Headline("motion in a change {how}, peak", "mm"),
    )  # fmt: skip
    rotation_peak: Any = q(_CHANGE, "rad", "largest rotation on the way", PEAK)
    ground_force_peak: Any = q(_CHANGE, "N", "largest force on the ground on the way", PEAK)
    ground_couple_peak: Any = q(_CHANGE, "N*m", "largest couple on the ground on the way", PEAK)
    kinetic_energy_peak: Any = q("change", "J", "largest kinetic energy on the way")
    potential_energy_peak: Any = q("change", "J", "largest potential energy on the way")
    peak_time: Any = q("change", "s", "time of the largest kinetic energy", exempt=PLACE)
    peak_speed: Any = q(
        "change", "rad/s", "crank speed at that time, negative after reversal", exempt=PLACE
    )
    settle_time: Any = q(
        "change", "s", "time from the end of the change until the motion has settled"
    )
    kinetic_energy_high: Any = q(
        "change {time}", "J", "largest sample of the kinetic energy in each interval of time"
    )
    translation_high: Any = q(
        f"{_CHANGE} {{time}}", "m", "largest sample of the displacement in each interval of time"
    )
    translation_low: Any = q(
        f"{_CHANGE} {{time}}", "m", "smallest sample of the displacement in each interval of time"
    )


@dataclass(frozen=True)
class Instant(Change):
    """At once."""

    ROOT: ClassVar[str] = "response/switching/instant"
    WORDS: ClassVar = {"how": "at once", "time": "instant_time"}
    worst_angle: Any = q(
        "change", "rad", "crank angle of the change that gives the largest kinetic energy",
        exempt=PLACE, circle=TURN,
    )  # fmt: skip
    worst_kinetic_energy_peak: Any = q(
        "change", "J", "largest kinetic energy over all crank angles of the change"
    )


@dataclass(frozen=True)
class Reversal(Change):
    """Through rest."""

    ROOT: ClassVar[str] = "response/switching/reversal"
    WORDS: ClassVar = {"how": "by reversal", "time": "reversal_time"}
    ground_force_peak: Any = q(
        _CHANGE, "N", "largest force on the ground on the way", PEAK,
        headline=Headline("force on the ground in it, peak", "N"),
    )  # fmt: skip
    speed: Any = q("change reversal_time", "rad/s", "crank speed, negative after reversal")
    slow_kinetic_energy: Any = q(
        "change", "J", "largest kinetic energy if the same speeds were passed infinitely slowly"
    )


@dataclass(frozen=True)
class Passages:
    """Where orders meet modes on the way through rest."""

    ROOT: ClassVar[str] = "response/switching/passage"
    change: Any = q("passage", "", "number of the change, from 1")
    mode: Any = q("passage", "", "mode that is met")
    order: Any = q("passage", "", "order that meets it")
    speed: Any = q("passage", "rad/s", "crank speed there")
    time: Any = q("passage", "s", "time from the start of the change")
    haste: Any = q(
        "passage", "",
        "order times acceleration over (damping ratio times frequency) squared; above 1 the "
        "resonance has no time to build up",
    )  # fmt: skip


@dataclass(frozen=True)
class BesidesChanges:
    """What the changes are held against."""

    ROOT: ClassVar[str] = "response/switching"
    steady_energy: Any = q("operation", "J", "largest kinetic energy of the steady state")


#: axis name -> (unit, long name)
AXES = {
    "other_mode": ("", "mode it is held against"),
    "operation": ("", "cylinders that work"),
    "balance": ("", "throws that weights cancel"),
    "change": ("", "from one operation to the other"),
    "instant_time": ("s", "end of an interval of time"),
    "reversal_time": ("s", "end of an interval of time"),
    "passage": ("", "meeting of an order and a mode, the first is 1"),
}
ENTRIES = tuple(
    entries_of(
        ModesOfBody, MotionOfBody, KineticEnergy, PotentialEnergy, OperationsKinetic,
        OperationsPotential, OverSpeed, LeftOut, Instant, Reversal, Passages, BesidesChanges,
    )
)  # fmt: skip
HELPS = {
    "response/": (ORDERS, RESONANCE),
    "response/modes/": (CANCELS,),
    "response/switching/": (ORDERS,),
}
