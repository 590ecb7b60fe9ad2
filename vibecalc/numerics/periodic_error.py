"""Error estimate of a collocation solution: one Newton step from it with one more Gauss point.

The step sees what the solution misses between its own points, what Newton left over, and, since
every point is put on its own piece there, crossings of a kink that were overlooked. It solves the
linearised problem around the whole turn, so that an error that feeds itself (a multiplier near 1)
is estimated with that growth.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.gauss import between_rules, gauss_rule
from vibecalc.numerics.periodic_condense import Step, gaps, newton_step, scalar_condition
from vibecalc.numerics.periodic_panels import (
    PeriodicProblem,
    PeriodicSolution,
    evaluate,
    panel_nodes,
)
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import FloatArray

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

    def honest(found: FloatArray) -> FloatArray:
        return np.where(lost, np.inf, found)

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
    if problem.switch is None or solution.piece is None or not solution.edge_error.any():
        return np.zeros((members, states))
    f, jacobian = problem.rhs(solution.nodes, solution.stages, solution.piece)
    rate = np.abs(f).reshape(members, -1, states).max(axis=1)
    bend = np.abs(jacobian).reshape(members, -1, states, states).max(axis=1)
    off = solution.edge_error * (solution.edges[:, -1] - solution.edges[:, 0])
    return np.asarray((bend @ rate[..., None])[..., 0] * off[:, None] ** 2)


def _step(
    problem: PeriodicProblem, edges: FloatArray, left: FloatArray, stages: FloatArray
) -> Step:
    """Newton step from these values, every point on its own piece."""
    rule, widths = gauss_rule(stages.shape[2]), np.diff(edges)
    f, jacobian = problem.rhs(panel_nodes(edges, stages.shape[2]), stages, None)
    return newton_step(rule, widths, jacobian, gaps(rule, widths, left, stages, f))


def _halved_step(problem: PeriodicProblem, solution: PeriodicSolution) -> Step:
    """The same with every panel in two, each with the solution's own number of points."""
    edges = solution.edges
    middle = 0.5 * (edges[:, 1:] + edges[:, :-1])
    halves = np.sort(np.concatenate([edges, middle], axis=1), axis=1)
    x = panel_nodes(halves, solution.points)
    at = np.concatenate([halves[:, :-1, None], x], axis=2)
    values = evaluate(solution, at.reshape(len(at), -1)).reshape(*at.shape, -1)
    return _step(problem, halves, values[:, :, 0], values[:, :, 1:])
