"""The table [isolation] of a case."""

from typing import Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Acceleration,
    Length,
    Number,
    RunUp,
    Table,
)
from vibecalc.core.case.rules import needs, wants
from vibecalc.parts.body_tables import no_matrices
from vibecalc.parts.tables import LOADS, Loads, shaking_acts
from vibecalc.unit_table import FREE_FALL

_WITHOUT = "leave [isolation] out for forces and balance only"


class Isolation(Table):
    """The body on its mounts: what reaches the ground."""

    model: Literal["pitch", "rigid_body", "planar"] = Field(
        description="pitch across the crankshaft, six freedoms, or three in the plane of the crank"
    )
    up: Literal["x", "y", "z"] = Field("z", description="gravity acts against this direction")
    gravity: Acceleration = Field(FREE_FALL, ge=0, description="acceleration of free fall")
    lever: Length | None = Field(None, gt=0, description="arm of `lever_force`; default: of mounts")
    loads: Loads = Field(("shaking", "torque"), min_length=1, description=LOADS)
    run_up: RunUp | None = Field(None, description="also pass a range of speeds")
    run_up_maxima: Number | None = Field(
        None, gt=0, le=1, description="local maxima of the run-up from this share of the highest on"
    )
    efficiency: bool | None = Field(
        None, strict=True, description="what mounts keep from the ground, by order and frequency"
    )
    RULES = (
        needs("run_up_maxima", "run_up", allowed='run_up = { from = 0, to = "..." } with it'),
        shaking_acts("isolation/support_force/by_cause has the torque alone"),
        wants("machine.body", hint=_WITHOUT),
        wants("machine.mounts", hint=_WITHOUT),
        *no_matrices(hint="[response] takes matrices"),
    )
