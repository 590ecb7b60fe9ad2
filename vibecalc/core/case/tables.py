"""Tables that any case may have: accuracy, references, limits, optimisation, searches, sweeps."""

import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from vibecalc.core.case.choice_tables import Robust, Stock
from vibecalc.core.case.fields import Labels, Name, Number, Table, Value, Where
from vibecalc.core.case.raw import get_key, tables_at
from vibecalc.core.case.rules import (
    Row,
    at_most_one,
    needs,
    no,
    one_of,
    refuse,
    same_length,
    unique,
)
from vibecalc.errors import KeyPath, Problem, UnitError
from vibecalc.units import si_value, split_number

# ----------------------------------------------------------------------------
# The tables of a case next to the machine: what is asked of it, and against what it is held.
# ----------------------------------------------------------------------------

SearchMethod = Literal[
    "sequential_quadratic", "hooke_jeeves", "nelder_mead", "differential_evolution"
]


class TiedKey(Table):
    """A key that follows a variable: factor times its value, plus an offset."""

    key: Name = Field(description="the key that follows")
    factor: Number = Field(1.0, description="times the value of the variable")
    offset: Value | None = Field(None, description="added to that, SI or with a unit; default: 0")


class Variable(Table):
    """One key of the case that the optimiser may change, with the keys that follow it."""

    key: Name = Field(description="as in machine.mounts.each.stiffness or ...cylinders[0].position")
    lower: Value | None = Field(None, description="lower bound, SI or with a unit")
    upper: Value | None = Field(None, description="upper bound, SI or with a unit")
    integer: bool | None = Field(
        None, strict=True, description="whole numbers between the bounds only"
    )
    choices: Labels = Field(
        (), description="the values that it may take, instead of bounds: SI, with a unit, or names"
    )
    follow: tuple[TiedKey, ...] = Field(
        (),
        alias="with",
        max_length=32,
        description="keys that follow it: each factor times its value, plus offset",
    )
    RULES = (
        one_of("lower upper", "choices"),
        needs("lower", "upper"),
        needs("upper", "lower"),
        at_most_one("integer", "choices"),
    )

    @property
    def moves(self) -> bool:
        """Whether it takes any value between its bounds."""
        return not (self.choices or self.integer)


class Objective(Table):
    """The quantity to make small or large; on an array its worst entry counts."""

    quantity: Name = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks entries along named axes")
    sense: Literal["min", "max"] = Field("min", description="make it small or large")


class Optimisation(Table):
    """Change some keys within bounds until the objective is best and all limits are kept."""

    variables: tuple[Variable, ...] = Field((), max_length=32, description="what to change")
    stock: tuple[Stock, ...] = Field(
        (), max_length=8, description="things of which one is picked, each several keys together"
    )
    robust: Robust | None = Field(
        None, description="improve the mean plus some deviations over tolerances of keys"
    )
    objective: Objective = Field(description="what to improve")
    starts: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        8, description="starting points spread over the bounds, besides the case as written"
    )
    method: SearchMethod | None = Field(
        None,
        description="what searches from each start, before the end is refined; "
        "default: sequential_quadratic",
    )
    compare: tuple[SearchMethod, ...] = Field(
        (),
        max_length=8,
        description="methods to run side by side, each alone from the case as written",
    )
    sensitivity: Literal["start", "optimum", "both"] | None = Field(
        None, description="where to take slopes of the objective, for advice in the report"
    )
    second_objective: Objective | None = Field(
        None, description="also trace the front between the objective and this one"
    )
    further_objectives: tuple[Objective, ...] = Field(
        (), max_length=3, description="the third and further objectives of the front"
    )
    front_points: Annotated[int, Field(strict=True, ge=2, le=200)] | None = Field(
        None, description="points of the front, both ends included; default: 15"
    )
    RULES = (
        needs("further_objectives", "second_objective"),
        needs("", "variables stock", allowed="what to change: variables, stock, or both"),
        unique("stock", "stocks"),
        "vibecalc.core.case.search_checks:check_variables",
        "vibecalc.core.case.choice_checks:check_choices",
    )

    @property
    def moving(self) -> tuple[Variable, ...]:
        """Variables between bounds; the others are picked."""
        return tuple(variable for variable in self.variables if variable.moves)


def _unit_twice(row: Row) -> bool:
    """Whether the unit stands in a value and as a key of its own."""
    values = row.entries("value") or [row["value"]]
    return bool(row["unit"]) and any(isinstance(one, str) and _unit_of(one) for one in values)


def _unit_of(value: str) -> str:
    try:
        return split_number(value)[1]
    except UnitError:
        return ""


_UNIT_ONCE = refuse(
    "unit", "the unit stands twice", _unit_twice, found="{value} and unit = {unit}", also="value"
)


class Reference(Table):
    """A published or measured number for this machine, shown next to ours."""

    quantity: Name = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks one entry along named axes")
    value: Value = Field(description="as printed: its last digit sets the default tolerance")
    unit: str = Field("", description="unit of the value, if the value does not carry it")
    rtol: Number | None = Field(None, gt=0, lt=1, description="relative tolerance")
    atol: Value | None = Field(None, description="absolute tolerance, in the value's unit")
    digits: Literal["rounded", "truncated"] = Field(
        "rounded", description="truncated: within a whole unit of the last digit, not half of one"
    )
    source: Name = Field(description="table, figure or page")
    kind: Literal["published", "measured"] = Field(
        "published", description="measured numbers are shown and never counted"
    )
    known_difference: str = Field("", description="why the source differs; then it is not counted")
    shown_by: str = Field(
        "", description="test that reproduces the printed value, or 'not reproducible: ...'"
    )
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")
    uncertainty: Value | None = Field(
        None,
        description="standard uncertainty for [fit], in the value's unit or in %; "
        "default: the tolerance over sqrt 3",
    )
    RULES = (at_most_one("rtol", "atol"), _UNIT_ONCE)


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


class ReferenceTable(Table):
    """Published or measured numbers for many entries of one quantity, one row for each."""

    quantity: Name = Field(description="result path")
    axis: Name = Field(description="axis that the rows pick entries of")
    where: Where = Field(default_factory=dict, description="picks along the other axes")
    file: str = Field(
        "", description="CSV next to the case, its first column entries; instead of entry and value"
    )
    column: str = Field("", description="name of the file's column that holds the values")
    entry: Labels = Field((), description="entries of the axis, one for each value")
    value: Annotated[tuple[Value, ...], Field(max_length=20_000)] = Field(
        (), description="as printed: last digits set the tolerance"
    )
    unit: str = Field("", description="unit of the values")
    rtol: Number | None = Field(None, gt=0, lt=1, description="relative tolerance")
    digits: Literal["rounded", "truncated"] = Field(
        "rounded", description="truncated: within a whole unit of the last digit, not half of one"
    )
    source: Name = Field(description="table, figure or page")
    kind: Literal["published", "measured"] = Field(
        "published", description="measured numbers are shown and never counted"
    )
    known_difference: str = Field("", description="why the source differs; then it is not counted")
    shown_by: str = Field("", description="test that reproduces the values, or why none can")
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")
    uncertainty: Value | None = Field(
        None, description="standard uncertainty of each for [fit], in their unit or in %"
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
    )


class Limit(Table):
    """A bound that a result has to keep; the optimiser takes the same list."""

    quantity: Name = Field(description="result path")
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
    if value is None or isinstance(value, bool) or not isinstance(value, str | int | float):
        return None
    try:
        return si_value(value)
    except (UnitError, OverflowError):
        return None


# ----------------------------------------------------------------------------
# A search along one key of the case for the value that brings a wanted result.
# ----------------------------------------------------------------------------

Key = Annotated[str, Field(min_length=1, max_length=200)]


class Find(Table):
    """Change one key between bounds until a result has a wanted value, or is at its extreme."""

    name: Annotated[str, Field(min_length=1, max_length=40)] = Field(
        description="names the results find/<name>/...: letters, digits and _",
        json_schema_extra={"pattern": "^[A-Za-z0-9_]+$"},
    )
    key: Key = Field(description="the number that is changed, as in machine.crank_train.rod_length")
    also: tuple[Key, ...] = Field(
        (), max_length=32, description="further keys, changed in the same ratio as this one"
    )
    lower: Value = Field(description="smallest value examined, SI or with a unit")
    upper: Value = Field(description="largest value examined, SI or with a unit")
    quantity: Name = Field(description="result path")
    where: Where = Field(
        default_factory=dict,
        description="picks an entry along named axes; of several left the largest counts",
    )
    target: Value | None = Field(None, description="the value wanted; or")
    change: Value | None = Field(
        None, description="what is wanted less what the case as written gives; or"
    )
    seek: Literal["minimum", "maximum"] | None = Field(
        None, description="the extreme between the bounds, instead of a value"
    )
    points: Annotated[int, Field(strict=True, ge=3, le=2000)] = Field(
        33, description="values of the first look, spread over the bounds"
    )
    RULES = (
        refuse(
            "",
            "a case with [optimisation] cannot have [[find]], too",
            lambda t: "optimisation" in t.case and t.path[-1] == 0,
            "one or the other",
            hint="search in a case of its own, with the optimum written into it",
            also=("optimisation",),
        ),
        refuse(
            "name",
            "a name that cannot stand in a result path",
            lambda t: isinstance(t["name"], str) and re.search("[^A-Za-z0-9_]", t["name"]),
            "letters, digits and _, as in rod_length_6_db",
            found="{name!r}",
        ),
        one_of(
            "target",
            "change",
            "seek",
            allowed="one of target (a value), change (from the case as written) or seek (an "
            "extreme)",
        ),
        "vibecalc.core.case.search_checks:check_find",
    )


# ----------------------------------------------------------------------------
# What a sweep varies: keys of the case along axes, or drawn from distributions.
# ----------------------------------------------------------------------------


class Distribution(Table):
    """How a key scatters; mean and deviation are those of the key itself, in every kind."""

    kind: Literal["uniform", "normal", "lognormal", "triangular"] = Field(
        description="uniform and triangular need lower and upper, the others mean and deviation"
    )
    lower: Value | None = Field(None, description="smallest value")
    upper: Value | None = Field(None, description="largest value")
    mode: Value | None = Field(
        None, description="likeliest value of a triangular one; default: half way"
    )
    mean: Value | None = Field(None, description="mean")
    deviation: Value | None = Field(None, description="standard deviation")


class Along(Table):
    """One key of the case and the values it takes: listed, between two ends, or drawn."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    key: Annotated[str, Field(min_length=1, max_length=200)] = Field(
        description="as in machine.mounts.each.stiffness or ...cylinders[0].crank_phase"
    )
    values: Labels = Field((), description="the values, SI or with a unit, or names of choices")
    start: Value | None = Field(None, alias="from", description="first value, SI or with a unit")
    stop: Value | None = Field(None, alias="to", description="last value, SI or with a unit")
    points: Annotated[int, Field(strict=True, le=10**15)] | None = Field(
        None, description="how many values from first to last; a sampling may do without"
    )
    spacing: Literal["linear", "log"] | None = Field(
        None, description="equal steps or equal ratios; default: linear"
    )
    distribution: Distribution | None = Field(None, description="how the key scatters")


class Axis(Along):
    """One axis of a sweep: a key, and those that vary together with it."""

    together: Annotated[tuple[Along, ...], Field(max_length=31)] = Field(
        (), alias="with", description="keys that take their values in step with this one"
    )


class Sweep(Table):
    """The same case at many points: a grid over its axes, or samples of them."""

    axes: Annotated[tuple[Axis, ...], Field(max_length=16)] = Field(
        (), description="what varies; the last axis varies fastest"
    )
    keep: Annotated[tuple[Name, ...], Field(max_length=200)] = Field(
        (), description="result paths to keep; default: single numbers, and those with a limit"
    )
    sampling: Literal["grid", "latin_hypercube", "sobol", "monte_carlo"] = Field(
        "grid", description="all combinations, or points spread over the axes"
    )
    points: Annotated[int, Field(strict=True, ge=2, le=10**15)] | None = Field(
        None, description="points of a sampling; default: 1024"
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**32 - 1)] | None = Field(
        None, description="names one of many equally good samplings; default: 1"
    )
    indices: bool = Field(
        False,
        strict=True,
        description="first-order and total Sobol indices; takes points times (axes + 2) runs",
    )
    RULES = (
        no(
            "points seed",
            lambda t: t["sampling"] == "grid",
            "{key} belongs to a sampling, and this sweep is a grid",
            'sampling = "sobol", "latin_hypercube" or "monte_carlo"',
        ),
        no(
            "indices",
            lambda t: t["sampling"] not in ("sobol", "monte_carlo"),
            "Sobol indices come from samples that do not depend on each other's axes",
            'sampling = "sobol" or "monte_carlo"',
        ),
    )
