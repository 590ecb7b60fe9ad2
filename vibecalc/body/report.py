"""The section of a body that is assembled of parts."""

from vibecalc.body.results import OfParts
from vibecalc.core.report.rows import Cells, Rows, by_axis, rows_of
from vibecalc.core.report.sections import Section, section
from vibecalc.core.results.record import Result

_PRINCIPAL = Rows(
    "principal",
    "",
    (
        Cells("principal_moments", "principal moment kg*m^2", "", 26),
        Cells("principal_axes", "axis, {}", "", 12),
    ),
    root=OfParts.ROOT,
)


def body(result: Result) -> Section | None:
    """Centre and moments along the axes, products, principal moments with their axes."""
    record = result.record
    if f"{OfParts.ROOT}/moments" not in record:
        return None
    along = (
        (f"{OfParts.ROOT}/centre", "mass centre", "mm"),
        (f"{OfParts.ROOT}/moments", "moment", "kg*m^2"),
    )
    lines = by_axis(record, "direction", "along or about", along)
    products = ((f"{OfParts.ROOT}/products", "product", "kg*m^2"),)
    lines += ["", *by_axis(record, "product", "pair", products)]
    lines += ["", *rows_of(record, _PRINCIPAL)[0]]
    shown = {path for path in record if path.startswith(f"{OfParts.ROOT}/")}
    return section("Body: its parts together, moments about the mass centre", [(lines, shown)])
