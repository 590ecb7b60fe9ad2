"""Ways to the running state over the crank angle, and how much each of them evaluates.

Work is counted in evaluations of the right-hand side at one crank angle. The mean demand of gas and
friction, which all of them start from, counts with the angles at which it is taken.
"""

import numpy as np

from vibecalc.accuracy.topic import Answer
from vibecalc.accuracy.yardsticks.roll_setup import RollSetup, spectrum
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.panels import running_integral
from vibecalc.response.roll.dynamic_start import steady_drive
from vibecalc.response.roll.fourier_state import fourier_state
from vibecalc.response.roll.problem import roll_problem
from vibecalc.response.roll.quick import POINTS, quick_spectrum, quick_turn
from vibecalc.response.roll.rates import shell_speed
from vibecalc.response.roll.running import ladder, running_state
from vibecalc.response.roll.shooting_state import shooting_state
from vibecalc.response.roll.steady import Steady, steady_state
from vibecalc.response.roll.turn import Turn

#: turns that the quick march takes, the repeated one included
_QUICK_TURNS = 3
#: of Newton's method, coarse points and fine
_COARSE, _FINE = 1e-9, 1e-13


def guess_work(setup: RollSetup) -> int:
    """What finding a start takes: the mean demand and, for a free machine, the quick march."""
    quick = not setup.mounted and setup.drive.circuit is None
    return setup.demand_work + quick * _QUICK_TURNS * POINTS


def split(setup: RollSetup, points: float) -> Answer:
    """Panels split at every kink, a number of Gauss points on each, from the usual start."""
    count = int(points)
    found = steady_state(
        setup.machine, setup.drive, count, started_at=setup.started_at,
        tolerance=_COARSE if count < 5 else _FINE,
    )  # fmt: skip
    if not found.found[0]:
        raise NumericalFailure(f"Newton's method finds no running state with {count} points")
    return Answer(spectrum(setup, found.turn), float(found.evaluations + guess_work(setup)))


def lifted(setup: RollSetup, points: float) -> Answer:
    """The same for a motor with fluxes, started from the state with its steady curve."""
    from vibecalc.response.roll.dynamic_start import lifted as with_fluxes

    count, drive = int(points), setup.drive
    near = steady_state(
        setup.machine, steady_drive(drive), count, started_at=setup.started_at, tolerance=_COARSE
    )
    if near.found[0]:
        found = steady_state(
            setup.machine, drive, count, started_at=setup.started_at,
            start=with_fluxes(drive, near),
        )  # fmt: skip
    if not near.found[0] or not found.found[0]:
        raise NumericalFailure(f"Newton's method finds no running state with {count} points")
    work = near.evaluations + found.evaluations + guess_work(setup)
    return Answer(spectrum(setup, found.turn), float(work))


def steady_curve(setup: RollSetup, points: float) -> Answer:
    """A motor with fluxes taken by the torque of its steady curve."""
    drive = steady_drive(setup.drive)
    found = steady_state(setup.machine, drive, int(points), started_at=setup.started_at)
    if not found.found[0]:
        raise NumericalFailure("no running state with the steady curve of the motor")
    values = spectrum(setup._replace(drive=drive), found.turn)
    return Answer(values, float(found.evaluations + guess_work(setup)))


class AsRun:
    """What a run does to a tolerance: points until two numbers of them agree, and multipliers."""

    def __init__(self, setup: RollSetup):
        self._setup = setup
        self._before: dict[tuple[int, ...], int] = {}

    def __call__(self, rtol: float) -> Answer:
        setup = self._setup
        found = running_state(
            setup.machine, setup.drive, rtol=rtol, orders=len(setup.orders),
            started_at=setup.started_at, course=True,
        )  # fmt: skip
        left = [state for state in (found.coarse, found.check, found.state) if state is not None]
        work = sum(self._counted(state) for state in left) + guess_work(setup)
        known, rungs = {state.points for state in left}, ladder(rtol)
        tried = rungs[: rungs.index(min(found.check.points, found.state.points))]
        tried = tuple(points for points in tried if points not in known)
        fluxes = setup.drive.fluxes > 0
        return Answer(
            spectrum(setup, found.state.turn),
            float(work + self._earlier(tried, rungs[0] if fluxes else 0)),
        )

    @staticmethod
    def _counted(state: Steady) -> int:
        # the right-hand side goes on counting where multipliers are found and courses looked at;
        # a free shell brought to rest on average took several of them, which the state has summed
        return max(state.evaluations, int(getattr(state.problem.rhs, "evaluations", 0)))

    def _earlier(self, tried: tuple[int, ...], first: int) -> int:
        """What the rungs took of which nothing is left, found once by going them again."""
        key = (*tried, first)
        if key not in self._before:
            setup, work, state = self._setup, 0, None
            drive = setup.drive
            if first:
                drive = steady_drive(drive)
                work += self._counted(
                    steady_state(setup.machine, drive, first, started_at=setup.started_at)
                )
            for points in tried:
                state = steady_state(
                    setup.machine, drive, points, started_at=setup.started_at, start=state
                )
                work += self._counted(state)
            self._before[key] = work
        return self._before[key]


def unsplit(setup: RollSetup, points: float) -> Answer:
    """Panels between the nodes of the gas tables alone; the motor's kinks lie inside them."""
    speed = np.array([setup.speed])
    momentum = None if setup.mounted else setup.momentum
    problem, rates = roll_problem(setup.machine, setup.drive, momentum)
    whole = problem._replace(switch=None, thresholds=None)
    guess = np.zeros((1, 3 if setup.mounted else 1))
    guess[:, 0] = speed
    found = solve_periodic(whole, int(points), guess, tolerance=_FINE)
    if not found.converged[0]:
        raise NumericalFailure(
            f"Newton's method goes to and fro over the kinks with {int(points)} points"
        )
    crank = found.stages[..., 0]
    time, ends = running_integral(found.edges, 1.0 / crank)
    angles, flat = found.nodes.reshape(1, -1), crank.reshape(1, -1)
    if setup.mounted:
        angle, shell = (found.stages[..., k].reshape(1, -1) for k in (1, 2))
    else:
        shell = shell_speed(rates.place(found.nodes), setup.momentum, flat)
        angle = np.zeros_like(flat)
    turn = Turn(
        angles, found.weights.reshape(1, -1), time.reshape(1, -1), flat, shell, angle, ends[:, -1]
    )
    return Answer(spectrum(setup, turn), float(rates.evaluations))


def fourier(setup: RollSetup, points: float) -> Answer:
    """Evenly spaced crank angles and a trigonometric polynomial through them."""
    found = fourier_state(setup.machine, setup.drive, int(points), setup.momentum)
    return Answer(spectrum(setup, found.turn), float(found.evaluations + setup.demand_work))


def shooting(setup: RollSetup, steps: float) -> Answer:
    """Runge-Kutta steps of order 4 on each panel and Newton's method on the start."""
    found = shooting_state(setup.machine, setup.drive, int(steps), setup.momentum)
    return Answer(spectrum(setup, found.turn), float(found.evaluations + setup.demand_work))


def quick(setup: RollSetup, points: float) -> Answer:
    """The coarse march of the energy."""
    found = quick_turn(
        setup.machine, setup.drive, setup.speed, float(setup.momentum[0]), points=int(points)
    )
    if found is None:
        raise NumericalFailure("the quick march stalls, or no turn of it repeats")
    values = quick_spectrum(found, len(setup.orders))
    return Answer(values, float(_QUICK_TURNS * int(points)))
