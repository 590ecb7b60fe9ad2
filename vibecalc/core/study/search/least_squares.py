"""Least squares within bounds, and what the points tell of the variables.

Residuals are dimensionless, computed less measured over the standard uncertainty. The search is
`scipy.optimize.least_squares` (Branch, Coleman and Li 1999) from several starts in the unit cube of
`problem.Box`; what it ends in is mended by Gauss-Newton steps with a Jacobian of known error.
"""

import math
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from vibecalc.core.study.search.derivatives import Slope, gradient
from vibecalc.core.study.search.local_search import Stranded, forward_slopes
from vibecalc.core.study.search.problem import Problem, Sampler
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray

#: variables (n,) in SI to residuals (m,) and what their rounding may be (m,)
Residuals = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

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
#: standard deviation of a variable of which only the bounds are known, over the way between these
FROM_BOUNDS = 1.0 / np.sqrt(12.0)
#: of a unit vector, what is no part of a combination
_NO_PART = 1e-3
#: a chi square that chance exceeds less often makes uncertainties grow
_LEAST_PROBABILITY = 0.05


class LeastSquares:
    """The least sum of squared residuals, and what it tells of n variables.

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

    Attributes
    ----------
    variables, variables_error : (n,) in SI, with their numerical error.
    residuals, chi_square : (m,) and the sum of their squares.
    slopes, slopes_error : (m, n) of the residuals over the coordinates of the unit cube, each from
        one bound to the other.
    widths : (n,) in SI, what one of a coordinate is at the end.
    moved_by : (n, m) in SI, how far the variables go with each residual, at most.
    active : (n,) -1 at the lower bound, 1 at the upper one, else 0.
    searches : (k + 1,) sums of squares where each search ended, infinite where it failed.
    spare, probability, growth : degrees of freedom, the probability of a chi square as large, and
        the factor of all uncertainties: the root of chi square over the degrees of freedom, where
        chance makes it as large less than once in twenty, else 1.
    covariance : (n, n) (J^T J)^-1 times the growth squared, by the singular value decomposition of
        the slopes J; infinite for variables that a combination without any effect is made of. A
        singular value that the error of the slopes exceeds is none.
    combinations, deviations : (n, n) orthogonal unit vectors, the best determined first, and the
        standard uncertainty (n,) along each over the way between the bounds, infinite where no
        slope is left.
    told, felt : (n,) False for combinations that are known no better than from the bounds, and for
        variables that no point depends on.
    """

    def __init__(
        self,
        residuals: Residuals,
        lower: FloatArray,
        upper: FloatArray,
        first: FloatArray,
        starts: FloatArray,
    ):
        sampler = Sampler(Problem(lambda variables: (residuals(variables)[0], ()), lower, upper))
        box = sampler.box
        places = np.vstack([box.unit(first)[None], starts])
        ends = [_searched(sampler, place) for place in places]
        self.searches = np.array([_cost(sampler, end) for end in ends])
        lowest = self.searches <= np.min(self.searches) * (1.0 + _SAME)
        best, self.failures = ends[int(np.argmax(lowest))], sampler.failures
        if best is None:
            words = f"none of {len(places)} searches for the least squares ended in a minimum"
            reasons = "; ".join(dict.fromkeys([*self.failures.values()][:3]))
            raise NumericalFailure(f"{words}: {reasons}" if reasons else words)
        noise = residuals(box.values(best))[1]
        place, moved, slopes = _mended(sampler, best, noise)
        self.felt = np.linalg.norm(slopes.first, axis=0) > np.linalg.norm(slopes.error, axis=0)
        # what no point feels stays as it was
        stays = np.where(self.felt, place, places[0])
        if _cost(sampler, stays) <= _cost(sampler, place) * (1.0 + _SAME) + _SAME:
            place = stays
        at_end = sampler(place)
        assert at_end is not None
        self.variables, self.residuals = box.values(place), at_end
        self.chi_square = float(at_end @ at_end)
        self.slopes, self.slopes_error = slopes.first, slopes.error
        self.widths = np.abs(box.slope(self.variables))
        self.active = np.where(place <= 0.0, -1.0, np.where(place >= 1.0, 1.0, 0.0))
        self.evaluations = sampler.count
        self._tell()
        strongest = max(float(np.linalg.norm(slopes.first, 2)), 1e-300)
        weak = float(np.clip(np.linalg.norm(slopes.error) / strongest, _WEAK, 1.0))
        self.moved_by = np.abs(np.linalg.pinv(slopes.first, rcond=weak)) * self.widths[:, None]
        rounding = 64.0 * EPSILON * (np.abs(self.variables) + self.widths)
        self.variables_error = moved * self.widths + self.moved_by @ noise + rounding

    def _tell(self) -> None:
        """What the slopes tell of the variables."""
        from scipy.special import chdtrc

        least = float(np.linalg.norm(self.slopes_error))
        rank = np.linalg.matrix_rank(self.slopes, tol=least or None)
        self.spare, self.probability, self.growth = len(self.residuals) - int(rank), 1.0, 1.0
        if self.spare > 0:
            self.probability = float(chdtrc(self.spare, self.chi_square))
        if self.probability < _LEAST_PROBABILITY and self.chi_square > self.spare:
            self.growth = math.sqrt(self.chi_square / self.spare)
        _, sizes, rows = np.linalg.svd(self.slopes, full_matrices=False)
        seen = sizes > max(least, 8.0 * EPSILON * float(sizes[0]))
        self.deviations = np.where(seen, self.growth / np.where(seen, sizes, 1.0), np.inf)
        weighed = rows[seen] * self.deviations[seen, None]
        self.covariance = weighed.T @ weighed
        lost = np.any(np.abs(rows[~seen]) > _NO_PART, axis=0)
        self.covariance[lost] = self.covariance[:, lost] = 0.0
        self.covariance[lost, lost] = np.inf
        largest = rows[np.arange(len(rows)), np.argmax(np.abs(rows), axis=1)]
        self.combinations = rows * np.sign(largest)[:, None]
        self.told = self.deviations < FROM_BOUNDS


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
            bounds=(0.0, 1.0),
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
        wanted = np.append(-here, np.zeros(place.size))
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
