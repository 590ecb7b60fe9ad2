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
from vibecalc.core.case.fields import key as described
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
    """One stock item: the values that it sets, together."""

    name: Name = described("name or part number, shown in tables")
    values: Settings = described("key of the table -> its value, SI or with a unit")


class Stock(Table):
    """A stock of which one item is picked, such as a catalogue of mounts."""

    name: ResultName = described("names the results: letters, digits and _")
    table: Key = described("table of the case that takes the item's values")
    also: tuple[Key, ...] = described(
        "further tables that take the same values", (), alias="further_tables", max_length=32
    )
    items: tuple[StockItem, ...] = described("items to choose from", (), max_length=1000)
    catalogue: str | None = described(
        "CSV with a line for each, or TOML with a table for each, instead of items", None
    )
    RULES = (_NAMED, one_of("items", "catalogue"), unique("items", "items of a stock"))


class Tolerance(Table):
    """Scatter of a key about its value, from one machine built to the next."""

    key: Key = described("as in machine.mounts.each.stiffness")
    half_width: Value | None = described(
        "evenly within so much on both sides: a size, or a share as '15 %'; or", None
    )
    deviation: Value | None = described(
        "normally distributed with this deviation: a size, or a share as '5 %'", None
    )
    RULES = (one_of("half_width", "deviation"),)


class Robust(Table):
    """Improve, and check limits for, the mean plus some standard deviations over tolerances."""

    tolerances: tuple[Tolerance, ...] = described(
        "keys that scatter, each on its own", min_length=1, max_length=32
    )
    sigmas: Number = described(
        "standard deviations added to the mean, to the worse side", 2.0, ge=0, le=10
    )
    samples: Annotated[int, Field(strict=True, ge=8, le=65536)] = described(
        "machines drawn, the same ones for all candidates: a power of two is best", 64
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**31 - 1)] = described(
        "another one draws other machines", 1
    )


# ----------------------------------------------------------------------------
# A search over keys of the case for what is best within limits.
# ----------------------------------------------------------------------------


class TiedKey(Table):
    """A key that follows a variable: factor times its value, plus an offset."""

    key: Name = described("the tied key")
    factor: Number = described("times the value of the variable", 1.0)
    offset: Value | None = described("added to that, SI or with a unit; default: 0", None)


class Variable(Table):
    """A design variable: one key of the case, with the keys tied to it."""

    key: Name = described("as in machine.mounts.each.stiffness or ...cylinders[0].position")
    lower: Value | None = described("lower bound, SI or with a unit", None, alias="min")
    upper: Value | None = described("upper bound, SI or with a unit", None, alias="max")
    integer: bool | None = described("integers between the bounds only", None, strict=True)
    choices: Labels = described(
        "the values that it may take, instead of bounds: SI, with a unit, or names", ()
    )
    follow: tuple[TiedKey, ...] = described(
        "keys that follow it: each factor times its value, plus offset",
        (),
        alias="followed_by",
        max_length=32,
    )
    RULES = (
        one_of("min max", "choices"),
        needs("min", "max"),
        needs("max", "min"),
        at_most_one("integer", "choices"),
    )

    @property
    def moves(self) -> bool:
        """Whether it takes any value between its bounds."""
        return not (self.choices or self.integer)


class Objective(Table):
    """The quantity to minimise or maximise; of an array the worst entry counts."""

    quantity: ResultPath = described("result path")
    where: Where = described("selects entries by named axes", default_factory=dict)
    sense: Literal["min", "max"] = described("minimise or maximise", "min")


class Optimisation(Table):
    """Vary keys within bounds for the best objective with all limits kept."""

    variables: tuple[Variable, ...] = described("design variables", (), max_length=32)
    stock: tuple[Stock, ...] = described(
        "things of which one is picked, each several keys together", (), max_length=8
    )
    robust: Robust | None = described(
        "improve the mean plus some deviations over tolerances of keys", None
    )
    objective: Objective = described("result to minimise or maximise")
    starts: Annotated[int, Field(strict=True, ge=1, le=1000)] = described(
        "starting points spread over the bounds, besides the case as written", 8
    )
    sensitivity: Literal["start", "optimum", "both"] | None = described(
        "where to take slopes of the objective, for advice in the report", None
    )
    second_objective: Objective | None = described(
        "also trace the front between the objective and this one", None
    )
    further_objectives: tuple[Objective, ...] = described(
        "the third and further objectives of the front", (), max_length=3
    )
    front_points: Annotated[int, Field(strict=True, ge=2, le=200)] | None = described(
        "points of the front, both ends included; default: 15", None
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
    """Vary one key between bounds until a result has a wanted value or an extreme."""

    name: ResultName = described("names the results find/<name>/...: letters, digits and _")
    key: Key = described("the varied number, as in machine.crank_train.rod_length")
    also: tuple[Key, ...] = described(
        "further keys, changed in the same ratio as this one",
        (),
        alias="scaled_with",
        max_length=32,
    )
    lower: Value = described("smallest value searched, SI or with a unit", alias="min")
    upper: Value = described("largest value searched, SI or with a unit", alias="max")
    quantity: ResultPath = described("result path")
    where: Where = described(
        "picks an entry along named axes; of several left the largest counts", default_factory=dict
    )
    target: Value | None = described("wanted value; or", None)
    change: Value | None = described("wanted change from the case as written; or", None)
    sense: Literal["min", "max"] | None = described(
        "the extreme between the bounds, instead of a value", None
    )
    points: Annotated[int, Field(strict=True, ge=3, le=2000)] = described(
        "values of the first look, spread over the bounds", 33
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
            "sense",
            allowed="one of target (a value), change (from the case as written) or sense (an "
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
    """Vary keys within bounds for the best fit of results to measurements."""

    variables: tuple[Variable, ...] = described("keys to fit", min_length=1, max_length=32)
    references: Literal["measured", "all"] = described(
        "what it is fitted to: references of kind measured, or all of them; those with "
        "a known_difference are left out",
        "measured",
    )
    starts: Annotated[int, Field(strict=True, ge=0, le=1000)] = described(
        "starting points spread over the bounds, besides the case as written", 4
    )
    RULES = (
        _apart("[optimisation]", "[fit]", _FIRST),
        _apart("[[find]]", "[fit]", _FIRST),
        refuse(
            "variables",
            "a fit moves numbers between bounds, it picks nothing from lists",
            lambda t: any("choices" in one or "integer" in one for one in t.each("variables")),
            "min and max",
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
    """Distribution of a key; mean and deviation are those of the key itself, in every kind."""

    kind: Literal["uniform", "normal", "lognormal", "triangular"] = described(
        "uniform and triangular need min and max, the others mean and deviation"
    )
    min: Value | None = described("smallest value", None)
    max: Value | None = described("largest value", None)
    mode: Value | None = described(
        "most likely value of a triangular distribution; default: half way", None
    )
    mean: Value | None = described("mean", None)
    deviation: Value | None = described("standard deviation", None)
    RULES = (
        by_kind(
            "distribution",
            uniform="min max",
            triangular="min max | mode",
            normal="mean deviation",
            lognormal="mean deviation",
        ),
    )


class Along(Table):
    """One key of the case and the values it takes: listed, between two ends, or drawn."""

    model_config = ConfigDict(validate_by_alias=True, validate_by_name=False)

    key: Key = described("as in machine.mounts.each.stiffness or ...cylinders[0].crank_phase")
    values: Swept = described(
        "the values, SI or with a unit, names of choices, lists or tables", ()
    )
    start: Value | None = described("first value, SI or with a unit", None, alias="from")
    stop: Value | None = described("last value, SI or with a unit", None, alias="to")
    points: Annotated[int, Field(strict=True, le=10**15)] | None = described(
        "how many values from first to last; a sampling may do without", None
    )
    spacing: Literal["linear", "log"] | None = described(
        "equal steps or equal ratios; default: linear", None
    )
    distribution: Distribution | None = described("random distribution of the key", None)
    RULES = (
        one_of("values", "from to", "distribution", allowed="values, from and to, or distribution"),
        needs("from", "to"),
        needs("to", "from"),
        needs("points", "from", "it counts what lies between two ends"),
        needs("spacing", "from", "it is of what lies between two ends"),
    )


class Axis(Along):
    """One axis of a sweep: a key, and those that vary together with it."""

    together: Annotated[tuple[Along, ...], Field(max_length=31)] = described(
        "keys that take their values in step with this one", (), alias="in_step"
    )


class Sweep(Table):
    """The same case at many points: a grid over its axes, or samples of them."""

    axes: Annotated[tuple[Axis, ...], Field(max_length=16)] = described(
        "what varies; the last axis varies fastest", ()
    )
    keep: Annotated[tuple[ResultPath, ...], Field(max_length=200)] = described(
        "result paths to keep; default: single numbers, and those with a limit", ()
    )
    objective: Objective | None = described("selects the best of the points; always kept", None)
    sampling: Literal["grid", "latin_hypercube", "sobol", "monte_carlo"] = described(
        "all combinations, or points spread over the axes", "grid"
    )
    points: Annotated[int, Field(strict=True, ge=2, le=10**15)] | None = described(
        "points of a sampling; default: 1024", None
    )
    seed: Annotated[int, Field(strict=True, ge=0, le=2**32 - 1)] | None = described(
        "names one of many equally good samplings; default: 1", None
    )
    indices: bool = described(
        "first-order and total Sobol indices; takes points times (axes + 2) runs",
        False,
        strict=True,
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
