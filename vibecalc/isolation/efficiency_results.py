"""Results of isolation efficiency: what acts on the body, what reaches the ground, their ratio."""

from dataclasses import dataclass
from typing import Any, ClassVar

from vibecalc.core.results.described import lead, q
from vibecalc.core.results.record import PEAK, RMS, SPECTRUM

_ORDERS = "order coordinate"
_HELD = "{what}{about} that the rigidly mounted body would send into the ground"
_GROUND = "{what}{about} of all mounts on the ground"


@dataclass(frozen=True)
class OfVector:
    """Of the length of a vector."""

    ROOT: ClassVar[str]
    held: Any = q(_ORDERS, "{unit}", _HELD, PEAK)
    held_rms: Any = q("", "{unit}", f"{_HELD}, over the cycle", RMS)
    held_peak: Any = q("", "{unit}", f"{_HELD}, largest over the cycle", PEAK)
    ground: Any = q(_ORDERS, "{unit}", _GROUND, PEAK)
    ground_rms: Any = q("", "{unit}", f"{_GROUND}, over the cycle", RMS)
    ground_peak: Any = q("", "{unit}", f"{_GROUND}, largest over the cycle", PEAK)
    by_order: Any = q("order component", "", "1 - {what} on the ground over that held still")
    rms: Any = lead("", "", "isolation of the {what}, r.m.s.")
    rms_level: Any = q("", "dB", "held still over on the ground, r.m.s.", exempt=SPECTRUM)
    peak: Any = q("", "", "the same of the peak of all orders")
    peak_level: Any = q("", "dB", "held still over on the ground, peak", exempt=SPECTRUM)


class OfForces(OfVector):
    """Of the resultant force."""

    ROOT = "isolation/efficiency/force"
    WORDS: ClassVar = {"what": "force", "unit": "N", "about": ""}


class OfCouples(OfVector):
    """Of the resultant couple about the mass centre."""

    ROOT = "isolation/efficiency/couple"
    WORDS: ClassVar = {"what": "couple", "unit": "N*m", "about": " about the mass centre"}


@dataclass(frozen=True)
class ByDirection:
    """Of each direction alone."""

    ROOT: ClassVar[str] = "isolation/efficiency"
    by_direction: Any = q("coordinate", "", "efficiency of the r.m.s. in each direction")
    transmissibility: Any = q("coordinate frequency", "", "load on the ground over load")
