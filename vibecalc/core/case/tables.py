"""What a case is held against, references and limits; and whose document its report is."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from vibecalc.core.case.fields import Labels, Name, Number, ResultPath, Table, Value, Where
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
    "unit", "the unit stands twice", _unit_twice, found="{value} and unit = {unit}", also="value"
)


#: what stands under `optimisation/start/` in a result
_AT_START = refuse(
    "at",
    "only a search has a start, and there is no [optimisation]",
    lambda t: t["at"] == "start" and "optimisation" not in t.case,
    "at = 'optimum', or no at: that is the result of any case",
)


class Printed(Table):
    """What a published or measured number and a table of such numbers have in common."""

    quantity: ResultPath = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks one entry along named axes")
    unit: str = Field("", description="unit of what is printed, if that does not carry it")
    rtol: Number | None = Field(None, gt=0, lt=1, description="relative tolerance")
    digits: Literal["rounded", "truncated"] = Field(
        "rounded", description="truncated: within a whole unit of the last digit, not half of one"
    )
    source: Name = Field(description="table, figure or page")
    kind: Literal["published", "measured"] = Field(
        "published", description="measured numbers are shown and never counted"
    )
    known_difference: str = Field("", description="why the source differs; then it is not counted")
    shown_by: str = Field(
        "", description="test that reproduces what is printed, or 'not reproducible: ...'"
    )
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")
    uncertainty: Value | None = Field(
        None,
        description="standard uncertainty for [fit], in the unit of what is printed or in %; "
        "default: the tolerance over sqrt 3",
    )


class Reference(Printed):
    """A published or measured number for this machine, shown next to ours."""

    value: Value = Field(description="as printed: its last digit sets the default tolerance")
    atol: Value | None = Field(None, description="absolute tolerance, in the value's unit")
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
            f"{given[0]} without {lacking[0]}" if given else "a table without numbers",
            allowed="a file, or entry and value",
        )
    elif len(entries) != len(values) or row["entry"] == []:
        yield row.problem(
            "value",
            "each entry has one value",
            found=f"{len(entries)} of entry and {len(values)} of value",
            allowed="as many of the one as of the other, at least one",
            also="entry",
        )


class ReferenceTable(Printed):
    """Published or measured numbers for many entries of one quantity, one row for each."""

    axis: Name = Field(description="axis that the rows pick entries of; `where` is of the others")
    file: str = Field(
        "", description="CSV next to the case, its first column entries; instead of entry and value"
    )
    column: str = Field("", description="name of the file's column that holds the values")
    entry: Labels = Field((), description="entries of the axis, one for each value")
    value: Annotated[tuple[Value, ...], Field(max_length=20_000)] = Field(
        (), description="as printed: last digits set the tolerance"
    )
    uncertainty_column: str = Field(
        "", description="name of the file's column that holds uncertainties, instead"
    )
    uncertainties: Annotated[tuple[Value, ...], Field(max_length=20_000)] = Field(
        (), description="one for each value, instead"
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
    """A row of the history."""

    revision: str = Field(description="letter or number")
    date: str = Field("", description="of issue")
    text: str = Field("", description="what has changed")


class Document(Table):
    """Title block of a report."""

    project: str = Field("", description="name or number")
    customer: str = Field("", description="made for")
    number: str = Field("", description="of the document")
    revision: str = Field("", description="letter or number")
    date: str = Field("", description="of issue")
    author: str = Field("", description="made by")
    checked: str = Field("", description="by")
    approved: str = Field("", description="by")
    remarks: str = Field("", description="below the summary")
    history: Annotated[tuple[Revision, ...], Field(max_length=50)] = Field(
        (), description="oldest first"
    )


class Limit(Table):
    """A bound that a result has to keep; the optimiser takes the same list."""

    quantity: ResultPath = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks entries along named axes")
    max: Value | None = Field(None, description="upper bound, SI or with a unit")
    min: Value | None = Field(None, description="lower bound, SI or with a unit")
    source: str = Field("", description="where the bound comes from")
    expect: Literal["kept", "broken"] = Field("kept", description="broken: for a demonstration")
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")
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
        for key, sign in (("max", 1.0), ("min", -1.0)):
            value = _si_value(limit.get(key))
            if value is not None and (key not in mine or sign * value < sign * mine[key][0]):
                mine[key] = (value, ("limit", position, key))
    for pair in bounds.values():
        if len(pair) == 2 and pair["min"][0] > pair["max"][0]:
            low, high = (repr(get_key(row.case, pair[key][1]))[:60] for key in ("min", "max"))
            first, second = sorted((pair["min"][1], pair["max"][1]), key=lambda path: path[1])
            yield row.problem(
                second,
                "two bounds contradict each other: no value can keep both",
                found=f"min = {low} and max = {high}",
                allowed="min <= max",
                also=first,
            )


def _si_value(value: Any) -> float | None:
    try:
        return si_value(value) if is_value(value) else None
    except UnitError:
        return None
