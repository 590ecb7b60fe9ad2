"""The march of `march.py` with DOP853 as scipy has it, used plainly: a yardstick."""

from collections.abc import Callable

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.gas_tables import TURN
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.turn import Turn


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
        found = solve_ivp(
            equations, (time, time + 10.0 * TURN / abs(state[1])), state, method="DOP853",
            rtol=tolerance, atol=tolerance, events=passes, dense_output=True,
        )  # fmt: skip
        evaluations += int(found.nfev)
        if not len(found.t_events[0]):
            raise NumericalFailure("DOP853 finds no end of the turn: the crank slows to rest")
        time, state, number = float(found.t_events[0][0]), found.y_events[0][0], number + 1
        marks = [*marks[-2:], (time, state)]
        change = _change(marks, mounted)
        if number == turns or (turns is None and change <= repeats):
            break
        if number >= most:
            raise NumericalFailure(
                f"dop853 has not come to a periodic state in {number} turns: the last differs from "
                f"the one before by {change:.2g} of its mean speed"
            )
    period = time - marks[-2][0]
    places = period * np.arange(points + 1) / points
    angle, speed, shell_angle, shell_speed = found.sol(marks[-2][0] + places)
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


def _change(marks: list[tuple[float, FloatArray]], mounted: bool) -> float:
    if len(marks) < 3:
        return float(np.inf)
    (t0, _), (t1, middle), (t2, last) = marks
    period = t2 - t1
    off = np.abs(last - middle)
    found = [abs(period - (t1 - t0)) / period, *(off[[1, 3]] * period / TURN).tolist()]
    return float(max([*found, off[2]] if mounted else found))
