"""Time marching of one machine from turn to turn until the turn repeats."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.excitation.gas_tables import TURN
from vibecalc.numerics.rounding import FloatArray
from vibecalc.roll.between_kinks import running
from vibecalc.roll.mechanism import RollDrive, RollMachine, is_mounted
from vibecalc.roll.turn import Turn

# ----------------------------------------------------------------------------
# Time marching of one machine from turn to turn until the turn repeats: the plain methods.
#
# Euler's method at a fixed step is what the program of Herold (1977, appendix A) runs, the
# classical Runge-Kutta method and DOP853 are yardsticks next to it. None of them examines the kinks
# of the tables, and none estimates its own error: compare a run with one of half the step.
# ----------------------------------------------------------------------------

#: accelerations (crank, shell) from crank angle, crank speed, shell angle and shell speed
_Rates = Callable[[float, float, float, float], tuple[float, float]]

#: crank angle, crank speed, shell angle, shell speed
_State = tuple[float, float, float, float]


class March(NamedTuple):
    """The last turn of a march.

    `turn` has k points evenly spaced in time or, with a fixed step, the steps and the interpolated
    ends, with the weights of the trapezoid rule in time. `crank_acceleration` (against the shell)
    and `shell_acceleration` (k,) in rad/s^2. `turns` were marched; `change` is by how much the
    last turn differs from the one before: period, and speeds over the mean speed (and with
    mounts the shell's angle), the largest. `evaluations` of the equations were made.
    """

    turn: Turn
    crank_acceleration: FloatArray
    shell_acceleration: FloatArray
    turns: int
    change: float
    evaluations: int


def march_to_repeat(
    machine: RollMachine,
    drive: RollDrive,
    method: str,
    *,
    started_at: float,
    shell_speed: float = 0.0,
    step: float = 0.5e-3,
    repeats: float = 1e-5,
    turns: int | None = None,
    most: int = 2000,
    points: int = 720,
    tolerance: float = 1e-8,
) -> March:
    """March from crank angle 0 and crank speed `started_at` until a turn repeats the one before.

    `method` is one of METHODS; `step` in s is that of "euler" and "rk4", while "dop853" runs at
    the relative `tolerance` and is read at `points` even times of the last turn. With `turns` that
    many are marched, whatever they do; the source marches 3. A fixed step meets every turn at
    other angles, so that turns repeat to about the square of its share of a turn only.

    Raises UsageError for an unknown method. NumericalFailure where the crank stops, the slip
    leaves its table, or no turn repeats to `repeats` within `most` turns.
    """
    if method not in METHODS:
        raise UsageError(f"no method {method!r}; there are {', '.join(METHODS)}")
    start = (0.0, float(started_at), 0.0, float(shell_speed))
    if started_at <= 0.0:
        raise NumericalFailure("a march to a running state has to start with the crank turning")
    rates = running(machine, drive)
    settings = _Settings(step, repeats, turns, most, points, is_mounted(machine))
    if method == "dop853":
        return March(*march_scipy(rates, start, tolerance, *settings))
    return _march_fixed(rates, start, method, settings)


class _Settings(NamedTuple):
    step: float
    repeats: float
    turns: int | None
    most: int
    points: int
    mounted: bool


#: columns of what is kept of a turn: time, the state, and both accelerations
_TIME, _ANGLE, _SPEED, _SHELL_ANGLE, _SHELL_SPEED, _CRANK, _SHELL = range(7)
_Row = tuple[float, float, float, float, float, float, float]


def _march_fixed(rates: _Rates, start: _State, method: str, settings: _Settings) -> March:
    rows: list[_Row] = []
    advance = _euler if method == "euler" else _rk4
    time, state, number, passed = 0.0, start, 0, [_first_row(rates, start)]
    change = np.inf
    while True:
        rows, time, state = advance(rates, time, state, settings.step, TURN * (number + 1))
        section = _between(rates, rows[-2], rows[-1], TURN * (number + 1))
        passed = [*passed[-2:], section]
        number += 1
        change = _change(passed, settings.mounted)
        if number == settings.turns or (settings.turns is None and change <= settings.repeats):
            break
        if number >= settings.most:
            raise NumericalFailure(_unsettled(method, number, change))
    inner = [row for row in rows if passed[-2][_TIME] < row[_TIME] < section[_TIME]]
    table = np.array([passed[-2], *inner, section])
    steps = round(time / settings.step)
    return _as_march(table, number, change, steps * (1 if method == "euler" else 4))


def _euler(
    rates: _Rates, time: float, state: _State, step: float, goal: float
) -> tuple[list[_Row], float, _State]:
    """Steps from `state` until the crank angle passes `goal`; every row, the last one beyond."""
    b, w, theta, s = state
    rows: list[_Row] = []
    keep = rows.append
    while b < goal:
        crank, shell = rates(b, w, theta, s)
        keep((time, b, w, theta, s, crank, shell))
        b += step * w
        theta += step * s
        w += step * crank
        s += step * shell
        time += step
    crank, shell = rates(b, w, theta, s)
    keep((time, b, w, theta, s, crank, shell))
    return rows, time, (b, w, theta, s)


def _rk4(
    rates: _Rates, time: float, state: _State, step: float, goal: float
) -> tuple[list[_Row], float, _State]:
    b, w, theta, s = state
    rows: list[_Row] = []
    half, sixth = 0.5 * step, step / 6.0
    while b < goal:
        c1, d1 = rates(b, w, theta, s)
        rows.append((time, b, w, theta, s, c1, d1))
        w2, s2 = w + half * c1, s + half * d1
        c2, d2 = rates(b + half * w, w2, theta + half * s, s2)
        w3, s3 = w + half * c2, s + half * d2
        c3, d3 = rates(b + half * w2, w3, theta + half * s2, s3)
        w4, s4 = w + step * c3, s + step * d3
        c4, d4 = rates(b + step * w3, w4, theta + step * s3, s4)
        b += sixth * (w + 2.0 * (w2 + w3) + w4)
        theta += sixth * (s + 2.0 * (s2 + s3) + s4)
        w += sixth * (c1 + 2.0 * (c2 + c3) + c4)
        s += sixth * (d1 + 2.0 * (d2 + d3) + d4)
        time += step
    crank, shell = rates(b, w, theta, s)
    rows.append((time, b, w, theta, s, crank, shell))
    return rows, time, (b, w, theta, s)


def _first_row(rates: _Rates, state: _State) -> _Row:
    crank, shell = rates(*state)
    return (0.0, *state, crank, shell)


def _between(rates: _Rates, before: _Row, after: _Row, goal: float) -> _Row:
    """Where the cubic through both rows, with their rates, has the crank angle `goal`."""
    length = after[_TIME] - before[_TIME]

    def cubic(value: int, rate: int, s: float) -> float:
        y, z = before[value], after[value]
        u, v = length * before[rate], length * after[rate]
        return y + s * (u + s * (3.0 * (z - y) - 2.0 * u - v + s * (u + v - 2.0 * (z - y))))

    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if cubic(_ANGLE, _SPEED, middle) < goal:
            low = middle
        else:
            high = middle
    s = 0.5 * (low + high)
    speed, shell_speed = cubic(_SPEED, _CRANK, s), cubic(_SHELL_SPEED, _SHELL, s)
    shell_angle = cubic(_SHELL_ANGLE, _SHELL_SPEED, s)
    crank, shell = rates(goal, speed, shell_angle, shell_speed)
    time = before[_TIME] + s * length
    return (time, goal, speed, shell_angle, shell_speed, crank, shell)


def _change(passed: list[_Row], mounted: bool) -> float:
    """Largest relative change over the last of two turns; infinite while there is one only."""
    if len(passed) < 3:
        return float(np.inf)
    first, middle, last = passed
    period, before = last[_TIME] - middle[_TIME], middle[_TIME] - first[_TIME]
    mean = TURN / period
    found = [abs(period - before) / period]
    found += [abs(last[k] - middle[k]) / mean for k in (_SPEED, _SHELL_SPEED)]
    if mounted:
        found.append(abs(last[_SHELL_ANGLE] - middle[_SHELL_ANGLE]))
    return max(found)


def _unsettled(method: str, turns: int, change: float) -> str:
    return (
        f"{method} has not come to a periodic state in {turns} turns: the last differs from the "
        f"one before by {change:.2g} of its mean speed"
    )


def _as_march(table: FloatArray, turns: int, change: float, evaluations: int) -> March:
    time = table[:, _TIME] - table[0, _TIME]
    gap = np.diff(time)
    share = np.zeros(len(time))
    share[:-1] += 0.5 * gap
    share[1:] += 0.5 * gap
    speed = table[:, _SPEED]
    angle = table[:, _ANGLE] - table[0, _ANGLE]
    turn = Turn(
        angle, share * speed, time, speed, table[:, _SHELL_SPEED], table[:, _SHELL_ANGLE],
        np.asarray(time[-1]),
    )  # fmt: skip
    return March(turn, table[:, _CRANK], table[:, _SHELL], turns, change, evaluations)


METHODS = ("euler", "rk4", "dop853")

# ----------------------------------------------------------------------------
# The march of `march.py` with DOP853 as scipy has it, used plainly: a yardstick.
# ----------------------------------------------------------------------------


def march_scipy(
    rates: Callable[[float, float, float, float], tuple[float, float]],
    start: tuple[float, float, float, float],
    tolerance: float,
    step: float,
    repeats: float,
    turns: int | None,
    most: int,
    points: int,
    mounted: bool,
) -> tuple[Turn, FloatArray, FloatArray, int, float, int]:
    """The fields of `march.March`; arguments as there. The step is the method's own."""
    from scipy.integrate import solve_ivp

    def equations(time: float, y: FloatArray) -> tuple[float, float, float, float]:
        b, w, theta, s = y.tolist()
        crank, shell = rates(b, w, theta, s)
        return w, crank, s, shell

    def passes(time: float, y: FloatArray) -> float:
        return float(y[0] - goal)

    passes.terminal, passes.direction = True, 1.0  # type: ignore[attr-defined]
    time, state, number, evaluations = 0.0, np.array(start), 0, 0
    marks = [(time, state)]
    while True:
        goal = TURN * (number + 1)
        # a turn may take ten times as long as its first speed says
        solution = solve_ivp(
            equations, (time, time + 10.0 * TURN / abs(state[1])), state, method="DOP853",
            rtol=tolerance, atol=tolerance, events=passes, dense_output=True,
        )  # fmt: skip
        evaluations += int(solution.nfev)
        if not len(solution.t_events[0]):
            raise NumericalFailure("DOP853 finds no end of the turn: the crank slows to rest")
        time, state, number = float(solution.t_events[0][0]), solution.y_events[0][0], number + 1
        marks = [*marks[-2:], (time, state)]
        change = _change_of_marks(marks, mounted)
        if number == turns or (turns is None and change <= repeats):
            break
        if number >= most:
            raise NumericalFailure(
                f"dop853 has not come to a periodic state in {number} turns: the last differs from "
                f"the one before by {change:.2g} of its mean speed"
            )
    period = time - marks[-2][0]
    places = period * np.arange(points + 1) / points
    angle, speed, shell_angle, shell_speed = solution.sol(marks[-2][0] + places)
    rows = zip(angle, speed, shell_angle, shell_speed, strict=True)
    both = [rates(*(float(value) for value in row)) for row in rows]
    crank, shell = np.array(both).T
    share = np.full(points + 1, period / points)
    share[[0, -1]] *= 0.5
    turn = Turn(
        angle - TURN * (number - 1), share * speed, places, speed, shell_speed, shell_angle,
        np.asarray(period),
    )  # fmt: skip
    return turn, crank, shell, number, change, evaluations


def _change_of_marks(marks: list[tuple[float, FloatArray]], mounted: bool) -> float:
    if len(marks) < 3:
        return float(np.inf)
    (t0, _), (t1, middle), (t2, last) = marks
    period = t2 - t1
    off = np.abs(last - middle)
    found = [abs(period - (t1 - t0)) / period, *(off[[1, 3]] * period / TURN).tolist()]
    return float(max([*found, off[2]] if mounted else found))
