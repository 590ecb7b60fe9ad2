"""The running state of roll machines by Gauss collocation over the crank angle."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.panels import PeriodicProblem, PeriodicSolution
from vibecalc.numerics.rounding import BoolArray, ComplexArray, FloatArray
from vibecalc.roll.mechanism import (
    WIDEST,
    AngleTerms,
    RollDrive,
    RollMachine,
    inertia,
    is_mounted,
    smooth_angles,
)
from vibecalc.roll.rates import (
    Demand,
    demand,
    roll_problem,
    terms_of_turn,
    turn_of,
    with_steady_flux,
)
from vibecalc.roll.turn import Turn

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
    if start is None:
        need = demand(machine, drive, terms_of_turn(machine, drive, edges))
    else:
        need = start.demand
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
    state = _solved(machine, drive, edges, points, need, momentum, speed, start, tolerance)
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
    start: SteadyTurn | None,
    tolerance: float,
) -> SteadyTurn:
    problem, rates = roll_problem(machine, drive, momentum, edges)
    guess: FloatArray | PeriodicSolution
    if start is not None:
        guess = start.solution
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


def is_stable(value: ComplexArray, error: FloatArray) -> BoolArray:
    """Of which machines none of the `multipliers` (B, n) is surely outside the unit circle."""
    return np.asarray(np.all(np.abs(value) <= 1.0 + error, axis=-1))


def within_table(state: SteadyTurn, drive: RollDrive) -> BoolArray:
    """Of which of the machines (B,) the slip stays in the table of the motor."""
    if drive.circuit is not None or drive.holds:
        return np.ones(len(state.solved), dtype=bool)
    slip = drive.synchronous_speed[..., None] - state.turn.crank_speed
    return np.asarray(np.max(np.abs(slip), axis=-1) <= drive.motor.largest)
