"""What a section of the report is: a title, its lines, and the results it has shown."""

from collections.abc import Iterable
from typing import NamedTuple

from vibecalc.pipeline.tolerance import UNRESOLVED
from vibecalc.report.lookup import magnitudes
from vibecalc.report.numbers import also, show
from vibecalc.report.tables import Column, number, table
from vibecalc.results.record import Quantity, Record


class Section(NamedTuple):
    """A titled part of the report; `shown` holds the paths that need no generic line any more."""

    title: str
    lines: list[str]
    shown: frozenset[str]


SCALARS = (Column("quantity", 40), number("value", 13), Column("unit", 10), Column("also", 32))


def scalar_rows(quantities: Iterable[Quantity], prefix: str = "") -> list[list[str]]:
    """Rows for `SCALARS`: path (without `prefix`), value, unit, and the same as rpm or Hz."""
    rows = []
    for quantity in quantities:
        value = magnitudes(quantity)[()]
        error = quantity.estimate
        kind = f"{quantity.amplitude}  " if quantity.amplitude else ""
        twin = also(quantity.path, float(value), quantity.unit, error)
        if error.unresolved(float(value)):
            twin = UNRESOLVED + (f", {twin}" if twin else "")
        name = quantity.path.removeprefix(prefix)
        rows.append([name, show(value, error), quantity.unit, kind + twin])
    return rows


def scalars(record: Record, paths: Iterable[str], prefix: str = "") -> tuple[list[str], set[str]]:
    """A table of those of `paths` that the record has as scalars, and which those were."""
    found = [record[path] for path in paths if path in record.quantities and not record[path].axes]
    if not found:
        return [], set()
    return table(SCALARS, scalar_rows(found, prefix)), {quantity.path for quantity in found}
