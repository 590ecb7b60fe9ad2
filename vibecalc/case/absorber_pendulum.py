"""A pendulum in the centrifugal field of a rotor, as a case gives it."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.case.absorber_fields import Positive, Share
from vibecalc.case.fields import (
    Angle,
    AngularSpeed,
    AngularStiffness,
    Inertia,
    Length,
    Mass,
    Moment,
    Table,
)


class Swings(Table):
    """Angles of swing up to which the order is followed."""

    to: Angle = Field(gt=0, description="largest angle by which the tangent turns")
    points: Annotated[int, Field(strict=True, ge=2, le=2000)] = Field(
        41, description="from zero on"
    )


class Rollers(Table):
    """Two equal rollers in equal cutouts that carry the mass: a bifilar mount."""

    mass: Mass = Field(gt=0, description="of all rollers of one pendulum")
    distance: Length = Field(
        gt=0, description="mean, from the axis to their centres across the vertex"
    )
    diameter: Length = Field(gt=0, description="of a roller")
    inertia: Inertia | None = Field(
        None, ge=0, description="of all about their own axes; default: solid ones"
    )


class Pendulum(Table):
    """Equal pendulums on a rotor that follow one order of its speed."""

    order: Positive = Field(description="of the excitation that they have to follow")
    mass: Mass = Field(gt=0, description="of one pendulum, without its rollers")
    count: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        1, description="pendulums that swing together"
    )
    vertex_distance: Length | None = Field(
        None, gt=0, description="from the axis to the mass centre at rest"
    )
    arm_radius: Length | None = Field(
        None, gt=0, description="from the axis to the centre of the path, instead"
    )
    path: Literal["circular", "cycloidal", "epicycloidal"] = Field(
        "circular", description="of the mass centre; an epicycloid keeps its order"
    )
    path_radius: Length | None = Field(
        None, gt=0, description="of curvature at the vertex; default: as the order wants it"
    )
    swing_inertia: Inertia = Field(
        0.0, ge=0, description="of one mass about its centre, where it turns with an arm"
    )
    rollers: Rollers | None = Field(None, description="of one pendulum; default: a point on an arm")
    damping_ratio: Share = Field(0.0, description="of small swings, on their own frequency")
    rotor_inertia: Inertia = Field(gt=0, description="of all that turns, without pendulums")
    rotor_stiffness: AngularStiffness = Field(
        0.0, ge=0, description="that holds the rotor against its mean turning; 0: none"
    )
    speed: AngularSpeed = Field(gt=0, description="mean speed of the rotor")
    torque: Moment | None = Field(
        None, gt=0, description="amplitude of the exciting torque: how far it swings"
    )
    swings: Swings | None = Field(None, description="detuning with the angle of swing")
