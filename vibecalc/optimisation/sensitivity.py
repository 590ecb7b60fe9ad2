"""What each variable does to the objective at a point, and what a small error in it costs."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.differences import measured_noise, slope
from vibecalc.optimisation.sampler import Evaluate, Sampler
from vibecalc.optimisation.search import set_scale
from vibecalc.optimisation.variables import Box

#: deviation that is tried at an optimum, as a share of the distance between the bounds
DEVIATION = 0.01


class Slopes(NamedTuple):
    """Derivatives of the objective by each variable, in the units of both, with their errors.

    `known` (n,) is False where there is none: on a kink or beside points without a value.
    """

    slope: np.ndarray
    error: np.ndarray
    known: np.ndarray


class Cost(NamedTuple):
    """What a deviation of a variable costs, the worse of both directions inside the bounds.

    `deviation` (n,) is how far the variable was moved, with its sign; `rise` (n,) the change of
    the objective there, positive for worse, and `rise_error` its error; `margin` (n,) the least
    margin of all limits there. `known` (n,) is False where neither direction has a value.
    """

    deviation: np.ndarray
    rise: np.ndarray
    rise_error: np.ndarray
    margin: np.ndarray
    known: np.ndarray


def slopes_at(
    evaluate: Evaluate, lower: ArrayLike, upper: ArrayLike, at: ArrayLike, accuracy: float = 0.0
) -> Slopes:
    """Differentiate the objective (its largest entry) at a point within the bounds.

    Parameters
    ----------
    evaluate, lower, upper, accuracy
        As of `constrained.minimise`; lower < upper.
    at : (n,) array

    Raises
    ------
    NumericalFailure
        If the point itself cannot be evaluated.

    Notes
    -----
    Five-point differences with `differences.slope`; the error counts truncation, measured noise
    and `accuracy`, the relative error of the values.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    point = np.asarray(at, dtype=float)
    box = Box(low, high)
    sampler = Sampler(_largest(evaluate), box, 10**9)
    unit = box.unit(point)
    vectors, _ = set_scale(sampler, unit[None, :])
    if vectors[0] is None:
        raise NumericalFailure(next(iter(sampler.failures.values())))
    noise = measured_noise(sampler, unit) + accuracy * np.abs(vectors[0]) / sampler.scale
    found, error = np.zeros(point.size), np.zeros(point.size)
    known = np.zeros(point.size, dtype=bool)
    for axis, direction in enumerate(np.eye(point.size)):
        try:
            one = slope(sampler, unit, direction, noise)
        except NumericalFailure:
            continue
        known[axis] = not one.kinked[0]
        found[axis], error[axis] = one.first[0], one.error[0]
    inner = box.slope(point)
    values = found * sampler.scale / inner
    doubt = error * sampler.scale / inner + 8.0 * EPSILON * np.abs(values)
    return Slopes(np.where(known, values, 0.0), np.where(known, doubt, 0.0), known)


def cost_of_deviation(
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    at: ArrayLike,
    *,
    share: float = DEVIATION,
    accuracy: float = 0.0,
    period: ArrayLike = 0.0,
) -> Cost:
    """Move each variable by `share` of the distance between its bounds, both ways, and look.

    Evaluated, not extrapolated: limits that hold an optimum, kinks and curvature are all in it.
    Parameters as of `slopes_at`, which also says what is raised; `period` as of
    `constrained.minimise`.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    around = Box(low, high, np.broadcast_to(np.asarray(period, dtype=float), low.shape)).around
    point = np.asarray(at, dtype=float)
    largest = _largest(evaluate)
    here = float(np.max(largest(point)[0]))
    size = point.size
    deviation, rise, error = np.zeros(size), np.full(size, -np.inf), np.zeros(size)
    margin, known = np.full(size, np.inf), np.zeros(size, dtype=bool)
    for axis in range(size):
        for side in (1.0, -1.0):
            moved = point.copy()
            wanted = point[axis] + side * share * (high[axis] - low[axis])
            moved[axis] = wanted
            if not (around[axis] or low[axis] <= wanted <= high[axis]):
                continue
            try:
                objective, margins = largest(moved)
            except NumericalFailure:
                continue
            there = float(np.max(objective))
            if not np.isfinite(there):
                continue
            known[axis] = True
            margin[axis] = min(margin[axis], float(np.min(margins, initial=np.inf)))
            if there - here > rise[axis]:
                deviation[axis], rise[axis] = moved[axis] - point[axis], there - here
                error[axis] = (accuracy + 4.0 * EPSILON) * (abs(there) + abs(here))
    return Cost(deviation, np.where(known, rise, 0.0), error, margin, known)


def _largest(evaluate: Evaluate) -> Evaluate:
    def one(variables: np.ndarray) -> tuple[ArrayLike, ArrayLike]:
        objective, margins = evaluate(variables)
        return np.max(np.atleast_1d(np.asarray(objective, dtype=float))), margins

    return one
