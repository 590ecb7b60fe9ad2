"""What each variable does to the objective at a point, and what a small error in it costs."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.derivatives import measured_noise, slope
from vibecalc.core.study.search.local_search import set_scale
from vibecalc.core.study.search.problem import Ahead, Box, ErrorsAt, Evaluate, Sampler, largest_part
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

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
    Five-point differences with `derivatives.slope`; the error counts truncation, measured noise
    and the slopes that `errors` of the values may have.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    point = np.asarray(at, dtype=float)
    box = Box(low, high)
    sampler = Sampler(evaluate, box, ahead=ahead, errors=errors)
    whole, unit = largest_part(sampler), box.unit(point)
    set_scale(sampler, unit[None, :])
    if sampler(unit) is None:
        raise NumericalFailure(sampler.failure(unit))
    noise, leaning = measured_noise(whole, unit), sampler.leaning(unit)
    first, error = np.zeros(point.size), np.zeros(point.size)
    known = np.zeros(point.size, dtype=bool)
    for axis, direction in enumerate(np.eye(point.size)):
        try:
            one = slope(whole, unit, direction, noise)
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
    around = Box(low, high, period).around
    point = np.asarray(at, dtype=float)
    here = float(np.max(evaluate(point)[0]))
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
            there = float(np.max(objective))
            if not np.isfinite(there):
                continue
            known[axis] = True
            least = min((float(np.min(one)) for one in margins), default=np.inf)
            margin[axis] = min(margin[axis], least)
            # where both directions cost the same, rounding would choose: the first counts
            tie = error[axis] + _TIE * abs(loss[axis]) if np.isfinite(loss[axis]) else 0.0
            if there - here > loss[axis] + tie:
                deviation[axis], loss[axis] = moved[axis] - point[axis], there - here
                error[axis] = 4.0 * EPSILON * (abs(there) + abs(here))
                if errors is not None:
                    error[axis] += float(errors(moved)[0] + errors(point)[0])
    return Cost(deviation, np.where(known, loss, 0.0), error, margin, known)
