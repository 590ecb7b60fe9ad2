"""The table [isolation] of a case."""

from typing import Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Acceleration,
    Length,
    RunUp,
    Table,
)


class Isolation(Table):
    """The body on its mounts: what reaches the ground."""

    model: Literal["pitch", "rigid_body", "planar"] = Field(
        description="pitch about the axis across the crankshaft, all six freedoms, or the three in "
        "the plane of the crank"
    )
    up: Literal["x", "y", "z"] = Field("z", description="gravity acts against this direction")
    gravity: Acceleration = Field(9.80665, ge=0, description="acceleration of free fall")
    lever: Length | None = Field(
        None, gt=0, description="couple over this lever is `lever_force`; default: of the mounts"
    )
    run_up: RunUp | None = Field(None, description="also pass a range of speeds")
