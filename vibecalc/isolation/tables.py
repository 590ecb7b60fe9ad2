"""The table [isolation] of a case."""

from typing import Literal

from vibecalc.core.case.fields import Acceleration, Length, Number, RunUp, Table, key
from vibecalc.core.case.rules import needs, wants
from vibecalc.parts.body_tables import no_matrices
from vibecalc.parts.tables import LOADS, Loads, shaking_acts
from vibecalc.unit_table import FREE_FALL

_WITHOUT = "omit [isolation] if only forces and balance are required"


class Isolation(Table):
    """The body on its mounts: motion, mount forces, transmitted forces."""

    model: Literal["pitch", "rigid_body", "planar"] = key(
        "pitch across the crankshaft, 6 dof (rigid_body), or 3 dof in the plane of the crank "
        "(planar)"
    )
    up: Literal["x", "y", "z"] = key("vertical direction, upwards (against gravity)", "z")
    gravity: Acceleration = key("acceleration of gravity", FREE_FALL, ge=0)
    lever: Length | None = key("arm of `couple_over_lever`; default: from the mounts", None, gt=0)
    loads: Loads = key(LOADS, ("shaking", "torque"), min_length=1)
    run_up: RunUp | None = key("also a slow run-up over a speed range", None)
    run_up_maxima: Number | None = key(
        "local maxima of the run-up above this share of the highest are reported", None, gt=0, le=1
    )
    efficiency: bool | None = key(
        "also isolation efficiency by order and frequency", None, strict=True
    )
    RULES = (
        needs("run_up_maxima", "run_up", allowed='run_up = { from = 0, to = "..." } with it'),
        shaking_acts("isolation/support_force/by_cause has the torque alone"),
        wants("machine.body", hint=_WITHOUT),
        wants("machine.mounts", hint=_WITHOUT),
        *no_matrices(hint="[response] accepts matrices"),
    )
