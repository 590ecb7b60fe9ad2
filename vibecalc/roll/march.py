"""Time marching of one machine from turn to turn until the turn repeats."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.excitation.gas_tables import TURN
from vibecalc.numerics import explicit_steps
from vibecalc.numerics.rounding import FloatArray
from vibecalc.roll.between_kinks import running
from vibecalc.roll.mechanism import RollDrive, RollMachine, is_mounted
from vibecalc.roll.turn import Turn, trapezoids

# ----------------------------------------------------------------------------
# Time marching of one machine from turn to turn until the turn repeats: the plain methods.
#
# Euler's method at a fixed step is what the program of Herold (1977, appendix A) runs, the
# classical Runge-Kutta method and DOP853 are yardsticks next to it. None of them examines the kinks
# of the tables, and none estimates its own error: compare a run with one of half the step.
# ----------------------------------------------------------------------------

#: accelerations (crank, shell) from crank angle, crank speed, shell angle and shell speed
_Rates = Callable[[float, float, float, float], tuple[float, float]]
#: time, crank angle, crank speed, shell angle, shell speed, acceleration of crank and of shell
_Row = tuple[float, float, float, float, float, float, float]
_TIME, _ANGLE, _SPEED, _SHELL_ANGLE, _SHELL_SPEED, _CRANK, _SHELL = range(7)
#: the row at the end of each turn, the rows of that turn, and evaluations so far
_Turns = Iterator[tuple[_Row, Callable[[], list[_Row]], int]]

METHODS = ("euler", "rk4", "dop853")


class March(NamedTuple):
    """The last turn of a march.

    `turn` has k points evenly spaced in time or, with a fixed step, the steps and the interpolated
    ends, with the weights of the trapezoid rule in time. `shell_acceleration` (k,) in rad/s^2.
    `turns` were marched; `change` is by how much the last turn differs from the one before: period,
    and speeds over the mean speed (and with mounts the shell's angle), the largest. `evaluations`
    of the equations were made.
    """

    turn: Turn
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
    if started_at <= 0.0:
        raise NumericalFailure("a march to a running state has to start with the crank turning")
    rates = running(machine, drive)
    state = (0.0, float(started_at), 0.0, float(shell_speed))
    first = (0.0, *state, *rates(*state))
    if method == "dop853":
        marched = _scipy_turns(rates, first, tolerance, points)
    else:
        marched = _fixed_turns(rates, first, method, step)
    marks, change = [first], np.inf
    for number, turned in enumerate(marched, 1):
        marks = [*marks[-2:], turned[0]]
        change = _change(marks, is_mounted(machine))
        if number == turns or (turns is None and change <= repeats):
            break
        if number >= most:
            raise NumericalFailure(
                f"{method} has not come to a periodic state in {number} turns: the last differs "
                f"from the one before by {change:.2g} of its mean speed"
            )
    _, rows, evaluations = turned
    table = np.array(rows())
    time = table[:, _TIME] - table[0, _TIME]
    speed = table[:, _SPEED]
    turn = Turn(
        table[:, _ANGLE] - TURN * (number - 1), trapezoids(time) * speed, time, speed,
        table[:, _SHELL_SPEED], table[:, _SHELL_ANGLE], np.asarray(time[-1]),
    )  # fmt: skip
    return March(turn, table[:, _SHELL], number, change, evaluations)


def _fixed_turns(rates: _Rates, first: _Row, method: str, step: float) -> _Turns:
    tableau = explicit_steps.METHODS[method]
    stages = len(tableau.stage)

    def motion(_: int, state: Sequence[float]) -> tuple[float, ...]:
        """Rates of crank angle, crank speed, shell angle and shell speed."""
        crank, shell = rates(*state)
        return state[1], crank, state[3], shell

    rows, begin, goal = [first], first, 0.0
    while True:
        goal += TURN
        rows = rows[-1:]
        while rows[-1][_ANGLE] < goal:
            _, *now, crank, shell = rows[-1]
            begun = (now[1], crank, now[3], shell)
            state = explicit_steps.explicit_step(tableau, motion, now, step, begun)
            rows.append((rows[-1][_TIME] + step, *state, *rates(*state)))
        end = _between(rates, rows[-2], rows[-1], goal)
        inner = [row for row in rows if begin[_TIME] < row[_TIME] < end[_TIME]]
        turn = [begin, *inner, end]
        yield end, lambda turn=turn: turn, stages * round(rows[-1][_TIME] / step)  # type: ignore[misc]
        begin = end


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
    state = (goal, speed, cubic(_SHELL_ANGLE, _SHELL_SPEED, s), shell_speed)
    return (before[_TIME] + s * length, *state, *rates(*state))


def _scipy_turns(rates: _Rates, first: _Row, tolerance: float, points: int) -> _Turns:
    """The same with DOP853 as scipy has it, used plainly: a yardstick whose step is its own."""
    from scipy.integrate import solve_ivp

    def equations(time: float, y: FloatArray) -> tuple[float, float, float, float]:
        b, w, theta, s = y.tolist()
        crank, shell = rates(b, w, theta, s)
        return w, crank, s, shell

    def passes(time: float, y: FloatArray) -> float:
        return float(y[0] - goal)

    def row_at(time: float, y: FloatArray) -> _Row:
        state: tuple[float, float, float, float] = tuple(y.tolist())
        return (float(time), *state, *rates(*state))

    passes.terminal, passes.direction = True, 1.0  # type: ignore[attr-defined]
    time, state, goal, evaluations = 0.0, np.array(first[_ANGLE:_CRANK]), 0.0, 0
    while True:
        goal += TURN
        # a turn may take ten times as long as its first speed says
        solution = solve_ivp(
            equations, (time, time + 10.0 * TURN / abs(state[1])), state, method="DOP853",
            rtol=tolerance, atol=tolerance, events=passes, dense_output=True,
        )  # fmt: skip
        evaluations += int(solution.nfev)
        if not len(solution.t_events[0]):
            raise NumericalFailure("DOP853 finds no end of the turn: the crank slows to rest")
        begin, time, state = time, float(solution.t_events[0][0]), solution.y_events[0][0]
        places = begin + (time - begin) * np.arange(points + 1) / points

        def rows(places: FloatArray = places, along: Any = solution.sol) -> list[_Row]:
            return [row_at(*both) for both in zip(places, along(places).T, strict=True)]

        yield row_at(time, state), rows, evaluations


def _change(marks: list[_Row], mounted: bool) -> float:
    """Largest relative change over the last of two turns; infinite while there is one only."""
    if len(marks) < 3:
        return float(np.inf)
    first, middle, last = marks
    period, before = last[_TIME] - middle[_TIME], middle[_TIME] - first[_TIME]
    mean = TURN / period
    found = [abs(period - before) / period]
    found += [abs(last[k] - middle[k]) / mean for k in (_SPEED, _SHELL_SPEED)]
    if mounted:
        found.append(abs(last[_SHELL_ANGLE] - middle[_SHELL_ANGLE]))
    return max(found)
