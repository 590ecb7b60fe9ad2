"""Small topics whose order of convergence is known, with failures and ties where asked."""

from collections.abc import Callable

import numpy as np

from vibecalc.core.accuracy.topic import Answer, Ask, Reference, Solver, Topic
from vibecalc.errors import NumericalFailure

Solve = Callable[[float], Answer]

#: one run of each level within so many seconds: tests count work, not seconds
ONCE = (60.0, 0)

#: x' = i x from 1 over one unit of time
TRUTH = np.array([np.exp(1j)])


def euler(steps: float) -> Answer:
    """Order 1."""
    return Answer(np.array([(1.0 + 1j / steps) ** int(steps)]), steps)


def runge_kutta(steps: float) -> Answer:
    """The classical method, order 4: its amplification is the series to the fourth power."""
    step = 1j / steps
    growth = 1.0 + step + step**2 / 2.0 + step**3 / 6.0 + step**4 / 24.0
    return Answer(np.array([growth ** int(steps)]), 4.0 * steps)


def gauss(points: float) -> Answer:
    """1 + the integral of i exp(i t), by Gauss's rule: geometric."""
    node, weight = np.polynomial.legendre.leggauss(int(points))
    half = 0.5 * (node + 1.0)
    return Answer(np.array([1.0 + 0.5 * np.sum(weight * 1j * np.exp(1j * half))]), points)


def exact(_: float) -> Answer:
    return Answer(TRUTH.copy(), 2.0)


def unstable(steps: float) -> Answer:
    if steps < 3:
        raise NumericalFailure("the step is above the limit of stability")
    if steps < 5:
        raise np.linalg.LinAlgError("singular matrix")
    return Answer(np.array([np.exp(1j) + 0.1 / steps]), steps)


def undefined(setting: float) -> Answer:
    return Answer(np.array([complex(np.nan if setting < 2 else np.inf)]), 1.0)


class Clock:
    """Time that passes in `slow` only."""

    now = 0.0

    def perf_counter(self) -> float:
        return self.now

    process_time = perf_counter

    def slow(self, setting: float) -> Answer:
        """As many seconds as the setting says."""
        self.now += setting
        return Answer(TRUTH + 0.1, setting)


def solver(
    solve: Solve, *settings: float, setting: str = "steps", default: float | None = None
) -> Solver:
    name, what = solve.__name__.replace("_", " "), setting if settings else ""
    return Solver(name, solve, what, settings or (1.0,), default, "as its name says")


def topic(
    *solvers: Solver, agreement: float = 1e-16, position: str = "", name: str = "after one unit"
) -> Topic:
    ask = Ask(name, "the end of x' = i x from 1", "rotation/end")
    truth = Reference(TRUTH, agreement, "closed form", 0.5 if position else None)
    return Topic(ask, "evaluations", lambda: truth, solvers, position, "rotation")


#: everything at once, for files and reports
FULL = topic(
    solver(euler, 4, 8, 16, 32, 64, 128),
    solver(runge_kutta, 4, 8, 16, 32, 64),
    solver(gauss, 2, 3, 4, 5, 6, 8, 10, setting="points", default=10),
    solver(exact),
    solver(unstable, 2, 4, 8),
    solver(undefined, 1, 2),
)
