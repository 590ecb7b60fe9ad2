"""Found values: what was changed, to what, and the result that this brings."""

from collections.abc import Mapping
from typing import Any

from vibecalc.errors import ResultError
from vibecalc.report.lookup import entries, name_of
from vibecalc.report.numbers import show
from vibecalc.report.sections.key_start import bound_unit, in_unit
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Result
from vibecalc.results.select import worst
from vibecalc.units import convert

PREFIX = "find/"
_DIGITS = 5
_COLUMNS = (
    Column("name", 13),
    Column("key", 23),
    number("written", 10),
    number("found", 10),
    Column("unit", 6),
    number("ratio", 8),
    number("reached", 10),
    number("wanted", 11),
)
_MOST = 8
_MACHINE, _COUNTS = "machine/", "/evaluations"


def find(result: Result) -> Section | None:
    """The section, None if the case searches for nothing."""
    own = [path for path in result.record if path.startswith(PREFIX)]
    rows, below, missing = [], list[str](), list[str]()
    machines: list[str] = []
    for search in entries(result, "find"):
        found = _found(result, search)
        if "value" in found:
            rows.append(_row(search, found))
            below += paragraph(_words(result, search, found), "-")
            machines += _machine(result, search, found)
        else:
            missing.append(str(search["name"]))
    if not rows:
        return None
    if missing:
        below += paragraph(f"nothing found for {', '.join(missing)}: see the warnings", "-")
    below += paragraph("all other sections show the case as written", "-")
    lines = [*table(_COLUMNS, rows), "", *below, *machines]
    return Section("Found values", lines, frozenset(own))


def _machine(result: Result, search: Mapping[str, Any], found: Mapping[str, Quantity]) -> list[str]:
    """What else is not as written in the machine found, by its numbers."""
    rows = []
    for name, quantity in found.items():
        path = name.removeprefix(_MACHINE)
        before = result.record.quantities.get(path)
        if path == name or before is None or before.axes or path.endswith(_COUNTS):
            continue
        written, error = before.values[()], quantity.error_estimate
        if abs(quantity.values[()] - written) > error + before.error_estimate:
            rows.append(
                [
                    path,
                    show(written, before.error_estimate, _DIGITS),
                    show(quantity.values[()], error, _DIGITS),
                    quantity.unit,
                ]
            )
    if not rows:
        return []
    head = Column(f"with {search['name']}", 50)
    return ["", *table((head, number("written"), number("found"), Column("unit", 10)), rows)]


def _found(result: Result, search: Mapping[str, Any]) -> dict[str, Quantity]:
    """What was found, by the last part of its path."""
    root = f"{PREFIX}{search['name']}/"
    return {
        path.removeprefix(root): quantity
        for path, quantity in result.record.items()
        if path.startswith(root)
    }


def _row(search: Mapping[str, Any], found: Mapping[str, Quantity]) -> list[str]:
    unit = bound_unit(search, found["value"].unit)
    return [
        str(search["name"]),
        str(search["key"]),
        show(*in_unit(found["written"], unit), _DIGITS) if "written" in found else "-",
        show(*in_unit(found["value"], unit), _DIGITS),
        unit,
        _number(found, "ratio"),
        _number(found, "reached"),
        str(search["seek"]) if search.get("seek") else _number(found, "wanted"),
    ]


def _words(result: Result, search: Mapping[str, Any], found: Mapping[str, Quantity]) -> str:
    where = dict(search.get("where") or {})
    path, key = str(search["quantity"]), str(search["key"])
    words = name_of(path, where)
    words += f": {_number(found, 'reached')} {found['reached'].unit}".rstrip()
    unit = bound_unit(search, found["value"].unit)
    words += f" with {key} = {show(*in_unit(found['value'], unit), _DIGITS)} {unit}".rstrip()
    words += _written(result, path, where)
    if search.get("change") is not None:
        words += f"; wanted: a change of {search['change']}"
    if search.get("also"):
        also = (
            f"{one} = {_number(found, f'also/{one}')} {found[f'also/{one}'].unit}"
            for one in search["also"]
        )
        words += f"; in the same ratio: {', '.join(also)}"
    others = found.get("others")
    if others is not None and others.values.size:
        values = (convert(float(other), others.unit, unit) for other in others.values[:_MOST])
        shown = ", ".join(show(other, digits=_DIGITS) for other in values)
        more = f" and {others.values.size - _MOST} more" if others.values.size > _MOST else ""
        what = "further extremes" if search.get("seek") else "further solutions"
        words += f"; {what} at {shown}{more} {unit}".rstrip()
    return words


def _written(result: Result, path: str, where: Mapping[str, Any]) -> str:
    quantity = result.record.quantities.get(path)
    if quantity is None:
        return ""
    try:
        value, _ = worst(quantity, where, "max")
    except ResultError:
        return ""
    shown = show(value, quantity.error_estimate, _DIGITS)
    return f"; as written {shown} {quantity.unit}".rstrip()


def _number(found: Mapping[str, Quantity], name: str) -> str:
    quantity = found.get(name)
    if quantity is None:
        return "-"
    return show(quantity.values[()], quantity.error_estimate, _DIGITS)
