"""A quantity as a notebook shows it: name, unit, axes and values in the unit that people read."""

from collections.abc import Callable
from html import escape
from typing import Any

import numpy as np

from vibecalc.core.report.html import html_blocks
from vibecalc.core.report.sections import read_as, written
from vibecalc.core.report.writing import Column, number, table
from vibecalc.core.results.record import Axis, Quantity
from vibecalc.units import convert

#: rows and columns of a small table
_ROWS, _COLUMNS = 8, 6


def quantity_html(quantity: Quantity) -> str:
    """A heading and a table of at most eight rows and six columns."""
    unit = read_as(quantity.path, quantity.unit)[1]
    text = written(quantity, unit)
    over = ", ".join(f"{axis.name} ({len(axis.values)})" for axis in quantity.axes)
    head = f"<b>{escape(quantity.path)}</b> {escape(quantity.long_name)}"
    head += f", in {escape(unit)}" * bool(unit) + f", over {escape(over)}" * bool(over)
    if not quantity.axes:
        return f"<div>{head}<br>{escape(text(quantity.values.item()))} {escape(unit)}</div>"
    return f"<div>{head}{_table(quantity.values, quantity.axes, text)}</div>"


def _table(cells: np.ndarray, axes: tuple[Axis, ...], text: Callable[[Any], str]) -> str:
    """The last two axes down and across; of further ones the first entry."""
    while cells.ndim > 2:
        cells, axes = cells[0], axes[1:]
    heads = _entries(axes[1], _COLUMNS) if len(axes) > 1 else [""]
    rows = [
        [name, *map(text, np.atleast_1d(row)[:_COLUMNS].tolist())]
        for name, row in zip(_entries(axes[0], _ROWS), cells, strict=False)
    ]
    if len(cells) > _ROWS or (len(axes) > 1 and len(axes[1].values) > _COLUMNS):
        rows.append(["...", *[""] * len(heads)])
    over = Column(" / ".join(one.name for one in axes))
    return "".join(html_blocks(table([over, *map(number, heads)], rows)))


def _entries(axis: Axis, most: int) -> list[str]:
    """The first entries of an axis, speeds in rpm and angles in deg."""
    unit = read_as(axis.name, axis.unit)[1]
    factor = convert(1.0, axis.unit, unit) if unit != axis.unit else 1.0
    return [f"{one * factor:.5g} {unit}".strip() if isinstance(one, float) else str(one)
            for one in axis.values[:most].tolist()]  # fmt: skip
