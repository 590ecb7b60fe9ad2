"""The table [excitation] of a case, with those below it."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import Length, Number, Table, key
from vibecalc.parts.tables import Idle, Names, Throws, cylinders_in

Order = Annotated[int, Field(strict=True, ge=1, le=400)]


class Balance(Table):
    """The balance table: sums of sin, cos, z sin and z cos over the cylinders."""

    orders: tuple[Order, ...] = key("orders to tabulate", (1, 2), min_length=1, max_length=64)


class Residual(Table):
    """Residual unbalance as one number, to compare and optimise crank trains."""

    force_weight: Number = key("weight of the forces", 1.0, ge=0)
    couple_weight: Number = key("weight of the couples", 1.0, ge=0)
    reference_length: Length = key("length by which couples are divided", gt=0)


class Excitation(Table):
    """Forces and couples of the crank train on the body."""

    orders: Order | None = key("highest order; default: from the tolerance", None)
    working: Names | None = key("names of the working cylinders; default: all", None)
    idle: Idle = key(
        "the other cylinders: stopped, or moving without gas force (unloaded)", "stopped"
    )
    balanced_for: Throws | None = key(
        "cylinders whose rotating mass is balanced by weights in the plane of the throw", None
    )
    driven_machine: Literal["on_body", "separate", "cancels_torque"] = key(
        "on_body: its stator returns the mean torque to the body, alternating torque acts; "
        "separate: the mean torque acts too; cancels_torque: no torque acts",
        "on_body",
    )
    balance: Balance | None = key("print the balance table", None)
    residual: Residual | None = key("residual unbalance of forces and couples", None)
    RULES = (*cylinders_in("working"), *cylinders_in("balanced_for"))
