"""A search along one key of the case for the value that brings a wanted result."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import Name, Table, Value, Where

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
