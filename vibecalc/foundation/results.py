"""Results of a machine on a foundation that moves: one mass, six freedoms, or tables."""

from collections.abc import Iterator
from typing import Any, ClassVar

from vibecalc.core.results.described import Group, entries_of, lead, q
from vibecalc.core.results.record import PEAK, RMS, Entry, Headline, entry

COUPLED = "foundation/coupled"
_ORDERS = "order direction"
_NATURAL = Headline("natural frequency, machine on foundation", "Hz", pick="ends")


class UpAndDown(Group):
    """Machine and foundation as two masses."""

    ROOT: ClassVar[str] = "foundation"
    natural_frequency: Any = q(
        "foundation_mode", "rad/s", "of machine and foundation", headline=_NATURAL
    )
    machine: Any = q("order", "m", "vertical motion of the machine", PEAK)
    motion: Any = q("order", "m", "vertical motion of the foundation", PEAK)
    ground_force: Any = q("order", "N", "force into the ground", PEAK)
    rigid_force: Any = q("order", "N", "force on a rigid foundation", PEAK)
    motion_peak: Any = lead("", "m", "motion of the foundation, peak", PEAK)
    ground_force_peak: Any = lead("", "N", "force into the ground, peak", PEAK)
    rigid_force_peak: Any = lead("", "N", "force into the ground, rigid foundation, peak", PEAK)


class CoupledModes(Group):
    """Modes of machine and foundation together."""

    ROOT: ClassVar[str] = f"{COUPLED}/modes"
    natural_frequency: Any = q(
        "coupled_mode", "rad/s", "of machine and foundation, undamped", headline=_NATURAL
    )
    damping_ratio: Any = q("coupled_mode", "", "modal damping ratio")
    machine_share: Any = q("coupled_mode", "", "share of the machine in the kinetic energy")


class FoundationMotion(Group):
    """Motion of a foundation that is one body."""

    ROOT: ClassVar[str] = f"{COUPLED}/body"
    translation: Any = q(_ORDERS, "m", "foundation at its reference point", PEAK)
    rotation: Any = q(_ORDERS, "rad", "rotation of the foundation", PEAK)


class BelowMounts(Group):
    """What the mounts stand on, and what passes through them."""

    ROOT: ClassVar[str] = COUPLED
    foot: Any = q("mount direction order", "m", "motion of the foundation at a mount", PEAK)
    foot_velocity_rms: Any = lead(
        "mount", "m/s", "velocity of the foundation at a mount, r.m.s.", RMS, read="mm/s"
    )
    power: Any = lead("order", "W", "power into the foundation, largest order", read="W")


def _below(name: str, where: str, better: str) -> Iterator[Entry]:
    """Loads below the mounts; efficiencies stand in the first table unless those at `better` do."""
    held = "that of the rigidly mounted machine"
    for what, unit, about in (("force", "N", ""), ("couple", "N*m", " about the origin")):
        path, words = f"{COUPLED}/{name}/{what}", f"{what} {where}{about}"
        head = Headline(f"{words}, r.m.s.", unit) if what == "force" else None
        share = Headline(f"isolation efficiency, {what}{about}, r.m.s.", unless=better.format(what))
        yield entry(path, _ORDERS, unit, words, PEAK)
        yield entry(f"{path}_rms", "", unit, f"{words}, all orders", RMS, headline=head)
        words = f"{words} / {held}"
        yield entry(
            f"{path}_efficiency", "", "", f"1 - r.m.s. of the {words}", headline=share, share=True
        )
        yield entry(f"{path}_by_order", "order", "", f"1 - {words}")
    yield entry(
        f"{COUPLED}/{name}/transmissibility",
        "coordinate foundation_frequency",
        "",
        f"load {where} / load on the machine, both at the reference point",
    )


AXES = {
    "foundation_mode": ("", "vertical mode of machine and foundation, lowest first"),
    "coupled_mode": ("", "mode of machine and foundation, lowest first"),
    "foundation_frequency": ("Hz", "frequency"),
}
ENTRIES = (
    *entries_of(UpAndDown, CoupledModes, FoundationMotion, BelowMounts),
    *_below("ground", "on the ground", "isolation/efficiency/{}/rms"),
    *_below("rigid", "on a rigid foundation", f"{COUPLED}/ground/{{}}_efficiency"),
)
