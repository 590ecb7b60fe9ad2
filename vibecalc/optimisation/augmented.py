"""Limits for searches that know none: an augmented Lagrangian around a direct search."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.optimisation.hooke_jeeves import Descent, Scalar
from vibecalc.optimisation.sampler import Values

FIRST_STEP = 0.125
FIRST_TOLERANCE = 1e-2
TOLERANCE = 1e-8
FIRST_WEIGHT = 1.0
LARGEST_WEIGHT = 1e4
MOST_ROUNDS = 60
#: violation, or slack of a margin that has a price, that counts as none
SETTLED = 1e-7

Inner = Callable[[Scalar, np.ndarray, float, float], Descent]


class Walk(NamedTuple):
    """Where one search stopped on the unit cube, in words why, and whether it had converged."""

    unit: np.ndarray
    reason: str
    converged: bool


def augmented(sampler: Values, start: np.ndarray, inner: Inner) -> Walk:
    """Search downhill from a start with a direct search, and keep all margins in the end.

    Parameters
    ----------
    sampler : Values
    start : (n,) array
        Point of the unit cube at which the sampler gives values.
    inner : callable
        The direct search, as `hooke_jeeves`.

    Notes
    -----
    A wall or an exact penalty would put a crease along each limit, on which a search along the
    axes stands still far from the optimum. Here the objective gains, for each margin, the smooth
    term w/2 max(0, p/w - margin)^2, whose price p is corrected after each round and becomes the
    multiplier. Steps shrink from round to round; the weight w grows only where the violation
    does not fall. R. M. Lewis and V. Torczon, SIAM J. Optim. 12 (2002), 1075-1089.
    """
    first = sampler(start)
    assert first is not None
    entries = sampler.entries
    price = np.zeros(first.size - entries)
    weight = FIRST_WEIGHT

    def merit(unit: np.ndarray) -> float:
        vector = sampler(unit)
        if vector is None:
            return np.inf
        short = np.maximum(0.0, price / weight - vector[entries:])
        return float(np.max(vector[:entries]) + 0.5 * weight * np.sum(short**2))

    if price.size == 0:
        found = inner(merit, start, FIRST_STEP, TOLERANCE)
        return Walk(found.point, _words(found.converged), found.converged)
    point, step, tolerance, before = start, FIRST_STEP, FIRST_TOLERANCE, np.inf
    for _ in range(MOST_ROUNDS):
        found = inner(merit, point, step, tolerance)
        point = found.point
        vector = sampler(point)
        assert vector is not None
        unsettled = float(np.max(np.abs(np.minimum(vector[entries:], price / weight))))
        if unsettled <= SETTLED and tolerance <= TOLERANCE:
            return Walk(point, _words(found.converged), found.converged)
        price = np.maximum(0.0, price - weight * vector[entries:])
        if unsettled > 0.25 * before and weight < LARGEST_WEIGHT:
            weight *= 4.0
        before = unsettled
        tolerance = max(TOLERANCE, 0.1 * tolerance)
        step = max(10.0 * tolerance, 0.2 * step)
    return Walk(point, "the limits did not settle", False)


def _words(converged: bool) -> str:
    return "converged" if converged else "stopped before its steps were small"
