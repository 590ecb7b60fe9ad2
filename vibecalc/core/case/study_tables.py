"""Tables of a case that let it run many times: optimisation, searches, sweeps."""

import re
from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from vibecalc.core.case.choice_tables import Robust, Stock
from vibecalc.core.case.fields import Labels, Name, Number, ResultPath, Swept, Table, Value, Where
from vibecalc.core.case.rules import at_most_one, needs, no, one_of, refuse, unique

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
        "vibecalc.core.case.search_checks:check_variables",
        "vibecalc.core.case.choice_checks:check_choices",
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
