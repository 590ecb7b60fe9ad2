"""Results of isolation efficiency: what acts on the body, what reaches the ground, their ratio."""

from typing import Any, ClassVar

from vibecalc.core.results.described import Group, lead, q
from vibecalc.core.results.record import PEAK, RMS, SPECTRUM

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
