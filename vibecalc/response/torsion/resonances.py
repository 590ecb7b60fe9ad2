"""Resonances of a damped line: the speeds at which a curve of peaks against speed is highest."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray

#: derivative by six values about the speed, exact for polynomials of degree 6
PLACES = np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])
WEIGHTS = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / 60.0
#: their distance over the width of the resonance: truncation and round-off about alike
DISTANCE = 0.02
#: change of a speed, relative, at which it counts as found
FOUND = 1e-11
#: times what the slope by values half as far apart says is missed
MISSED = 4.0
#: roundings, as shares of the width, by which a slope of these values shifts a place
SHIFT = 100.0
STEPS = 80


class Resonances(NamedTuple):
    """By section and rising speed (r,): speed in rad/s with its error, and the value there."""

    section: IntArray
    speed: FloatArray
    speed_error: FloatArray
    value: FloatArray


def resonances(curve: Callable[[FloatArray], FloatArray], speed: ArrayLike) -> Resonances:
    """Local maxima, inside the range, of `curve`: speeds (s,) -> values (s, sections).

    Each maximum of the values at the given speeds (rising, close enough to see every resonance) is
    refined: the slope of the curve, from six values about a speed, is brought to zero between the
    neighbours. A peak over the cycle is smooth where it is highest (a change of the angle at which
    it is reached makes a kink upwards, which is never a maximum). Sections without a resonance
    have no entry; neither have maxima at the ends of the range.

    Raises
    ------
    NumericalFailure
        A value is not finite (undamped resonance: mask it before), or the search does not end.
    """
    speeds = np.asarray(speed, dtype=float)
    values = curve(speeds)
    if not np.all(np.isfinite(values)):
        raise NumericalFailure("resonances: the curve is infinite at some speed (no damping there)")
    inner = values[1:-1]
    place, section = np.nonzero((inner > values[:-2]) & (inner >= values[2:]))
    keep = np.lexsort((place, section))
    place, section = place[keep] + 1, section[keep]
    if len(place) == 0:
        none = np.zeros(0)
        return Resonances(section, none, none, none)
    low, at, high = speeds[place - 1], speeds[place], speeds[place + 1]

    def value(where: FloatArray) -> FloatArray:
        """Curve of each one's own section at (r, k)."""
        found = curve(where.ravel()).reshape(*where.shape, -1)
        return np.asarray(np.take_along_axis(found, section[:, None, None], axis=2)[..., 0])

    at, error = refined(value, low, at, high)
    order = np.lexsort((at, section))
    return Resonances(section[order], at[order], error[order], value(at[:, None])[order, 0])


def refined(
    value: Callable[[FloatArray], FloatArray], low: FloatArray, at: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Maxima (r,) of curves between `low` and `high`, seen at `at`, and the error of each place.

    `value` takes places (r, k), those of each curve in its row. Raises NumericalFailure where the
    search does not end.
    """
    distance = DISTANCE * (high - low)
    for _ in range(3):
        # width of the resonance from its curvature
        about = value(at[:, None] + np.array([-1.0, 0.0, 1.0]) * distance[:, None])
        bend = np.abs(about[:, 0] - 2.0 * about[:, 1] + about[:, 2])
        bend = np.maximum(bend, 1e-10 * about[:, 1]) / distance**2
        distance = np.minimum(DISTANCE * np.sqrt(about[:, 1] / bend), (high - low) / 8.0)
        distance = np.minimum(distance, low / 4.0 + np.where(low > 0.0, 0.0, distance))
        low, at, high = _narrowed(value, low, at, high)
    at, moved = _zero_slope(value, low, high, distance)
    return at, np.minimum(moved + _missed(value, at, distance), high - low) + 8.0 * EPSILON * at


def _missed(
    value: Callable[[FloatArray], FloatArray], at: FloatArray, distance: FloatArray
) -> FloatArray:
    """What is between the zeros of a slope and of the one by values half as far apart.

    That has a 64th of the truncation; over the curvature it tells how far the slope is off.
    """
    seen = value(at[:, None] + np.append(0.5 * PLACES, [0.0, -1.0, 1.0]) * distance[:, None])
    slope = 2.0 * np.abs(seen[:, :6] @ WEIGHTS)
    bend = np.abs(seen[:, 7] - 2.0 * seen[:, 6] + seen[:, 8])
    width = distance / DISTANCE
    share = slope / np.maximum(bend, EPSILON * np.abs(seen[:, 6]))
    return np.asarray(MISSED * share * distance + SHIFT * EPSILON * width)


def _narrowed(
    value: Callable[[FloatArray], FloatArray], low: FloatArray, at: FloatArray, high: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bracket of each maximum, a quarter as wide."""
    share = np.arange(9) / 8.0
    where = low[:, None] + (high - low)[:, None] * share
    best = np.clip(np.argmax(value(where), axis=1), 1, 7)
    row = np.arange(len(at))
    return where[row, best - 1], where[row, best], where[row, best + 1]


def _zero_slope(
    value: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    distance: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Bracketed secant on the slope; the end that stays has its slope halved (Illinois)."""

    def slope(where: FloatArray) -> FloatArray:
        return np.asarray(value(where[:, None] + PLACES * distance[:, None]) @ WEIGHTS)

    low, high = low.copy(), high.copy()
    left, right = slope(low), slope(high)
    at, side = 0.5 * (low + high), np.zeros(len(low))
    for _ in range(STEPS):
        between = (left > 0.0) & (right < 0.0)
        gap = np.where(between, left - right, 1.0)
        target = np.where(between, low + (high - low) * left / gap, 0.5 * (low + high))
        moved, at = np.abs(target - at), target
        if np.all((moved <= FOUND * at) | (high - low <= FOUND * at)):
            return at, np.minimum(moved, high - low)
        here = slope(at)
        rises = here > 0.0
        low, high = np.where(rises, at, low), np.where(rises, high, at)
        right = np.where(rises, np.where(side > 0, 0.5 * right, right), here)
        left = np.where(rises, here, np.where(side < 0, 0.5 * left, left))
        side = np.where(rises, 1.0, -1.0)
    raise NumericalFailure("resonances: the slope of the curve did not come to zero")
