"""What each variable does to the objective at a point, and what a small error in it costs."""

from contextlib import suppress

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.derivatives import measured_noise, slopes_along
from vibecalc.core.study.search.local_search import set_scale
from vibecalc.core.study.search.problem import Problem, Sampler
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

#: costs of both directions that agree to this share are the same
_TIE = 1e-6
#: deviation that is tried at an optimum, as a share of the distance between the bounds
DEVIATION = 0.01


def slopes_at(problem: Problem, at: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Differentiate the objective at a point within the bounds.

    Parameters
    ----------
    problem : Problem
        With lower < upper.
    at : (n,) array

    Returns
    -------
    slopes, errors : (n,) arrays
        Derivatives by each variable, in the units of both; NaN where there is none: on a kink or
        next to points without a value.

    Raises
    ------
    NumericalFailure
        If the point itself cannot be evaluated.

    Notes
    -----
    Five-point differences with `derivatives.slopes_along`; the error counts truncation, measured
    noise and the slopes that errors of the values may have.
    """
    sampler = Sampler(problem)
    box = sampler.box
    unit = box.unit(np.asarray(at, dtype=float))
    set_scale(sampler, unit[None, :])
    if sampler(unit) is None:
        raise NumericalFailure(sampler.failure(unit))
    whole = sampler.largest_part()
    noise, leaning = measured_noise(whole, unit), whole.leaning(unit)
    first, error = np.full((2, unit.size), np.nan)
    for axis, direction in enumerate(np.eye(unit.size)):
        with suppress(NumericalFailure):
            one = slopes_along(whole, unit, direction[None], noise)
            if not one.kinked[0, 0]:
                first[axis], error[axis] = one.first[0, 0], one.error[0, 0] + leaning[0, axis]
    scale = sampler.scale / box.slope(box.values(unit))
    return first * scale, (error + 8.0 * EPSILON * np.abs(first)) * scale


def cost_of_deviation(problem: Problem, at: ArrayLike) -> np.ndarray:
    """Move each variable by a share of the distance between its bounds, both ways, and look.

    Evaluated, not extrapolated: limits that hold an optimum, kinks and curvature are all in it.
    NumericalFailure if the point `at` (n,) itself has no value.

    Returns
    -------
    rows : (n, 4) array
        Of the worse direction how far the variable was moved, with its sign, the change of the
        objective there, positive for worse, and its error; and the least margin of all limits in
        either. NaN where neither direction has a value.
    """
    box, point = problem.box, np.asarray(at, dtype=float)
    low, high = box.lower, box.upper
    places = [
        [
            moved
            for moved in (point + step, point - step)
            if box.around[axis] or low[axis] <= moved[axis] <= high[axis]
        ]
        for axis, step in enumerate(np.diag(DEVIATION * (high - low)))
    ]
    if problem.ahead is not None:
        problem.ahead(np.array([point, *(moved for pair in places for moved in pair)]))
    goal, _, *off = problem.evaluate(point)
    here, rows = float(np.max(goal)), np.full((point.size, 4), np.nan)
    for axis, pair in enumerate(places):
        found = []
        for moved in pair:
            with suppress(NumericalFailure):
                goal, margins, *more = problem.evaluate(moved)
                there = float(np.max(goal))
                least = min((float(np.min(one)) for one in margins), default=np.inf)
                error = 4.0 * EPSILON * (abs(there) + abs(here))
                error += sum(float(one[0]) for one in (*off, *more))
                if np.isfinite(there):
                    found.append((moved[axis] - point[axis], there - here, error, least))
        if found:
            # where both directions cost the same, rounding would choose: the first counts
            first, worse = found[0], max(found, key=lambda one: one[1])
            tied = worse[1] <= first[1] + first[2] + _TIE * abs(first[1])
            rows[axis] = (*(first if tied else worse)[:3], min(one[3] for one in found))
    return rows
