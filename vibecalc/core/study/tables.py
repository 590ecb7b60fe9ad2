"""Tables of a case that ask for more than one run: [[find]] and [sweep]."""

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from vibecalc.core.case.fields import Labels, Name, Table, Value, Where

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
    lower: Value = Field(description="smallest value looked at, SI or with a unit")
    upper: Value = Field(description="largest value looked at, SI or with a unit")
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
    points: Annotated[int, Field(strict=True, le=10**15)] | None = Field(
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
