"""The search for the damper of a shaft line."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.fields import (
    Angle,
    AngularDamping,
    AngularStiffness,
    Inertia,
    Name,
    Number,
    Table,
    Unit,
)
from vibecalc.case.torsion_tables import LineSpeeds

Power = Annotated[float, Field(gt=0), Unit("W")]


class DamperValues(Table):
    """A damper from a table, to be compared with the one that is found."""

    stiffness: AngularStiffness = Field(0.0, ge=0, description="of its springs; 0: none")
    damping: AngularDamping = Field(ge=0, description="viscous")


class DamperLimits(Table):
    """What the damper has to keep at every speed."""

    heat: Power | None = Field(None, description="in its dashpot, mean over the cycle")
    travel: Angle | None = Field(
        None, gt=0, description="of the ring against its station, peak over the cycle"
    )


class DamperBounds(Table):
    """From and to, of each number that is looked for."""

    stiffness: tuple[AngularStiffness, AngularStiffness] | None = Field(
        None, description="of the springs; from 0 to 0 is a ring in oil"
    )
    damping: tuple[AngularDamping, AngularDamping] | None = Field(None, description="viscous")
    inertia: tuple[Inertia, Inertia] | None = Field(
        None, description="of the ring; needed where it is looked for"
    )


class DamperDesign(Table):
    """Spring and damper of a ring on the line that make its worst section best."""

    on: Name = Field(description="name of a station, or of a damper that is replaced")
    find: Annotated[
        tuple[Literal["stiffness", "damping", "inertia"], ...],
        Field(min_length=1, max_length=3),
    ] = Field(("stiffness", "damping"), description="numbers to look for")
    inertia: Inertia | None = Field(
        None, gt=0, description="of the ring; default: that of the damper that is replaced"
    )
    stiffness: AngularStiffness | None = Field(
        None, ge=0, description="where it is not looked for; default: of the replaced damper"
    )
    damping: AngularDamping | None = Field(
        None, ge=0, description="where it is not looked for; default: of the replaced damper"
    )
    objective: Literal["torque", "twist", "stress"] = Field(
        "torque", description="half range over the cycle in the worst section at the worst speed"
    )
    sections: Annotated[tuple[Name, ...], Field(max_length=64)] = Field(
        (), description="names of shafts that count; default: all"
    )
    speeds: LineSpeeds | None = Field(
        None, description="that count; default: those of [response.torsion]"
    )
    limits: DamperLimits | None = Field(None, description="that the damper has to keep")
    bounds: DamperBounds | None = Field(None, description="of what is looked for")
    compare: DamperValues | None = Field(None, description="a table value to compare with")
    rings: Annotated[tuple[Inertia, ...], Field(max_length=32)] = Field(
        (), description="inertias of other rings, whose best dampers are told beside it"
    )
    tolerance: Number = Field(
        0.1, gt=0, lt=1, description="error of spring and damper whose cost is told"
    )
