"""Periodic solution to a tolerance: Gauss points are added until the estimate is below it."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import between_rules, gauss_rule
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.panels import (
    PanelStep,
    PeriodicProblem,
    PeriodicSolution,
    evaluate,
    gaps,
    newton_step,
    panel_nodes,
    require_converged,
    scalar_condition,
)
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray

# ----------------------------------------------------------------------------
# Error estimate of a collocation solution: one Newton step from it with one more Gauss point.
#
# The step sees what the solution misses between its own points, what Newton left over, and, since
# every point is put in its own interval there, crossings of a kink that were overlooked. It solves
# the linearised problem around the whole turn, so that an error that feeds itself (a multiplier
# near 1) is estimated with that growth.
# ----------------------------------------------------------------------------

#: for what one more point still misses, and for what the linearised step leaves out
_SAFETY = 2.0
#: two coarse answers with kinks between their points differ by less than either is off
_SAFETY_WITH_KINKS = 3.0
#: roundings of the values and of the right-hand side in a panel, times the root of their number
#: and the condition
_ROUNDINGS = 2.0


class PeriodicError(NamedTuple):
    """Absolute errors of the states (B, n): at the edges, and anywhere between.

    Integrals over the turn of smooth functions have errors of the size of `ends`. `round_off`
    (B, n) is the part that more points do not lower. All are infinite for members that have not
    converged. `transfer` (B, P, n, n) are the panels' transfers with one more point.
    """

    ends: FloatArray
    between: FloatArray
    round_off: FloatArray
    transfer: FloatArray


def estimate_error(
    problem: PeriodicProblem, solution: PeriodicSolution, *, kinks_inside: bool = False
) -> PeriodicError:
    """Errors of a solution of `problem`.

    With `kinks_inside` a second step is taken, with every panel halved: where panels are not split
    at kinks, one more point misses about as much as the solution does, and the difference of the
    two may vanish by chance.
    """
    more = solution.points + 1
    values = np.concatenate([solution.left[:, :, None], solution.stages], axis=2)
    stages = between_rules(solution.points, more) @ values
    members, states = len(stages), stages.shape[-1]
    with np.errstate(all="ignore"):
        step = _step(problem, solution.edges, solution.left, stages)
        ends = np.abs(step.left).max(axis=1)
        between = np.abs(step.stages).reshape(members, -1, states).max(axis=1)
        if kinks_inside:
            halves = _halved_step(problem, solution)
            ends = np.maximum(ends, np.abs(halves.left[:, ::2]).max(axis=1))
            inner = np.abs(halves.stages).reshape(members, -1, states).max(axis=1)
            between = np.maximum(between, inner)
        ends = ends + _edges_off(problem, solution)
        size = np.abs(stages).reshape(members, -1, states).max(axis=1)
        condition = step.condition
        if condition is None:
            condition = scalar_condition(step.transfer)
        roundings = _ROUNDINGS * np.sqrt(stages.shape[1]) * UNIT_ROUNDOFF
        floor = roundings * condition[:, None] * size
    lost = ~solution.converged[:, None] | ~np.isfinite(ends + between + floor)
    safety = _SAFETY_WITH_KINKS if kinks_inside else _SAFETY

    def honest(estimate: FloatArray) -> FloatArray:
        return np.where(lost, np.inf, estimate)

    return PeriodicError(
        honest(safety * ends + floor),
        honest(safety * np.maximum(between, ends) + floor),
        honest(floor),
        step.transfer,
    )


def _edges_off(problem: PeriodicProblem, solution: PeriodicSolution) -> FloatArray:
    """What edges that are off their kink by d change (B, n): the slopes' change over d, times d.

    No point stands between the edge and the kink, so that the step cannot see it.
    """
    members, states = len(solution.left), solution.left.shape[2]
    if problem.switch is None or solution.interval is None or not solution.edge_error.any():
        return np.zeros((members, states))
    f, jacobian = problem.rhs(solution.nodes, solution.stages, solution.interval)
    rate = np.abs(f).reshape(members, -1, states).max(axis=1)
    bend = np.abs(jacobian).reshape(members, -1, states, states).max(axis=1)
    off = solution.edge_error * (solution.edges[:, -1] - solution.edges[:, 0])
    return np.asarray((bend @ rate[..., None])[..., 0] * off[:, None] ** 2)


def _step(
    problem: PeriodicProblem, edges: FloatArray, left: FloatArray, stages: FloatArray
) -> PanelStep:
    """Newton step from these values, every point in its own interval."""
    rule, widths = gauss_rule(stages.shape[2]), np.diff(edges)
    f, jacobian = problem.rhs(panel_nodes(edges, stages.shape[2]), stages, None)
    return newton_step(rule, widths, jacobian, gaps(rule, widths, left, stages, f))


def _halved_step(problem: PeriodicProblem, solution: PeriodicSolution) -> PanelStep:
    """The same with every panel in two, each with the solution's own number of points."""
    edges = solution.edges
    middle = 0.5 * (edges[:, 1:] + edges[:, :-1])
    halves = np.sort(np.concatenate([edges, middle], axis=1), axis=1)
    x = panel_nodes(halves, solution.points)
    at = np.concatenate([halves[:, :-1, None], x], axis=2)
    values = evaluate(solution, at.reshape(len(at), -1)).reshape(*at.shape, -1)
    return _step(problem, halves, values[:, :, 0], values[:, :, 1:])


# ----------------------------------------------------------------------------
# Periodic solution to a tolerance: Gauss points are added until the error estimate is below it.
# ----------------------------------------------------------------------------

POINT_LEVELS = (2, 3, 4, 6, 8, 12, 16)
#: an estimate that does not fall below this part of the one before has met round-off
_NO_GAIN = 0.5
#: if it has come down to so many times the part that is round-off for certain
_NEAR_ROUND_OFF = 1e3
#: points to begin with, and from which relative tolerance on
_FIRST = ((2, 1e-4), (3, 1e-6), (4, 1e-8))
#: from this relative tolerance on panels need not be split at the kinks of the state
_COARSE = 1e-3
#: Newton is asked for this part of the tolerance
_NEWTON_SHARE = 1e-2


def solve_to(
    problem: PeriodicProblem,
    tolerance: ArrayLike,
    guess: ArrayLike | PeriodicSolution,
    *,
    where: Literal["ends", "between"] = "between",
    first: int | None = None,
    partial: bool = False,
) -> tuple[PeriodicSolution, PeriodicError]:
    """Periodic solution whose error estimate is at most `tolerance`.

    Parameters
    ----------
    tolerance : float or array (n,) or (B, n)
        Absolute, for each state.
    guess : array or PeriodicSolution
        As for `solve_periodic`.
    where : "between" or "ends"
        Whether the values at any x or those at the edges (and integrals over the turn) shall be so
        good.
    first : int, optional
        Points to begin with, going on along 2, 3, 4, 6, 8, 12, 16; by default chosen from the
        tolerance in relation to the guess.
    partial : bool
        Return the best that was found, with its errors (infinite for members without a solution),
        where an exception would be raised.

    Raises
    ------
    NumericalFailure
        Newton's method fails on every level, round-off keeps the estimate above the tolerance, or
        the levels end.
    """
    bound = np.asarray(tolerance, dtype=np.float64)
    relative = _relative(problem, bound, guess)
    if relative >= _COARSE and problem.switch is not None:
        coarse = _unsplit(problem, bound, guess, where, first)
        if coarse is not None:
            return coarse
    begin = next((level for level, least in _FIRST if relative >= least), 6)
    begin = begin if first is None else first
    levels = [begin, *(level for level in POINT_LEVELS if level > begin)]
    best: tuple[PeriodicSolution, PeriodicError] | None = None
    excess, before, points = np.inf, np.inf, levels.pop(0)
    start: ArrayLike | PeriodicSolution = guess
    while True:
        solution = solve_periodic(problem, points, start, tolerance=_newton_tolerance(bound, best))
        error = estimate_error(problem, solution)
        before, excess = excess, _excess(error, bound, where)
        if best is None or excess < _excess(best[1], bound, where):
            best = solution, error
        if excess <= 1.0:
            return solution, error
        floor = _excess_of(error.round_off, bound)
        stuck = excess > _NO_GAIN * before and excess < _NEAR_ROUND_OFF * floor
        met_round_off = floor > 1.0 or stuck
        if not levels or met_round_off:
            break
        last, points = points, levels.pop(0)
        while levels and _expected(excess, before, last, points) > 0.5:
            points = levels.pop(0)
        start = solution if solution.converged.all() else guess
    if partial:
        return best
    require_converged(best[0])
    raise NumericalFailure(_refusal(best, bound, where, met_round_off))


def _unsplit(
    problem: PeriodicProblem,
    bound: FloatArray,
    guess: ArrayLike | PeriodicSolution,
    where: str,
    points: int | None,
) -> tuple[PeriodicSolution, PeriodicError] | None:
    """The solution with every point in its own interval, if that is good enough."""
    whole = problem._replace(switch=None, thresholds=None)
    solution = solve_periodic(whole, points or 2, guess, tolerance=1e-8)
    error = estimate_error(whole, solution, kinks_inside=True)
    return (solution, error) if _excess(error, bound, where) <= 1.0 else None


def _relative(
    problem: PeriodicProblem, bound: FloatArray, guess: ArrayLike | PeriodicSolution
) -> float:
    """Smallest tolerance in relation to the size of the states, as far as it is known."""
    if problem.scale is not None:
        size = float(np.max(problem.scale))
    elif isinstance(guess, PeriodicSolution):
        size = float(np.max(np.abs(guess.stages)))
    else:
        size = float(np.max(np.abs(np.asarray(guess))))
    return float(np.min(bound)) / max(size, 1e-300)


def _newton_tolerance(
    bound: FloatArray, best: tuple[PeriodicSolution, PeriodicError] | None
) -> float:
    """Relative to the states, from their size on the level before."""
    if best is None:
        return 1e-8
    size = np.abs(best[0].stages).max(axis=(0, 1, 2))
    smallest = float(np.min(bound / np.where(size > 0.0, size, 1.0)))
    return float(np.clip(_NEWTON_SHARE * smallest, 1e-14, 1e-8))


def _excess(error: PeriodicError, bound: FloatArray, where: str) -> float:
    return _excess_of(error.ends if where == "ends" else error.between, bound)


def _excess_of(error: FloatArray, bound: FloatArray) -> float:
    """Largest error over its tolerance."""
    return float(np.max(error / bound))


def _expected(excess: float, before: float, last: int, points: int) -> float:
    """Excess with more points if it falls geometrically, as cautiously as the last two levels say.

    Without two finite ones to compare nothing is skipped.
    """
    if not (np.isfinite(before) and np.isfinite(excess)) or excess >= before:
        return 0.0
    level = POINT_LEVELS.index(last) if last in POINT_LEVELS else 1
    gained = last - (POINT_LEVELS[level - 1] if level > 0 else 1)
    return float(excess * (excess / before) ** ((points - last) / max(gained, 1)))


def _refusal(
    best: tuple[PeriodicSolution, PeriodicError], bound: FloatArray, where: str, round_off: bool
) -> str:
    solution, error = best
    reached = error.ends if where == "ends" else error.between
    ratio = reached / bound
    member, state = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    asked = float(np.broadcast_to(bound, ratio.shape)[member, state])
    reason = (
        "round-off stands in the way of a smaller one"
        if round_off
        else "give narrower panels, or a larger tolerance"
    )
    return (
        f"periodic solution: the error estimate of state {int(state)} of member {int(member)} is "
        f"{float(reached[member, state]):.2e} with {solution.points} points in each of "
        f"{solution.edges.shape[1] - 1} panels, asked for {asked:.2e}; {reason}"
    )
