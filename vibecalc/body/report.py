"""The section of a body that is assembled of parts."""

from vibecalc.body.results import ROOT
from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import Section, section
from vibecalc.core.report.writing import number, show, table
from vibecalc.core.results.record import Result


def body(result: Result) -> Section | None:
    """Centre and moments along the axes, products, principal moments with their axes."""
    record = result.record
    if f"{ROOT}/moments" not in record:
        return None
    along = (
        (f"{ROOT}/centre", "mass centre", "mm"),
        (f"{ROOT}/moments", "moment", "kg*m^2"),
    )
    lines = by_axis(record, "direction", "along or about", along)
    lines += ["", *by_axis(record, "product", "pair", ((f"{ROOT}/products", "product", "kg*m^2"),))]
    principal, axes = record[f"{ROOT}/principal_moments"], record[f"{ROOT}/principal_axes"]
    rows = [
        [
            show(float(principal.values[i]), principal.error_estimate),
            *(show(float(entry), axes.error_estimate) for entry in axes.values[i]),
        ]
        for i in range(len(principal.values))
    ]
    columns = (
        number("principal moment kg*m^2", 26),
        *(number(f"axis, {one}", 12) for one in "xyz"),
    )
    lines += ["", *table(columns, rows)]
    shown = {path for path in record if path.startswith(f"{ROOT}/")}
    return section("Body: its parts together, moments about the mass centre", [(lines, shown)])
