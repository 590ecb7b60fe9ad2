"""The table [excitation] of a case, with those below it."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Length,
    Number,
    Table,
)
from vibecalc.parts.tables import Idle, Names, Throws, cylinders_in

Order = Annotated[int, Field(strict=True, ge=1, le=400)]


class Balance(Table):
    """The balance table: sums of sin, cos, z sin and z cos over the cylinders."""

    orders: tuple[Order, ...] = Field(
        (1, 2), min_length=1, max_length=64, description="orders to tabulate"
    )


class Residual(Table):
    """One number for what is left unbalanced, for comparing and optimising crank trains."""

    force_weight: Number = Field(1.0, ge=0, description="weight of the forces")
    couple_weight: Number = Field(1.0, ge=0, description="weight of the couples")
    reference_length: Length = Field(gt=0, description="couples are divided by it")


class Excitation(Table):
    """Forces and couples of the crank train on the body."""

    orders: Order | None = Field(
        None, description="highest order kept; without it the tolerance decides"
    )
    working: Names | None = Field(
        None, description="names of the cylinders that work; default: all"
    )
    idle: Idle = Field(
        "stopped", description="the others: stopped, or moving without gas force (unloaded)"
    )
    balanced_for: Throws | None = Field(
        None, description="throws whose rotating mass is cancelled by weights in their own plane"
    )
    driven_machine: Literal["on_body", "separate", "cancels_torque"] = Field(
        "on_body",
        description="on_body: its stator gives the body the mean torque back, what alternates acts "
        "on the body; separate: the mean acts, too; cancels_torque: none of it acts, as if the "
        "stator followed every pulsation",
    )
    balance: Balance | None = Field(None, description="print the balance table")
    residual: Residual | None = Field(None, description="weighted residual of forces and couples")
    RULES = (*cylinders_in("working"), *cylinders_in("balanced_for"))
