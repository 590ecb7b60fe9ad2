"""What one objective costs in another: the front between the two, by constrained optima."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.constrained import minimise
from vibecalc.optimisation.optimum import Optimum

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
    found: Optimum
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
    accuracy: float = 0.0,
    period: ArrayLike = 0.0,
) -> Front:
    """Trace the points where neither objective can become smaller without the other growing.

    Parameters
    ----------
    evaluate : callable
        `evaluate(variables (n,)) -> (objective, second objective, margins (m,))`, both to be made
        small; points that cannot be evaluated as in `minimise`.
    lower, upper, first, starts, rtol, accuracy, period
        As of `minimise`; the ends of the front are searched from all starts.
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
        minimise, lower=lower, upper=upper, rtol=rtol, accuracy=accuracy, period=period
    )

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

        return search(limited, first=start, starts=more)

    def described(found: Optimum) -> _Point:
        one, two, _ = both(found.variables)
        error = accuracy * abs(two) + _carried(both, found, lower, upper)
        return _Point(found, one, two, error)

    def end_of(goal: int) -> _Point:
        def alone(variables: np.ndarray) -> tuple[float, np.ndarray]:
            values = both(variables)
            return float(values[goal]), values[2]

        return described(search(alone, first=first, starts=starts))

    def far_end(lowest: _Point, span: float) -> _Point:
        """Of all points with the best second objective, nearly the one with the best first."""
        for slack in _SLACKS:
            try:
                bound = lowest.second + slack * span
                return described(bounded(bound, span, lowest.found.variables))
            except NumericalFailure as failure:
                why = str(failure)
        notes.append(f"the best second objective is reached at many points, this is one: {why}")
        return lowest

    notes: list[str] = []
    begin, other = end_of(0), end_of(1)
    span = begin.second - other.second
    if span <= begin.second_error + other.second_error:
        return _front([begin], len(remembered), ("one point is the best for both objectives",))
    if other.found.free_directions:
        other = far_end(other, span)
    found = [begin]
    gaps = [_Gap(begin, other, begin.second, other.second)]
    for _ in range(points - 2):
        gap = gaps.pop(int(np.argmax([one.size() for one in gaps])))
        bound = 0.5 * (gap.high + gap.low)
        point = None
        for start, more in ((gap.left, 0), (gap.right, 2)):
            try:
                point = described(bounded(bound, span, start.found.variables, more))
                break
            except NumericalFailure as failure:
                why = str(failure)
        if point is None:
            notes.append(f"no optimum with the second objective at {bound:.6g}: {why}")
            continue
        found.append(point)
        gaps.append(_Gap(gap.left, point, gap.high, bound))
        gaps.append(_Gap(point, gap.right, min(bound, point.second), gap.low))
    kept = _undominated([*found, other])
    if len(kept) < len(found) + 1:
        notes.append(f"{len(found) + 1 - len(kept)} points were as good as others or dominated")
    return _front(kept, len(remembered), tuple(notes))


def _undominated(points: list[_Point]) -> list[_Point]:
    """Points that no other beats in one objective while it is as good in the other."""
    ones, twos = (
        np.array(part) for part in ([p.first for p in points], [p.second for p in points])
    )
    near_one, near_two = (SAME * max(float(np.ptp(part)), 1e-300) for part in (ones, twos))
    kept: list[_Point] = []
    for index in np.lexsort((twos, ones)):
        one, two = ones[index], twos[index]
        beaten = (ones <= one + near_one) & (twos <= two + near_two)
        better = beaten & ((ones < one - near_one) | (twos < two - near_two))
        same = any(abs(p.first - one) <= near_one and abs(p.second - two) <= near_two for p in kept)
        if not np.any(better) and not same:
            kept.append(points[index])
    return kept


def _carried(
    both: Callable[[np.ndarray], tuple[float, float, np.ndarray]],
    found: Optimum,
    lower: ArrayLike,
    upper: ArrayLike,
) -> float:
    """Error of the second objective that comes from the errors of the variables."""
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    total = 0.0
    for axis, error in enumerate(found.variables_error):
        if error == 0.0:
            continue
        step = max(_STEP * (high[axis] - low[axis]), float(error))
        rises = []
        for side in (-1.0, 1.0):
            beside = found.variables.copy()
            beside[axis] = np.clip(beside[axis] + side * step, low[axis], high[axis])
            if beside[axis] != found.variables[axis]:
                try:
                    rise = abs(both(beside)[1] - both(found.variables)[1])
                except NumericalFailure:
                    continue
                rises.append(rise / abs(beside[axis] - found.variables[axis]))
        total += float(error) * max(rises, default=0.0)
    return total


def _front(points: list[_Point], evaluations: int, notes: tuple[str, ...]) -> Front:
    return Front(
        variables=np.array([p.found.variables for p in points]),
        variables_error=np.array([p.found.variables_error for p in points]),
        objective=np.array([p.first for p in points]),
        objective_error=np.array([p.found.objective_error for p in points]),
        second_objective=np.array([p.second for p in points]),
        second_objective_error=np.array([p.second_error for p in points]),
        evaluations=evaluations,
        notes=notes,
    )
