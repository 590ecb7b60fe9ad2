"""The running state by other methods: collocations and marches that a user would write."""

from math import ceil, cos, log, pi, sin
from typing import NamedTuple

import numpy as np

from vibecalc.core.accuracy.other_integrators import march_scipy
from vibecalc.core.accuracy.topic import Answer
from vibecalc.core.run.stage import Scene
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.panels import running_integral
from vibecalc.numerics.rounding import ComplexArray, FloatArray
from vibecalc.roll.between_kinks import running
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch, is_mounted, smooth_angles
from vibecalc.roll.methods import fourier_state, shooting_state
from vibecalc.roll.model import build_roll, fitted_motor, roll_drive
from vibecalc.roll.rates import roll_problem, shell_speed
from vibecalc.roll.running import Running, point_levels, running_state, steady_drive
from vibecalc.roll.steady import (
    POINTS,
    SteadyTurn,
    quick_spectrum,
    quick_turn,
    started_momentum,
    steady_state,
)
from vibecalc.roll.turn import Turn, harmonics, readings

# ----------------------------------------------------------------------------
# The roll machine of a case with its running state: what every method is given.
# ----------------------------------------------------------------------------

#: what is left of a disturbance when a march counts as settled
_FADED = 1e-12
#: Gauss points on each panel of the mean demand (`demand.py`)
_DEMAND = 4


class RollSetup(NamedTuple):
    """One machine, alone and as a batch of one (B = 1), and what its marches begin with.

    `momentum` (1,) N m s is that of a free machine; `speed` and `shell_speed`, rad/s, have it at
    crank angle zero; `turns` is how many turns a march takes until 1e-12 of a disturbance is left.
    """

    alone: RollMachine
    machine: RollMachine
    drive: RollDrive
    running: Running
    started_at: float | None
    momentum: FloatArray
    speed: float
    shell_speed: float
    turns: int
    orders: FloatArray
    rtol: float
    points: int | None

    @property
    def mounted(self) -> bool:
        """Whether the shell is held to the ground."""
        return is_mounted(self.machine)

    @property
    def panels(self) -> int:
        """Panels between the kinks that hang on the crank angle alone."""
        return int(np.asarray(self.running.state.problem.edges).shape[-1]) - 1

    @property
    def demand_work(self) -> int:
        """Crank angles at which the mean demand is taken, which every quick start needs."""
        return _DEMAND * self.panels


def roll_setup(scene: Scene) -> RollSetup:
    """The machine of [response.roll] and its running state at the tolerance of the case."""
    case = scene.case
    assert case.response is not None and case.response.roll is not None
    options, parts = case.response.roll, build_roll(case)
    drive, machine = roll_drive(parts), as_batch(parts.machine)
    fitted = fitted_motor(parts.motor)
    if fitted is not None:
        drive = drive._replace(circuit=fitted.circuit)
    points = options.points if options.method == "collocation" else None
    running = running_state(
        machine, drive, rtol=case.accuracy.rtol, orders=options.orders,
        started_at=options.started_at, points=points, between_points=True,
    )  # fmt: skip
    fading = max(float(np.max(np.abs(running.multiplier))), 1e-12)
    turns = 1 + ceil(log(_FADED) / log(fading))
    momentum, speed, shell = running.state.momentum, options.started_at, 0.0
    if speed is None:
        need = running.state.demand
        speed = float(np.max(drive.synchronous_speed) - np.max(need.slip))
        if not is_mounted(machine):
            still = float(started_momentum(machine, speed)[0])
            whole = float(machine.shell_inertia[0] + machine.rotor_inertia[0])
            shell = (float(momentum[0]) - still) / whole
    return RollSetup(
        parts.machine, machine, drive, running, options.started_at, momentum, speed, shell,
        turns, np.arange(1.0, options.orders + 1), case.accuracy.rtol, points,
    )  # fmt: skip


def spectrum(
    setup: RollSetup, turn: Turn, shell_acceleration: FloatArray | None = None
) -> ComplexArray:
    """Harmonics (orders,) of the shell's acceleration, rad/s^2, complex 0-to-peak, of a turn."""
    if shell_acceleration is None:
        read = readings(setup.machine, setup.drive, turn, pistons=False)
        shell_acceleration = read.shell_acceleration
    return np.asarray(harmonics(turn, shell_acceleration, setup.orders)[0])


# ----------------------------------------------------------------------------
# Ways to the running state over the crank angle, and how much each of them evaluates.
#
# Work is counted in evaluations of the right-hand side at one crank angle. The mean demand of gas
# and friction, which all of them start from, counts with the angles at which it is taken.
# ----------------------------------------------------------------------------

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
    if not found.solved[0]:
        raise NumericalFailure(f"Newton's method finds no running state with {count} points")
    return Answer(spectrum(setup, found.turn), float(found.evaluations + guess_work(setup)))


def lifted(setup: RollSetup, points: float) -> Answer:
    """The same for a motor with fluxes, started from the state with its steady curve."""
    from vibecalc.roll.running import lifted as with_fluxes

    count, drive = int(points), setup.drive
    near = steady_state(
        setup.machine, steady_drive(drive), count, started_at=setup.started_at, tolerance=_COARSE
    )
    if near.solved[0]:
        found = steady_state(
            setup.machine, drive, count, started_at=setup.started_at,
            start=with_fluxes(drive, near),
        )  # fmt: skip
    if not near.solved[0] or not found.solved[0]:
        raise NumericalFailure(f"Newton's method finds no running state with {count} points")
    work = near.evaluations + found.evaluations + guess_work(setup)
    return Answer(spectrum(setup, found.turn), float(work))


def steady_curve(setup: RollSetup, points: float) -> Answer:
    """A motor with fluxes taken by the torque of its steady curve."""
    drive = steady_drive(setup.drive)
    found = steady_state(setup.machine, drive, int(points), started_at=setup.started_at)
    if not found.solved[0]:
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
            started_at=setup.started_at, between_points=True,
        )  # fmt: skip
        left = [state for state in (found.coarse, found.check, found.state) if state is not None]
        work = sum(self._counted(state) for state in left) + guess_work(setup)
        known, levels = {state.points for state in left}, point_levels(rtol)
        tried = levels[: levels.index(min(found.check.points, found.state.points))]
        tried = tuple(points for points in tried if points not in known)
        fluxes = setup.drive.fluxes > 0
        return Answer(
            spectrum(setup, found.state.turn),
            float(work + self._earlier(tried, levels[0] if fluxes else 0)),
        )

    @staticmethod
    def _counted(state: SteadyTurn) -> int:
        # the right-hand side goes on counting where multipliers are found and courses examined;
        # a free shell brought to rest on average took several of them, which the state has summed
        return max(state.evaluations, int(getattr(state.problem.rhs, "evaluations", 0)))

    def _earlier(self, tried: tuple[int, ...], first: int) -> int:
        """What the levels took of which nothing is left, found once by going them again."""
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


# ----------------------------------------------------------------------------
# Marches of the roll machine that a user would write, each analysed over its last turn.
# ----------------------------------------------------------------------------

_TURN = 2.0 * pi
#: turns of the published program
_PUBLISHED_TURNS = 3
#: Gauss points between the nodes of the gas tables at which an adaptive march is read
_READ = 6
_READ_PANEL = pi / 36.0


def fixed_steps(setup: RollSetup, method: str, step: float) -> Answer:
    """ "euler" or "rk4" at a step in s until all has faded, its last turn analysed once."""
    found = march_to_repeat(
        setup.alone, setup.drive, method, started_at=setup.speed,
        shell_speed=setup.shell_speed, step=step, turns=setup.turns,
    )  # fmt: skip
    fields = found.turn._asdict().items()
    turn = Turn(**{name: np.asarray(part)[None] for name, part in fields if part is not None})
    values = spectrum(setup, turn, found.shell_acceleration[None])
    return Answer(values, float(found.evaluations))


def as_published(setup: RollSetup, step: float) -> Answer:
    """Euler's rule for three turns, two integrals for each order in step with it.

    Window and phase are those of Herold (1977), appendix A: the integrals of the last turn begin
    and end with whole steps, and their phase counts with the period of the turn before.
    """
    rates = running(setup.alone, setup.drive)
    b, w, theta, s, clock = 0.0, setup.speed, 0.0, setup.shell_speed, 0.0
    begun, period, turns, steps = 0.0, 1.0, 0, 0
    orders = setup.orders.astype(int).tolist()
    cosines, sines = [0.0] * len(orders), [0.0] * len(orders)
    while True:
        if b >= _TURN * (turns + 1):
            turns += 1
            period, begun = clock - begun, clock
            if turns == _PUBLISHED_TURNS:
                break
            cosines, sines = [0.0] * len(orders), [0.0] * len(orders)
        crank, shell = rates(b, w, theta, s)
        phase = _TURN * (clock - begun) / period
        for place, order in enumerate(orders):
            cosines[place] += step * shell * cos(order * phase)
            sines[place] += step * shell * sin(order * phase)
        b += step * w
        theta += step * s
        w += step * crank
        s += step * shell
        clock += step
        steps += 1
    values = (np.array(cosines) - 1j * np.array(sines)) * (2.0 / period)
    return Answer(values, float(steps))


def adaptive(setup: RollSetup, method: str, rtol: float) -> Answer:
    """An integrator of scipy over the crank angle until all has faded, read at Gauss points.

    The step is the integrator's own; it knows of no kink.
    """
    rates = running(setup.alone, setup.drive)

    def by_angle(angle: float, state: FloatArray) -> FloatArray:
        _, w, theta, s = state.tolist()
        if not w > 0.0:
            raise NumericalFailure("the crank comes to a standstill on the way")
        crank, shell = rates(angle, w, theta, s)
        return np.asarray(np.array([1.0, crank, s, shell]) / w)

    edges, rule = smooth_angles(setup.machine, setup.drive, _READ_PANEL), gauss_rule(_READ)
    widths = np.diff(edges)[:, None]
    own = (edges[:-1, None] + widths * rule.nodes).ravel()
    weight = (widths * rule.weights).ravel()
    last = _TURN * (setup.turns - 1)
    size = np.array([_TURN / setup.speed, setup.speed, 1e-2, 1.0])
    start = np.array([0.0, setup.speed, 0.0, setup.shell_speed])
    times = np.concatenate([[0.0, last], last + own, [last + _TURN]])
    found = march_scipy(by_angle, start, times, rtol, rtol * size, method)
    first, inner, end = found.states[1], found.states[2:-1], found.states[-1]
    turn = Turn(
        own[None], weight[None], (inner[:, 0] - first[0])[None], inner[None, :, 1],
        inner[None, :, 3], inner[None, :, 2], np.array([end[0] - first[0]]),
    )  # fmt: skip
    # by the speed, which is smoother where the motor's curve has a kink than the acceleration
    values = spectrum(setup, turn, turn.shell_speed)
    rate = 1j * setup.orders * _TURN / turn.period
    return Answer(rate * values, float(found.evaluations))


# ----------------------------------------------------------------------------
# The turn of a running state gone over once more: an eighth-order march from point to point.
#
# The march takes the equations as they are at every point of it, with the kinks where they truly
# lie, and knows of the collocation nothing but the start at crank angle zero and where to stop. The
# pair of Dormand and Prince of order 8 is taken without its error estimate: from one collocation
# point to the next is so short that a step leaves no more than rounding.
# ----------------------------------------------------------------------------


class Retraced(NamedTuple):
    """Spectrum (orders,) along the march, rad/s^2, and how far the turn fails to close.

    `gap` is relative to the crank speed, the speeds of crank and shell alike.
    """

    values: ComplexArray
    gap: float


def retrace(setup: RollSetup, found: SteadyTurn) -> Retraced:
    """The turn of a machine whose motor has a steady curve, in plain floats in the time domain."""
    rates = running(setup.alone, setup.drive)
    solution, turn = found.solution, found.turn
    edges = solution.edges[0]
    first = solution.left[0, 0]
    start = np.array([0.0, first[0], 0.0, 0.0])
    if setup.mounted:
        start[2:] = first[1:3]
    else:
        moved = _first_shell_speed(setup, float(first[0]))
        start[3] = moved

    def by_angle(angle: float, state: FloatArray) -> FloatArray:
        _, w, theta, s = state.tolist()
        crank, shell = rates(angle, w, theta, s)
        return np.asarray(np.array([1.0, crank, s, shell]) / w)

    nodes = turn.crank_angle[0]
    places = np.unique(np.concatenate([edges, nodes]))
    path = _path(by_angle, places, start)
    own = path[np.searchsorted(places, nodes)]
    shell = [rates(b, *row[1:].tolist())[1] for b, row in zip(nodes.tolist(), own, strict=True)]
    again = Turn(
        turn.crank_angle, turn.weight, own[None, :, 0], own[None, :, 1], own[None, :, 3],
        own[None, :, 2], path[-1:, 0],
    )  # fmt: skip
    off = np.abs(path[-1] - start)[[1, 3]] / start[1]
    return Retraced(spectrum(setup, again, np.array(shell)[None]), float(np.max(off)))


def departure(setup: RollSetup, found: SteadyTurn) -> float:
    """Sum of what all steps from one edge to the next depart from the state, over its scale.

    For a motor with fluxes, all panels at once: the sum bounds how far a march along the turn
    would be off, as long as disturbances fade.
    """
    from scipy.integrate import DOP853

    rates, solution = found.problem.rhs, found.solution
    edges = solution.edges[0]
    size = np.asarray(found.problem.scale)
    parts = 8
    x, state = edges[:-1].copy(), solution.left[0].copy()
    step = np.diff(edges) / parts
    for _ in range(parts):
        slopes: list[FloatArray] = []
        for row, share in zip(DOP853.A, DOP853.C, strict=True):
            there = state.copy()
            for factor, slope in zip(row, slopes, strict=False):
                there += (step * factor)[:, None] * slope
            at = (x + share * step)[None, :, None]
            slopes.append(rates(at, there[None, :, None], None)[0][0, :, 0])
        state += step[:, None] * np.einsum("s,spn->pn", DOP853.B, np.array(slopes))
        x += step
    off = np.abs(state - np.roll(solution.left[0], -1, axis=0)) / size
    return float(np.max(np.sum(off, axis=0)))


def _first_shell_speed(setup: RollSetup, speed: float) -> float:
    from vibecalc.roll.mechanism import inertia

    moved = inertia(setup.machine, np.zeros((1, 1)))
    coupling, shell = float(moved.coupling[0, 0]), float(moved.shell[0, 0])
    return (float(setup.momentum[0]) - coupling * speed) / shell


def _path(rates, places: FloatArray, start: FloatArray) -> FloatArray:  # type: ignore[no-untyped-def]
    """States (k, n) at the ascending places (k,), one step of order 8 between neighbours."""
    from scipy.integrate import DOP853

    rows = [np.asarray(DOP853.A[k, :k]) for k in range(len(DOP853.C))]
    slopes = np.empty((len(DOP853.C), len(start)))
    path, state = [start], start
    for at, step in zip(places[:-1].tolist(), np.diff(places).tolist(), strict=True):
        for k, row in enumerate(rows):
            slopes[k] = rates(at + DOP853.C[k] * step, state + step * (row @ slopes[:k]))
        state = state + step * (DOP853.B @ slopes)
        path.append(state)
    return np.array(path)
