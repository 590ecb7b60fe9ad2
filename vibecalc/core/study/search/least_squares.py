"""Least squares within bounds, and what the points tell of the variables.

Residuals are dimensionless, computed less measured over the standard uncertainty. The search is
`scipy.optimize.least_squares` (Branch, Coleman and Li 1999) from several starts in the unit cube of
`problem.Box`; what it ends in is mended by Gauss-Newton steps with a Jacobian of known error.
"""

from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.derivatives import Slope, gradient
from vibecalc.core.study.search.local_search import Stranded, forward_slopes
from vibecalc.core.study.search.problem import Problem, Sampler
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray

#: variables (n,) in SI to residuals (m,) and what their rounding may be (m,)
Residuals = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

# ----------------------------------------------------------------------------
# The search from several starts.
# ----------------------------------------------------------------------------

#: of a search, which is mended, and of what is no worse
_SEARCH_TOLERANCE, _TOLERANCE = 1e-7, 1e-12
_MOST_STEPS = 200
#: of a sum of squares, what two ends may differ by and still count as one
_SAME = 1e-7
_MENDINGS = 6
#: step on the unit cube after which slopes are those of the place before
_SETTLED = 1e-8
#: Gauss-Newton steps leave alone what is this much weaker than the strongest slope
_WEAK = 1e-8


class LeastSquares(NamedTuple):
    """The best end of all searches.

    `variables` (n,) in SI with their numerical error; `residuals` (m,) and the sum of their
    squares; `slopes` (m, n) of the residuals over the coordinates of the unit cube, each from one
    bound to the other, with their error; `widths` (n,) in SI is what one of a coordinate is at the
    end; `moved_by` (n, m) in SI is how far the variables go with each residual, at most; `active`
    (n,) is -1 at the lower bound, 1 at the upper one. `searches` (k,) are the sums of squares where
    each search ended, infinite where it failed.
    """

    variables: FloatArray
    variables_error: FloatArray
    residuals: FloatArray
    chi_square: float
    slopes: FloatArray
    slopes_error: FloatArray
    widths: FloatArray
    moved_by: FloatArray
    active: FloatArray
    searches: FloatArray
    evaluations: int
    failures: tuple[str, ...]


def least_squares_within(
    residuals: Residuals,
    lower: FloatArray,
    upper: FloatArray,
    first: FloatArray,
    starts: FloatArray,
) -> LeastSquares:
    """Make the sum of the squared residuals least.

    Parameters
    ----------
    residuals : of variables (n,) in SI: residuals (m,) and their numerical errors (m,), m >= n;
        raises NumericalFailure where there are none.
    lower, upper : (n,) bounds in SI.
    first : (n,) the first start, in SI.
    starts : (k, n) further starts in the unit cube.

    Raises
    ------
    NumericalFailure : no search ends in a minimum.
    """
    sampler = Sampler(Problem(lambda variables: (residuals(variables)[0], ()), lower, upper))
    box = sampler.box
    places = np.vstack([box.unit(first)[None], starts])
    ends = [_searched(sampler, place) for place in places]
    costs = np.array([_cost(sampler, end) for end in ends])
    best = ends[int(np.argmax(costs <= np.min(costs) * (1.0 + _SAME)))]
    if best is None:
        reasons = "; ".join(dict.fromkeys([*sampler.failures.values()][:3]))
        raise NumericalFailure(
            f"none of {len(places)} searches for the least squares ended in a minimum"
            + (f": {reasons}" if reasons else "")
        )
    noise = residuals(box.values(best))[1]
    place, moved, slopes = _mended(sampler, best, noise)
    # what no point feels stays as it was
    idle = np.linalg.norm(slopes.first, axis=0) <= np.linalg.norm(slopes.error, axis=0)
    stays = np.where(idle, places[0], place)
    if _cost(sampler, stays) <= _cost(sampler, place) * (1.0 + _SAME) + _SAME:
        place = stays
    at_end, values = sampler(place), box.values(place)
    assert at_end is not None
    widths = np.abs(box.slope(values))
    strongest = max(float(np.linalg.norm(slopes.first, 2)), 1e-300)
    weak = float(np.clip(np.linalg.norm(slopes.error) / strongest, _WEAK, 1.0))
    moved_by = np.abs(np.linalg.pinv(slopes.first, rcond=weak)) * widths[:, None]
    rounding = 64.0 * EPSILON * (np.abs(values) + widths)
    return LeastSquares(
        variables=values,
        variables_error=moved * widths + moved_by @ noise + rounding,
        residuals=at_end,
        chi_square=float(at_end @ at_end),
        slopes=slopes.first,
        slopes_error=slopes.error,
        widths=widths,
        moved_by=moved_by,
        active=np.where(place <= 0.0, -1.0, np.where(place >= 1.0, 1.0, 0.0)),
        searches=costs,
        evaluations=sampler.count,
        failures=tuple(sampler.failures.values()),
    )


def _searched(sampler: Sampler, start: FloatArray) -> FloatArray | None:
    """Where a search ends; None where it does not end in a minimum."""
    from scipy.optimize import least_squares

    if sampler(start) is None:
        return None

    def residuals(place: FloatArray) -> FloatArray:
        vector = sampler(place)
        return np.full(sampler.parts, np.nan) if vector is None else vector

    # not a number, or a slope next to a point without results
    with suppress(ValueError, np.linalg.LinAlgError, Stranded), np.errstate(invalid="ignore"):
        found = least_squares(
            residuals,
            start,
            jac=lambda place: forward_slopes(sampler, place),
            bounds=(np.zeros(start.size), np.ones(start.size)),
            xtol=_SEARCH_TOLERANCE,
            ftol=_SEARCH_TOLERANCE,
            gtol=_TOLERANCE,
            max_nfev=_MOST_STEPS,
        )
        return np.asarray(found.x) if found.status > 0 else None
    return None


def _mended(
    sampler: Sampler, place: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray, Slope]:
    """Gauss-Newton steps within the bounds: the place, the last step (n,), and slopes there."""
    from scipy.optimize import lsq_linear

    cost = _cost(sampler, place)
    for _ in range(_MENDINGS):
        slopes, here = gradient(sampler, place, noise), sampler(place)
        assert here is not None
        weak = _WEAK * max(float(np.linalg.norm(slopes.first)), 1e-300)
        table = np.vstack([slopes.first, weak * np.eye(place.size)])
        wanted = np.concatenate([-here, np.zeros(place.size)])
        room = -place - 1e-300, 1.0 - place + 1e-300
        after = place + lsq_linear(table, wanted, bounds=room, method="bvls").x
        after = np.where(np.abs(after - np.round(after)) < 4.0 * EPSILON, np.round(after), after)
        moved, there = np.abs(after - place), _cost(sampler, after)
        if not there <= cost * (1.0 + 1e-10) + 1e-300:
            break
        place, cost = after, min(cost, there)
        if np.max(moved) <= _SETTLED:
            break
    return place, moved, slopes


def _cost(sampler: Sampler, place: FloatArray | None) -> float:
    vector = None if place is None else sampler(place)
    return np.inf if vector is None else float(vector @ vector)


# ----------------------------------------------------------------------------
# What the points tell: covariance, and combinations of variables that they do not tell apart.
# ----------------------------------------------------------------------------

#: standard deviation of a variable of which only the bounds are known, over the way between these
FROM_BOUNDS = 1.0 / np.sqrt(12.0)
#: of a unit vector, what is no part of a combination
_NO_PART = 1e-3


class Determined(NamedTuple):
    """What least squares tell of n variables, all in ways between their bounds.

    `covariance` (n, n) is infinite for variables that a combination without any effect is made of.
    `combinations` (n, n) are orthogonal unit vectors, the best determined first, `deviations` (n,)
    the standard uncertainty along each, infinite where no slope is left; `told` (n,) is False for
    combinations that are known no better than from the bounds, `felt` (n,) for variables that no
    point depends on.
    """

    covariance: FloatArray
    combinations: FloatArray
    deviations: FloatArray
    told: FloatArray
    felt: FloatArray


def what_is_determined(slopes: FloatArray, error: FloatArray, growth: float = 1.0) -> Determined:
    """Singular values and vectors of a Jacobian (m, n) over the ways between bounds.

    The covariance is (J^T J)^-1 times `growth` squared, by the singular value decomposition; a
    singular value that the error of the slopes exceeds is none.
    """
    _, sizes, rows = np.linalg.svd(slopes, full_matrices=False)
    floor = max(float(np.linalg.norm(error)), 8.0 * EPSILON * float(sizes[0]))
    seen = sizes > floor
    deviations = np.where(seen, growth / np.where(seen, sizes, 1.0), np.inf)
    weighed = rows[seen] * deviations[seen, None]
    covariance = weighed.T @ weighed
    lost = np.any(np.abs(rows[~seen]) > _NO_PART, axis=0)
    covariance[lost] = covariance[:, lost] = 0.0
    covariance[lost, lost] = np.inf
    largest = rows[np.arange(len(rows)), np.argmax(np.abs(rows), axis=1)]
    return Determined(
        covariance,
        rows * np.sign(largest)[:, None],
        deviations,
        deviations < FROM_BOUNDS,
        np.linalg.norm(slopes, axis=0) > np.linalg.norm(error, axis=0),
    )
