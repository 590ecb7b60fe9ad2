"""A damper on a shaft line: a ring behind oil or springs, or pendulums."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import (
    AngularDamping,
    AngularStiffness,
    Inertia,
    Length,
    Mass,
    Name,
    Number,
    Table,
)

DamperKind = Literal["viscous", "spring", "pendulum"]


class LineDamper(Table):
    """What hangs on a station. Its hub and casing belong to the inertia of the station."""

    name: Name = Field(description="label used in tables and in `where`")
    on: Name = Field(description="name of the station that carries it")
    kind: DamperKind = Field(description="a ring in oil, a ring on springs, or pendulums")
    inertia: Inertia | None = Field(
        None, gt=0, description="of the ring, about the axis of its station"
    )
    stiffness: AngularStiffness | None = Field(
        None, ge=0, description="of the springs between station and ring"
    )
    damping: AngularDamping = Field(
        0.0, ge=0, description="viscous, between station and ring or pendulums"
    )
    loss_factor: Number = Field(
        0.0, ge=0, le=10, description="of the springs, k (1 + i loss_factor)"
    )
    order: Number | None = Field(
        None, gt=0, le=400, description="of its station's own turns, to which pendulums are tuned"
    )
    mass: Mass | None = Field(None, gt=0, description="of one pendulum")
    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        1, description="equal pendulums"
    )
    arm_radius: Length | None = Field(
        None, gt=0, description="from the axis to the point that a pendulum swings about"
    )
