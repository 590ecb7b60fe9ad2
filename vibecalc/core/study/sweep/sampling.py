"""Samples: points spread over the unit cube; mean, quantiles and Sobol indices of results."""

import functools
import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Points spread over the unit cube, each computed from its number alone.
#
# No point needs those before it, so that workers can share a sampling of any size without a list of
# its points: whole-number arithmetic, and the published direction numbers of Sobol points.
# All take point numbers (len,) and return (len, dimensions) values in the open interval (0, 1).
# ----------------------------------------------------------------------------

_BITS = 30  # of a Sobol point; 2^30 points is the longest sequence
_ROUNDS = 8
_STREAM = 1 << 40  # more numbers than any sampling takes from one stream


def monte_carlo(points: np.ndarray, dimensions: int, size: int, seed: int) -> np.ndarray:
    """Independent uniform numbers; `size` does not matter."""
    return _centred(_random(points[:, None] * dimensions + np.arange(dimensions), seed, 0))


def latin_hypercube(points: np.ndarray, dimensions: int, size: int, seed: int) -> np.ndarray:
    """One point in each of `size` equal slices of every dimension (McKay et al. 1979)."""
    inside = _centred(
        _random(points[:, None] * dimensions + np.arange(dimensions), seed, 1), bits=22
    )
    columns = [_shuffled(points, size, seed, column) for column in range(dimensions)]
    # 22 random bits inside a slice leave room for slices: the sum stays below 1
    return np.asarray((np.stack(columns, axis=1) + inside) / size)


def sobol(points: np.ndarray, dimensions: int, size: int, seed: int) -> np.ndarray:
    """Sobol points (Joe and Kuo 2008), their digits shifted at random, which keeps the net."""
    directions = _directions(dimensions, max(size - 1, 1).bit_length())
    gray = points ^ (points >> 1)
    digits = np.zeros((points.size, dimensions), dtype=np.uint64)
    for bit, direction in enumerate(directions):
        digits ^= np.where((gray[:, None] >> bit) & 1, direction, np.uint64(0))
    shift = _random(np.arange(dimensions)[None, :], seed, 2) >> np.uint64(64 - _BITS)
    finer = _random(points[:, None] * dimensions + np.arange(dimensions), seed, 3)
    return _centred((digits ^ shift) << np.uint64(64 - _BITS) | finer >> np.uint64(_BITS))


SEQUENCES = {"monte_carlo": monte_carlo, "latin_hypercube": latin_hypercube, "sobol": sobol}


def resample(size: int, repetition: int, seed: int) -> np.ndarray:
    """Draw `size` of the numbers 0 to size - 1 with replacement, a fixed draw each time."""
    uniform = _centred(_random(np.arange(size), seed, 16 + repetition))
    return np.minimum((uniform * size).astype(np.int64), size - 1)


def _random(counter: np.ndarray, seed: int, stream: int) -> np.ndarray:
    """64 random bits for each counter (Steele, Lea and Flood 2014, SplitMix64)."""
    named = np.array([[seed], [stream]], dtype=np.uint64)  # scalars would warn of overflow
    start = _mix(named[0] * _GOLDEN + named[1] * _GOLDEN_TWO)
    return _mix(start + (counter.astype(np.uint64) + np.uint64(1)) * _GOLDEN)


_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_GOLDEN_TWO = np.uint64(0xD1B54A32D192ED03)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)


def _mix(word: np.ndarray) -> np.ndarray:
    word = (word ^ (word >> np.uint64(30))) * _FIRST
    word = (word ^ (word >> np.uint64(27))) * _SECOND
    return np.asarray(word ^ (word >> np.uint64(31)))


def _centred(word: np.ndarray, bits: int = 52) -> np.ndarray:
    """Middle of one of 2^bits equal cells of (0, 1), chosen by the leading bits of a word."""
    return np.asarray(((word >> np.uint64(64 - bits)).astype(float) + 0.5) * 2.0**-bits)


def _shuffled(points: np.ndarray, size: int, seed: int, column: int) -> np.ndarray:
    """Place of each point in a random order of 0 to size - 1.

    A Feistel network shuffles the next power of four; a place beyond `size` walks on to the next.
    """
    half = (max(size - 1, 1).bit_length() + 1) // 2
    mask = np.uint64((1 << half) - 1)
    place = points.astype(np.uint64)
    wandering = np.ones(place.shape, dtype=bool)
    while np.any(wandering):
        left, right = place[wandering] >> np.uint64(half), place[wandering] & mask
        for turn in range(_ROUNDS):
            word = _random(right, seed, _STREAM + column * _ROUNDS + turn)
            left, right = right, left ^ (word >> np.uint64(64 - half))
        place[wandering] = left << np.uint64(half) | right
        wandering = place >= np.uint64(size)
    return place.astype(np.int64)


@functools.lru_cache(maxsize=64)
def _directions(dimensions: int, bits: int) -> np.ndarray:
    """Direction numbers (bits, dimensions), read off the points 1, 2, 4, ... of the sequence."""
    from scipy.stats import qmc

    engine = qmc.Sobol(dimensions, scramble=False, bits=_BITS)
    found = np.zeros((bits, dimensions), dtype=np.uint64)
    passed, before = 0, np.zeros(dimensions, dtype=np.uint64)
    for bit in range(bits):
        engine.fast_forward((1 << bit) - passed)
        point = np.rint(engine.random(1)[0] * 2.0**_BITS).astype(np.uint64)
        passed = (1 << bit) + 1
        # in Gray code the number 2^bit has its own bit and the one below it
        before = point ^ before
        found[bit] = before
    found.setflags(write=False)
    return found


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


# ----------------------------------------------------------------------------
# Sobol indices: which share of a result's variance each axis of a sweep brings about.
# ----------------------------------------------------------------------------

FEWEST = 16  # sampled points; below, resampling says nothing
REPETITIONS = 200
_SEED = 2010


class Indices(NamedTuple):
    """Sobol indices (axes, ...) and the number of sampled points they rest on.

    `first` is what an axis brings about alone, `total` with all its interactions.
    """

    first: Statistic
    total: Statistic
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
    trailing = values.shape[1:]
    runs = values.reshape(-1, axes + 2, *trailing)
    wrong = np.broadcast_to(np.asarray(errors, dtype=float), values.shape).reshape(runs.shape)
    if usable is not None:
        whole = np.asarray(usable, dtype=bool).reshape(-1, axes + 2).all(axis=1)
        runs, wrong = runs[whole], wrong[whole]
    _check(runs)
    largest = np.max(wrong, axis=(0, 1))
    terms = _terms(runs)
    parts = _parts(*(term.mean(axis=0) for term in terms))
    if not np.all(parts.variance > largest**2):
        raise NumericalFailure(
            "no Sobol indices: the result does not vary beyond its own numerical error"
        )
    first_error, total_error = _errors(runs, terms, parts, largest)
    spread = _resampled(terms)
    return Indices(
        Statistic(parts.first, first_error, spread.first),
        Statistic(parts.total, total_error, spread.total),
        len(runs),
    )


class _Terms(NamedTuple):
    """What is averaged, for each sampled point; values count from their mean."""

    product: np.ndarray  # f(B) (f(AB) - f(A)), (n, axes, ...)
    step: np.ndarray  # f(AB) - f(A)
    half_square: np.ndarray  # (f(AB) - f(A))^2 / 2
    square: np.ndarray  # (f(A)^2 + f(B)^2) / 2, (n, ...)
    centre: np.ndarray  # (f(A) + f(B)) / 2


class _Parts(NamedTuple):
    first: np.ndarray
    total: np.ndarray
    variance: np.ndarray


def _terms(runs: np.ndarray) -> _Terms:
    centred = runs - np.mean(runs[:, :2], axis=(0, 1))
    a, b, mixed = centred[:, :1], centred[:, 1:2], centred[:, 2:]
    step = mixed - a
    square, centre = 0.5 * (a**2 + b**2)[:, 0], 0.5 * (a + b)[:, 0]
    return _Terms(b * step, step, 0.5 * step**2, square, centre)


def _parts(
    product: np.ndarray,
    step: np.ndarray,
    half_square: np.ndarray,
    square: np.ndarray,
    centre: np.ndarray,
) -> _Parts:
    """Indices from averaged terms; 0 where nothing varies."""
    variance = np.maximum(square - centre**2, 0.0)
    safe = np.where(variance > 0.0, variance, np.inf)
    return _Parts((product - centre * step) / safe, half_square / safe, variance)


def _resampled(terms: _Terms) -> _Parts:
    """Standard deviation of the indices over repeated draws of the sampled points."""
    size = len(terms.square)
    draws = [resample(size, repetition, _SEED) for repetition in range(REPETITIONS)]
    found = [_parts(*(term[draw].mean(axis=0) for term in terms)) for draw in draws]
    return _Parts(*(np.std(np.stack(part), axis=0, ddof=1) for part in zip(*found, strict=True)))


def _errors(
    runs: np.ndarray, terms: _Terms, parts: _Parts, largest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of what errors of the values, at most `largest`, and round-off do to the indices."""
    centred = np.abs(runs - np.mean(runs[:, :2], axis=(0, 1)))
    # a centred value is off by the error of the value and that of the mean
    off = 2.0 * largest + 4.0 * UNIT_ROUNDOFF * np.max(np.abs(runs), axis=(0, 1))
    size, steps = np.mean(centred[:, :2], axis=(0, 1)), np.mean(np.abs(terms.step), axis=0)
    counted = (len(runs) + 8) * UNIT_ROUNDOFF
    of_variance = off * (2.0 * size + off) + counted * parts.variance
    of_product = off * (np.mean(centred[:, 1], axis=0) + steps + off)
    of_product = of_product + counted * np.mean(np.abs(terms.product), axis=0)
    of_square = off * (steps + 0.5 * off) + counted * np.mean(terms.half_square, axis=0)
    return (
        (of_product + np.abs(parts.first) * of_variance) / parts.variance,
        (of_square + parts.total * of_variance) / parts.variance,
    )


def _check(runs: np.ndarray) -> None:
    if len(runs) < FEWEST:
        raise NumericalFailure(
            f"{len(runs)} sampled points are too few for Sobol indices, they take {FEWEST}"
        )
    if not np.all(np.isfinite(runs)):
        raise NumericalFailure("Sobol indices need finite values, and some runs have no bound")
