"""Forces and couples of the crank train on the body, order by order."""

import numpy as np

from vibecalc.report.lookup import labels, magnitudes
from vibecalc.report.numbers import show, show_phase
from vibecalc.report.sections.balance import balance
from vibecalc.report.sections.section import Section, scalars
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

_ROWS = 12
_KINDS = ("force", "couple")


def excitation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    lines, shown = _orders(record)
    peaks, peaked = _peaks(record)
    lines += peaks
    shown |= peaked
    single, singles = scalars(record, ["excitation/residual"])
    lines += ["", *single] if single else []
    sums, summed = balance(result)
    lines += sums
    shown |= singles | summed
    title = "Excitation: crank train on the body"
    return Section(title, lines, frozenset(shown)) if lines else None


def _orders(record: Record) -> tuple[list[str], set[str]]:
    rows, silent, shown, left_out = [], [], set(), 0
    for kind in _KINDS:
        quantity = record.quantities.get(f"excitation/{kind}")
        if quantity is None or [axis.name for axis in quantity.axes] != ["order", "direction"]:
            continue
        shown.add(quantity.path)
        orders, directions = (labels(axis) for axis in quantity.axes)
        error = quantity.error_estimate
        for j, direction in enumerate(directions):
            column = quantity.values[:, j]
            if not np.any(np.abs(column) > error):
                silent.append(f"{kind} {direction}")
                continue
            acting = [i for i in range(len(orders)) if abs(column[i]) > error]
            left_out += max(len(acting) - _ROWS, 0)
            rows += [
                [
                    f"{kind} {direction}",
                    orders[i],
                    show(abs(column[i]), error),
                    quantity.unit,
                    show_phase(complex(column[i]), error),
                ]
                for i in acting[:_ROWS]
            ]
    if not shown:
        return [], shown
    columns = (
        Column("component", 14),
        number("order", 6),
        number("amplitude", 14),
        Column("unit", 8),
        number("phase deg", 10),
    )
    lines = table(columns, rows) if rows else []
    if silent:
        lines += paragraph("zero at every order: " + ", ".join(silent))
    if left_out:
        lines += paragraph(f"{left_out} further entries of higher order are in the result file")
    return lines, shown


def _peaks(record: Record) -> tuple[list[str], set[str]]:
    rows, shown = [], set()
    for kind in _KINDS:
        quantity = record.quantities.get(f"excitation/{kind}_peak")
        if quantity is None or [axis.name for axis in quantity.axes] != ["direction"]:
            continue
        shown.add(quantity.path)
        values = magnitudes(quantity)
        cells = [show(value, quantity.error_estimate) for value in values]
        rows.append([kind, *[*cells, "", "", ""][:3], quantity.unit])
    if not rows:
        return [], shown
    columns = (
        Column("largest over a turn", 20),
        number("x", 14),
        number("y", 14),
        number("z", 14),
        Column("unit", 8),
    )
    return ["", *table(columns, rows)], shown
