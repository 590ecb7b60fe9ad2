"""Smallest and largest value of every result of a sweep, and where they are."""

import numpy as np

from vibecalc.report.numbers import show
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.sweep.worst import Worst, numeric, worst
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity

_COLUMNS = (
    Column("quantity", 39),
    Column("", 8),
    number("value", 12),
    Column("unit", 7),
    Column("at", 28),
)


def extreme_lines(sweep: SweepView) -> list[str]:
    """A table with two rows for each result: its smallest and its largest value.

    Of several entries at a point the largest one counts, but each order of a level has rows of its
    own. What is the same at all points has one
    row; infinite values are counted below the table.
    """
    rows: list[list[str]] = []
    unbounded: list[str] = []
    for path in numeric(sweep):
        counted = worst(sweep, path)
        orders = _orders(sweep.kept[path])
        for place, order in enumerate(orders):
            name = f"  order={order}" if place else f"{path}\n  order={order}"
            rows += _rows(sweep, path, worst(sweep, path, {"order": order}), name)
        if not orders:
            rows += _rows(sweep, path, counted, path)
        infinite = int(np.count_nonzero(np.isinf(counted.values)))
        if infinite:
            finite = np.isfinite(counted.values)
            most = show(np.max(counted.values[finite])) if finite.any() else "none"
            unit = sweep.kept[path].unit
            unbounded.append(
                f"{path} is unbounded at {infinite} points; the largest finite value is "
                f"{most} {unit}".rstrip()
            )
    if not rows:
        return []
    return [*table(_COLUMNS, rows), *(line for words in unbounded for line in paragraph(words))]


def first_of(values: np.ndarray, errors: np.ndarray, side: str) -> int:
    """The point of the largest ("max") or smallest value; of equal ones, within errors, the first.

    NaN does not count; ValueError if there is nothing else.
    """
    known = ~np.isnan(values)
    if not known.any():
        raise ValueError("there is no value to choose from")
    signed = np.where(known, values if side == "max" else -values, -np.inf)
    top = signed.max()
    if not np.isfinite(top):
        return int(np.argmax(known & (signed == top)))
    slack = np.where(np.isfinite(errors), errors, 0.0)
    at = int(np.argmax(signed))
    return int(np.argmax(known & (signed >= top - slack - slack[at])))


def _orders(quantity: Quantity) -> list[int]:
    """Orders of a level: one may fall far below another, and each has its own best place."""
    if quantity.unit != "dB":
        return []
    return [int(n) for axis in quantity.axes if axis.name == "order" for n in axis.values]


def _rows(sweep: SweepView, path: str, counted: Worst, name: str) -> list[list[str]]:
    unit = sweep.kept[path].unit
    if np.all(np.isnan(counted.values)):
        return [[name, "", "none", unit, "no point was computed"]]
    low, high = (first_of(counted.values, counted.errors, side) for side in ("min", "max"))
    if low == high:
        label = counted.label(low)
        everywhere = "at all points" + (f"\n({label})" if label and label not in name else "")
        return [[name, "constant", _value(counted, low), unit, everywhere]]
    return [
        [name, "smallest", _value(counted, low), unit, _place(sweep, counted, low, name)],
        ["", "largest", _value(counted, high), unit, _place(sweep, counted, high, name)],
    ]


def _value(counted: Worst, point: int) -> str:
    return show(counted.values[point], counted.estimate(point))


def _place(sweep: SweepView, counted: Worst, point: int, name: str) -> str:
    words = sweep.words_of(point).replace(", ", "\n")
    label = counted.label(point)
    return f"{words}\n({label})" if label and label not in name else words
