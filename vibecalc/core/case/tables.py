"""What a case is held against, references and limits; and whose document its report is."""

from collections.abc import Iterator
from typing import Any, Literal

from vibecalc.core.case.fields import (
    Labels,
    Name,
    Number,
    ResultAxis,
    ResultPath,
    Table,
    Value,
    Where,
    key,
)
from vibecalc.core.case.raw import get_key, is_value, tables_at
from vibecalc.core.case.rules import Row, at_most_one, needs, refuse, same_length
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import si_value, split_number


def _unit_twice(row: Row) -> bool:
    """Whether the unit stands in a value and as a key of its own."""
    values = row.entries("value") or [row["value"]]
    return bool(row["unit"]) and any(map(_has_unit, values))


def _has_unit(value: Any) -> bool:
    try:
        return isinstance(value, str) and bool(split_number(value)[1])
    except UnitError:
        return False


_UNIT_ONCE = refuse(
    "unit", "the unit is given twice", _unit_twice, found="{value} and unit = {unit}", also="value"
)


#: what stands under `optimisation/start/` in a result
_AT_START = refuse(
    "at",
    "only a search has a start, and there is no [optimisation]",
    lambda t: t["at"] == "start" and "optimisation" not in t.case,
    "at = 'optimum', or no at: that is the result of any case",
)


class Printed(Table):
    """Common keys of published or measured numbers."""

    quantity: ResultPath = key("result path")
    where: Where = key("selects one entry by named axes", default_factory=dict)
    unit: str = key("unit of the printed number, if not written with it", "")
    rtol: Number | None = key("relative tolerance", None, gt=0, lt=1)
    digits: Literal["rounded", "truncated"] = key(
        "truncated: a whole unit of the last digit is allowed, instead of half", "rounded"
    )
    source: Name = key("table, figure or page")
    kind: Literal["published", "measured"] = key(
        "measured numbers are shown but not counted", "published"
    )
    known_difference: str = key("reason for a difference; the number is then not counted", "")
    shown_by: str = key("test that reproduces the printed number, or 'not reproducible: ...'", "")
    at: Literal["start", "optimum"] = key("start or optimum of an [optimisation]", "optimum")
    uncertainty: Value | None = key(
        "standard uncertainty for [fit], in the unit of what is printed or in %; "
        "default: the tolerance over sqrt 3",
        None,
    )


class Reference(Printed):
    """A published or measured number for this machine, shown next to ours."""

    value: Value = key("as printed; its last digit sets the default tolerance")
    atol: Value | None = key("absolute tolerance, in the value's unit", None)
    RULES = (at_most_one("rtol", "atol"), _UNIT_ONCE, _AT_START)


def _numbers(row: Row) -> Iterator[Problem]:
    """Entries and their values stand in a file, or both here; a file is read elsewhere."""
    entries, values = row.entries("entry"), row.entries("value")
    lacking = [key for key in ("value", "entry") if key not in row]
    given = row.said("entry", "value")
    if row["file"] or "column" in row:
        return
    if lacking:
        yield row.problem(
            given[0] if given else "",
            f"{given[0]} without {lacking[0]}" if given else "the table has no values",
            allowed="a file, or entry and value",
        )
    elif len(entries) != len(values) or row["entry"] == []:
        yield row.problem(
            "value",
            "entry and value differ in length",
            found=f"{len(entries)} of entry and {len(values)} of value",
            allowed="the same number of each, at least one",
            also="entry",
        )


class ReferenceTable(Printed):
    """Published or measured numbers for many entries of one quantity, one per row."""

    axis: ResultAxis = key("axis of the rows; `where` selects along the others")
    file: str = key(
        "CSV next to the case with the entries in its first column, instead of entry and value", ""
    )
    column: str = key("column of the values in the file", "")
    entry: Labels = key("entries of the axis, one per value", ())
    value: tuple[Value, ...] = key(
        "as printed; last digits set the tolerance", (), max_length=20_000
    )
    uncertainty_column: str = key(
        "column of the uncertainties in the file, instead of uncertainty", ""
    )
    uncertainties: tuple[Value, ...] = key(
        "one per value, instead of uncertainty", (), max_length=20_000
    )
    RULES = (
        at_most_one("uncertainty", "uncertainty_column", "uncertainties"),
        same_length("value", "uncertainties"),
        needs("uncertainty_column", "file", allowed="file and column, or uncertainties"),
        needs("column", "file", allowed="file and column, or entry and value"),
        _numbers,
        _UNIT_ONCE,
        _AT_START,
    )


class Revision(Table):
    """A row of the revision history."""

    revision: str = key("letter or number")
    date: str = key("of issue", "")
    text: str = key("description of the change", "")


class Document(Table):
    """Title block of a report."""

    project: str = key("project name or number", "")
    customer: str = key("name of the customer", "")
    number: str = key("document number", "")
    revision: str = key("letter or number", "")
    date: str = key("of issue", "")
    author: str = key("prepared by", "")
    checked: str = key("checked by", "")
    approved: str = key("approved by", "")
    remarks: str = key("text below the summary", "")
    history: tuple[Revision, ...] = key("revisions, oldest first", (), max_length=50)


class Limit(Table):
    """A limit on a result; the optimiser observes it too."""

    quantity: ResultPath = key("result path")
    where: Where = key("selects entries by named axes", default_factory=dict)
    max: Value | None = key("upper limit, SI or with a unit", None)
    min: Value | None = key("lower limit, SI or with a unit", None)
    source: str = key("origin of the limit", "")
    expect: Literal["kept", "broken"] = key(
        "broken: the case demonstrates an exceeded limit", "kept"
    )
    at: Literal["start", "optimum"] = key("start or optimum of an [optimisation]", "optimum")
    RULES = (
        refuse(
            "",
            "a limit needs max or min",
            lambda t: t.lacks("max", "min"),
            'max = "100 N", or min, or both',
        ),
        _AT_START,
    )


def contradictions(row: Row) -> Iterator[Problem]:
    """Yield each pair of bounds on one quantity that no value can keep."""
    bounds: dict[str, dict[str, tuple[float, KeyPath]]] = {}
    for position, limit in tables_at(row.case, "limit"):
        if limit.get("expect") == "broken":
            continue
        where = limit.get("where")
        entries = sorted(map(repr, where.items())) if isinstance(where, dict) else []
        mine = bounds.setdefault(repr((limit.get("quantity"), entries, limit.get("at"))), {})
        for side, sign in (("max", 1.0), ("min", -1.0)):
            value = _si_value(limit.get(side))
            if value is not None and (side not in mine or sign * value < sign * mine[side][0]):
                mine[side] = (value, ("limit", position, side))
    for pair in bounds.values():
        if len(pair) == 2 and pair["min"][0] > pair["max"][0]:
            low, high = (repr(get_key(row.case, pair[side][1]))[:60] for side in ("min", "max"))
            first, second = sorted((pair["min"][1], pair["max"][1]), key=lambda path: path[1])
            yield row.problem(
                second,
                "the bounds contradict each other: no value can satisfy both",
                found=f"min = {low} and max = {high}",
                allowed="min <= max",
                also=first,
            )


def _si_value(value: Any) -> float | None:
    try:
        return si_value(value) if is_value(value) else None
    except UnitError:
        return None
