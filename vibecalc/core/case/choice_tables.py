"""What [optimisation] may pick from a stock, and which keys scatter about the values found."""

from typing import Annotated

from pydantic import BeforeValidator, Field

from vibecalc.core.case.fields import Kind, Name, Number, Table, Value, read_labels
from vibecalc.core.case.rules import one_of, unique

Key = Annotated[str, Field(min_length=1, max_length=200)]
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

    name: Annotated[str, Field(min_length=1, max_length=40)] = Field(
        description="names the results: letters, digits and _",
        json_schema_extra={"pattern": "^[A-Za-z0-9_]+$"},
    )
    table: Key = Field(description="table of the case that takes over what is picked")
    also: tuple[Key, ...] = Field(
        (), max_length=32, description="further tables that take over the same"
    )
    items: tuple[StockItem, ...] = Field((), max_length=1000, description="what there is")
    catalogue: str | None = Field(
        None,
        description="CSV with a line for each, or TOML with a table for each, instead of items",
    )
    RULES = (one_of("items", "catalogue"), unique("items", "items of a stock"))


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
