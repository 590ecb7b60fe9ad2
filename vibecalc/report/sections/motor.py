"""Axial force of the motor's skewed conductors: its largest orders, and what they add up to."""

import numpy as np

from vibecalc.report.lookup import along
from vibecalc.report.numbers import show, show_phase
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import number, paragraph, table
from vibecalc.results.record import Record, Result

_ROWS = 8
_FOLDER = "excitation/motor/"
_SCALARS = tuple(_FOLDER + name for name in ("mean_force", "sum_of_amplitudes", "peak", "rms"))


def motor(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    lines, shown = _orders(result.record)
    single, singles = scalars(result.record, _SCALARS, _FOLDER)
    if single:
        lines += [""] * bool(lines) + single
        lines += paragraph(
            "The sum of amplitudes is a bound: no turn reaches it unless all orders peak at once. "
            "Where rotor and stator sit on one body the force loads the bearing and does not shake "
            "the body."
        )
    title = "Motor: axial force of skewed conductors"
    return Section(title, lines, frozenset(shown | singles)) if lines else None


def _orders(record: Record) -> tuple[list[str], set[str]]:
    hit = along(record, _FOLDER + "axial_force", "order")
    if hit is None:
        return [], set()
    quantity, orders = hit
    values, error = np.asarray(quantity.values), quantity.error_estimate
    acting = np.flatnonzero(np.abs(values) > error)
    largest = acting[np.argsort(-np.abs(values[acting]), kind="stable")][:_ROWS]
    rows = [
        [
            str(int(orders[i])),
            show(abs(values[i]), error),
            quantity.unit,
            show_phase(complex(values[i]), error),
        ]
        for i in largest
    ]
    columns = (number("order", 14), number("amplitude", 14), number("unit", 8), number("phase deg"))
    lines = table(columns, rows) if rows else paragraph("zero at every order")
    if len(acting) > len(rows):
        lines += paragraph(
            f"the {len(rows)} largest; {len(acting) - len(rows)} further orders are in the result "
            "file"
        )
    return lines, {quantity.path}
