"""Motion of the pistons: harmonics, what a truncation leaves out, extremes over a turn."""

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, first, others, rows_of
from vibecalc.core.report.sections import (
    Section,
    having,
    read_as,
    scalars,
    section,
    together,
    written,
)
from vibecalc.core.report.writing import number, show_phase, table
from vibecalc.core.results.record import Record, Result

_OF_ORDERS = (
    Cells("position_harmonics", "position mm", "mm"),
    Cells("position_harmonics", "phase deg", show_phase),
    Cells("acceleration_harmonics", "acceleration m/s^2", ""),
    Cells("acceleration_harmonics", "phase deg", show_phase),
)
_HARMONICS = Rows("order", "order", _OF_ORDERS, "kinematics", places=first(12),
                  rest=others("{left} more, up to order {last}, in the result file"))  # fmt: skip
_TURN = ("kinematics/position", "kinematics/velocity", "kinematics/acceleration")


def kinematics(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    dropped = scalars(record, ["kinematics/dropped_acceleration"])
    details = {"harmonics of the pistons": together(rows_of(record, _HARMONICS), dropped)}
    return section("Piston motion", [_extremes(record), rows_of(record, _CYLINDERS)], details)


#: strokes and dead centres, where slave rods make them differ
_ENDS = (
    Cells("stroke", "stroke mm", "mm"),
    Cells("top_dead_centre", "top dead centre at deg", "deg"),
    Cells("bottom_dead_centre", "bottom dead centre at deg", "deg"),
)
_CYLINDERS = Rows("cylinder", "cylinder", _ENDS, "kinematics/cylinder", merge=True)


def _extremes(record: Record) -> tuple[list[str], set[str]]:
    rows, shown = [], set()
    for path in _TURN:
        quantity = having(record, path, "crank_angle")
        if quantity is None:
            continue
        name, unit = read_as(path, quantity.unit)
        cells, write = [name], written(quantity, unit)
        for i in (int(np.argmin(quantity.values)), int(np.argmax(quantity.values))):
            cells.append(write(quantity.values[i]))
            cells.append(f"{np.degrees(quantity.axes[0].values[i]):.1f}")
        rows.append([*cells, unit])
        shown.add(path)
    heads = map(number, ("minimum", "at deg", "maximum", "at deg"))
    return table(("extremes over a turn, sampled", *heads, "unit"), rows), shown
