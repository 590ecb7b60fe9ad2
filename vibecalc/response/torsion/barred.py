"""Barred ranges: the speeds at which a curve exceeds its limit."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, FloatArray


class BarredRanges(NamedTuple):
    """By rising speed (b,): ends in rad/s, and whether the curve crosses its limit there.

    An end where it does not cross is an end of the speeds that were asked for. `error` is absolute,
    of both ends, for a curve without error.
    """

    start: FloatArray
    end: FloatArray
    start_crosses: BoolArray
    end_crosses: BoolArray
    error: FloatArray


def barred_ranges(excess: Callable[[FloatArray], FloatArray], speed: ArrayLike) -> BarredRanges:
    """Ranges in which `excess`, curve minus limit at speeds (s,), is above zero.

    `speed` (s,) rising must be close enough that no range lies between two of them: put the
    resonances of the curve among them. Ends are brought to neighbouring numbers by bisection.
    Infinite excess (an undamped resonance) is inside a range.

    Raises
    ------
    NumericalFailure
        The excess is not a number somewhere.
    """
    speeds = np.asarray(speed, dtype=float)
    above = _above(excess, speeds)
    change = np.flatnonzero(above[1:] != above[:-1])
    low, high, rising = speeds[change], speeds[change + 1], above[change + 1]
    for _ in range(70):
        middle = 0.5 * (low + high)
        if np.all(high - low <= 2.0 * EPSILON * high):
            break
        upper = _above(excess, middle) == rising
        low, high = np.where(upper, low, middle), np.where(upper, middle, high)
    # the side inside the range counts, so that both ends are within it
    starts, ends = high[rising], low[~rising]
    start_crosses, end_crosses = np.ones(len(starts), bool), np.ones(len(ends), bool)
    if len(above) and above[0]:
        starts = np.concatenate([speeds[:1], starts])
        start_crosses = np.concatenate([[False], start_crosses])
    if len(above) and above[-1]:
        ends = np.concatenate([ends, speeds[-1:]])
        end_crosses = np.concatenate([end_crosses, [False]])
    return BarredRanges(starts, ends, start_crosses, end_crosses, 4.0 * EPSILON * ends)


def _above(excess: Callable[[FloatArray], FloatArray], speeds: FloatArray) -> BoolArray:
    values = excess(speeds) if len(speeds) else np.zeros(0)
    if np.any(np.isnan(values)):
        raise NumericalFailure("barred ranges: curve minus limit is not a number at some speed")
    return np.asarray(values > 0.0)
