"""A quantity as a notebook shows it: name, unit, axes and values in the unit that people read."""

from html import escape
from itertools import islice
from typing import Any

import numpy as np

from vibecalc.core.report.sections import read_as
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.errors import UnitError
from vibecalc.units import convert

#: rows and columns of a small table
_ROWS, _COLUMNS = 8, 6


def quantity_html(quantity: Quantity) -> str:
    """A heading and a table of at most eight rows and six columns."""
    _, unit = read_as(quantity.path, quantity.unit)
    try:
        factor = convert(1.0, quantity.unit, unit)
    except UnitError:
        factor, unit = 1.0, quantity.unit
    values = np.asarray(quantity.values)
    error = quantity.estimate * factor
    cells = values * factor if values.dtype.kind in "iufc" else values
    over = ", ".join(f"{axis.name} ({len(axis.values)})" for axis in quantity.axes)
    head = f"<b>{escape(quantity.path)}</b> {escape(quantity.long_name)}"
    head += f", in {escape(unit)}" * bool(unit) + f", over {escape(over)}" * bool(over)
    if not quantity.axes:
        return f"<div>{head}<br>{escape(_shown(cells.item(), error))} {escape(unit)}</div>"
    return f"<div>{head}{_table(cells, quantity.axes, error)}</div>"


def _table(cells: np.ndarray, axes: tuple[Axis, ...], error: Any) -> str:
    """The last two axes down and across; of further ones the first entry."""
    while cells.ndim > 2:
        cells, axes = cells[0], axes[1:]
    down, across = axes[0], axes[1] if len(axes) > 1 else None
    rows = []
    if across is not None:
        rows.append(["", *_entries(across, _COLUMNS)])
    names = _entries(down, _ROWS)
    for name, row in zip(names, cells, strict=False):
        entries = islice(np.atleast_1d(row).tolist(), _COLUMNS)
        rows.append([name, *(_shown(one, error) for one in entries)])
    if len(cells) > _ROWS or (across is not None and len(across.values) > _COLUMNS):
        rows.append(["..."])
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows
    )
    return f"<table><caption>{escape(' / '.join(one.name for one in axes))}</caption>{body}</table>"


def _entries(axis: Axis, most: int) -> list[str]:
    """The first entries of an axis, speeds in rpm and angles in deg."""
    _, unit = read_as(axis.name, axis.unit)
    try:
        factor = convert(1.0, axis.unit, unit) if axis.unit else 1.0
    except UnitError:
        factor, unit = 1.0, axis.unit
    values = [one * factor if isinstance(one, float) else one for one in axis.values.tolist()]
    return [f"{one:.5g} {unit}".strip() if isinstance(one, float) else str(one)
            for one in values[:most]]  # fmt: skip


def _shown(value: Any, error: Any) -> str:
    return show(value, error) if isinstance(value, int | float | complex) else str(value)
