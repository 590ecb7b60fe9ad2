"""From which crank angles a machine at rest starts at all: intervals with refined boundaries."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.numerics.runge_kutta_march import march
from vibecalc.numerics.typing import BoolArray, FloatArray
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.start_up_states import ANGLE, FULL_LOAD, STATES, Load
from vibecalc.response.roll.start_up_system import StartUpSystem
from vibecalc.response.roll.start_up_verdict import running_branch

#: parts into which every bracket is cut in one batch
_PARTS = 6

#: brackets beyond which the set counts as without structure
_MOST = 100


class StartAngles(NamedTuple):
    """Where the machine starts.

    `angle`, `starts` (k,): the angles examined first, rad, and what came of them. `interval`
    (n, 2): where it starts, from and to, in rad, the second one up to a turn beyond 2 pi; `error`
    is that of each end. `fraction` is the share of the turn from which it starts, with
    `fraction_error`. Intervals or gaps narrower than the step of `angle` may be missed; `islands`
    says that the search for the ends has met such, so that there are probably more.
    """

    angle: FloatArray
    starts: BoolArray
    interval: FloatArray
    error: float
    fraction: float
    fraction_error: float
    islands: bool


def start_angles(
    machine: RollMachine,
    drive: RollDrive,
    *,
    duration: float,
    angles: int = 72,
    load: Load = FULL_LOAD,
    started_speed: float | None = None,
    width: float = 1e-6,
    tolerance: float = 1e-7,
) -> StartAngles:
    """Start one machine from rest at `angles` even crank angles, and find the borders between.

    It counts as started once its mean speed over a turn reaches `started_speed` (rad/s; the speed
    of the breakdown torque, if not given) within `duration` s. Each border is enclosed to within
    `width` rad.

    Raises NumericalFailure where the slip leaves a table that is not continued (any machine that
    rocks turns backward: a table to locked rotor needs to be continued), and where the borders
    multiply as they are refined.
    """
    goal = running_branch(drive) if started_speed is None else started_speed

    def outcome(angle: FloatArray) -> BoolArray:
        return starts_from(machine, drive, angle, duration, load, goal, tolerance)

    first = TURN * np.arange(angles) / angles
    starts = outcome(first)
    low, high, risen, islands = first, np.append(first[1:], TURN), starts, False
    falls = starts != np.roll(starts, -1)
    low, high, risen = low[falls], high[falls], ~starts[falls]
    while len(low) and float(np.max(high - low)) > width:
        inner = low[:, None] + (high - low)[:, None] * np.arange(1, _PARTS) / _PARTS
        found = outcome(np.mod(inner.ravel(), TURN)).reshape(inner.shape)
        edges = np.concatenate([low[:, None], inner, high[:, None]], axis=1)
        values = np.concatenate([~risen[:, None], found, risen[:, None]], axis=1)
        row, place = np.nonzero(values[:, :-1] != values[:, 1:])
        islands = islands or len(row) > len(low)
        if len(row) > _MOST:
            raise NumericalFailure(
                f"the angles from which the machine starts have no clear borders: {len(row)} were "
                f"found and more come up; friction or a longer run makes them clear"
            )
        low, high, risen = edges[row, place], edges[row, place + 1], values[row, place + 1]
    middle = 0.5 * (low + high)
    error = 0.5 * float(np.max(high - low)) if len(low) else 0.0
    interval = _intervals(middle, risen, bool(starts[0]))
    # the sum of the lengths, each with the errors of two ends
    fraction = float(np.sum(interval[:, 1] - interval[:, 0])) / TURN
    return StartAngles(
        first, starts, interval, error, fraction, len(middle) * error / TURN, islands
    )


def starts_from(
    machine: RollMachine,
    drive: RollDrive,
    angle: FloatArray,
    duration: float,
    load: Load,
    goal: float,
    tolerance: float = 1e-7,
) -> BoolArray:
    """Whether the machine, from rest at the crank angles (b,), runs a turn at a mean of `goal`."""
    system = StartUpSystem(machine, drive, load, tolerance, until_speed=goal)
    count = len(angle)
    state = np.zeros((count, STATES))
    state[:, ANGLE] = angle
    march(
        system,
        np.zeros(count),
        state,
        system.first_piece(state, 0.0),
        np.full(count, duration),
        absolute=tolerance * system.scale,
        stops=np.broadcast_to(load.time, (count, len(load.time))),
        keep=False,
    )
    return system.started(count)


def _intervals(border: FloatArray, risen: BoolArray, all_or_none: bool) -> FloatArray:
    """Intervals (n, 2) between borders where the machine begins (`risen`) and ceases to start."""
    if not len(border):
        return np.array([[0.0, TURN]]) if all_or_none else np.zeros((0, 2))
    begins, ends = border[risen], border[~risen]
    place = np.searchsorted(ends, begins)
    closed = np.append(ends, ends[:1] + TURN)
    return np.stack([begins, closed[place]], axis=1)
