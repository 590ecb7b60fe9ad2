"""Rods, counterweights and balance shafts of a crank train, as a case writes them."""

from typing import Annotated, Literal

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
    key,
)
from vibecalc.core.case.rules import needs, one_of, refers

# ----------------------------------------------------------------------------
# What not every crank train has.
# ----------------------------------------------------------------------------


class Rod(Table):
    """A connecting rod as two point masses: one with the wrist pin, one with the crank pin."""

    mass: Mass = key("mass of one connecting rod", gt=0)
    crank_pin_to_mass_centre: Length | None = key(
        "distance from the crank pin to the mass centre of the rod", None, ge=0
    )
    reciprocating_fraction: Number | None = key(
        "share of the rod mass that moves with the piston", None, ge=0, le=1
    )
    inertia: Inertia | None = key(
        "about its own mass centre; default: that of the two point masses", None, ge=0
    )
    RULES = (one_of("crank_pin_to_mass_centre", "reciprocating_fraction"),)


class ArticulatedRod(Table):
    """A slave rod: hinged on the rod of another cylinder, not on the crank pin."""

    on: Name = key("the cylinder whose rod is the master")
    knuckle_radius: Length = key("from crank pin to knuckle pin, on the master rod", ge=0)
    knuckle_angle: Angle | None = key(
        "of the knuckle pin from the axis of the master rod, in the sense of rotation; "
        "default: that between the two cylinders",
        None,
    )
    rod_length: Length = key("from the knuckle pin to the wrist pin", gt=0)
    knuckle_mass: Mass | None = key(
        "moving with the knuckle pin; default: as the rod's mass at a crank pin", None, ge=0
    )
    rod_mass: Mass | None = key(
        "of the slave rod; the rest of it moves with the piston", None, gt=0
    )
    inertia: Inertia | None = key(
        "about its own mass centre; default: that of the two point masses", None, ge=0
    )
    RULES = (
        refers("on", "machine.crank_train.cylinders", "cylinder"),
        needs("inertia", "rod_mass"),
        needs("rod_mass", "inertia"),
    )


class Counterweight(Table):
    """A weight fixed to the crankshaft."""

    name: Name = key("label", "counterweight")
    unbalance: Unbalance = key("mass times radius", ge=0)
    phase: Angle = key("angle by which it leads crank angle zero", 0.0)
    position: Length = key("along the crankshaft, from the train's origin", 0.0)


class BalanceShaft(Table):
    """An extra shaft with an unbalance, geared to the crankshaft."""

    name: Name = key("label", "balance shaft")
    unbalance: Unbalance = key("mass times radius", ge=0)
    speed_ratio: Annotated[Literal[-2, -1, 1, 2], Whole] = key(
        "shaft speed over crank speed; negative turns the other way"
    )
    phase: Angle = key("angle of the unbalance from the stroke at crank angle 0", 0.0)
    position: Point = key("from the train's origin, along x, y, z", (0.0, 0.0, 0.0))
