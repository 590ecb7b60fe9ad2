"""What an optimum costs: the front to a second objective, and small errors of its variables."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.conditions import measured_noise, slope
from vibecalc.core.study.search.local_search import set_scale
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Ahead, Box, ErrorsAt, Evaluate, Optimum, Sampler
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# What one objective costs in another: the front between the two, by constrained optima.
# ----------------------------------------------------------------------------

Both = Callable[[np.ndarray], tuple[float, float, ArrayLike]]

#: objectives closer than this share of the front are the same
SAME = 1e-9
#: slack of the second objective, as a share of the front, where its optimum is not unique
_SLACKS = (1e-6, 1e-5, 1e-4, 1e-3)
#: step of the slopes that carry an error of the variables over, as a share of their bounds
_STEP = 1e-6


class Front(NamedTuple):
    """Points of the front, the best first objective first.

    `objective` and `second_objective` (k,) with absolute errors, `variables` and
    `variables_error` (k, n). Errors are those of the exact point with the same bound on the
    second objective. `evaluations` counts points evaluated, all searches together; `notes` says
    what was left out.
    """

    variables: np.ndarray
    variables_error: np.ndarray
    objective: np.ndarray
    objective_error: np.ndarray
    second_objective: np.ndarray
    second_objective_error: np.ndarray
    evaluations: int
    notes: tuple[str, ...]


class _Point(NamedTuple):
    optimum: Optimum
    first: float
    second: float
    second_error: float


class _Gap(NamedTuple):
    """Two points of the front and the bounds on the second objective still open between them."""

    left: _Point
    right: _Point
    high: float
    low: float

    def size(self) -> float:
        """Area of the rectangle in which the front between them has to lie."""
        return max(0.0, self.right.first - self.left.first) * max(0.0, self.high - self.low)


def front(
    evaluate: Both,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    first: ArrayLike | None = None,
    points: int = 15,
    starts: int = 8,
    rtol: float = 1e-9,
    errors: ErrorsAt | None = None,
    period: ArrayLike = 0.0,
    ahead: Ahead | None = None,
) -> Front:
    """Trace the points where neither objective can become smaller without the other growing.

    Parameters
    ----------
    evaluate : callable
        `evaluate(variables (n,)) -> (objective, second objective, margins (m,))`, both to be made
        small; points that cannot be evaluated as in `minimise`.
    lower, upper, first, starts, rtol, errors, period, ahead
        As of `minimise`, with errors of both objectives, then of the margins; the ends of the front
        are searched from all starts.
    points : int
        Points asked for, ends included; at least 2. Fewer come back where the front jumps.

    Raises
    ------
    NumericalFailure
        If an end of the front has no optimum (see `minimise`).

    Notes
    -----
    Epsilon-constraint method (Y. Y. Haimes, L. S. Lasdon, D. A. Wismer, IEEE Trans. SMC-1 (1971),
    296-297): between the two ends the second objective is bounded and the first one minimised,
    from the neighbour. The next bound halves the gap in which the front may hide most. It also
    finds the parts of a front that bulge inwards, which weighted sums miss. Dominated points are
    removed. Where the best second objective is reached on a continuum, the last point bounds it
    a millionth of the front above, or more where a kink is in the way, which makes it unique.
    """
    remembered: dict[bytes, tuple[float, float, np.ndarray]] = {}
    search = partial(
        minimise,
        lower=lower,
        upper=upper,
        rtol=rtol,
        period=period,
        ahead=ahead,
    )

    def of(goal: int, span: float | None = None) -> ErrorsAt | None:
        """Errors of one objective and of the margins, with that on the second one."""
        if errors is None:
            return None

        def off(variables: np.ndarray) -> np.ndarray:
            one, two, *others = errors(variables)
            more = [] if span is None else [two / span]
            return np.array([(one, two)[goal], *others, *more])

        return off

    def both(variables: np.ndarray) -> tuple[float, float, np.ndarray]:
        key = variables.tobytes()
        if key not in remembered:
            one, two, margins = evaluate(variables)
            remembered[key] = (one, two, np.atleast_1d(np.asarray(margins, dtype=float)))
        return remembered[key]

    def bounded(bound: float, span: float, start: np.ndarray, more: int = 0) -> Optimum:
        def limited(variables: np.ndarray) -> tuple[float, np.ndarray]:
            one, two, margins = both(variables)
            return one, np.append(margins, (bound - two) / span)

        return search(limited, first=start, starts=more, errors=of(0, span))

    def described(optimum: Optimum) -> _Point:
        one, two, _ = both(optimum.variables)
        off = 0.0 if errors is None else float(errors(optimum.variables)[1])
        error = off + _carried(both, optimum, lower, upper)
        return _Point(optimum, one, two, error)

    def end_of(goal: int) -> _Point:
        def alone(variables: np.ndarray) -> tuple[float, np.ndarray]:
            values = both(variables)
            return float(values[goal]), values[2]

        return described(search(alone, first=first, starts=starts, errors=of(goal)))

    def far_end(lowest: _Point, span: float) -> _Point:
        """Of all points with the best second objective, nearly the one with the best first."""
        for slack in _SLACKS:
            try:
                bound = lowest.second + slack * span
                return described(bounded(bound, span, lowest.optimum.variables))
            except NumericalFailure as failure:
                why = str(failure)
        notes.append(f"the best second objective is reached at many points, this is one: {why}")
        return lowest

    notes: list[str] = []
    begin, other = end_of(0), end_of(1)
    span = begin.second - other.second
    if span <= begin.second_error + other.second_error:
        return _front([begin], len(remembered), ("one point is the best for both objectives",))
    if other.optimum.free_directions:
        other = far_end(other, span)
    front_points = [begin]
    gaps = [_Gap(begin, other, begin.second, other.second)]
    for _ in range(points - 2):
        gap = gaps.pop(int(np.argmax([one.size() for one in gaps])))
        bound = 0.5 * (gap.high + gap.low)
        point = None
        for start, more in ((gap.left, 0), (gap.right, 2)):
            try:
                point = described(bounded(bound, span, start.optimum.variables, more))
                break
            except NumericalFailure as failure:
                why = str(failure)
        if point is None:
            notes.append(f"no optimum with the second objective at {bound:.6g}: {why}")
            continue
        front_points.append(point)
        gaps.append(_Gap(gap.left, point, gap.high, bound))
        gaps.append(_Gap(point, gap.right, min(bound, point.second), gap.low))
    best = _undominated([*front_points, other])
    if len(best) < len(front_points) + 1:
        notes.append(
            f"{len(front_points) + 1 - len(best)} points were as good as others or dominated"
        )
    return _front(best, len(remembered), tuple(notes))


def _undominated(points: list[_Point]) -> list[_Point]:
    """Points that no other beats in one objective while it is as good in the other."""
    ones, twos = (
        np.array(part) for part in ([p.first for p in points], [p.second for p in points])
    )
    near_one, near_two = (SAME * max(float(np.ptp(part)), 1e-300) for part in (ones, twos))
    best: list[_Point] = []
    for index in np.lexsort((twos, ones)):
        one, two = ones[index], twos[index]
        beaten = (ones <= one + near_one) & (twos <= two + near_two)
        better = beaten & ((ones < one - near_one) | (twos < two - near_two))
        same = any(abs(p.first - one) <= near_one and abs(p.second - two) <= near_two for p in best)
        if not np.any(better) and not same:
            best.append(points[index])
    return best


def _carried(
    both: Callable[[np.ndarray], tuple[float, float, np.ndarray]],
    optimum: Optimum,
    lower: ArrayLike,
    upper: ArrayLike,
) -> float:
    """Error of the second objective that comes from the errors of the variables."""
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    total = 0.0
    for axis, error in enumerate(optimum.variables_error):
        if error == 0.0:
            continue
        step = max(_STEP * (high[axis] - low[axis]), float(error))
        slopes = []
        for side in (-1.0, 1.0):
            nearby = optimum.variables.copy()
            nearby[axis] = np.clip(nearby[axis] + side * step, low[axis], high[axis])
            if nearby[axis] != optimum.variables[axis]:
                try:
                    increase = abs(both(nearby)[1] - both(optimum.variables)[1])
                except NumericalFailure:
                    continue
                slopes.append(increase / abs(nearby[axis] - optimum.variables[axis]))
        total += float(error) * max(slopes, default=0.0)
    return total


def _front(points: list[_Point], evaluations: int, notes: tuple[str, ...]) -> Front:
    return Front(
        variables=np.array([p.optimum.variables for p in points]),
        variables_error=np.array([p.optimum.variables_error for p in points]),
        objective=np.array([p.first for p in points]),
        objective_error=np.array([p.optimum.objective_error for p in points]),
        second_objective=np.array([p.second for p in points]),
        second_objective_error=np.array([p.second_error for p in points]),
        evaluations=evaluations,
        notes=notes,
    )


# ----------------------------------------------------------------------------
# What each variable does to the objective at a point, and what a small error in it costs.
# ----------------------------------------------------------------------------

#: costs of both directions that agree to this share are the same
_TIE = 1e-6
#: deviation that is tried at an optimum, as a share of the distance between the bounds
DEVIATION = 0.01


class ObjectiveSlopes(NamedTuple):
    """Derivatives of the objective by each variable, in the units of both, with their errors.

    `known` (n,) is False where there is none: on a kink or next to points without a value.
    """

    slope: np.ndarray
    error: np.ndarray
    known: np.ndarray


class Cost(NamedTuple):
    """What a deviation of a variable costs, the worse of both directions inside the bounds.

    `deviation` (n,) is how far the variable was moved, with its sign; `loss` (n,) the change of
    the objective there, positive for worse, and `loss_error` its error; `margin` (n,) the least
    margin of all limits there. `known` (n,) is False where neither direction has a value.
    """

    deviation: np.ndarray
    loss: np.ndarray
    loss_error: np.ndarray
    margin: np.ndarray
    known: np.ndarray


def slopes_at(
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    at: ArrayLike,
    errors: ErrorsAt | None = None,
    ahead: Ahead | None = None,
) -> ObjectiveSlopes:
    """Differentiate the objective at a point within the bounds.

    Parameters
    ----------
    evaluate, lower, upper, errors, ahead
        As of `minimise.minimise`; lower < upper.
    at : (n,) array

    Raises
    ------
    NumericalFailure
        If the point itself cannot be evaluated.

    Notes
    -----
    Five-point differences with `conditions.slope`; the error counts truncation, measured noise
    and the slopes that `errors` of the values may have.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    point = np.asarray(at, dtype=float)
    box = Box(low, high)
    sampler = Sampler(evaluate, box, 10**9, ahead, errors)
    unit = box.unit(point)
    vectors, _ = set_scale(sampler, unit[None, :])
    if vectors[0] is None:
        raise NumericalFailure(next(iter(sampler.failures.values())))
    noise, leaning = measured_noise(sampler, unit), sampler.leaning(unit)
    first, error = np.zeros(point.size), np.zeros(point.size)
    known = np.zeros(point.size, dtype=bool)
    for axis, direction in enumerate(np.eye(point.size)):
        try:
            one = slope(sampler, unit, direction, noise)
        except NumericalFailure:
            continue
        known[axis] = not one.kinked[0]
        first[axis], error[axis] = one.first[0], one.error[0] + leaning[0, axis]
    inner = box.slope(point)
    values = first * sampler.scale / inner
    uncertainty = error * sampler.scale / inner + 8.0 * EPSILON * np.abs(values)
    return ObjectiveSlopes(np.where(known, values, 0.0), np.where(known, uncertainty, 0.0), known)


def cost_of_deviation(
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    at: ArrayLike,
    *,
    share: float = DEVIATION,
    errors: ErrorsAt | None = None,
    period: ArrayLike = 0.0,
) -> Cost:
    """Move each variable by `share` of the distance between its bounds, both ways, and look.

    Evaluated, not extrapolated: limits that hold an optimum, kinks and curvature are all in it.
    Parameters as of `slopes_at`, which also says what is raised; `period` as of
    `minimise.minimise`.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    around = Box(low, high, np.broadcast_to(np.asarray(period, dtype=float), low.shape)).around
    point = np.asarray(at, dtype=float)
    here = float(evaluate(point)[0])
    size = point.size
    deviation, loss, error = np.zeros(size), np.full(size, -np.inf), np.zeros(size)
    margin, known = np.full(size, np.inf), np.zeros(size, dtype=bool)
    for axis in range(size):
        for side in (1.0, -1.0):
            moved = point.copy()
            wanted = point[axis] + side * share * (high[axis] - low[axis])
            moved[axis] = wanted
            if not (around[axis] or low[axis] <= wanted <= high[axis]):
                continue
            try:
                objective, margins = evaluate(moved)
            except NumericalFailure:
                continue
            there = float(objective)
            if not np.isfinite(there):
                continue
            known[axis] = True
            margin[axis] = min(margin[axis], float(np.min(margins, initial=np.inf)))
            # where both directions cost the same, rounding would choose: the first counts
            tie = error[axis] + _TIE * abs(loss[axis]) if np.isfinite(loss[axis]) else 0.0
            if there - here > loss[axis] + tie:
                deviation[axis], loss[axis] = moved[axis] - point[axis], there - here
                error[axis] = 4.0 * EPSILON * (abs(there) + abs(here))
                if errors is not None:
                    error[axis] += float(errors(moved)[0] + errors(point)[0])
    return Cost(deviation, np.where(known, loss, 0.0), error, margin, known)
