"""The table [foundation] of a case."""

from pydantic import Field

from vibecalc.core.case.fields import Damping, Mass, Number, Stiffness, Table


class Foundation(Table):
    """What the mounts stand on, as one mass that moves up and down on a spring."""

    mass: Mass = Field(gt=0, description="of the part of the floor, deck or block that moves")
    stiffness: Stiffness = Field(gt=0, description="of what carries that mass, up and down")
    damping: Damping = Field(0.0, ge=0, description="viscous, parallel to the stiffness")
    loss_factor: Number = Field(0.0, ge=0, le=1, description="of the stiffness")
