"""Tables of quantities that share one axis: a row for each entry, a column for each quantity."""

from collections.abc import Sequence

import numpy as np

from vibecalc.report.lookup import having, labels, magnitudes
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, table
from vibecalc.results.record import Record


def by_axis(
    record: Record, axis: str, title: str, names: Sequence[tuple[str, str]], width: int = 22,
    each: int = 14, digits: int = 6, factors: Sequence[float] | None = None,
    blank: str = "",
) -> list[str]:  # fmt: skip
    """Lines of a table of the quantities `names` (path, words) over `axis`; [] if there are none.

    `factors` turn the SI of each into the unit that its words say. Of the quantity `blank` an
    infinite entry is none, shown as "-".
    """
    scale = factors or [1.0] * len(names)
    found = [
        (quantity, words, factor)
        for (path, words), factor in zip(names, scale, strict=True)
        if (quantity := having(record, path, axis)) is not None
    ]
    if not found:
        return []
    columns = [Column(title, width), *(number(words, each) for _, words, _ in found)]
    rows = []
    for place, label in enumerate(labels(found[0][0].axes[0])):
        row = [label]
        for quantity, _, factor in found:
            value = float(magnitudes(quantity)[place]) * factor
            if quantity.path == blank and not np.isfinite(value):
                row.append("-")
                continue
            row.append(show(value, factor * quantity.error_estimate, digits))
        rows.append(row)
    return table(columns, rows)


def entry_of(record: Record, path: str, **where: str) -> float | None:
    """One real entry by the labels of its axes; None if the record does not have it."""
    quantity = record.quantities.get(path)
    if quantity is None or set(where) != {axis.name for axis in quantity.axes}:
        return None
    places = []
    for axis in quantity.axes:
        hits = np.flatnonzero(np.array(labels(axis)) == where[axis.name])
        if not hits.size:
            return None
        places.append(int(hits[0]))
    return float(magnitudes(quantity)[tuple(places)])
