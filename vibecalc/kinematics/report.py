"""Motion of the pistons: harmonics, what a truncation leaves out, extremes over a turn."""

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, first, others, rows_of
from vibecalc.core.report.sections import (
    Section,
    along,
    read_as,
    scalars,
    section,
    together,
)
from vibecalc.core.report.writing import Column, number, show, show_phase, table
from vibecalc.core.results.record import Record, Result
from vibecalc.units import convert

_HARMONICS = Rows(
    "order",
    "order",
    (
        Cells("position_harmonics", "position mm", "mm"),
        Cells("position_harmonics", "phase deg", show_phase),
        Cells("acceleration_harmonics", "acceleration m/s^2", ""),
        Cells("acceleration_harmonics", "phase deg", show_phase),
    ),
    root="kinematics",
    places=first(12),
    rest=others("{left} more, up to order {last}, in the result file"),
)
_TURN = ("kinematics/position", "kinematics/velocity", "kinematics/acceleration")


def kinematics(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    dropped = scalars(record, ["kinematics/dropped_acceleration"])
    details = {"harmonics of the pistons": together(rows_of(record, _HARMONICS), dropped)}
    return section("Piston motion", [_extremes(record), rows_of(record, _CYLINDERS)], details)


#: strokes and dead centres, where slave rods make them differ
_CYLINDERS = Rows(
    "cylinder",
    "cylinder",
    (
        Cells("stroke", "stroke mm", "mm"),
        Cells("top_dead_centre", "top dead centre at deg", "deg"),
        Cells("bottom_dead_centre", "bottom dead centre at deg", "deg"),
    ),
    root="kinematics/cylinder",
    merge=True,
)


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
        Column("over one turn, as sampled"),
        number("minimum"),
        number("at deg"),
        number("maximum"),
        number("at deg"),
        Column("unit"),
    ]
    return table(columns, rows), shown
