"""Results of machine and foundation in six freedoms, and of a foundation of tables."""

from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import entries_of, q
from vibecalc.core.results.record import PEAK, RMS, Headline

_ORDERS = "half_order direction"


@dataclass(frozen=True)
class CoupledModes:
    """Modes of machine and foundation together."""

    ROOT: ClassVar[str] = "foundation/coupled/modes"
    natural_frequency: Any = q(
        "coupled_mode", "rad/s", "of machine and foundation, undamped",
        headline=Headline("natural frequency, machine on foundation", "Hz", pick="ends"),
    )  # fmt: skip
    damping_ratio: Any = q("coupled_mode", "", "modal damping ratio")
    machine_share: Any = q("coupled_mode", "", "share of the kinetic energy that is in the machine")


@dataclass(frozen=True)
class FoundationMotion:
    """Motion of a foundation that is one body."""

    ROOT: ClassVar[str] = "foundation/coupled/body"
    translation: Any = q(_ORDERS, "m", "foundation at its reference point", PEAK)
    rotation: Any = q(_ORDERS, "rad", "rotation of the foundation", PEAK)


@dataclass(frozen=True)
class BelowMounts:
    """What the mounts stand on, and what passes through them."""

    ROOT: ClassVar[str] = "foundation/coupled"
    foot: Any = q("mount direction half_order", "m", "motion of what a mount stands on", PEAK)
    foot_velocity_rms: Any = q(
        "mount", "m/s",
        "velocity of what a mount stands on, length of the vector, all orders", RMS,
        headline=Headline("velocity of the foundation at a mount, r.m.s.", "mm/s"),
    )  # fmt: skip
    power: Any = q(
        "half_order", "W", "mean power through the mounts into the foundation",
        headline=Headline("power into the foundation, largest order", "W"),
    )  # fmt: skip


@dataclass(frozen=True)
class Passed:
    """Loads below the mounts; efficiencies stand in the first table unless others do."""

    ROOT: ClassVar[str]
    force: Any = q(_ORDERS, "N", "force {where}", PEAK)
    force_rms: Any = q(
        "", "N", "force {where}, all orders", RMS, headline=Headline("force {where}, r.m.s.", "N")
    )
    force_efficiency: Any = q(
        "", "", "1 - r.m.s. of the force {where} over that of the machine held still",
        headline=Headline("isolation of the force, r.m.s.", unless="{force}"),
    )  # fmt: skip
    force_by_order: Any = q(
        "half_order", "", "1 - force {where} over that of the machine held still"
    )
    couple: Any = q(_ORDERS, "N*m", "couple {where} about the origin", PEAK)
    couple_rms: Any = q("", "N*m", "couple {where} about the origin, all orders", RMS)
    couple_efficiency: Any = q(
        "", "",
        "1 - r.m.s. of the couple {where} about the origin over that of the machine held still",
        headline=Headline("isolation of the couple about the origin, r.m.s.", unless="{couple}"),
    )  # fmt: skip
    couple_by_order: Any = q(
        "half_order",
        "",
        "1 - couple {where} about the origin over that of the machine held still",
    )
    transmissibility: Any = q(
        "coordinate foundation_frequency", "",
        "load {where} over a load of one size on the machine, both at the reference point",
    )  # fmt: skip


class OnRigid(Passed):
    """Of the same machine on a rigid foundation."""

    ROOT = "foundation/coupled/rigid"
    WORDS: ClassVar = {
        "where": "on a rigid foundation",
        "force": "foundation/coupled/ground/force_efficiency",
        "couple": "foundation/coupled/ground/couple_efficiency",
    }


class OnGround(Passed):
    """Through the foundation."""

    ROOT = "foundation/coupled/ground"
    WORDS: ClassVar = {
        "where": "on the ground",
        "force": "isolation/efficiency/force/rms",
        "couple": "isolation/efficiency/couple/rms",
    }


AXES = {
    "coupled_mode": ("", "mode of machine and foundation, lowest first"),
    "foundation_frequency": ("Hz", "frequency"),
}
ENTRIES = tuple(entries_of(CoupledModes, FoundationMotion, BelowMounts, OnGround, OnRigid))
