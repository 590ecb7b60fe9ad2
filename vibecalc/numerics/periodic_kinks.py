"""Panels split where the switch of a periodic solution crosses the kinks of a curve of the state.

The crossings are those of the polynomials through the switch at both ends and at the Gauss points
of a panel. An excursion beyond a threshold that is narrower than `NARROW` periods is left out: a
continuous right-hand side feels it with the third power of its width only.
"""

from functools import lru_cache

import numpy as np

from vibecalc.numerics.gauss import (
    GaussRule,
    differentiation_matrix,
    gauss_rule,
    interpolation_rows,
)
from vibecalc.numerics.periodic_newton import levels, pieces_at
from vibecalc.numerics.periodic_panels import PeriodicProblem, PeriodicSolution, evaluate
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray

#: relative to the period
NARROW = 2e-6
_ITERATIONS = 60
#: relative to a panel, a step of Newton's method after which the next one is below rounding
_CLOSE = 1e-9


def split(problem: PeriodicProblem, solution: PeriodicSolution) -> tuple[FloatArray, IntArray]:
    """Edges (B, P' + 1) with the crossings among the given ones, and the pieces (B, P').

    P' is the number of given panels and of the most crossings that a member has; members with
    fewer get panels without width at their end.
    """
    base = problem.batch_edges(len(solution.edges))
    member, place = _crossings(problem, solution)
    member, place = _without_narrow(member, place, base)
    count = np.bincount(member, minlength=len(base))
    first = np.cumsum(count) - count
    extra = np.repeat(base[:, -1:], max(int(count.max(initial=0)), 0), axis=1)
    extra[member, np.arange(len(member)) - first[member]] = place
    edges = np.sort(np.concatenate([base, extra], axis=1), axis=1)
    middle = 0.5 * (edges[:, 1:] + edges[:, :-1])
    return edges, pieces_at(problem, evaluate(solution, middle)[:, :, None])[..., 0]


def _crossings(problem: PeriodicProblem, solution: PeriodicSolution) -> tuple[IntArray, FloatArray]:
    """Member and x of every crossing, sorted by both."""
    assert problem.switch is not None
    assert problem.thresholds is not None
    bounds = np.asarray(problem.thresholds, dtype=np.float64)
    ends = solution.ends
    states = [ends[:, :-1, None], solution.stages, ends[:, 1:, None]]
    switch = problem.switch(np.concatenate(states, axis=2))
    member, panel, low, high, level, rising = _brackets(solution.points, switch, bounds)
    widths = np.diff(solution.edges)
    real = widths[member, panel] > 0.0
    member, panel, level = member[real], panel[real], level[real]
    bound = bounds[level] if bounds.ndim == 1 else bounds[member, level]
    rule = gauss_rule(solution.points)
    values = switch[member, panel] - bound[:, None]
    root = _roots(rule, values, low[real], high[real], rising[real])
    at = solution.edges[member, panel] + widths[member, panel] * root
    order = np.lexsort((at, member))
    return member[order], at[order]


def _brackets(
    points: int, switch: FloatArray, bounds: FloatArray
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, IntArray, BoolArray]:
    """Intervals that hold a crossing: member, panel, both ends, threshold, whether it goes up.

    The polynomials are sampled at equal steps, and at the summit of the parabola through three
    samples where the middle one is the largest or the smallest, so that no excursion hides there.
    """
    rule, steps = gauss_rule(points), 2 * points + 2
    at, basis = _sampling(points)
    sample = switch @ basis.T
    sample[..., 0], sample[..., -1] = switch[..., 0], switch[..., -1]
    place = np.broadcast_to(at, sample.shape)
    before, middle, after = sample[..., :-2], sample[..., 1:-1], sample[..., 2:]
    summit = (after - middle) * (middle - before) < 0.0
    if summit.any():
        bend = np.where(summit, before - 2.0 * middle + after, 1.0)
        shift = np.minimum(np.maximum(0.5 * (before - after) / bend, -0.5), 0.5)
        place = place.copy()
        inner = np.nonzero(summit)
        moved = place[..., 1:-1][inner] + shift[inner] / steps
        rows = interpolation_rows(rule.closed_nodes, rule.closed_weights, moved)
        place[..., 1:-1][inner] = moved
        middle[inner] = np.sum(rows * switch[inner[:2]], axis=-1)
    level = levels(sample, bounds)
    jump = level[..., 1:] - level[..., :-1]
    member, panel, sub = np.nonzero(jump)
    times = np.abs(jump[member, panel, sub])
    each = np.repeat(np.arange(len(member)), times)
    within = np.arange(len(each)) - np.repeat(np.cumsum(times) - times, times)
    member, panel, sub = member[each], panel[each], sub[each]
    lowest = np.minimum(level[member, panel, sub], level[member, panel, sub + 1])
    low, high = place[member, panel, sub], place[member, panel, sub + 1]
    return member, panel, low, high, lowest + within, jump[member, panel, sub] > 0


@lru_cache(maxsize=32)
def _sampling(points: int) -> tuple[FloatArray, FloatArray]:
    """Equal steps over a panel (k,), and rows (k, s + 2) from the values at the closed nodes."""
    rule, at = gauss_rule(points), np.linspace(0.0, 1.0, 2 * points + 3)
    basis = interpolation_rows(rule.closed_nodes, rule.closed_weights, at)
    at.flags.writeable = basis.flags.writeable = False
    return at, basis


def _roots(
    rule: GaussRule, values: FloatArray, low: FloatArray, high: FloatArray, rising: BoolArray
) -> FloatArray:
    """Zeros on [low, high] of polynomials given at the closed nodes (k, s + 2): Newton, bisection.

    `rising` (k,): the sign changes upwards. If round-off has it beyond an end, that end is found.
    """
    slopes = values @ differentiation_matrix(len(rule.nodes)).T
    both = np.stack([values, slopes], axis=-1)
    at = 0.5 * (low + high)
    for _ in range(_ITERATIONS):
        rows = interpolation_rows(rule.closed_nodes, rule.closed_weights, at)
        value, slope = (rows[:, None] @ both)[:, 0].T
        above = (value >= 0.0) == rising
        low, high = np.where(above, low, at), np.where(above, at, high)
        target = at - value / np.where(slope == 0.0, EPSILON, slope)
        straight = (target >= low) & (target <= high)
        target = np.where(straight, target, 0.5 * (low + high))
        moved = np.abs(target - at)
        at = target
        if (moved <= np.where(straight, _CLOSE, 2.0 * EPSILON)).all():
            break
    return at


def _without_narrow(
    member: IntArray, place: FloatArray, base: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Crossings less the pairs that enclose next to nothing."""
    if len(place) < 2:
        return member, place
    width = np.diff(place) / (base[member[1:], -1] - base[member[1:], 0])
    close = (width < NARROW) & (member[1:] == member[:-1])
    if not close.any():
        return member, place
    keep = np.ones(len(place), dtype=bool)
    for index in np.flatnonzero(close):
        if keep[index]:
            keep[index] = keep[index + 1] = False
    return member[keep], place[keep]
