"""Tables of a case that let it run many times: optimisation, searches, fits, sweeps."""

import re
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import BeforeValidator, ConfigDict, Field

from vibecalc.core.case.fields import (
    Kind,
    Labels,
    Name,
    Number,
    ResultPath,
    Swept,
    Table,
    Value,
    Where,
    read_labels,
)
from vibecalc.core.case.raw import tables_at
from vibecalc.core.case.rules import (
    Row,
    Rule,
    at_most_one,
    by_kind,
    needs,
    no,
    once,
    one_of,
    refuse,
    unique,
)
from vibecalc.errors import Problem

# ----------------------------------------------------------------------------
# Names and keys; which searches do not go together.
# ----------------------------------------------------------------------------

Key = Annotated[str, Field(min_length=1, max_length=200)]
#: a word of a result path
ResultName = Annotated[
    str,
    Field(min_length=1, max_length=40, json_schema_extra={"pattern": "^[A-Za-z0-9_]+$"}),
]
_NAMED = refuse(
    "name",
    "a name that cannot stand in a result path",
    lambda t: isinstance(t["name"], str) and re.search("[^A-Za-z0-9_]", t["name"]),
    "letters, digits and _, as in front_mount",
    found="{name!r}",
)


def _apart(other: str, this: str, hint: str) -> Rule:
    """A case does not have both; of a list its first entry says so."""
    key = other.strip("[]")
    return refuse(
        "",
        f"a case with {other} cannot have {this}, too",
        lambda t: key in t.case and t.path[1:] in ((), (0,)),
        "one or the other",
        hint=hint,
        also=(key,),
    )


# ----------------------------------------------------------------------------
# What [optimisation] may pick from a stock, and which keys scatter about the values found.
# ----------------------------------------------------------------------------

Settings = Annotated[
    dict[str, int | float | str],
    Field(min_length=1, max_length=32),
    BeforeValidator(read_labels),
    Kind("labels"),
]


class StockItem(Table):
    """One thing that can be bought: the keys that it settles, together."""

    name: Name = Field(description="as it is ordered: label in tables")
    values: Settings = Field(description="key of the table -> its value, SI or with a unit")


class Stock(Table):
    """Things of which one is picked, as the mounts of a catalogue."""

    name: ResultName = Field(description="names the results: letters, digits and _")
    table: Key = Field(description="table of the case that takes over what is picked")
    also: tuple[Key, ...] = Field(
        (), max_length=32, description="further tables that take over the same"
    )
    items: tuple[StockItem, ...] = Field((), max_length=1000, description="what there is")
    catalogue: str | None = Field(
        None,
        description="CSV with a line for each, or TOML with a table for each, instead of items",
    )
    RULES = (_NAMED, one_of("items", "catalogue"), unique("items", "items of a stock"))


class Tolerance(Table):
    """How far a key scatters about its value, from one machine built to the next."""

    key: Key = Field(description="as in machine.mounts.each.stiffness")
    half_width: Value | None = Field(
        None, description="evenly within so much on both sides: a size, or a share as '15 %'; or"
    )
    deviation: Value | None = Field(
        None, description="normally distributed with this deviation: a size, or a share as '5 %'"
    )
    RULES = (one_of("half_width", "deviation"),)


class Robust(Table):
    """Improve, and hold to the limits, the mean plus so many deviations over tolerances."""

    tolerances: tuple[Tolerance, ...] = Field(
        min_length=1, max_length=32, description="keys that scatter, each on its own"
    )
    sigmas: Number = Field(
        2.0, ge=0, le=10, description="deviations added to the mean, to the worse side"
    )
    samples: Annotated[int, Field(strict=True, ge=8, le=65536)] = Field(
        64, description="machines drawn, the same ones for all candidates: a power of two is best"
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31 - 1)] = Field(
        1, description="another one draws other machines"
    )


# ----------------------------------------------------------------------------
# A search over keys of the case for what is best within limits.
# ----------------------------------------------------------------------------


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

    quantity: ResultPath = Field(description="result path")
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
        needs("front_points", "second_objective", "a front needs a second objective"),
        needs("", "variables stock", allowed="what to change: variables, stock, or both"),
        unique("stock", "stocks"),
        "vibecalc.core.case.search_checks:check_search",
    )

    @property
    def moving(self) -> tuple[Variable, ...]:
        """Variables between bounds; the others are picked."""
        return tuple(variable for variable in self.variables if variable.moves)

    @property
    def goals(self) -> tuple[Objective, ...]:
        """All objectives, in the order of the front."""
        second = () if self.second_objective is None else (self.second_objective,)
        return (self.objective, *second, *self.further_objectives)


# ----------------------------------------------------------------------------
# A search along one key of the case for the value that brings a wanted result.
# ----------------------------------------------------------------------------


class Find(Table):
    """Change one key between bounds until a result has a wanted value, or is at its extreme."""

    name: ResultName = Field(description="names the results find/<name>/...: letters, digits and _")
    key: Key = Field(description="the number that is changed, as in machine.crank_train.rod_length")
    also: tuple[Key, ...] = Field(
        (), max_length=32, description="further keys, changed in the same ratio as this one"
    )
    lower: Value = Field(description="smallest value examined, SI or with a unit")
    upper: Value = Field(description="largest value examined, SI or with a unit")
    quantity: ResultPath = Field(description="result path")
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
        _apart(
            "[optimisation]",
            "[[find]]",
            "search in a case of its own, with the optimum written into it",
        ),
        _NAMED,
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
# Keys of a case that are fitted to what was measured of the machine.
# ----------------------------------------------------------------------------


def _points(row: Row) -> Iterator[Problem]:
    """A fit needs something measured."""
    kinds = [
        one.get("kind", "published")
        for name in ("reference", "reference_table")
        for _, one in tables_at(row.case, name)
    ]
    wanted = row["references"]
    if kinds and (wanted == "all" or wanted in kinds):
        return
    yield row.problem(
        "",
        "there is nothing to fit to: the case has no "
        + ("[[reference]]" if wanted == "all" else f"[[reference]] of kind {wanted!r}"),
        allowed='[[reference]] or [[reference_table]] with kind = "measured"',
        hint='references = "all" takes published ones, too' if kinds else "",
    )


_FIRST = "write the values of the fit into the case, then search"


class Fit(Table):
    """Change some keys within bounds until the results come closest to what was measured."""

    variables: tuple[Variable, ...] = Field(min_length=1, max_length=32, description="what to fit")
    references: Literal["measured", "all"] = Field(
        "measured",
        description="what it is fitted to: references of kind measured, or all of them; those with "
        "a known_difference are left out",
    )
    starts: Annotated[int, Field(strict=True, ge=0, le=1000)] = Field(
        4, description="starting points spread over the bounds, besides the case as written"
    )
    RULES = (
        _apart("[optimisation]", "[fit]", _FIRST),
        _apart("[[find]]", "[fit]", _FIRST),
        refuse(
            "variables",
            "a fit moves numbers between bounds, it picks nothing from lists",
            lambda t: any("choices" in one or "integer" in one for one in t.each("variables")),
            "lower and upper",
            hint="[optimisation] picks from lists",
        ),
        _points,
        "vibecalc.core.case.search_checks:check_search",
    )

    @property
    def moving(self) -> tuple[Variable, ...]:
        """The variables, all of which lie between bounds."""
        return self.variables


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
    RULES = (
        by_kind(
            "distribution",
            uniform="lower upper",
            triangular="lower upper | mode",
            normal="mean deviation",
            lognormal="mean deviation",
        ),
    )


class Along(Table):
    """One key of the case and the values it takes: listed, between two ends, or drawn."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    key: Key = Field(
        description="as in machine.mounts.each.stiffness or ...cylinders[0].crank_phase"
    )
    values: Swept = Field(
        (), description="the values, SI or with a unit, names of choices, lists or tables"
    )
    start: Value | None = Field(None, alias="from", description="first value, SI or with a unit")
    stop: Value | None = Field(None, alias="to", description="last value, SI or with a unit")
    points: Annotated[int, Field(strict=True, le=10**15)] | None = Field(
        None, description="how many values from first to last; a sampling may do without"
    )
    spacing: Literal["linear", "log"] | None = Field(
        None, description="equal steps or equal ratios; default: linear"
    )
    distribution: Distribution | None = Field(None, description="how the key scatters")
    RULES = (
        one_of("values", "from to", "distribution", allowed="values, from and to, or distribution"),
        needs("from", "to"),
        needs("to", "from"),
        needs("points", "from", "it counts what lies between two ends"),
        needs("spacing", "from", "it is of what lies between two ends"),
    )


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
    keep: Annotated[tuple[ResultPath, ...], Field(max_length=200)] = Field(
        (), description="result paths to keep; default: single numbers, and those with a limit"
    )
    objective: Objective | None = Field(
        None, description="what the best of the points is by; it is kept"
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
        once("keep", "quantity"),
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
