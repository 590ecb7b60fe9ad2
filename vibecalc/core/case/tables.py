"""The tables of a case beside the machine: what is asked of it, and against what it is held."""

from typing import Annotated, Literal

from pydantic import Field

from vibecalc.core.case.fields import (
    Acceleration,
    Labels,
    Length,
    Name,
    Number,
    RunUp,
    Table,
    Value,
    Where,
)
from vibecalc.response.tables import Idle, Names, Throws

Order = Annotated[int, Field(strict=True, ge=1, le=400)]


class Kinematics(Table):
    """Motion of the pistons; present, it also puts the motion over one turn into the result."""

    series: Literal["exact", "truncated"] = Field(
        "exact", description="exact motion, or the binomial series in (R/L)^2 cut after `terms`"
    )
    terms: Annotated[int, Field(strict=True, ge=1, le=400)] | None = Field(
        None, description="terms of a truncated series; 1 is the classic first and second order"
    )


class Balance(Table):
    """The balance table: sums of sin, cos, z sin and z cos over the cylinders."""

    orders: tuple[Order, ...] = Field(
        (1, 2), min_length=1, max_length=64, description="orders to tabulate"
    )


class Residual(Table):
    """One number for what is left unbalanced, for comparing and optimising crank trains."""

    force_weight: Number = Field(1.0, ge=0, description="weight of the forces")
    couple_weight: Number = Field(1.0, ge=0, description="weight of the couples")
    reference_length: Length = Field(gt=0, description="couples are divided by it")


class Excitation(Table):
    """Forces and couples of the crank train on the body."""

    orders: Order | None = Field(
        None, description="highest order kept; without it the tolerance decides"
    )
    working: Names | None = Field(
        None, description="names of the cylinders that work; default: all"
    )
    idle: Idle = Field(
        "stopped", description="the others: stopped, or moving without gas force (unloaded)"
    )
    balanced_for: Throws | None = Field(
        None, description="throws whose rotating mass is cancelled by weights in their own plane"
    )
    driven_machine: Literal["on_body", "separate", "cancels_torque"] = Field(
        "on_body",
        description="on_body: its stator gives the body the mean torque back, what alternates acts "
        "on the body; separate: the mean acts, too; cancels_torque: none of it acts, as if the "
        "stator followed every pulsation",
    )
    balance: Balance | None = Field(None, description="print the balance table")
    residual: Residual | None = Field(None, description="weighted residual of forces and couples")


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


SearchMethod = Literal[
    "sequential_quadratic", "hooke_jeeves", "nelder_mead", "differential_evolution"
]


class Tied(Table):
    """A key that follows a variable: factor times its value, plus an offset."""

    key: Name = Field(description="the key that follows")
    factor: Number = Field(1.0, description="times the value of the variable")
    offset: Value | None = Field(None, description="added to that, SI or with a unit; default: 0")


class Variable(Table):
    """One key of the case that the optimiser may change, with the keys that follow it."""

    key: Name = Field(description="as in machine.mounts.each.stiffness or ...cylinders[0].position")
    lower: Value = Field(description="lower bound, SI or with a unit")
    upper: Value = Field(description="upper bound, SI or with a unit")
    follow: tuple[Tied, ...] = Field(
        (),
        alias="with",
        max_length=32,
        description="keys that follow it: each factor times its value, plus offset",
    )


class Objective(Table):
    """The quantity to make small or large; on an array its worst entry counts."""

    quantity: Name = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks entries along named axes")
    sense: Literal["min", "max"] = Field("min", description="make it small or large")


class Optimisation(Table):
    """Change some keys within bounds until the objective is best and all limits are kept."""

    variables: tuple[Variable, ...] = Field(
        min_length=1, max_length=32, description="what to change"
    )
    objective: Objective = Field(description="what to improve")
    starts: Annotated[int, Field(strict=True, ge=1, le=1000)] = Field(
        8, description="starting points spread over the bounds, beside the case as written"
    )
    method: SearchMethod | None = Field(
        None,
        description="what searches from each start, before the end is refined; "
        "default: sequential_quadratic",
    )
    compare: tuple[SearchMethod, ...] = Field(
        (),
        max_length=8,
        description="methods to run side by side, each alone from the case as written",
    )
    sensitivity: Literal["start", "optimum", "both"] | None = Field(
        None, description="where to take slopes of the objective, for advice in the report"
    )
    second_objective: Objective | None = Field(
        None, description="also trace the front between the objective and this one"
    )
    front_points: Annotated[int, Field(strict=True, ge=2, le=200)] | None = Field(
        None, description="points of the front, both ends included; default: 15"
    )


class Accuracy(Table):
    """The one dial between speed and accuracy."""

    rtol: Number = Field(
        1e-9, ge=1e-14, le=0.1, description="of the largest magnitude of each quantity"
    )


class Reference(Table):
    """A published or measured number for this machine, shown beside ours."""

    quantity: Name = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks one entry along named axes")
    value: Value = Field(description="as printed: its last digit sets the default tolerance")
    unit: str = Field("", description="unit of the value, if the value does not carry it")
    rtol: Number | None = Field(None, gt=0, lt=1, description="relative tolerance")
    atol: Value | None = Field(None, description="absolute tolerance, in the value's unit")
    digits: Literal["rounded", "truncated"] = Field(
        "rounded", description="truncated: within a whole unit of the last digit, not half of one"
    )
    source: Name = Field(description="table, figure or page")
    kind: Literal["published", "measured"] = Field(
        "published", description="measured numbers are shown and never counted"
    )
    known_difference: str = Field("", description="why the source differs; then it is not counted")
    shown_by: str = Field(
        "", description="test that reproduces the printed value, or 'not reproducible: ...'"
    )
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")


class ReferenceTable(Table):
    """Published or measured numbers for many entries of one quantity, one row for each."""

    quantity: Name = Field(description="result path")
    axis: Name = Field(description="axis that the rows pick entries of")
    where: Where = Field(default_factory=dict, description="picks along the other axes")
    file: str = Field(
        "", description="CSV beside the case, its first column entries; instead of entry and value"
    )
    column: str = Field("", description="name of the file's column that holds the values")
    entry: Labels = Field((), description="entries of the axis, one for each value")
    value: Annotated[tuple[Value, ...], Field(max_length=20_000)] = Field(
        (), description="as printed: last digits set the tolerance"
    )
    unit: str = Field("", description="unit of the values")
    rtol: Number | None = Field(None, gt=0, lt=1, description="relative tolerance")
    digits: Literal["rounded", "truncated"] = Field(
        "rounded", description="truncated: within a whole unit of the last digit, not half of one"
    )
    source: Name = Field(description="table, figure or page")
    kind: Literal["published", "measured"] = Field(
        "published", description="measured numbers are shown and never counted"
    )
    known_difference: str = Field("", description="why the source differs; then it is not counted")
    shown_by: str = Field("", description="test that reproduces the values, or why none can")
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")


class Limit(Table):
    """A bound that a result has to keep; the optimiser takes the same list."""

    quantity: Name = Field(description="result path")
    where: Where = Field(default_factory=dict, description="picks entries along named axes")
    max: Value | None = Field(None, description="upper bound, SI or with a unit")
    min: Value | None = Field(None, description="lower bound, SI or with a unit")
    source: str = Field("", description="where the bound comes from")
    expect: Literal["kept", "broken"] = Field("kept", description="broken: for a demonstration")
    at: Literal["start", "optimum"] = Field("optimum", description="for cases with [optimisation]")
