"""Periodic solutions by Gauss collocation on panels, with kinks in x and in the state.

Kinks in x stand among the given edges. Kinks in the state are found: the equations are solved with
every point on its own piece, the panels are split at the crossings, and solving and splitting
alternate until the edges stand. Since the right-hand side is continuous at a kink, an edge that is
off by d changes the solution by the order of d^2, so that the edges settle quadratically.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.gauss import between_rules
from vibecalc.numerics.periodic_kinks import split
from vibecalc.numerics.periodic_newton import newton
from vibecalc.numerics.periodic_panels import (
    PeriodicProblem,
    PeriodicSolution,
    constant_start,
    evaluate,
    panel_nodes,
)
from vibecalc.numerics.typing import FloatArray, IntArray

MOST_SPLITS = 12
#: edges that are off by less (in periods) stand: the solution is off by about the square of that
_STANDS = 3e-9
#: an edge that moved by d is off by so many d^2 after it: at most, and where `rest` is given (the
#: machines of Herold (1977) have 0.5 to 3)
_GROWN, _GROWN_HERE = 1e2, 10.0
#: what Newton is asked for before the first splitting
_ROUGH = 1e-3
#: and with how many points at most, from a constant state
_ROUGH_POINTS = 3


def solve_periodic(
    problem: PeriodicProblem,
    points: int,
    guess: ArrayLike | PeriodicSolution,
    *,
    tolerance: float = 1e-13,
    rest: float | None = None,
) -> PeriodicSolution:
    """Periodic solution with `points` Gauss points in each panel.

    Parameters
    ----------
    problem : PeriodicProblem
        Right-hand side, edges and, if it depends on the state piecewise, switch and thresholds.
    points : int
        From 1 (implicit midpoint rule) to about 20. The values at edges have order 2 points.
    guess : array (n,) or (B, n), or PeriodicSolution
        A constant state, or another solution (of any points and panels) to start from.
    tolerance : float
        Of the Newton iteration, relative to the scale of the states.
    rest : float, optional
        Edges at kinks may be off by so much of a period, by the quadratic law alone: saves a round
        where the values count. Multipliers are off by as much as the edges are.

    Returns
    -------
    PeriodicSolution
        `converged` says for which members there is one; no exception is raised. `edge_error` above
        3e-9, or `rest`, means that the edges did not come to rest within the allowed number of
        splittings.

    Source: Ascher, Mattheij and Russell (1995), Numerical solution of boundary value problems for
    ordinary differential equations, chapter 5.
    """
    if problem.switch is None:
        start = _onto_rule(guess, points, problem)
        return newton(problem, start._replace(edge_error=np.zeros(len(start.edges))),
                      tolerance=tolerance)  # fmt: skip
    if isinstance(guess, PeriodicSolution) and guess.piece is not None:
        solution = guess
    else:
        rough = points if isinstance(guess, PeriodicSolution) else min(points, _ROUGH_POINTS)
        start = _onto_rule(guess, rough, problem)._replace(piece=None)
        solution = newton(problem, start, tolerance=max(_ROUGH, tolerance))
    before = np.full(len(solution.edges), np.inf)
    stands = _STANDS if rest is None else rest
    coarse = solution.points < points
    for _ in range(MOST_SPLITS):
        edges, piece = split(problem, solution)
        move = _movement(solution.edges, edges)
        solution = _carried(solution, edges, piece, points)
        aim = float(np.clip(move.max() ** 4, tolerance, _ROUGH))
        off = _left_over(move, before, points)
        if rest is not None and points > 2:
            off = np.minimum(off, _GROWN_HERE * np.minimum(move, 1e3) ** 2)
        solution = newton(problem, solution, tolerance=aim)._replace(edge_error=off)
        at_rest = (off[solution.converged] <= stands).all() and aim <= tolerance
        if at_rest and not coarse:
            break
        # few points may have overlooked a crossing
        before, coarse = move, False
    return solution


def _onto_rule(
    guess: ArrayLike | PeriodicSolution, points: int, problem: PeriodicProblem
) -> PeriodicSolution:
    """The start with this number of points."""
    if not isinstance(guess, PeriodicSolution):
        return constant_start(problem, points, guess)
    base = problem.batch_edges(len(guess.edges))
    free = problem.switch is None or guess.piece is None
    if free and (guess.edges.shape != base.shape or np.any(guess.edges != base)):
        return _carried(guess, base, None, points)
    if free:
        guess = guess._replace(piece=None)
    if guess.points == points:
        return guess
    values = np.concatenate([guess.left[:, :, None], guess.stages], axis=2)
    return guess._replace(stages=between_rules(guess.points, points) @ values)


def _carried(
    solution: PeriodicSolution, edges: FloatArray, piece: IntArray | None, points: int
) -> PeriodicSolution:
    """Values of a solution on other panels, as a start."""
    members, panels, states = len(edges), edges.shape[1] - 1, solution.left.shape[2]
    at = np.concatenate([edges[:, :-1, None], panel_nodes(edges, points)], axis=2)
    values = evaluate(solution, at.reshape(members, -1))
    values = values.reshape(members, panels, points + 1, states)
    transfer = np.broadcast_to(np.eye(states), (members, panels, states, states))
    return solution._replace(
        edges=edges, piece=piece, left=values[:, :, 0], stages=values[:, :, 1:], transfer=transfer
    )


def _movement(old: FloatArray, new: FloatArray) -> FloatArray:
    """Largest movement of an edge (B,) over the period; infinite if their number has changed."""
    if old.shape != new.shape:
        # panels without width at the end, as others of the batch may have asked for
        count = max(old.shape[1], new.shape[1])
        old, new = (
            np.concatenate([e, np.repeat(e[:, -1:], count - e.shape[1], axis=1)], axis=1)
            for e in (old, new)
        )
    moved = np.abs(new - old).max(axis=1) / (new[:, -1] - new[:, 0])
    panels = [np.count_nonzero(np.diff(e) > 0.0, axis=1) for e in (old, new)]
    return np.where(panels[0] == panels[1], moved, np.inf)


def _left_over(move: FloatArray, before: FloatArray, points: int) -> FloatArray:
    """How far edges still are from their place, from their last two movements.

    With one or two points the discretisation changes with the edges, so that they settle linearly.
    """
    known = before < 1.0
    ratio = np.minimum(move / np.where(known & (before > 0.0), before, 1.0), 1.0)
    expected = move * ratio if points < 3 else move * ratio**2
    expected = np.maximum(expected, _GROWN * np.minimum(move, 1.0) ** 2 * (points > 2))
    return np.where(known, np.minimum(expected, move), move)
