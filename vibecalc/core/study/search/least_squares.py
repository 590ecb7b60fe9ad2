"""Least squares within bounds, and what the points tell of the variables.

Residuals are dimensionless, computed less measured over the standard uncertainty. The search is
`scipy.optimize.least_squares` (Branch, Coleman and Li 1999) from several starts in the unit cube of
`problem.Box`; what it ends in is mended by Gauss-Newton steps with a Jacobian of known error.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.problem import Box
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, FloatArray

#: variables (n,) in SI to residuals (m,) and what their rounding may be (m,)
Residuals = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

# ----------------------------------------------------------------------------
# Slopes of the residuals by differences in the unit cube.
# ----------------------------------------------------------------------------

#: steps of differences while searching, and the first of the last ones
_SEARCH_STEP, _LAST_STEP = 1e-5, 4e-3
#: how often the last steps are halved at most, and how well slopes then are known at best
_HALVINGS, _KNOWN = 4, 1e-8

_Unit = Callable[[FloatArray], FloatArray]


def _difference(residuals: _Unit, place: FloatArray, which: int, step: float) -> FloatArray:
    """Slope (m,) along one coordinate, of second order; one-sided where a bound is near."""

    def there(shift: float) -> FloatArray:
        moved = place.copy()
        moved[which] += shift
        return residuals(moved)

    if step <= place[which] <= 1.0 - step:
        return (there(step) - there(-step)) / (2.0 * step)
    way = step if place[which] < 0.5 else -step
    return (-3.0 * there(0.0) + 4.0 * there(way) - there(2.0 * way)) / (2.0 * way)


def _slopes(residuals: _Unit, place: FloatArray) -> FloatArray:
    """Jacobian (m, n) of the first order, as a search takes it."""
    here, columns = residuals(place), []
    for j in range(place.size):
        moved = place.copy()
        moved[j] += _SEARCH_STEP if place[j] < 0.5 else -_SEARCH_STEP
        columns.append((residuals(moved) - here) / (moved[j] - place[j]))
    return np.stack(columns, axis=1)


def slopes_with_error(
    residuals: _Unit, place: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Jacobian (m, n) at a point of the unit cube and what it may be off (m, n).

    Steps are halved and differences extrapolated to none (Richardson), until what the last halving
    has changed no longer shrinks; `noise` (m,) is what the residuals may be off.
    """
    found, errors = [], []
    for j in range(place.size):
        step = _LAST_STEP
        coarse, best, off = _difference(residuals, place, j, step), None, None
        for _ in range(_HALVINGS):
            step *= 0.5
            fine = _difference(residuals, place, j, step)
            extrapolated = (4.0 * fine - coarse) / 3.0
            change = np.abs(extrapolated - fine) + 3.0 * noise / step
            if off is not None and np.linalg.norm(change) >= np.linalg.norm(off):
                break
            best, off, coarse = extrapolated, change, fine
            if np.linalg.norm(off) <= _KNOWN * np.linalg.norm(best):
                break
        assert best is not None and off is not None
        found.append(best)
        errors.append(off)
    return np.stack(found, axis=1), np.stack(errors, axis=1)


# ----------------------------------------------------------------------------
# The search from several starts.
# ----------------------------------------------------------------------------

#: of a search, which is mended, and of what is no worse
_SEARCH_TOLERANCE, _TOLERANCE = 1e-7, 1e-12
_MOST_STEPS = 200
#: of a sum of squares, what two ends may differ by and still count as one
_SAME = 1e-7
#: of the way between bounds, from where on a variable may be on its bound
_NEAR = 1e-4
_MENDINGS = 6
#: Gauss-Newton steps leave alone what is this much weaker than the strongest slope
_WEAK = 1e-8


class SearchEnd(NamedTuple):
    """Where one search began and ended, (n,) in SI; chi squared is infinite where it failed."""

    start: FloatArray
    end: FloatArray
    chi_square: float


class LeastSquares(NamedTuple):
    """The best end of all searches.

    `variables` (n,) in SI with their numerical error; `residuals` (m,); `slopes` (m, n) of the
    residuals over the coordinates of the unit cube, each from one bound to the other, with their
    error; `widths` (n,) in SI is what one of a coordinate is at the end; `moved_by` (n, m) in SI is
    how far the variables go with each residual, at most; `active` (n,) is -1 at the lower bound, 1
    at the upper one.
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
    searches: tuple[SearchEnd, ...]
    evaluations: int
    failures: tuple[str, ...]


class _Counted:
    """Residuals in the unit cube, counted; not a number where there are none."""

    def __init__(self, residuals: Residuals, box: Box):
        self.residuals, self.box = residuals, box
        self.evaluations = 0
        self.failures: list[str] = []
        self.size = 0
        self.noise = np.zeros(0)
        self._last: tuple[FloatArray, FloatArray] | None = None

    def __call__(self, place: FloatArray) -> FloatArray:
        if self._last is not None and np.array_equal(self._last[0], place):
            return self._last[1]
        self.evaluations += 1
        try:
            found, self.noise = self.residuals(self.box.values(place))
        except NumericalFailure as failure:
            self.failures.append(str(failure))
            return np.full(max(self.size, 1), np.nan)
        self.size = found.size
        self._last = (place.copy(), found)
        return found


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
    box = Box(lower, upper)
    counted = _Counted(residuals, box)
    places = np.vstack([box.unit(first), starts]) if len(starts) else box.unit(first)[None]
    ends = [_searched(counted, place) for place in places]
    known = [end for end in ends if end is not None]
    if not known:
        reasons = "; ".join(dict.fromkeys(counted.failures[:3]))
        raise NumericalFailure(
            f"none of {len(places)} searches for the least squares ended in a minimum"
            + (f": {reasons}" if reasons else "")
        )
    least = min(cost for _, cost in known)
    place, cost = next(end for end in known if end[1] <= least * (1.0 + _SAME))
    place, moved, slopes, error = _mended(counted, place, cost)
    # what no point feels stays as it was
    idle = np.linalg.norm(slopes, axis=0) <= np.linalg.norm(error, axis=0)
    kept = np.where(idle, places[0], place)
    if np.any(idle) and _cost(counted, kept) <= _cost(counted, place) * (1.0 + _SAME) + _SAME:
        place = kept
    at_end = counted(place)
    widths = np.abs(box.slope(box.values(place)))
    strongest = max(float(np.linalg.norm(slopes, 2)), 1e-300)
    weak = max(_WEAK, float(np.linalg.norm(error)) / strongest)
    moved_by = np.abs(np.linalg.pinv(slopes, rcond=min(weak, 1.0))) * widths[:, None]
    values = box.values(place)
    return LeastSquares(
        variables=values,
        variables_error=moved * widths
        + moved_by @ counted.noise
        + 64.0 * EPSILON * (np.abs(values) + widths),
        residuals=at_end,
        chi_square=float(at_end @ at_end),
        slopes=slopes,
        slopes_error=error,
        widths=widths,
        moved_by=moved_by,
        active=np.where(place <= 0.0, -1.0, np.where(place >= 1.0, 1.0, 0.0)),
        searches=tuple(
            SearchEnd(
                box.values(start),
                box.values(start if end is None else end[0]),
                np.inf if end is None else end[1],
            )
            for start, end in zip(places, ends, strict=True)
        ),
        evaluations=counted.evaluations,
        failures=tuple(counted.failures),
    )


def _searched(counted: _Counted, start: FloatArray) -> tuple[FloatArray, float] | None:
    """Where a search ends, with its sum of squares; None where it does not end in a minimum."""
    from scipy.optimize import least_squares

    if not np.all(np.isfinite(counted(start))):
        return None
    try:
        with np.errstate(invalid="ignore"):
            found = least_squares(
                counted,
                start,
                jac=lambda place: _slopes(counted, place),
                bounds=(np.zeros(start.size), np.ones(start.size)),
                xtol=_SEARCH_TOLERANCE,
                ftol=_SEARCH_TOLERANCE,
                gtol=_TOLERANCE,
                max_nfev=_MOST_STEPS,
            )
    except (ValueError, np.linalg.LinAlgError):  # a slope next to a point without results
        return None
    if found.status <= 0:
        return None
    return np.asarray(found.x), float(2.0 * found.cost)


def _mended(
    counted: _Counted, place: FloatArray, cost: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Gauss-Newton steps within the bounds: the place, the last step (n,), slopes, their error.

    Variables that come next to a bound are put on it where that is no worse.
    """
    from scipy.optimize import lsq_linear

    moved = np.zeros(place.size)
    slopes, error = slopes_with_error(counted, place, counted.noise)
    for _ in range(_MENDINGS):
        here = counted(place)
        weak = _WEAK * max(float(np.linalg.norm(slopes)), 1e-300)
        table = np.vstack([slopes, weak * np.eye(place.size)])
        wanted = np.concatenate([-here, np.zeros(place.size)])
        step = lsq_linear(table, wanted, bounds=(-place - 1e-300, 1.0 - place + 1e-300)).x
        after = np.clip(place + step, 0.0, 1.0)
        for end in (0.0, 1.0):
            near = np.abs(after - end) <= _NEAR
            towards = np.where(near, end, after)
            if np.any(near) and _cost(counted, towards) <= cost * (1.0 + _TOLERANCE):
                after = towards
        there = _cost(counted, after)
        moved = np.abs(after - place)
        if not there <= cost * (1.0 + 1e-10) + 1e-300:
            break
        place, cost = after, min(cost, there)
        if np.max(moved) <= 1e-11:
            break
    if np.max(moved) > _NEAR or np.any((place <= 0.0) | (place >= 1.0)):
        slopes, error = slopes_with_error(counted, place, counted.noise)
    return place, moved, slopes, error


def _cost(counted: _Counted, place: FloatArray) -> float:
    found = counted(place)
    return float(found @ found) if np.all(np.isfinite(found)) else np.inf


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
