"""The table [isolation] of a case."""

from typing import Literal

from vibecalc.core.case.fields import (
    Acceleration,
    Length,
    Number,
    RunUp,
    Table,
    key,
)
from vibecalc.core.case.rules import needs, wants
from vibecalc.parts.body_tables import no_matrices
from vibecalc.parts.tables import LOADS, Loads, shaking_acts
from vibecalc.unit_table import FREE_FALL

_WITHOUT = "leave [isolation] out for forces and balance only"


class Isolation(Table):
    """The body on its mounts: what reaches the ground."""

    model: Literal["pitch", "rigid_body", "planar"] = key(
        "pitch across the crankshaft, six freedoms, or three in the plane of the crank"
    )
    up: Literal["x", "y", "z"] = key("gravity acts against this direction", "z")
    gravity: Acceleration = key("acceleration of free fall", FREE_FALL, ge=0)
    lever: Length | None = key("arm of `couple_over_lever`; default: of mounts", None, gt=0)
    loads: Loads = key(LOADS, ("shaking", "torque"), min_length=1)
    run_up: RunUp | None = key("also pass a range of speeds", None)
    run_up_maxima: Number | None = key(
        "local maxima of the run-up from this share of the highest on", None, gt=0, le=1
    )
    efficiency: bool | None = key(
        "what mounts keep from the ground, by order and frequency", None, strict=True
    )
    RULES = (
        needs("run_up_maxima", "run_up", allowed='run_up = { from = 0, to = "..." } with it'),
        shaking_acts("isolation/support_force/by_cause has the torque alone"),
        wants("machine.body", hint=_WITHOUT),
        wants("machine.mounts", hint=_WITHOUT),
        *no_matrices(hint="[response] takes matrices"),
    )
