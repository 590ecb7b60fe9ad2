"""Motion of the pistons: harmonics, what a truncation leaves out, extremes over a turn."""

import numpy as np

from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    Section,
    along,
    read_as,
    scalars,
    section,
    together,
)
from vibecalc.core.report.writing import Column, number, paragraph, show, show_phase, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.units import convert

_ROWS = 12
_HARMONICS = ("kinematics/position_harmonics", "kinematics/acceleration_harmonics")
_TURN = ("kinematics/position", "kinematics/velocity", "kinematics/acceleration")


def kinematics(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    dropped = scalars(record, ["kinematics/dropped_acceleration"])
    details = {"harmonics of the pistons": together(_harmonics(record), dropped)}
    return section("Piston motion", [_extremes(record), _cylinders(record)], details)


_CYLINDERS = (
    ("kinematics/cylinder/stroke", "stroke", "mm"),
    ("kinematics/cylinder/top_dead_centre", "top dead centre at", "deg"),
    ("kinematics/cylinder/bottom_dead_centre", "bottom dead centre at", "deg"),
)


def _cylinders(record: Record) -> tuple[list[str], set[str]]:
    """Strokes and dead centres, where slave rods make them differ."""
    lines = by_axis(record, "cylinder", "cylinder", _CYLINDERS, 14, 26)
    return lines, {path for path, *_ in _CYLINDERS}


def _harmonics(record: Record) -> tuple[list[str], set[str]]:
    quantities = {path: hit for path in _HARMONICS if (hit := along(record, path, "order"))}
    if not quantities:
        return [], set()
    orders = sorted({int(order) for _, values in quantities.values() for order in values})
    columns = [Column("order", 6)]
    for path, (quantity, _) in quantities.items():
        word = path.rsplit("/", 1)[-1].removesuffix("_harmonics")
        unit = read_as(path, quantity.unit)[1]
        columns += [number(f"{word} {unit}", 20), number("phase deg", 10)]
    rows = []
    for order in orders[:_ROWS]:
        row = [str(order)]
        for quantity, values in quantities.values():
            row += _cells(quantity, values, order)
        rows.append(row)
    lines = table(columns, rows)
    if len(orders) > _ROWS:
        lines += paragraph(
            f"{len(orders) - _ROWS} more, up to order {orders[-1]}, in the result file"
        )
    return lines, set(quantities)


def _cells(quantity: Quantity, orders: np.ndarray, order: int) -> list[str]:
    here = np.flatnonzero(orders == order)
    if here.size == 0:
        return ["", ""]
    value = complex(quantity.values[here[0]])
    error = quantity.error_estimate
    factor = convert(1.0, quantity.unit, read_as(quantity.path, quantity.unit)[1])
    return [show(abs(value) * factor, error * factor), show_phase(value, error)]


def _extremes(record: Record) -> tuple[list[str], set[str]]:
    rows, shown = [], set()
    for path in _TURN:
        hit = along(record, path, "crank_angle")
        if hit is None:
            continue
        quantity, angle = hit
        low, high = int(np.argmin(quantity.values)), int(np.argmax(quantity.values))
        name, unit = read_as(path, quantity.unit)
        factor = convert(1.0, quantity.unit, unit)
        cells = [name]
        for i in (low, high):
            cells += [show(quantity.values[i] * factor, quantity.error_estimate * factor)]
            cells += [f"{np.degrees(angle[i]):.1f}"]
        rows.append([*cells, unit])
        shown.add(path)
    if not rows:
        return [], set()
    columns = [
        Column("over one turn, as sampled", 28),
        number("minimum", 13),
        number("at deg", 8),
        number("maximum", 13),
        number("at deg", 8),
        Column("unit", 8),
    ]
    return table(columns, rows), shown
