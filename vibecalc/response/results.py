"""Results of the body on its suspension, and of the change between two operations."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, named, q
from vibecalc.core.results.record import CANCELS, ORDERS, PEAK, PLACE, RESONANCE, TURN

# ----------------------------------------------------------------------------
# Results of the body on its suspension: modes, motion, energies.
# ----------------------------------------------------------------------------

_ORDERS = "order direction"
#: with mounts at known places the force on each says more than the sum
_SUPPORTS = "isolation/support_force/steady_peak"
_POINT = "of the reference point"


class Modes(Group):
    """Of a body on its suspension; its natural frequencies stand `elsewhere` in the first table."""

    natural_frequency: Any = lead(
        "mode", "rad/s", "natural frequency", pick="ends", unless="{elsewhere}"
    )
    damping_ratio: Any = q("mode", "", "modal damping ratio")
    shape: Any = q("mode coordinate", "", f"mode shape {_POINT}, m and rad, of unit modal mass")
    energy_fraction: Any = q(
        "mode coordinate", "", "share of the kinetic energy of a mode, about the mass centre"
    )


class ModesOfBody(Modes):
    """How alike they are, with rotations times their radius of inertia, and how near orders are."""

    ROOT: ClassVar[str] = "response/modes"
    WORDS: ClassVar = {"elsewhere": "isolation/modes/natural_frequency"}
    assurance: Any = q("mode other_mode", "", f"modal assurance criterion {_POINT}")
    nearest_order: Any = q("mode", "", "excited order nearest to a mode at operating speed")
    distance: Any = q("mode", "", "frequency of that order / natural frequency - 1")


class Motion(Group):
    """Of a body at the operating speed."""

    translation_harmonics: Any = q(_ORDERS, "m", f"displacement {_POINT}", PEAK)
    rotation_harmonics: Any = q(_ORDERS, "rad", "rotation", PEAK)


class MotionOfBody(Motion):
    """Its largest values, too, and what its suspension sends into the ground."""

    ROOT: ClassVar[str] = "response"
    translation_peak: Any = lead(
        "direction", "m", "displacement of the reference point, peak", PEAK, about=_POINT
    )
    rotation_peak: Any = lead("direction", "rad", "rotation of the body, peak", PEAK, read="mrad")
    ground_force: Any = q(_ORDERS, "N", "force on the ground", PEAK)
    ground_couple: Any = q(_ORDERS, "N*m", "couple on the ground about the reference point", PEAK)
    ground_force_peak: Any = lead(
        "direction", "N", "force on the ground, peak", PEAK, unless=_SUPPORTS
    )
    ground_couple_peak: Any = lead(
        "direction", "N*m", "couple on the ground, peak", PEAK, unless=_SUPPORTS,
        about="about the reference point",
    )  # fmt: skip


class Energy(Group):
    """Of one kind, at the operating speed."""

    mean_by_order: Any = q("order", "J", "mean {kind} energy of one order over its cycle",
        name="{kind} energy by order, mean")  # fmt: skip
    peak_by_order: Any = q("order", "J", "largest {kind} energy of one order alone",
        name="{kind} energy by order, peak")  # fmt: skip
    mean: Any = q("", "J", "mean {kind} energy over a turn")
    peak: Any = q("", "J", "largest {kind} energy over a turn")


class KineticEnergy(Energy):
    """The one that stands in the first table."""

    ROOT: ClassVar[str] = "response/kinetic_energy"
    WORDS: ClassVar = {"kind": "kinetic"}
    mean: Any = lead("", "J", "kinetic energy, mean")
    peak: Any = lead("", "J", "kinetic energy, peak")


class PotentialEnergy(Energy):
    """That of the suspension."""

    ROOT = "response/potential_energy"
    WORDS: ClassVar = {"kind": "potential"}


_WAYS = "operation balance"
_ALONE = "of throws and balance weights, without pistons, counterweights and shafts"


class OperationsEnergy(Group):
    """Of one kind, of all operations with all balances; the angle of weights is to the pistons."""

    mean: Any = q(_WAYS, "J", "mean {kind} energy over a turn")
    peak: Any = q(_WAYS, "J", "largest {kind} energy over a turn")
    mean_low: Any = q(_WAYS, "J", "mean {kind} energy at the best angle of the weights")
    mean_high: Any = q(_WAYS, "J", "mean {kind} energy at the worst angle of the weights")
    peak_low: Any = q(_WAYS, "J", "largest {kind} energy at the best angle of the weights")
    peak_high: Any = q(_WAYS, "J", "largest {kind} energy at the worst angle of the weights")
    rotating_mean: Any = q(_WAYS, "J", f"mean {{kind}} energy {_ALONE}")
    rotating_peak: Any = q(_WAYS, "J", f"largest {{kind}} energy {_ALONE}")
    difference: Any = named("balance", "J", "range of the mean {kind} energy over the operations")
    weighted: Any = named("balance", "J", "mean {kind} energy, weighted over the operations")


class OperationsKinetic(OperationsEnergy):
    """That of the motion."""

    ROOT = "response/operations/kinetic_energy"
    WORDS: ClassVar = {"kind": "kinetic"}


class OperationsPotential(OperationsEnergy):
    """That of the suspension."""

    ROOT = "response/operations/potential_energy"
    WORDS: ClassVar = {"kind": "potential"}


class OverSpeed(Group):
    """Over the range of speeds."""

    ROOT: ClassVar[str] = "response/run_up"
    kinetic_energy: Any = q("speed", "J", "mean kinetic energy over a turn at each speed")
    potential_energy: Any = q("speed", "J", "mean potential energy over a turn at each speed")


class LeftOut(Group):
    """Intervals of speed about undamped resonances."""

    ROOT: ClassVar[str] = "response/resonances_skipped"
    low: Any = q("resonance_skipped", "rad/s", "last speed computed below")
    centre: Any = q("resonance_skipped", "rad/s", "speed of the undamped resonance")
    high: Any = q("resonance_skipped", "rad/s", "first speed computed above")
    order: Any = q("resonance_skipped", "", "order in resonance")
    mode: Any = q("resonance_skipped", "", "mode in resonance")


# ----------------------------------------------------------------------------
# Results of the change between two operations.
# ----------------------------------------------------------------------------


_CHANGE = "change direction"
_TIME = "{time}"


class Change(Group):
    """Of one way of changing; histories hold the largest or smallest sample of each interval."""

    translation_peak: Any = lead(_CHANGE, "m", "displacement, {how}, peak", PEAK, about=_POINT)
    rotation_peak: Any = q(_CHANGE, "rad", "rotation in the change, peak", PEAK)
    ground_force_peak: Any = q(_CHANGE, "N", "force on the ground in the change, peak", PEAK)
    ground_couple_peak: Any = q(_CHANGE, "N*m", "couple on the ground in the change, peak", PEAK)
    kinetic_energy_peak: Any = q("change", "J", "kinetic energy in the change, peak")
    potential_energy_peak: Any = q("change", "J", "potential energy in the change, peak")
    peak_time: Any = named("change", "s", "time of the kinetic energy peak", exempt=PLACE)
    peak_speed: Any = named("change", "rad/s", "crank speed at that time, signed", exempt=PLACE)
    settle_time: Any = named("change", "s", "settling time after the change")
    kinetic_energy_high: Any = q(f"change {_TIME}", "J", "largest kinetic energy at about a time")
    translation_high: Any = q(f"{_CHANGE} {_TIME}", "m", f"largest displacement {_POINT}")
    translation_low: Any = q(f"{_CHANGE} {_TIME}", "m", f"smallest displacement {_POINT}")


class Instant(Change):
    """At once; the worst angle is that of the crank with the largest kinetic energy of all."""

    ROOT: ClassVar[str] = "response/switching/instant"
    WORDS: ClassVar = {"how": "instantaneous change", "time": "instant_time"}
    worst_angle: Any = named("change", "rad", "worst crank angle", exempt=PLACE, circle=TURN)
    worst_kinetic_energy_peak: Any = named("change", "J", "kinetic energy peak at that angle")


class Reversal(Change):
    """Through rest."""

    ROOT: ClassVar[str] = "response/switching/reversal"
    WORDS: ClassVar = {"how": "change via standstill", "time": "reversal_time"}
    ground_force_peak: Any = lead(_CHANGE, "N", "force on the ground, {how}, peak", PEAK)
    speed: Any = q("change reversal_time", "rad/s", "crank speed, negative after reversal")
    slow_kinetic_energy: Any = named("change", "J", "kinetic energy peak, quasi-static passage")


class Passages(Group):
    """Where orders meet modes on the way through rest.

    Haste is the order times the acceleration over the square of damping ratio times frequency.
    """

    ROOT: ClassVar[str] = "response/switching/passage"
    change: Any = q("passage", "", "number of the change, from 1")
    mode: Any = q("passage", "", "mode in resonance")
    order: Any = q("passage", "", "order in resonance")
    speed: Any = q("passage", "rad/s", "crank speed at resonance")
    time: Any = q("passage", "s", "time from the start of the change")
    haste: Any = q("passage", "", "haste; above 1 the resonance does not build up")


class BesidesChanges(Group):
    """What the changes are held against."""

    ROOT: ClassVar[str] = "response/switching"
    steady_energy: Any = q("operation", "J", "largest kinetic energy of the steady state",
        name="kinetic energy, peak")  # fmt: skip


#: axis name -> (unit, long name)
AXES = {
    "other_mode": ("", "mode compared"),
    "operation": ("", "working cylinders"),
    "balance": ("", "throws balanced by weights"),
    "change": ("", "change of operation"),
    "instant_time": ("s", "end of an interval of time"),
    "reversal_time": ("s", "end of an interval of time"),
    "passage": ("", "resonance passage, from 1"),
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
