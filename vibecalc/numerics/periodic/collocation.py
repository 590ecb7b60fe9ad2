"""Periodic solutions by Gauss collocation: damped Newton, panels split at kinks of the state."""

from functools import lru_cache
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.gauss import (
    GaussRule,
    between_rules,
    differentiation_matrix,
    gauss_rule,
    interpolation_rows,
)
from vibecalc.numerics.periodic.panels import (
    Gaps,
    PeriodicProblem,
    PeriodicSolution,
    constant_start,
    evaluate,
    gaps,
    newton_step,
    panel_nodes,
)
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Damped Newton iteration for the collocation equations of a periodic problem, panels fixed.
#
# Every member of the batch has its own step length and its own end of iteration; members that have
# ended stay as they are while the others go on.
# ----------------------------------------------------------------------------

MOST_ITERATIONS = 40
MOST_HALVINGS = 12
#: factor of quadratic convergence assumed before two corrections are known
_RATE = 100.0
#: a correction below this that no longer shrinks is round-off
_STALLED = 1e-7
#: relative residual that round-off alone may leave
_ROUND_OFF = 1e-14


class _State(NamedTuple):
    """Iterate with what the right-hand side says there; `size` (B,) of the relative residual."""

    left: FloatArray
    stages: FloatArray
    jacobian: FloatArray
    missed: Gaps
    size: FloatArray


class _StateAt(Protocol):
    """Evaluates an iterate."""

    def __call__(self, left: FloatArray, stages: FloatArray, scale: FloatArray, /) -> _State: ...


def newton(
    problem: PeriodicProblem,
    start: PeriodicSolution,
    *,
    tolerance: float = 1e-13,
    most: int = MOST_ITERATIONS,
) -> PeriodicSolution:
    """Solve on the edges and with the intervals of `start`, from its values.

    A member has converged when the correction that would follow is predicted, from the two before,
    to lie below `tolerance` times the scale, or when corrections are down to round-off. Members
    that fail keep their last acceptable iterate and are marked in `converged`; nothing is raised.
    """
    rule, interval = gauss_rule(start.points), start.interval
    widths, x = start.edges[:, 1:] - start.edges[:, :-1], panel_nodes(start.edges, start.points)
    members = len(widths)

    def state_at(left: FloatArray, stages: FloatArray, scale: FloatArray) -> _State:
        f, jacobian = problem.rhs(x, stages, interval)
        missed = gaps(rule, widths, left, stages, f)
        return _State(left, stages, jacobian, missed, _size(missed, scale))

    with np.errstate(all="ignore"):
        scale = _scale(problem, start.stages)
        now = state_at(start.left, start.stages, scale)
        active = np.isfinite(now.size)
        converged = np.zeros(members, dtype=bool)
        correction = np.full(members, np.inf)
        rate = np.full(members, _RATE)
        transfer, count = start.transfer, 0
        while active.any() and count < most:
            count += 1
            step = newton_step(rule, widths, now.jacobian, now.missed)
            transfer = step.transfer if count == 1 else _pick(active, step.transfer, transfer)
            if problem.scale is None:
                scale = _scale(problem, now.stages, step.stages)
                now = now._replace(size=_size(now.missed, scale))
            last = _largest(step.stages, scale)
            active &= np.isfinite(last)
            known = correction < 1.0
            rate = np.where(known, np.maximum(last / correction**2, 1e-2), rate)
            ended = (last <= tolerance) | ((last < 1e-2) & (rate * last**2 <= tolerance))
            ended |= (last < _STALLED) & (last > 0.25 * correction)
            ended &= active
            correction = np.where(active, last, correction)
            if (ended | ~active).all():
                now = _moved(now, step.left, step.stages, ended.astype(np.float64))
                converged |= ended
                active = np.zeros(members, dtype=bool)
                break
            now, taken = _search(state_at, now, step.left, step.stages, active, ended, scale)
            converged |= ended
            active &= ~ended & (taken > 0.0)
            # a shortened step says nothing of the quadratic convergence
            correction = np.where(taken < 1.0, np.maximum(correction, 1.0), correction)
    return start._replace(left=now.left, stages=now.stages, transfer=transfer, converged=converged)


def _search(
    state_at: _StateAt, now: _State, left: FloatArray, stages: FloatArray,
    active: BoolArray, ended: BoolArray, scale: FloatArray,
) -> tuple[_State, FloatArray]:  # fmt: skip
    """Step along the correction, halved until the residual shrinks; lengths (B,), 0 if none does.

    Members that have ended take the whole step whatever their residual, which is round-off.
    """
    length = active.astype(np.float64)
    for _ in range(MOST_HALVINGS):
        trial = _moved(now, left, stages, length)
        tried = state_at(trial.left, trial.stages, scale)
        enough = np.maximum((1.0 - 0.1 * length) * now.size, _ROUND_OFF)
        good = (tried.size <= enough) | ended | ~active
        if good.all():
            return tried, length
        length = np.where(good, length, 0.5 * length)
    length = np.where(good, length, 0.0)
    trial = _moved(now, left, stages, length)
    return state_at(trial.left, trial.stages, scale), length


def _moved(now: _State, left: FloatArray, stages: FloatArray, length: FloatArray) -> _State:
    if (length == 1.0).all():
        return now._replace(left=now.left + left, stages=now.stages + stages)
    moves = length > 0.0
    shown = length[:, None, None]
    return now._replace(
        left=np.where(moves[:, None, None], now.left + shown * left, now.left),
        stages=np.where(
            moves[:, None, None, None], now.stages + shown[..., None] * stages, now.stages
        ),
    )


def _pick(active: BoolArray, new: FloatArray, old: FloatArray) -> FloatArray:
    return new if active.all() else np.where(active[:, None, None, None], new, old)


def _size(missed: Gaps, scale: FloatArray) -> FloatArray:
    """Residual (B,) relative to the scale, infinite where it is not a number."""
    size = np.maximum(_largest(missed.stages, scale), _largest(missed.ends, scale))
    return np.where(size < np.inf, size, np.inf)


def _largest(values: FloatArray, scale: FloatArray) -> FloatArray:
    """Largest magnitude of every member (B,) of values (B, ..., n) over scale (B, n)."""
    if scale.shape[1] == 1:
        flat = np.abs(values.reshape(len(scale), -1))
        return np.asarray(np.maximum.reduce(flat, axis=1) / scale[:, 0])
    flat = np.abs(values.reshape(len(scale), -1, scale.shape[1]))
    found = np.maximum.reduce(flat, axis=1, initial=0.0)
    return np.asarray(np.maximum.reduce(found / scale, axis=1))


def _scale(
    problem: PeriodicProblem, stages: FloatArray, step: FloatArray | None = None
) -> FloatArray:
    """Sizes of the states (B, n): as given, or the largest value, or else of the correction."""
    members, states = len(stages), stages.shape[-1]
    if problem.scale is not None:
        return np.broadcast_to(np.asarray(problem.scale, dtype=np.float64), (members, states))
    size = np.abs(stages.reshape(members, -1, states)).max(axis=1)
    if size.all():
        return np.asarray(size)
    if step is not None:
        size = np.maximum(size, np.abs(step.reshape(members, -1, states)).max(axis=1))
    return np.where(size > 0.0, size, 1.0)


def intervals_at(problem: PeriodicProblem, y: FloatArray) -> IntArray:
    """Interval of every point: how many thresholds lie at or below the switch; y (B, P, s, n)."""
    if problem.switch is None or problem.thresholds is None:
        return np.zeros(y.shape[:-1], dtype=np.int64)
    return levels(problem.switch(y), problem.thresholds)


def levels(values: FloatArray, thresholds: FloatArray) -> IntArray:
    """Number of thresholds (T,) or (B, T) at or below each value (B, P, s)."""
    bounds = np.asarray(thresholds, dtype=np.float64)
    if bounds.ndim == 1:
        return np.searchsorted(bounds, values, side="right").astype(np.int64)
    count = np.zeros(values.shape, dtype=np.int64)
    for bound in bounds.T:
        count += values >= bound[:, None, None]
    return count


# ----------------------------------------------------------------------------
# Panels split where the switch of a periodic solution crosses the kinks of a curve of the state.
#
# The crossings are those of the polynomials through the switch at both ends and at the Gauss points
# of a panel. An excursion beyond a threshold that is narrower than `NARROW` periods is left out: a
# continuous right-hand side feels it with the third power of its width only.
# ----------------------------------------------------------------------------

#: relative to the period
NARROW = 2e-6
_ITERATIONS = 60
#: relative to a panel, a step of Newton's method after which the next one is below rounding
_CLOSE = 1e-9


def split(problem: PeriodicProblem, solution: PeriodicSolution) -> FloatArray:
    """Edges (B, P' + 1) with the crossings among the given ones.

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
    return np.sort(np.concatenate([base, extra], axis=1), axis=1)


def _crossings(problem: PeriodicProblem, solution: PeriodicSolution) -> tuple[IntArray, FloatArray]:
    """Member and x of every crossing, sorted by both."""
    assert problem.switch is not None
    assert problem.thresholds is not None
    bounds = np.asarray(problem.thresholds, dtype=np.float64)
    at_ends = solution.ends
    states = [at_ends[:, :-1, None], solution.stages, at_ends[:, 1:, None]]
    switch = problem.switch(np.concatenate(states, axis=2))
    member, panel, level, ends, heights = _brackets(solution.points, switch, bounds)
    widths = solution.edges[:, 1:] - solution.edges[:, :-1]
    real = widths[member, panel] > 0.0
    if not real.all():
        member, panel, level = member[real], panel[real], level[real]
        ends, heights = ends[:, real], heights[:, real]
    bound = bounds[level] if bounds.ndim == 1 else bounds[member, level]
    values = switch[member, panel] - bound[:, None]
    root = _roots(gauss_rule(solution.points), values, ends, heights - bound)
    at = solution.edges[member, panel] + widths[member, panel] * root
    order = np.lexsort((at, member))
    return member[order], at[order]


def _brackets(
    points: int, switch: FloatArray, bounds: FloatArray
) -> tuple[IntArray, IntArray, IntArray, FloatArray, FloatArray]:
    """Intervals that hold a crossing (k,): member, panel, threshold; ends and switch there (2, k).

    The polynomials are sampled at equal steps, and at the peak of the parabola through three
    samples where the middle one is the largest or the smallest, so that no excursion hides there.
    """
    rule, steps = gauss_rule(points), 2 * points + 2
    at, basis = _sampling(points)
    sample = switch @ basis.T
    sample[..., 0], sample[..., -1] = switch[..., 0], switch[..., -1]
    place = np.broadcast_to(at, sample.shape)
    before, middle, after = sample[..., :-2], sample[..., 1:-1], sample[..., 2:]
    peak = (after - middle) * (middle - before) < 0.0
    if peak.any():
        bend = np.where(peak, before - 2.0 * middle + after, 1.0)
        shift = np.minimum(np.maximum(0.5 * (before - after) / bend, -0.5), 0.5)
        place = place.copy()
        inner = np.nonzero(peak)
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
    both = member, panel, np.stack([sub, sub + 1])
    return member, panel, level[both].min(axis=0) + within, place[both], sample[both]


@lru_cache(maxsize=32)
def _sampling(points: int) -> tuple[FloatArray, FloatArray]:
    """Equal steps over a panel (k,), and rows (k, s + 2) from the values at the closed nodes."""
    rule, at = gauss_rule(points), np.linspace(0.0, 1.0, 2 * points + 3)
    basis = interpolation_rows(rule.closed_nodes, rule.closed_weights, at)
    at.flags.writeable = basis.flags.writeable = False
    return at, basis


def _roots(
    rule: GaussRule, values: FloatArray, ends: FloatArray, heights: FloatArray
) -> FloatArray:
    """Zeros between `ends` (2, k) of polynomials given at the closed nodes (k, s + 2).

    Newton's method from where the chord through their `heights` (2, k) at the ends is zero, with
    bisection. If round-off has a zero beyond an end, that end is found.
    """
    slopes = values @ differentiation_matrix(len(rule.nodes)).T
    both = np.stack([values, slopes], axis=-1)
    low, high = ends
    rise = heights[1] - heights[0]
    rising = rise > 0.0
    share = -heights[0] / rise
    at = low + (high - low) * np.where((share >= 0.0) & (share <= 1.0), share, 0.5)
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
    return np.asarray(at)


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


# ----------------------------------------------------------------------------
# Periodic solutions by Gauss collocation on panels, with kinks in x and in the state.
#
# Kinks in x stand among the given edges. Kinks in the state are found: the equations are solved
# with every point in its own interval, the panels are split at the crossings, and solving and
# splitting alternate until the edges stand. Since the right-hand side is continuous at a kink, an
# edge that is off by d changes the solution by the order of d^2, so that the edges settle
# quadratically.
# ----------------------------------------------------------------------------

MOST_SPLITS = 12
#: edges that are off by less (in periods) stand: the solution is off by about the square of that
_STANDS = 3e-9
#: an edge that moved by d is off by so many d^2 after it: at most, and where `rest` is given (the
#: machines of Herold (1977) have 0.5 to 3)
_GROWN, _GROWN_HERE = 1e2, 10.0
#: what Newton is asked for before the first splitting, and with how many points at most: enough to
#: find the crossings so well that they need to be moved once only
_ROUGH, _ROUGH_POINTS = 1e-5, 4
#: what it is asked for while the edges still move
_MOVING = 1e-3


def solve_periodic(
    problem: PeriodicProblem,
    points: int,
    guess: ArrayLike | PeriodicSolution,
    *,
    tolerance: float = 1e-13,
    edge_tolerance: float | None = None,
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
    edge_tolerance : float, optional
        Edges at kinks may be off by so much of a period, by the quadratic law alone: saves a round
        where the values count. Multipliers are off by as much as the edges are.

    Returns
    -------
    PeriodicSolution
        `converged` says for which members there is one; no exception is raised. `edge_error` above
        3e-9, or `edge_tolerance`, means that the edges did not come to rest within the allowed
        number of splittings.

    Source: Ascher, Mattheij and Russell (1995), Numerical solution of boundary value problems for
    ordinary differential equations, chapter 5.
    """
    if problem.switch is None:
        start = _onto_rule(guess, points, problem)
        return newton(problem, start._replace(edge_error=np.zeros(len(start.edges))),
                      tolerance=tolerance)  # fmt: skip
    if isinstance(guess, PeriodicSolution) and guess.interval is not None:
        solution = guess
    else:
        start = _onto_rule(guess, min(points, _ROUGH_POINTS), problem)._replace(interval=None)
        solution = newton(problem, start, tolerance=max(_ROUGH, tolerance))
    before = np.full(len(solution.edges), np.inf)
    stands = _STANDS if edge_tolerance is None else edge_tolerance
    coarse = solution.points < points
    for _ in range(MOST_SPLITS):
        edges = split(problem, solution)
        move = _movement(solution.edges, edges)
        solution = carried(problem, solution, edges, points)
        aim = min(max(float(move.max()) ** 4, tolerance), _MOVING)
        off = _left_over(move, before, points)
        if edge_tolerance is not None and points > 2:
            off = np.minimum(off, _GROWN_HERE * np.minimum(move, 1e3) ** 2)
        solution = newton(problem, solution, tolerance=aim)._replace(edge_error=off)
        settled = (off[solution.converged] <= stands).all() and aim <= tolerance
        if settled and not coarse:
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
    free = problem.switch is None or guess.interval is None
    if free and (guess.edges.shape != base.shape or np.any(guess.edges != base)):
        return carried(problem._replace(switch=None), guess, base, points)
    if free:
        guess = guess._replace(interval=None)
    if guess.points == points:
        return guess
    values = np.concatenate([guess.left[:, :, None], guess.stages], axis=2)
    return guess._replace(stages=between_rules(guess.points, points) @ values)


def carried(
    problem: PeriodicProblem, solution: PeriodicSolution, edges: FloatArray, points: int
) -> PeriodicSolution:
    """Values of a solution on other panels, as a start, with the intervals in their middles."""
    members, panels, states = len(edges), edges.shape[1] - 1, solution.left.shape[2]
    parts = [edges[:, :-1, None], panel_nodes(edges, points)]
    if problem.switch is not None:
        parts.append(0.5 * (edges[:, 1:, None] + edges[:, :-1, None]))
    at = np.concatenate(parts, axis=2)
    values = evaluate(solution, at.reshape(members, -1)).reshape(*at.shape, states)
    interval = None
    if problem.switch is not None:
        interval = intervals_at(problem, values[:, :, -1:])[..., 0]
    transfer = np.broadcast_to(np.eye(states), (members, panels, states, states))
    return solution._replace(
        edges=edges,
        interval=interval,
        left=values[:, :, 0],
        stages=values[:, :, 1 : points + 1],
        transfer=transfer,
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
    panels = [(e[:, 1:] > e[:, :-1]).sum(axis=1) for e in (old, new)]
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
