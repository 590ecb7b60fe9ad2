"""Integrators on the equations of motion of a change, by steps and by tolerance."""

from collections.abc import Callable
from functools import partial

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder
from vibecalc.accuracy.yardsticks.changes import Change, rates_of
from vibecalc.accuracy.yardsticks.integrators import Marched, march_fixed, march_scipy

RTOLS = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
#: the implicit method takes too many steps beyond
LEAST_OF_RADAU = 1e-7
#: panels between two times of a superposition, and Gauss points on each
_PANELS, _POINTS = 8, 16

#: a method's name and its number of steps or rtol to translations (times, 3)
March = Callable[[str, float], Answer]


def integrator_ladders(march: March, steps: tuple[float, ...]) -> list[Ladder]:
    """Euler and RK4 with these numbers of steps, scipy's methods with falling tolerances."""
    found = [
        Ladder(name, words, "steps", steps, partial(march, way), theory=theory)
        for name, way, words, theory in (
            ("Euler", "euler", "explicit Euler on the equations of motion", "order 1"),
            ("RK4", "rk4", "classical Runge-Kutta on the equations of motion", "order 4"),
        )
    ]
    for name, words in (
        ("RK45", "scipy's pair of Dormand and Prince"),
        ("DOP853", "scipy's pair of order 8"),
        ("Radau", "scipy's implicit method of order 5"),
    ):
        mine = tuple(rtol for rtol in RTOLS if name != "Radau" or rtol >= LEAST_OF_RADAU)
        found.append(Ladder(name, words, "rtol", mine, partial(march, name)))
    return found


def marcher(change: Change, operation: int, acceleration: float, times: np.ndarray) -> March:
    """Translations at `times` from the change on, the crank speeding up by `acceleration`.

    The number of fixed steps is a multiple of that of the times.
    """
    matrix, rates = rates_of(change, operation, acceleration)
    length = np.maximum(np.abs(change.start[:6]), 1e-3 * np.max(np.abs(change.start[:3])))
    scale = np.concatenate([length, length * change.speed])
    grid = np.concatenate([[0.0], times])

    def march(way: str, setting: float) -> Answer:
        if way in ("euler", "rk4"):
            run: Marched = march_fixed(
                rates, change.start, 0.0, float(times[-1]), int(setting), way
            )
            every = int(setting) // len(times)
            return Answer(run.states[every::every, :3], run.evaluations)
        jacobian = matrix if way == "Radau" else None
        run = march_scipy(rates, change.start, grid, setting, setting * scale, way, jacobian)
        return Answer(run.states[1:, :3], run.evaluations)

    return march


def superposed(
    change: Change, operation: int, acceleration: float, times: np.ndarray
) -> np.ndarray:
    """Translations (k, 3) at k evenly spaced `times` by Duhamel's integral in place of steps.

    The state matrix is taken as it is, without modes: its exponential moves the state over a panel,
    and the load of every Gauss point from there to the panel's end. Only rounding is left.
    """
    from scipy.linalg import expm

    matrix, rates = rates_of(change, operation, acceleration)
    length = float(times[0]) / _PANELS
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    places = 0.5 * length * (1.0 + nodes)
    gains = 0.5 * length * weights[:, None, None] * expm(matrix * (length - places)[:, None, None])
    over, rest = expm(matrix * length), np.zeros(len(matrix))
    state, shown = change.start, []
    for panel in range(_PANELS * len(times)):
        loads = np.array([rates(panel * length + place, rest) for place in places])
        state = over @ state + np.einsum("pij,pj->i", gains, loads)
        shown.append(state[:3])
    return np.array(shown[_PANELS - 1 :: _PANELS])
