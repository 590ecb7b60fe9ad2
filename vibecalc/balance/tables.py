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
    key,
)
from vibecalc.core.case.rules import once, one_of, pair_ordered, refers, refuse, unique

Order = Annotated[int, Field(strict=True, ge=1, le=400)]
Between = Annotated[tuple[Length, ...], Field(min_length=2, max_length=2)]


class Weight(Table):
    """A weight to be found, on the crankshaft or on a balance shaft."""

    name: Name | None = key("label; default: its number", None)
    position: Length | None = key("along the crankshaft, from the train's origin; or between", None)
    between: Between | None = key("free position, from the first to the second of these", None)
    phase: Angle | None = key("fixed angle of the weight, or of its opposite; default: free", None)
    largest_unbalance: Unbalance | None = key(
        "maximum mass times radius; default: no limit", None, gt=0
    )
    radius: Length | None = key("radius of its mass centre, to report its mass", None, gt=0)
    RULES: ClassVar[tuple[Any, ...]] = (
        one_of("position", "between"),
        pair_ordered("between", equal=False),
    )


class CrankWeight(Weight):
    """A weight on the crankshaft."""

    name: Name = key("label")
    throw: Name | None = key("at the throw of this cylinder, instead of position", None)
    RULES = (
        one_of("position", "between", "throw"),
        pair_ordered("between", equal=False),
        refers("throw", "machine.crank_train.cylinders", "cylinder"),
    )


class Shaft(Table):
    """A balance shaft with one weight, or with two that may differ."""

    name: Name = key("label")
    speed_ratio: Annotated[Literal[-2, -1, 1, 2], Whole] = key(
        "shaft speed over crank speed; negative turns the other way"
    )
    position: Point = key(
        "of its axis, across the crankshaft, from the train's origin", (0.0, 0.0, 0.0)
    )
    weights: tuple[Weight, ...] = key("one weight or two", min_length=1, max_length=2)
    RULES = (unique("weights", "weights of a shaft"),)


class Balance(Table):
    """Balance weights that minimise the residual force and couple on the body."""

    orders: tuple[Order, ...] | None = key(
        "orders to balance; default: those at which the weights rotate",
        None,
        min_length=1,
        max_length=2,
    )
    force_weight: Number = key("weight of the forces", 1.0, ge=0)
    couple_weight: Number = key("weight of the couples across the crankshaft", 1.0, ge=0)
    roll_weight: Number = key("weight of the couple about the crankshaft, with torques", 0.0, ge=0)
    reference_length: Length = key("length by which couples are divided", gt=0)
    counterweights: tuple[CrankWeight, ...] = key("weights on the crankshaft", (), max_length=64)
    shafts: tuple[Shaft, ...] = key("balance shafts", (), max_length=16)
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
