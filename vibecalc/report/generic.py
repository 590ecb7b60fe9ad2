"""Tables for quantities that no section knows: new results show up without changes here."""

from collections.abc import Sequence

import numpy as np

from vibecalc.report.lookup import labels, magnitudes
from vibecalc.report.numbers import show
from vibecalc.report.sections.section import SCALARS, scalar_rows
from vibecalc.report.tables import WIDTH, Column, number, table
from vibecalc.results.record import Axis, Quantity

#: Longer arrays belong into pictures and the result file.
LONGEST = 24
_COLUMN = 15
_PER_TABLE = (WIDTH - 2 - 22) // (_COLUMN + 1)


def grouped(quantities: Sequence[Quantity], prefix: str = "") -> list[str]:
    """Scalars in one table, then one table for each axis that short vectors share.

    What is longer than `LONGEST` or has more axes is left out; `prefix` is cut from the paths.
    """
    scalars = [quantity for quantity in quantities if not quantity.axes]
    lines = table(SCALARS, scalar_rows(scalars, prefix)) if scalars else []
    vectors: dict[tuple[str, tuple[str, ...]], list[Quantity]] = {}
    for quantity in quantities:
        if len(quantity.axes) == 1 and 0 < np.size(quantity.values) <= LONGEST:
            axis = quantity.axes[0]
            vectors.setdefault((axis.name, tuple(labels(axis))), []).append(quantity)
    for members in vectors.values():
        for first in range(0, len(members), _PER_TABLE):
            lines += [""] if lines else []
            lines += _vectors(members[0].axes[0], members[first : first + _PER_TABLE], prefix)
    return lines


def _vectors(axis: Axis, members: Sequence[Quantity], prefix: str) -> list[str]:
    head = f"{axis.name} {axis.unit}".rstrip()
    columns = [Column(head, 22)]
    columns += [
        number(f"{quantity.path.removeprefix(prefix)} {quantity.unit}".rstrip(), _COLUMN)
        for quantity in members
    ]
    rows = []
    for i, label in enumerate(labels(axis)):
        cells = [_cell(quantity, i) for quantity in members]
        rows.append([label, *cells])
    return table(columns, rows)


def _cell(quantity: Quantity, i: int) -> str:
    values = magnitudes(quantity)
    if values.dtype.kind not in "biuf":
        return str(values[i])
    return show(values[i], quantity.error_estimate)
