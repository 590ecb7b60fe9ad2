"""Samples: points spread over the unit cube; mean, quantiles and Sobol indices of results."""

import functools
import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Points spread over the unit cube, by numpy and scipy.
#
# Workers share a sampling without a list of its points: each draws the blocks that its points are
# in, a Latin hypercube as a whole. What was drawn stands in the file of the sweep; another version
# of the libraries may draw otherwise, so `drawn_by` belongs to what a sweep is.
# Blocks are (points, dimensions) in the open interval (0, 1).
# ----------------------------------------------------------------------------

_BLOCK = 1 << 16
#: half of the finest step of a Sobol point, and of a double below one
_HALF, _FINEST = 2.0**-31, 2.0**-54
#: longest sampling of each kind
MOST_POINTS = {"monte_carlo": 1 << 30, "latin_hypercube": 10_000_000, "sobol": 1 << 30}


def drawn(sampling: str, points: np.ndarray, dimensions: int, size: int, seed: int) -> np.ndarray:
    """Points (len, dimensions) in (0, 1) of a sampling of `size` points, by their numbers (len,).

    `sampling` is "monte_carlo" (independent uniform numbers), "latin_hypercube" (one point in
    each of `size` equal slices of every dimension, McKay et al. 1979) or "sobol" (Sobol points of
    Joe and Kuo 2008, scrambled at random, which keeps the net).
    """
    length = size if sampling == "latin_hypercube" else min(_BLOCK, 1 << (size - 1).bit_length())
    found = np.empty((points.size, dimensions))
    blocks = points // length
    for block in np.unique(blocks).tolist():
        mine = blocks == block
        found[mine] = _block(sampling, dimensions, length, seed, block)[points[mine] % length]
    return np.clip(found, _FINEST, 1.0 - 2.0 * _FINEST)


@functools.lru_cache(maxsize=4)
def _block(sampling: str, dimensions: int, length: int, seed: int, block: int) -> np.ndarray:
    if sampling == "monte_carlo":
        return np.random.default_rng([seed, block]).random((length, dimensions))
    from scipy.stats import qmc

    if sampling == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, rng=seed).random(length))
    engine = qmc.Sobol(dimensions, rng=seed)
    if block:  # scipy refuses to go on by nothing
        engine.fast_forward(block * length)
    return np.asarray(engine.random(length) + _HALF)


def drawn_by() -> str:
    """The libraries that draw samples, with their versions."""
    import scipy

    return f"numpy {np.__version__}, scipy {scipy.__version__}"


# ----------------------------------------------------------------------------
# Mean and quantiles of sampled results, with how much another sampling would differ.
#
# Values are (n, ...): samples along the first axis, any axes of a result after it. `errors` (n,
# ...) are the absolute numerical errors of the values. Every statistic carries two uncertainties in
# its own unit: `error` bounds what numerical errors and round-off do to it, `standard_error` is one
# standard deviation of what the choice of samples does. The latter takes samples as independent;
# for Sobol points and Latin hypercubes, which spread better, it is too large rather than too small.
# ----------------------------------------------------------------------------

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
    value = np.quantile(values, levels, axis=0, method="median_unbiased")
    # no order statistic moves by more than the largest error of a sample
    moved = np.max(errors, axis=0) + 4.0 * UNIT_ROUNDOFF * np.max(np.abs(values), axis=0)
    halves = []
    for level in levels:
        rank, width = _rank(level, count), math.sqrt(count * level * (1.0 - level))
        around = np.clip([rank - width, rank + width], 0.0, count - 1.0) / (count - 1.0)
        halves.append(0.5 * np.diff(np.quantile(values, around, axis=0), axis=0)[0])
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


# ----------------------------------------------------------------------------
# Sobol indices: which share of a result's variance each axis of a sweep brings about.
# ----------------------------------------------------------------------------

FEWEST = 16  # sampled points; below, resampling says nothing
REPETITIONS = 200
_SEED = 2010


class Indices(NamedTuple):
    """Sobol indices (axes, ...) with their standard errors, from so many sampled points.

    `first` is what an axis brings about alone, `total` with all its interactions.
    """

    first: np.ndarray
    first_spread: np.ndarray
    total: np.ndarray
    total_spread: np.ndarray
    samples: int


def sobol_indices(
    values: np.ndarray,
    axes: int,
    errors: np.ndarray | float = 0.0,
    usable: np.ndarray | None = None,
) -> Indices:
    """First-order and total Sobol indices of a result (n (axes + 2), ...) in the order of a design.

    First-order after Saltelli et al. 2010, Computer Physics Communications 181, table 2 (b), total
    after Jansen 1999 (f). `errors` are absolute, as the values; a sampled point of which a run is
    not `usable` (n (axes + 2),) is left out with all its runs. Standard errors are from resampling
    the points with a fixed draw, and like those of `mean` too large for Sobol points. An estimate
    may lie a little outside 0 to 1. NumericalFailure for fewer than 16 points, for values that are
    not finite, and for a result that does not vary beyond its own numerical error.
    """
    values = np.asarray(values, dtype=float)
    runs = values.reshape(-1, axes + 2, *values.shape[1:])
    wrong = np.broadcast_to(np.asarray(errors, dtype=float), values.shape).reshape(runs.shape)
    if usable is not None:
        whole = np.asarray(usable, dtype=bool).reshape(-1, axes + 2).all(axis=1)
        runs, wrong = runs[whole], wrong[whole]
    size = len(runs)
    if size < FEWEST:
        raise NumericalFailure(
            f"{size} sampled points are too few for Sobol indices, they take {FEWEST}"
        )
    if not np.all(np.isfinite(runs)):
        raise NumericalFailure("Sobol indices need finite values, and some runs have no bound")
    centred = runs - np.mean(runs[:, :2], axis=(0, 1))
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    step = mixed - a
    terms = b * step, step, 0.5 * step**2, 0.5 * (a**2 + b**2), 0.5 * (a + b)

    def indices(draw: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """First-order and total indices of some of the points, 0 where nothing varies."""
        product, moved, half_square, square, centre = (term[draw].mean(axis=0) for term in terms)
        variance = np.maximum(square - centre**2, 0.0)
        safe = np.where(variance > 0.0, variance, np.inf)
        return (product - centre * moved) / safe, half_square / safe, variance[0]

    first, total, variance = indices(np.arange(size))
    if not np.all(variance > np.max(wrong, axis=(0, 1)) ** 2):
        raise NumericalFailure(
            "no Sobol indices: the result does not vary beyond its own numerical error"
        )
    draws = np.random.default_rng(_SEED).integers(size, size=(REPETITIONS, size))
    found = [indices(draw)[:2] for draw in draws]
    spread = [np.std(np.stack(part), axis=0, ddof=1) for part in zip(*found, strict=True)]
    return Indices(first, spread[0], total, spread[1], size)
