"""What a change of each parameter does to each harmonic of the shell: slopes and larger changes."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray
from vibecalc.roll.mechanism import PER_CYLINDER, RollDrive, RollMachine, member
from vibecalc.roll.rates import surely_fastest
from vibecalc.roll.running import running_state
from vibecalc.roll.steady import SteadyTurn, is_stable, multipliers, steady_state, within_table
from vibecalc.roll.turn import level, shell_harmonics

# ----------------------------------------------------------------------------
# Slopes: by how much each parameter changes each harmonic of the shell, for small changes.
# ----------------------------------------------------------------------------

#: relative step of a parameter; the others are its double and both the other way
_STEP = 1e-3
_FACTORS = (1.0 + _STEP, 1.0 - _STEP, 1.0 + 2.0 * _STEP, 1.0 - 2.0 * _STEP)
_SHARED = (
    "rod_length",
    "crank_radius",
    "shell_inertia",
    "rotor_inertia",
    "motor_scale",
    "shell_stiffness",
    "shell_damping",
    "friction_torque",
    "friction_damping",
    "piston_friction",
)
_OF_CYLINDERS = ("reciprocating_mass", "gas_scale")


class Sensitivity(NamedTuple):
    """dB for one percent more of each parameter (parameters, orders), and the error of each."""

    parameters: tuple[str, ...]
    value: FloatArray
    error: FloatArray


def sensitivity(
    machine: RollMachine,
    drive: RollDrive,
    orders: Sequence[int],
    cylinders: Sequence[str],
    *,
    points: int,
    started_at: float | None = None,
) -> Sensitivity:
    """Slopes of the levels of the shell's acceleration for one machine (B = 1), as one batch.

    Central differences in the logarithm of each parameter with two steps, extrapolated; the error
    is what the extrapolation changed. Parameters that are zero are left out.
    """
    rows = parameters(machine, cylinders)
    batch = altered(machine, [(row, factor) for row in rows for factor in _FACTORS])
    state = steady_state(batch, drive, points, started_at=started_at)
    if not state.solved.all():
        lost = rows[int(np.flatnonzero(~state.solved)[0]) // len(_FACTORS)][0]
        raise NumericalFailure(
            f"roll: with {lost} changed by two thousandths the running state is lost, so that its "
            "levels have no slope; leave sensitivity away"
        )
    high = _levels(batch, drive, state, orders).reshape(len(rows), len(_FACTORS), len(orders))
    near = (high[:, 0] - high[:, 1]) / (np.log1p(_STEP) - np.log1p(-_STEP))
    far = (high[:, 2] - high[:, 3]) / (np.log1p(2.0 * _STEP) - np.log1p(-2.0 * _STEP))
    slope = (4.0 * near - far) / 3.0
    noise = 1e4 * EPSILON / _STEP
    error = np.abs(slope - near) + noise
    percent = np.log1p(0.01)
    return Sensitivity(tuple(name for name, _, _ in rows), percent * slope, percent * error)


class Parameter(NamedTuple):
    """What may be altered: its name, its field of the machine, and which cylinder's it is."""

    name: str
    field: str
    cylinder: int | None


def parameters(machine: RollMachine, cylinders: Sequence[str]) -> list[Parameter]:
    """Every parameter of the machine that is there, that is not zero."""
    names: dict[str, str] = {"motor_scale": "motor_torque"}
    rows = [
        Parameter(names.get(field, field), field, None)
        for field in _SHARED
        if np.any(getattr(machine, field))
    ]
    words = {"reciprocating_mass": "reciprocating_mass", "gas_scale": "gas_force"}
    for field in _OF_CYLINDERS:
        rows += [
            Parameter(f"{words[field]} {name}", field, place)
            for place, name in enumerate(cylinders)
            if np.any(getattr(machine, field)[..., place])
        ]
    return rows


def altered(machine: RollMachine, changes: Sequence[tuple[Parameter | None, float]]) -> RollMachine:
    """One machine (B = 1) for each change: a parameter times a factor, or None for no change."""
    fields = {
        name: np.repeat(getattr(machine, name), len(changes), axis=0) for name in machine._fields
    }
    for row, (parameter, factor) in enumerate(changes):
        if parameter is None:
            continue
        if parameter.field in PER_CYLINDER:
            fields[parameter.field][row, parameter.cylinder] *= factor
        else:
            fields[parameter.field][row] *= factor
    return RollMachine(**fields)


# ----------------------------------------------------------------------------
# What larger changes of the machine do to the shell: each one solved for, no slope.
# ----------------------------------------------------------------------------

#: the rounding of a sum over a turn, over the largest harmonic
_ROUNDING = 1e3 * EPSILON
#: dB for a relative change, when it is small
_DECIBELS = 20.0 / np.log(10.0)


class LevelChange(NamedTuple):
    """Changes of level, dB, for one factor on each parameter (parameters, orders).

    `lost` are parameters with which no running state was found, each with the reason in words;
    they are not among `parameters`.
    """

    parameters: tuple[str, ...]
    value: FloatArray
    error: FloatArray
    lost: tuple[tuple[str, str], ...]


def changes(
    machine: RollMachine,
    drive: RollDrive,
    orders: Sequence[int],
    cylinders: Sequence[str],
    factors: Sequence[float],
    *,
    points: int,
    started_at: float | None = None,
) -> list[LevelChange]:
    """Levels of the shell's acceleration with each parameter times each factor, less those as is.

    For one machine (B = 1), which runs. All altered machines are one batch; one that it does not
    surely solve is solved alone, by all that `running_state` knows. The error is twice what two
    more points on each panel change, and the rounding.
    """
    rows = parameters(machine, cylinders)
    asked = [(row, factor) for factor in factors for row in rows]
    batch = altered(machine, [(None, 1.0), *asked])
    fits = _turns(batch)
    # a stand-in for what cannot turn at all; it is not examined
    usable = altered(machine, [(None, 1.0), *((r, f if ok else 1.0) for (r, f), ok in
                                              zip(asked, fits[1:], strict=True))])  # fmt: skip
    first = steady_state(usable, drive, points, started_at=started_at)
    finer = steady_state(usable, drive, points + 2, started_at=started_at, start=first)
    level, other = (_levels(usable, drive, state, orders) for state in (first, finer))
    sure = first.solved & finer.solved & surely_fastest(usable, drive, first.turn)
    sure &= is_stable(*multipliers(first)) & within_table(first, drive)
    reasons: dict[int, str] = {}
    for place in np.flatnonzero(~sure | ~fits):
        if not fits[place]:
            reasons[int(place)] = "the rod is too short for the crank"
            continue
        try:
            alone = _alone(member(batch, int(place)), drive, orders, points, started_at)
        except NumericalFailure as failure:
            reasons[int(place)] = str(failure).removeprefix("roll: ")
        else:
            level[place], other[place] = alone
    return [
        _change(rows, 1 + step * len(rows), level, other, reasons) for step in range(len(factors))
    ]


def _change(
    rows: Sequence[Parameter],
    start: int,
    level: FloatArray,
    other: FloatArray,
    reasons: dict[int, str],
) -> LevelChange:
    places = np.arange(start, start + len(rows))
    if 0 in reasons or not np.isfinite(level[0]).all():
        raise NumericalFailure(
            "roll: the running state is lost when it is solved for once more, so that nothing can "
            "be said of changes; leave sensitivity away"
        )
    lost = {int(place): reasons[int(place)] for place in places if int(place) in reasons}
    for place in places:
        if int(place) not in lost and not np.isfinite(level[place]).all():
            lost[int(place)] = "a harmonic vanishes, which has no level"
    usable = np.array([place for place in places if int(place) not in lost], dtype=int)
    value = level[usable] - level[0]
    uncertainty = np.abs(value - (other[usable] - other[0]))
    error = 2.0 * uncertainty + _rounding(level[usable]) + _rounding(level[:1])
    names = tuple(rows[place - start].name for place in usable)
    return LevelChange(
        names, value, error, tuple((rows[p - start].name, words) for p, words in lost.items())
    )


def _rounding(levels: FloatArray) -> FloatArray:
    """dB; the rounding of a harmonic is that of the largest one."""
    below = np.max(levels, axis=-1, keepdims=True, initial=-np.inf) - levels
    return np.asarray(_DECIBELS * _ROUNDING * 10.0 ** (below / 20.0))


def _alone(
    machine: RollMachine,
    drive: RollDrive,
    orders: Sequence[int],
    points: int,
    started_at: float | None,
) -> tuple[FloatArray, FloatArray]:
    running = running_state(
        machine, drive, rtol=1.0, orders=max(orders), started_at=started_at, points=points
    )
    level, other = (
        _levels(machine, drive, one, orders)[0] for one in (running.state, running.check)
    )
    return level, other


def _levels(
    machine: RollMachine, drive: RollDrive, state: SteadyTurn, orders: Sequence[int]
) -> FloatArray:
    numbers = np.asarray(orders, dtype=float)
    return level(shell_harmonics(machine, drive, state.turn, numbers, state.place))


def _turns(batch: RollMachine) -> BoolArray:
    """Whether the rod reaches over the crank, in all positions of all cylinders."""
    offset = np.abs(batch.wrist_pin_offset)
    return np.asarray(batch.rod_length > batch.crank_radius + offset)
