"""What all sections on a shaft line share: its parts, words for orders, speeds and sections."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels, magnitudes, speed_of, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from vibecalc.machine.shaft_line import ShaftLine

TORSION = "response/torsion/"
#: rad -> mrad, rad -> degrees, Pa -> N/mm^2
MILLI, DEGREES, MEGA = 1e3, 180.0 / math.pi, 1e-6
#: orders and modes beyond these are in the result file only
MOST_ORDERS, MOST_MODES = 60, 6
#: a speed of so many times the operating one still counts where the case names no range
_BEYOND = 1.25


def line_of(result: Result) -> "ShaftLine | None":
    """The shaft line of the case with what its dimensions give; None if the case has none."""
    if not table_of(result.case, "machine", "shaft_line"):
        return None
    from vibecalc.case.load import validate
    from vibecalc.machine.shaft_line import build_shaft_line

    return build_shaft_line(validate(dict(result.case)))


def asked(result: Result) -> dict[str, object]:
    """The table `response.torsion` of the case."""
    return dict(table_of(result.case, "response", "torsion"))


def has_pendulums(result: Result) -> bool:
    """Whether natural frequencies change with the speed, as a pendulum's field does."""
    line = line_of(result)
    return line is not None and bool(np.any(line.speed_stiffness))


def speed_range(result: Result) -> tuple[float, float]:
    """Lowest and highest crank speed in rad/s that count, of the case or about its own speed."""
    speeds = table_of(result.case, "response", "torsion", "speeds")
    if "from" in speeds and "to" in speeds:
        return float(speeds["from"]), float(speeds["to"])
    return 0.0, _BEYOND * (speed_of(result) or 0.0)


def range_words(result: Result) -> str:
    """`300 to 1000 rpm`."""
    low, high = (turns(speed) for speed in speed_range(result))
    return f"{low} to {high} rpm"


def turns(speed: float) -> str:
    """A speed in rad/s as rpm, short: `300`, `859.87`."""
    return short(rpm(speed))


def short(value: float) -> str:
    """Five digits at most, without zeros at the end."""
    return f"{float(value):.5g}" if math.isfinite(value) else show(value)


def order_text(order: float) -> str:
    """`0.5`, `3`; `-` for none."""
    return f"{float(order):g}" if order else "-"


def within(value: float, error: float, digits: int = 4) -> str:
    """A number with no more digits than its error leaves: `40 +- 20`; plain where all are known.

    The error is rounded up to one digit.
    """
    if not math.isfinite(value) or not math.isfinite(error) or abs(value) <= error:
        return show(value, error, digits)
    if error < 0.5 * 10.0 ** (math.floor(math.log10(abs(value))) + 1 - digits):
        return show(value, digits=digits)
    power = math.floor(math.log10(error))
    doubt = math.ceil(error / 10.0**power - 1e-9) * 10.0**power
    places = max(-power, 0)
    return f"{round(value, -power):.{places}f} +- {doubt:.{places}f}"


def meeting(mode: float, order: float) -> str:
    """`mode 2, order 3`, or nothing where no critical is near."""
    return f"mode {int(mode)}, order {order_text(order)}" if mode and order else ""


def vector(record: Record, name: str, axis: str) -> np.ndarray | None:
    """Real values of a quantity of one axis under `TORSION`, None if it is missing or empty."""
    quantity = having(record, TORSION + name, axis)
    return None if quantity is None else magnitudes(quantity)


def names(record: Record, path: str, axis: str) -> list[str]:
    """Labels of an axis of a quantity under `TORSION`, none if the record does not have it."""
    quantity = record.quantities.get(TORSION + path)
    found = [own for own in quantity.axes if own.name == axis] if quantity is not None else []
    return labels(found[0]) if found else []


def cell(
    quantity: Quantity | None, place: int | tuple[int, ...], factor: float = 1.0, digits: int = 5
) -> str:
    """One entry in the unit that `factor` makes of SI; blank if the quantity is missing."""
    if quantity is None:
        return ""
    value = np.asarray(quantity.values)[place]
    size = float(abs(value)) if np.iscomplexobj(value) else float(value)
    return show(factor * size, abs(factor) * quantity.error_estimate, digits)


def undamped_frequency(record: Record) -> np.ndarray | None:
    """Frequencies of the line without damping, which Holzer's tables are of."""
    found = vector(record, "modes/undamped_frequency", "mode")
    return vector(record, "modes/natural_frequency", "mode") if found is None else found


def elastic_modes(result: Result, undamped: bool = False) -> list[int]:
    """Places of the modes that an order of the case meets within its speeds, the lowest first.

    At most `MOST_MODES`; the lowest elastic one in any case.
    """
    natural = vector(result.record, "modes/natural_frequency", "mode")
    if undamped:
        natural = undamped_frequency(result.record)
    if natural is None:
        return []
    top = highest_frequency(result)
    elastic = [int(i) for i in np.flatnonzero(natural > 0.0)]
    return [i for n, i in enumerate(elastic) if n == 0 or natural[i] <= top][:MOST_MODES]


def highest_frequency(result: Result) -> float:
    """Of the highest order of the case at its highest speed, rad/s."""
    excited = having(result.record, TORSION + "excitation/total", "half_order")
    highest = 12.0 if excited is None else float(np.max(np.asarray(excited.axes[0].values)))
    return highest * speed_range(result)[1]


def entry(quantity: Quantity | None, name: str, factor: float = 1.0, digits: int = 5) -> str:
    """The entry of a section as in `cell`; blank if the quantity does not have this section.

    Stresses belong to sections with a section modulus, what a line has without dampers to others.
    """
    place = place_of(quantity, name)
    return "" if place is None else cell(quantity, place, factor, digits)


def place_of(quantity: Quantity | None, name: str) -> int | None:
    """Where a section, station or other thing with a name stands on the first axis."""
    found = [] if quantity is None else labels(quantity.axes[0])
    return found.index(name) if name in found else None


def worst_section(record: Record) -> str | None:
    """The most loaded section, at the worst speed or at the operating one.

    Of shafts whose stress is known the most stressed one, else the one of the largest torque;
    where some speeds have no bound, at the operating speed.
    """
    for name in ("largest/stress_half_range", "largest/torque_half_range", "stress_half_range",
                 "torque_half_range"):  # fmt: skip
        load = vector(record, name, "section")
        if load is not None and 0.0 < np.max(load) < np.inf:
            return names(record, name, "section")[int(np.argmax(load))]
    return None


def joined(words: Iterable[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    found = list(words)
    return " and ".join([", ".join(found[:-1]), found[-1]] if len(found) > 1 else found)
