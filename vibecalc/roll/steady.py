"""The running state of roll machines by Gauss collocation, from a coarse first guess."""

from bisect import bisect_right
from math import sqrt
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.panels import (
    PeriodicProblem,
    PeriodicSolution,
    constant_start,
    running_integral,
)
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray
from vibecalc.roll.mechanism import (
    WIDEST,
    AngleTerms,
    Inertia,
    RollDrive,
    RollMachine,
    inertia,
    is_mounted,
    member,
    place_at,
    smooth_angles,
)
from vibecalc.roll.rates import (
    POINTS_OF_TERMS,
    Demand,
    TermsOfTurn,
    demand,
    roll_problem,
    terms_of_turn,
    turn_of,
    with_steady_flux,
)
from vibecalc.roll.turn import Turn

# ----------------------------------------------------------------------------
# A coarse running state of one free machine in some hundred microseconds.
#
# The energy of the machine over the crank angle, E = mu w^2 / 2 + H^2 / (2 J), obeys dE/db = torque
# (`rates.py`). What depends on the angle alone is taken at evenly spaced angles in one go; the
# energy is then marched over them in plain floats by the rule of Adams and Bashforth of second
# order, until a turn repeats. Good to some tenths of a decibel, without any error estimate: a start
# for better methods.
# ----------------------------------------------------------------------------

#: angles of a turn, further turns at most, and the change of the energy at which a turn repeats
POINTS = 72
_MOST_TURNS = 12
_REPEATS = 1e-4
#: of the terms of a turn, which of their angles a march takes
_EVERY = 2
_TURN = 2.0 * np.pi


class QuickTurn(NamedTuple):
    """Crank angles (k,), crank speed and torque of the motor there (k,), and the place (1, k).

    `momentum` is the angular momentum, N m s.
    """

    crank_angle: FloatArray
    crank_speed: FloatArray
    motor_torque: FloatArray
    place: AngleTerms
    momentum: float


def quick_turn(
    machine: RollMachine,
    drive: RollDrive,
    speed: float,
    momentum: float | None = None,
    points: int = POINTS,
    terms: TermsOfTurn | None = None,
) -> QuickTurn | None:
    """The turn of one machine (B = 1) without mounts that a march from `speed`, rad/s, comes to.

    The `momentum` is by default that of a shell at rest at crank angle zero. None where the
    crank stalls or no turn repeats. For motors with a steady curve by pieces. With `terms` the
    march goes over every other one of their angles, and the work of the load between is exact.
    """
    if terms is None:
        angle = np.linspace(0.0, _TURN, points, endpoint=False, dtype=np.float64)
        place = place_at(machine, drive, angle[None])
        step, load = _TURN / points, place.load[0]
        work = 1.5 * step * load
        work[1:] -= 0.5 * step * load[:-1]
        work[0] -= 0.5 * step * load[-1]
        ahead, behind = [1.5 * step] * points, [0.5 * step] * points
    else:
        place = terms.place
        load = place.load.reshape(1, len(terms.edges) - 1, -1)
        done, ends = running_integral(terms.edges[None], load)
        angle, done = terms.angle[::_EVERY], done.ravel()[::_EVERY]
        width = np.diff(angle, append=angle[0] + _TURN)
        work = np.diff(done, append=done[0] + ends[0, -1])
        ratio = 0.5 * width / np.append(width[-1], width[:-1])
        ahead, behind = (width * (1.0 + ratio)).tolist(), (width * ratio).tolist()
    every = slice(None, None, 1 if terms is None else _EVERY)
    moved = place.moved
    shell = moved.shell[0, every]
    conserved = float(moved.coupling[0, 0]) * speed if momentum is None else momentum
    still = (0.5 * conserved**2) / shell
    double = 2.0 * shell / moved.determinant[0, every]
    columns = (still.tolist(), double.tolist(), work.tolist(), ahead, behind)
    rows: list[tuple[float, ...]] = list(zip(*columns, strict=True))
    motor, drag = _motor(machine, drive), float(place.drag[0, 0])
    # as if the first torque had been there before
    last = motor.torque(speed) - drag * speed
    marched = _march(rows, motor, drag, rows[0][0] + speed * speed / rows[0][1], last)
    for _ in range(_MOST_TURNS):
        if marched is None:
            return None
        before, marched = marched, _march(rows, motor, drag, marched.energy, marched.last)
        if marched is not None and abs(marched.energy - before.energy) <= _REPEATS * before.energy:
            speeds, torques = np.array(marched.speeds), np.array(marched.torques)
            return QuickTurn(angle, speeds, torques, place, conserved)
    return None


class _Motor(NamedTuple):
    """Thresholds in slip; polynomials of each piece in the speed itself, highest power first."""

    threshold: list[float]
    origin: list[float]
    rows: list[list[float]]
    synchronous: float

    def torque(self, speed: float) -> float:
        part = bisect_right(self.threshold, self.synchronous - speed)
        away, torque = self.origin[part] - speed, 0.0
        for factor in self.rows[part]:
            torque = torque * away + factor
        return torque


def _motor(machine: RollMachine, drive: RollDrive) -> _Motor:
    curve, scale = drive.motor, float(machine.motor_scale[0])
    synchronous = float(drive.synchronous_speed.max())
    rows = (scale * curve.coefficient[:, ::-1]).tolist()
    return _Motor(curve.threshold.tolist(), (synchronous - curve.base).tolist(), rows, synchronous)


class _MarchedTurn(NamedTuple):
    """Energy after a turn, last torque of motor and drag; speed and torque of the motor (k,)."""

    energy: float
    last: float
    speeds: list[float]
    torques: list[float]


def _march(
    rows: list[tuple[float, ...]],
    motor: _Motor,
    drag: float,
    energy: float,
    last: float,
) -> _MarchedTurn | None:
    """March over a turn; `last` is the torque of motor and drag at the angle before."""
    threshold, origin, polynomials, synchronous = motor
    straight = len(polynomials[0]) == 2
    speeds, torques = [], []
    for still, double, work, ahead, behind in rows:
        square = (energy - still) * double
        if not square > 0.0:
            return None
        w = sqrt(square)
        part = bisect_right(threshold, synchronous - w)
        away, row = origin[part] - w, polynomials[part]
        if straight:
            torque = row[0] * away + row[1]
        else:
            torque = 0.0
            for factor in row:
                torque = torque * away + factor
        now = torque - drag * w
        energy += work + ahead * now - behind * last
        last = now
        speeds.append(w)
        torques.append(torque)
    return _MarchedTurn(energy, last, speeds, torques)


# ----------------------------------------------------------------------------
# The running state of roll machines by Gauss collocation over the crank angle.
#
# Source: the equations of Herold (1977) as `rates.py` has them; the method is in
# docs/theory_roll.md.
# ----------------------------------------------------------------------------

#: rounds until the shell of a free machine stands still on average, and what counts as still
_MOST_ROUNDS = 12
_STILL = 1e-14
#: panel ends that are off their kink by more of a turn have not come to rest
_EDGES_SETTLED = 1e-5


class SteadyTurn(NamedTuple):
    """Running states of the machines (B,), with how they were found.

    `momentum` (B,) is the angular momentum of a free machine, N m s (zero for a mounted one);
    `multiplier` (B, n) are the Floquet multipliers that are not 1 by symmetry. `solved` (B,) is
    false where there is no solution; the turn of such a machine means nothing. `place` is what
    depends on the crank angle alone at the points of the turn, `widest` the width that no panel
    exceeds, rad.
    """

    turn: Turn
    momentum: FloatArray
    solution: PeriodicSolution
    problem: PeriodicProblem
    demand: Demand
    solved: BoolArray
    points: int
    evaluations: int
    place: AngleTerms
    widest: float = WIDEST


def started_momentum(machine: RollMachine, speed: float | FloatArray) -> FloatArray:
    """Angular momentum of free machines (B,), N m s: crank at angle zero at `speed`, shell at rest.

    So does the source start its simulation.
    """
    lead = machine.crank_radius.shape
    return np.asarray(inertia(machine, np.zeros((*lead, 1))).coupling[..., 0] * speed)


def steady_state(
    machine: RollMachine,
    drive: RollDrive,
    points: int,
    *,
    started_at: float | FloatArray | None = None,
    start: SteadyTurn | None = None,
    tolerance: float = 1e-13,
    widest: float | None = None,
) -> SteadyTurn:
    """Running states of the machines (B,) with `points` Gauss points on each panel.

    Parameters
    ----------
    started_at : rad/s; fixes the angular momentum of a free machine, see `started_momentum`.
        Without it the momentum is the one with which the shell does not turn on average.
    start : a solution for the same number of machines to begin from.
    tolerance : relative, of the values. Above 1e-12 the ends of panels at kinks of the motor's
        curve are found to its root only, which the values do not feel, but `multipliers` would.
    widest : of a panel, rad; see `torques.widest_panel`. Default: as in `start`, else 10 degrees.

    Machines without a solution are marked in `solved`; nothing is raised.
    """
    if widest is None:
        widest = WIDEST if start is None else start.widest
    edges = smooth_angles(machine, drive, widest)
    known: SteadyTurn | TermsOfTurn = start or terms_of_turn(machine, drive, edges)
    need = known.demand if isinstance(known, SteadyTurn) else demand(machine, drive, known)
    slip = np.where(need.possible, need.slip, 0.0)
    speed = np.broadcast_to(drive.synchronous_speed, slip.shape) - slip
    momentum: FloatArray | None = None
    rounds = 0
    if not is_mounted(machine):
        if started_at is not None:
            momentum = started_momentum(machine, started_at)
        else:
            rounds = _MOST_ROUNDS
            momentum = resting_momentum(machine, speed) if start is None else start.momentum
    state = _solved(machine, drive, edges, points, need, momentum, speed, known, tolerance)
    for _ in range(rounds):
        turn, spent = state.turn, state.evaluations
        wanted = still_momentum(machine, turn.crank_angle, turn.weight, turn.crank_speed)
        change = np.abs(wanted - state.momentum)[state.solved]
        if np.all(change <= _STILL * np.abs(wanted[state.solved])):
            break
        state = _solved(machine, drive, edges, points, need, wanted, speed, state, tolerance)
        state = state._replace(evaluations=state.evaluations + spent)
    return state._replace(widest=widest)


def _solved(
    machine: RollMachine,
    drive: RollDrive,
    edges: FloatArray,
    points: int,
    need: Demand,
    momentum: FloatArray | None,
    speed: FloatArray,
    start: SteadyTurn | TermsOfTurn,
    tolerance: float,
) -> SteadyTurn:
    problem, rates = roll_problem(machine, drive, momentum, edges)
    guess: FloatArray | PeriodicSolution
    if isinstance(start, SteadyTurn):
        guess = start.solution
    else:
        rates.keep(start)
        if momentum is not None and drive.circuit is None:
            guess = _quick_guess(machine, drive, problem, start, momentum, speed)
        else:
            still = np.zeros((len(speed), rates.rigid - 1))
            guess = with_steady_flux(drive, np.concatenate([speed[:, None], still], axis=1))
    # how far ends of panels may be off their kinks, in turns, where only values count
    loose = 0.1 * float(np.sqrt(tolerance)) if tolerance > 1e-12 else None
    solution = solve_periodic(problem, points, guess, tolerance=tolerance, edge_tolerance=loose)
    turn = turn_of(rates, solution)
    forward = np.all(turn.crank_speed > 0.0, axis=-1)
    # panel ends that wander belong to no solution
    settled = solution.edge_error < _EDGES_SETTLED
    good = np.asarray(solution.converged & need.possible & forward & settled)
    return SteadyTurn(
        turn, np.zeros(len(speed)) if momentum is None else momentum, solution, problem, need,
        good, points, rates.evaluations, rates.place(solution.nodes),
    )  # fmt: skip


def _quick_guess(
    machine: RollMachine,
    drive: RollDrive,
    problem: PeriodicProblem,
    terms: TermsOfTurn,
    momentum: FloatArray,
    speed: FloatArray,
) -> FloatArray | PeriodicSolution:
    """A march of some turns, of one machine for all; the constant speed if it leads nowhere."""
    middle = len(speed) // 2
    one, (moved, *others) = slice(middle, middle + 1), terms.place
    place = AngleTerms(Inertia(*(part[one] for part in moved)), *(part[one] for part in others))
    synchronous = float(drive.synchronous_speed.max())
    quick = quick_turn(
        member(machine, middle), drive, synchronous, float(momentum[middle]),
        terms=terms._replace(place=place),
    )  # fmt: skip
    if quick is None:
        return speed[:, None]
    blank = constant_start(problem, POINTS_OF_TERMS, speed[:, None])
    at = np.concatenate([blank.edges[:1, :-1, None], blank.nodes[:1]], axis=2)
    speeds = np.interp(at, quick.crank_angle, quick.crank_speed, period=_TURN)
    every = (speed / speed[middle])[:, None, None] * speeds
    return blank._replace(left=every[:, :, :1], stages=every[:, :, 1:, None])


def still_momentum(
    machine: RollMachine, angle: FloatArray, weight: FloatArray | float, speed: FloatArray
) -> FloatArray:
    """Angular momentum (B,) with which the shell of a free machine stands still on average.

    From crank angles, their weights and crank speeds (B, k).
    """
    moved = inertia(machine, angle)
    share = np.sum(weight * moved.coupling / moved.shell, axis=-1)
    return np.asarray(share / np.sum(weight / (moved.shell * speed), axis=-1))


def resting_momentum(machine: RollMachine, speed: FloatArray) -> FloatArray:
    """That momentum, were the crank's speed constant."""
    angles = np.broadcast_to(np.arange(16) * (np.pi / 8.0), (len(speed), 16))
    return still_momentum(machine, angles, 1.0, speed[:, None])


def multipliers(state: SteadyTurn) -> tuple[ComplexArray, FloatArray]:
    """Floquet multipliers (B, n) by falling size, and their errors; those that are 1 are left out.

    The crank angle has no neutral phase, and a free machine at fixed momentum neither angle nor
    momentum of its shell (three multipliers that are 1 in time; one for a mounted machine).
    """
    from vibecalc.numerics.periodic.multipliers import floquet_multipliers

    value, error = floquet_multipliers(state.problem, state.solution)
    return value, error


def is_stable(state: SteadyTurn) -> BoolArray:
    """Which of the machines (B,) have no multiplier that is surely outside the unit circle."""
    value, error = multipliers(state)
    return np.asarray(np.all(np.abs(value) <= 1.0 + error, axis=-1))


def within_table(state: SteadyTurn, drive: RollDrive) -> BoolArray:
    """Of which of the machines (B,) the slip stays in the table of the motor."""
    if drive.circuit is not None or drive.holds:
        return np.ones(len(state.solved), dtype=bool)
    slip = drive.synchronous_speed[..., None] - state.turn.crank_speed
    return np.asarray(np.max(np.abs(slip), axis=-1) <= drive.motor.largest)
