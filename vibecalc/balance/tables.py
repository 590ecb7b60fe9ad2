"""The table [balance] of a case, with those below it."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    Length,
    Name,
    Number,
    Point,
    Table,
    Unbalance,
    Whole,
)
from vibecalc.core.case.rules import once, one_of, pair_ordered, refers, refuse, unique

Order = Annotated[int, Field(strict=True, ge=1, le=400)]
Between = Annotated[tuple[Length, ...], Field(min_length=2, max_length=2)]


class Weight(Table):
    """A weight that is sought: on the crankshaft or on a balance shaft."""

    name: Name | None = Field(None, description="label; default: its number")
    position: Length | None = Field(
        None, description="along the crankshaft, from the train's origin; or between"
    )
    between: Between | None = Field(
        None, description="its position is free from the first to the second of these"
    )
    phase: Angle | None = Field(
        None, description="angle at which it stands, or opposite to it; default: free"
    )
    largest_unbalance: Unbalance | None = Field(
        None, gt=0, description="mass times radius that there is room for; default: no bound"
    )
    radius: Length | None = Field(
        None, gt=0, description="of its mass centre from the axis of the shaft, for its mass"
    )
    RULES: ClassVar[tuple[Any, ...]] = (
        one_of("position", "between"),
        pair_ordered("between", equal=False),
    )


class CrankWeight(Weight):
    """A weight on the crankshaft."""

    name: Name = Field(description="label")
    throw: Name | None = Field(
        None, description="it stands at the throw of this cylinder, instead of a position"
    )
    RULES = (
        one_of("position", "between", "throw"),
        pair_ordered("between", equal=False),
        refers("throw", "machine.crank_train.cylinders", "cylinder"),
    )


class Shaft(Table):
    """A balance shaft: one part with one weight, or with two that may differ."""

    name: Name = Field(description="label")
    speed_ratio: Annotated[Literal[-2, -1, 1, 2], Whole] = Field(
        description="shaft speed over crank speed; negative turns the other way"
    )
    position: Point = Field(
        (0.0, 0.0, 0.0), description="of its axis, across the crankshaft, from the train's origin"
    )
    weights: tuple[Weight, ...] = Field(min_length=1, max_length=2, description="one weight or two")
    RULES = (unique("weights", "weights of a shaft"),)


class Balance(Table):
    """Weights sought for the least force and couple that they leave on the body."""

    orders: tuple[Order, ...] | None = Field(
        None,
        min_length=1,
        max_length=2,
        description="orders that count; default: those at which the weights turn",
    )
    force_weight: Number = Field(1.0, ge=0, description="weight of the forces")
    couple_weight: Number = Field(
        1.0, ge=0, description="weight of the couples across the crankshaft"
    )
    roll_weight: Number = Field(
        0.0, ge=0, description="weight of the couple about the crankshaft, which torques join"
    )
    reference_length: Length = Field(gt=0, description="couples are divided by it")
    counterweights: tuple[CrankWeight, ...] = Field(
        (), max_length=64, description="weights on the crankshaft"
    )
    shafts: tuple[Shaft, ...] = Field((), max_length=16, description="balance shafts")
    RULES = (
        unique("counterweights"),
        unique("shafts"),
        once("orders", "order"),
        refuse(
            "",
            "{header} has neither counterweights nor shafts",
            lambda row: not row.entries("counterweights") and not row.entries("shafts"),
            "counterweights, shafts, or both",
            hint="counterweights stand on the crankshaft, shafts turn once or twice as fast",
        ),
        refuse(
            "force_weight",
            "nothing counts: the weights of forces and couples are all zero",
            lambda row: not any(row.number(f"{of}_weight") for of in ("force", "couple", "roll")),
            "a weight above zero",
        ),
    )

    @property
    def weights(self) -> list[Weight]:
        """All of them: those on the crankshaft, then those of the shafts."""
        return [*self.counterweights, *(one for shaft in self.shafts for one in shaft.weights)]
