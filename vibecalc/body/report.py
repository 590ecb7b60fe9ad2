"""The section of a body that is assembled of parts."""

from vibecalc.body.results import OfParts
from vibecalc.core.report.rows import Cells, Rows, rows_of
from vibecalc.core.report.sections import Section, section, together
from vibecalc.core.results.record import Result

_TABLES = {
    ("direction", "along or about"): (
        Cells("centre", "mass centre mm", "mm"),
        Cells("moments", "moment kg*m^2"),
    ),
    ("product", "pair"): (Cells("products", "product kg*m^2"),),
    ("principal", ""): (
        Cells("principal_moments", "principal moment kg*m^2"),
        Cells("principal_axes", "axis, {}"),
    ),
}


def body(result: Result) -> Section | None:
    """Centre and moments along the axes, products, principal moments with their axes."""
    tables = [
        rows_of(result.record, Rows(*of, columns, OfParts.ROOT, merge=True))
        for of, columns in _TABLES.items()
    ]
    title = "Body assembled from parts: inertia about the mass centre"
    return section(title, [together(*tables)], shown=[f"{OfParts.ROOT}/mass"])
