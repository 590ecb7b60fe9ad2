"""Mean and quantiles of sampled results, with how much another sampling would differ.

Values are (n, ...): samples along the first axis, any axes of a result after it. `errors` (n, ...)
are the absolute numerical errors of the values. Every statistic carries two uncertainties in its
own unit: `error` bounds what numerical errors and round-off do to it, `standard_error` is one
standard deviation of what the choice of samples does. The latter takes samples as independent;
for Sobol points and Latin hypercubes, which spread better, it is too large rather than too small.
"""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)


class Statistic(NamedTuple):
    """A statistic with its numerical error and its standard error; three arrays of one shape."""

    value: np.ndarray
    error: np.ndarray
    standard_error: np.ndarray


def mean(values: np.ndarray, errors: np.ndarray | float = 0.0) -> Statistic:
    """Mean over the samples, shape (...); NumericalFailure for one sample, or infinite ones."""
    values, errors = _samples(values, errors, fewest=2)
    count = len(values)
    centre, round_off = _mean(values)
    variance = np.sum((values - centre) ** 2, axis=0) / (count - 1)
    return Statistic(centre, np.mean(errors, axis=0) + round_off, np.sqrt(variance / count))


def deviation(values: np.ndarray, errors: np.ndarray | float = 0.0) -> Statistic:
    """Standard deviation of one sample, shape (...); raises as `mean` does, from three samples.

    Its standard error comes from the fourth moment, so that values need not be normal.
    """
    values, errors = _samples(values, errors, fewest=3)
    count = len(values)
    centre, centre_error = _mean(values)
    apart = values - centre
    variance = np.sum(apart**2, axis=0) / (count - 1)
    spread = np.sqrt(variance)
    # the deviation is a norm of the values: it moves by no more than the norm of their errors
    moved = np.sqrt(np.sum((errors + centre_error) ** 2, axis=0) / (count - 1))
    error = moved + (count + 8) * UNIT_ROUNDOFF * spread
    fourth = np.mean(apart**4, axis=0)
    of_variance = np.sqrt(np.maximum(fourth - variance**2 * (count - 3) / (count - 1), 0.0) / count)
    of_spread = np.divide(of_variance, 2.0 * spread, out=np.zeros_like(spread), where=spread > 0.0)
    return Statistic(spread, error, of_spread)


def quantiles(
    values: np.ndarray, levels: tuple[float, ...] = LEVELS, errors: np.ndarray | float = 0.0
) -> Statistic:
    """Quantiles, shape (levels, ...), median-unbiased whatever the distribution.

    They lie between order statistics as type 8 of Hyndman and Fan 1996. The standard error is
    half the distance of the order statistics one standard deviation of the rank to both sides,
    which holds for any distribution too. NumericalFailure where those lie outside the sample:
    there are too few samples for that level (see `fewest_samples`).
    """
    values, errors = _samples(values, errors, fewest=max(map(fewest_samples, levels)))
    count = len(values)
    ordered = np.sort(values, axis=0)
    value = np.stack([_ranked(ordered, _rank(level, count)) for level in levels])
    # no order statistic moves by more than the largest error of a sample
    moved = np.max(errors, axis=0) + 4.0 * UNIT_ROUNDOFF * np.max(np.abs(values), axis=0)
    halves = []
    for level in levels:
        rank, width = _rank(level, count), math.sqrt(count * level * (1.0 - level))
        low, high = max(rank - width, 0.0), min(rank + width, count - 1.0)
        halves.append(0.5 * (_ranked(ordered, high) - _ranked(ordered, low)))
    return Statistic(value, np.broadcast_to(moved, value.shape), np.stack(halves))


def fewest_samples(level: float) -> int:
    """Samples from which on a quantile has a standard error: 3 for 0.5, 41 for 0.05."""
    rarer = min(level, 1.0 - level)
    if not 0.0 < rarer < 1.0:
        raise ValueError(f"a quantile belongs to a level between 0 and 1, not {level}")
    # the rank of the quantile is at least its standard deviation sqrt(n p (1 - p))
    count = 2
    while _rank(rarer, count) < math.sqrt(count * rarer * (1.0 - rarer)):
        count += 1
    return count


def _rank(level: float, count: int) -> float:
    """Where a quantile lies among `count` ordered samples, counted from 0."""
    return level * (count + 1.0 / 3.0) - 2.0 / 3.0


def _ranked(ordered: np.ndarray, rank: float) -> np.ndarray:
    below = min(int(rank), len(ordered) - 2)
    share = rank - below
    return np.asarray((1.0 - share) * ordered[below] + share * ordered[below + 1])


def _mean(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean in two passes, so that round-off grows with the scatter and not with the size."""
    rough = np.mean(values, axis=0)
    apart = values - rough
    centre = rough + np.mean(apart, axis=0)
    grown = (len(values) + 2) * UNIT_ROUNDOFF * np.mean(np.abs(apart), axis=0)
    largest = np.max(np.abs(values), axis=0)
    return centre, grown + 2.0 * UNIT_ROUNDOFF * (np.abs(centre) + UNIT_ROUNDOFF * largest)


def _samples(
    values: np.ndarray, errors: np.ndarray | float, fewest: int
) -> tuple[np.ndarray, np.ndarray]:
    values = np.asarray(values, dtype=float)
    errors = np.broadcast_to(np.asarray(errors, dtype=float), values.shape)
    if len(values) < fewest:
        raise NumericalFailure(
            f"{len(values)} samples are too few for this statistic, it takes {fewest}"
        )
    if not (np.all(np.isfinite(values)) and np.all(np.isfinite(errors))):
        raise NumericalFailure(
            "a statistic needs finite values, and some samples are infinite: "
            "a peak has no bound there"
        )
    return values, errors
