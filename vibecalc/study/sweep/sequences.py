"""Points spread over the unit cube, each computed from its number alone.

No point needs those before it, so that workers can share a sampling, and no platform or library
version changes it: whole-number arithmetic, and the published direction numbers of Sobol points.
All take point numbers (len,) and return (len, dimensions) values in the open interval (0, 1).
"""

import functools

import numpy as np

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
