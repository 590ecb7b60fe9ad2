"""Rods, counterweights and balance shafts of a crank train, as a case writes them."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Angle,
    Inertia,
    Length,
    Mass,
    Name,
    Number,
    Point,
    Table,
    Unbalance,
    Whole,
)
from vibecalc.core.case.rules import needs, one_of, refers

# ----------------------------------------------------------------------------
# What not every crank train has.
# ----------------------------------------------------------------------------


class Rod(Table):
    """A connecting rod as two point masses: one with the wrist pin, one with the crank pin."""

    mass: Mass = Field(gt=0, description="mass of one connecting rod")
    crank_pin_to_mass_centre: Length | None = Field(
        None, ge=0, description="distance from the crank pin to the mass centre of the rod"
    )
    reciprocating_fraction: Number | None = Field(
        None, ge=0, le=1, description="share of the rod mass that moves with the piston"
    )
    inertia: Inertia | None = Field(
        None, ge=0, description="about its own mass centre; default: that of the two point masses"
    )
    RULES = (one_of("crank_pin_to_mass_centre", "reciprocating_fraction"),)


class ArticulatedRod(Table):
    """A slave rod: hinged on the rod of another cylinder, not on the crank pin."""

    on: Name = Field(description="the cylinder whose rod is the master")
    knuckle_radius: Length = Field(
        ge=0, description="distance of the knuckle pin from the crank pin, on the master rod"
    )
    knuckle_angle: Angle | None = Field(
        None,
        description="of the knuckle pin from the axis of the master rod, in the sense of rotation; "
        "default: that between the two cylinders",
    )
    rod_length: Length = Field(gt=0, description="from the knuckle pin to the wrist pin")
    knuckle_mass: Mass | None = Field(
        None,
        ge=0,
        description="what moves with the knuckle pin; default: the rod's mass at a crank pin",
    )
    rod_mass: Mass | None = Field(
        None, gt=0, description="of the slave rod, the rest of it moves with the piston"
    )
    inertia: Inertia | None = Field(
        None, ge=0, description="about its own mass centre; default: that of the two point masses"
    )
    RULES = (
        refers("on", "machine.crank_train.cylinders", "cylinder"),
        needs("inertia", "rod_mass"),
        needs("rod_mass", "inertia"),
    )


class Counterweight(Table):
    """A weight fixed to the crankshaft."""

    name: Name = Field("counterweight", description="label")
    unbalance: Unbalance = Field(ge=0, description="mass times radius")
    phase: Angle = Field(0.0, description="angle by which it leads crank angle zero")
    position: Length = Field(0.0, description="along the crankshaft, from the train's origin")


class BalanceShaft(Table):
    """An extra shaft with an unbalance, geared to the crankshaft."""

    name: Name = Field("balance shaft", description="label")
    unbalance: Unbalance = Field(ge=0, description="mass times radius")
    speed_ratio: Annotated[Literal[-2, -1, 1, 2], Whole] = Field(
        description="shaft speed over crank speed; negative turns the other way"
    )
    phase: Angle = Field(0.0, description="angle of the unbalance from the stroke at crank angle 0")
    position: Point = Field((0.0, 0.0, 0.0), description="from the train's origin, along x, y, z")
