"""Joints with play: what a case says of clearances and of the contact in them."""

from typing import Literal

from pydantic import Field

from vibecalc.case.fields import Damping, Length, Name, Stiffness, Table


class Play(Table):
    """A dead band between two contacts."""

    clearance: Length = Field(gt=0, description="free travel from one contact to the other")
    stiffness: Stiffness = Field(gt=0, description="of a contact")
    contact_damping: Damping = Field(0.0, description="viscous, while in contact")
    film_damping: Damping = Field(
        0.0, description="viscous, while in the gap: a linearised squeeze film"
    )


class Joint(Play):
    """A bearing with play along the cylinder."""

    spring: Literal["continuous", "full_deflection"] = Field(
        "continuous",
        description="force beyond the clearance: stiffness times what goes beyond it, or times the "
        "whole deflection, which jumps at contact",
    )


class Joints(Table):
    """Bearings with play in the running gear of one cylinder."""

    cylinder: Name | None = Field(None, description="which one; default: the first that works")
    wrist_pin: Joint = Field(description="between rod and piston")
    crank_pin: Joint | None = Field(
        None, description="between crank and rod; the rod is then a mass between two gaps"
    )
    bore: Play | None = Field(None, description="between piston and cylinder wall: piston slap")
