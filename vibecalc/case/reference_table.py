"""Rows of reference tables as single references."""

from vibecalc.case.schema import Case
from vibecalc.case.tables import Reference
from vibecalc.errors import KeyPath


def expand_references(case: Case) -> tuple[Case, dict[KeyPath, KeyPath]]:
    """The case with one reference for each row of its tables, and where those rows stand.

    The second result maps the key path of every reference made here to that of its table.
    """
    if not case.reference_table:
        return case, {}
    rows = list(case.reference)
    origins: dict[KeyPath, KeyPath] = {}
    for number, table in enumerate(case.reference_table):
        for entry, value in zip(table.entry, table.value, strict=True):
            origins["reference", len(rows)] = ("reference_table", number)
            rows.append(
                Reference(
                    quantity=table.quantity,
                    where={**table.where, table.axis: entry},
                    value=value,
                    unit=table.unit,
                    rtol=table.rtol,
                    digits=table.digits,
                    source=table.source,
                    kind=table.kind,
                    known_difference=table.known_difference,
                    shown_by=table.shown_by,
                    at=table.at,
                )
            )
    return case.model_copy(update={"reference": tuple(rows), "reference_table": ()}), origins
