"""Keys that a search changes: after how much they repeat, and values of them in words."""

import math
from typing import TYPE_CHECKING

from vibecalc.parts.firing import cycle_angle
from vibecalc.units import convert, split_number

if TYPE_CHECKING:
    from vibecalc.case.schema import Machine


def shown_as(value: float, unit: str, written: float | str) -> str:
    """A value of the SI unit `unit` as a text in the unit that `written` carries, if it does."""
    own = split_number(written)[1] if isinstance(written, str) else ""
    return f"{convert(value, unit, own):.6g} {own}" if own else f"{value:.6g} {unit}".rstrip()


def period_of(key: str, machine: "Machine") -> float:
    """After how much in rad a key repeats itself: an angle of the crank train; 0 for all others.

    The throw of a cylinder stands for its firing, too, and that repeats itself with the cycle.
    """
    name = key.rpartition(".")[2]
    if not key.startswith("machine.crank_train."):
        return 0.0
    if name in ("crank_phase", "bank_angle", "firing_angle"):
        return cycle_angle(machine)
    return 2.0 * math.pi if name == "phase" else 0.0
