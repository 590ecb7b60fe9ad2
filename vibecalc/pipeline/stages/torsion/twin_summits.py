"""The highest of summits that stand between two speeds of a sweep, where kinks part them.

A peak over the cycle is the highest of many curves, one for each angle. Where two of them cross
the curve has a kink, and two summits may stand side by side within one step of the sweep.
"""

from collections.abc import Callable

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.resonances import refined

#: value (r, k) of each one's own curve at speeds (r, k)
Value = Callable[[FloatArray], FloatArray]

#: relative height by which a refined maximum may miss the one that was seen
CORNER = 1e-11
#: relative distances at which a refined maximum is looked at, and steps (each a quarter) of a
#: search by values
BESIDE = np.array([1e-9, 3e-8, 1e-6, 3e-5])
CLIMBS = 12
#: parts of a step in which it is looked at, and how high, over the highest, a summit among these
#: places is that may still be the highest
PARTS, EQUAL = 16, 0.97


def highest(
    make: Callable[[IntArray], Value],
    section: IntArray,
    low: FloatArray,
    at: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Places (r,) in rad/s of the highest values between `low` and `high`, and their errors.

    `at` (r,) is a place that is higher than both ends. `make` gives the curves of sections. Of
    summits of the same height that at the lowest speed counts.
    """
    row, brackets = _twins(make(section), low, at, high)
    left, middle, right = (np.concatenate(pair) for pair in zip((low, at, high), brackets,
                                                               strict=True))  # fmt: skip
    owner = np.concatenate([np.arange(len(at)), row])
    own = section[owner]
    found, error = _climbed(make, own, *refined(make(own), left, middle, right), left, right)
    if not len(row):
        return found, error
    value = make(own)(found[:, None])[:, 0]
    best = np.arange(len(at))
    for place in range(len(at), len(found)):
        known = best[owner[place]]
        over = value[place] / value[known] - 1.0
        if over > CORNER or (over >= -CORNER and found[place] < found[known]):
            best[owner[place]] = place
    return found[best], error[best]


def _twins(
    value: Value, low: FloatArray, at: FloatArray, high: FloatArray
) -> tuple[IntArray, tuple[FloatArray, FloatArray, FloatArray]]:
    """Rows, and brackets (low, middle, high), of steps in which more than one summit shows."""
    where = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, PARTS + 1)
    seen = value(where)
    inside = seen[:, 1:-1]
    top = (inside > seen[:, :-2]) & (inside >= seen[:, 2:])
    top &= inside >= EQUAL * np.max(seen, axis=1, keepdims=True)
    top &= np.sum(top, axis=1, keepdims=True) > 1
    row, place = np.nonzero(top)
    return row, (where[row, place], where[row, place + 1], where[row, place + 2])


def _climbed(
    make: Callable[[IntArray], Value],
    section: IntArray,
    at: FloatArray,
    error: FloatArray,
    low: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Places (r,) of maxima, and errors, where a kink of the curve lies beside a slope of zero.

    The slope is one of values about a place; where the greatest angle changes among them it is
    that of neither side, and a place a little further on is higher.
    """
    offset = at[:, None] * np.array([0.0, *-BESIDE, *BESIDE])
    seen = make(section)(np.clip(at[:, None] + offset, low[:, None], high[:, None]))
    higher = seen[:, 1:] > seen[:, :1] * (1.0 + CORNER)
    off = np.flatnonzero(np.any(higher, axis=1))
    if not len(off):
        return at, error
    reach = 100.0 * np.max(np.where(higher, np.tile(BESIDE, 2), 0.0), axis=1)[off] * at[off]
    own, row = make(section[off]), np.arange(len(off))
    left, right = np.maximum(at[off] - reach, low[off]), np.minimum(at[off] + reach, high[off])
    for _ in range(CLIMBS):
        where = left[:, None] + (right - left)[:, None] * np.linspace(0.0, 1.0, 9)
        best = np.clip(np.argmax(own(where), axis=1), 1, 7)
        left, middle, right = where[row, best - 1], where[row, best], where[row, best + 1]
    at, error = at.copy(), error.copy()
    at[off], error[off] = middle, right - left + 1e-8 * middle
    return at, error
