"""Speeds that matter on a curve: critical speeds, peaks between samples, barred ranges."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray, IntArray, distinct

# ----------------------------------------------------------------------------
# Critical speeds: where an order of excitation meets a natural frequency.
# ----------------------------------------------------------------------------


class CriticalSpeeds(NamedTuple):
    """By rising speed (c,) in rad/s; `mode` is the place of its frequency, `error` absolute."""

    speed: FloatArray
    order: FloatArray
    mode: IntArray
    error: FloatArray


def critical_speeds(
    natural_frequency: ArrayLike,
    order: ArrayLike,
    lowest: float,
    highest: float,
    frequency_error: ArrayLike = 0.0,
) -> CriticalSpeeds:
    """Every speed from `lowest` to `highest` with order times speed a natural frequency (m,).

    Rigid modes (frequency 0) and order 0 have none. `frequency_error` (m,) is absolute.
    """
    natural, orders = np.asarray(natural_frequency, dtype=float), np.asarray(order, dtype=float)
    mode, place = np.meshgrid(np.arange(len(natural)), np.arange(len(orders)), indexing="ij")
    met = (natural[mode] > 0.0) & (orders[place] > 0.0)
    mode, place = mode[met], place[met]
    speed = natural[mode] / orders[place]
    uncertainty = np.broadcast_to(frequency_error, natural.shape)[mode] / orders[place]
    inside = (speed >= lowest) & (speed <= highest)
    mode, place, speed, uncertainty = (
        mode[inside],
        place[inside],
        speed[inside],
        uncertainty[inside],
    )
    first = np.lexsort((orders[place], speed))
    error = uncertainty + EPSILON * speed
    return CriticalSpeeds(speed[first], orders[place][first], mode[first], error[first])


# ----------------------------------------------------------------------------
# Resonances of a damped line: the speeds at which a curve of peaks against speed is highest.
# ----------------------------------------------------------------------------

#: derivative by six values about the speed, exact for polynomials of degree 6
PLACES = np.array([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0])
WEIGHTS = np.array([-1.0, 9.0, -45.0, 45.0, -9.0, 1.0]) / 60.0
#: their distance over the width of the resonance: truncation and round-off about alike
DISTANCE = 0.02
#: change of a speed, relative, at which it counts as found
CONVERGED = 1e-11
#: times what the slope by values half as far apart says is missed
MISSED = 4.0
#: roundings, as shares of the width, by which a slope of these values shifts a place
SHIFT = 100.0
#: parts of a bracket at which it is examined
NARROWING = np.arange(9) / 8.0
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
        near = at[:, None] + np.array([-1.0, 0.0, 1.0]) * distance[:, None]
        where = low[:, None] + (high - low)[:, None] * NARROWING
        about, narrowed_values = np.split(value(np.concatenate([near, where], axis=1)), [3], axis=1)
        bend = np.abs(about[:, 0] - 2.0 * about[:, 1] + about[:, 2])
        bend = np.maximum(bend, 1e-10 * about[:, 1]) / distance**2
        distance = np.minimum(DISTANCE * np.sqrt(about[:, 1] / bend), (high - low) / 8.0)
        distance = np.minimum(distance, low / 4.0 + np.where(low > 0.0, 0.0, distance))
        # a quarter of what was between them
        best, row = (
            np.clip(np.argmax(narrowed_values, axis=1), 1, len(NARROWING) - 2),
            np.arange(len(at)),
        )
        low, at, high = where[row, best - 1], where[row, best], where[row, best + 1]
    at, moved = _zero_slope(value, low, high, distance)
    return at, np.minimum(moved + _missed(value, at, distance), high - low) + 8.0 * EPSILON * at


def _missed(
    value: Callable[[FloatArray], FloatArray], at: FloatArray, distance: FloatArray
) -> FloatArray:
    """What is between the zeros of a slope and of the one by values half as far apart.

    That has a 64th of the truncation; over the curvature it tells how far the slope is off.
    """
    around = value(at[:, None] + np.append(0.5 * PLACES, [0.0, -1.0, 1.0]) * distance[:, None])
    slope = 2.0 * np.abs(around[:, :6] @ WEIGHTS)
    bend = np.abs(around[:, 7] - 2.0 * around[:, 6] + around[:, 8])
    width = distance / DISTANCE
    share = slope / np.maximum(bend, EPSILON * np.abs(around[:, 6]))
    return np.asarray(MISSED * share * distance + SHIFT * EPSILON * width)


def _zero_slope(
    value: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    distance: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Bracketed secant on the slope; the end that stays has its slope halved (Illinois)."""

    def slope(where: FloatArray) -> FloatArray:
        return np.asarray(value(where[:, None] + steps) @ WEIGHTS)

    steps = PLACES * distance[:, None]
    low, high = low.copy(), high.copy()
    ends = value(np.concatenate([low[:, None] + steps, high[:, None] + steps], axis=1))
    left, right = ends[:, : len(PLACES)] @ WEIGHTS, ends[:, len(PLACES) :] @ WEIGHTS
    at, side = 0.5 * (low + high), np.zeros(len(low))
    for _ in range(STEPS):
        between = (left > 0.0) & (right < 0.0)
        gap = np.where(between, left - right, 1.0)
        target = np.where(between, low + (high - low) * left / gap, 0.5 * (low + high))
        moved, at = np.abs(target - at), target
        if np.all((moved <= CONVERGED * at) | (high - low <= CONVERGED * at)):
            return at, np.minimum(moved, high - low)
        here = slope(at)
        rises = here > 0.0
        low, high = np.where(rises, at, low), np.where(rises, high, at)
        right = np.where(rises, np.where(side > 0, 0.5 * right, right), here)
        left = np.where(rises, here, np.where(side < 0, 0.5 * left, left))
        side = np.where(rises, 1.0, -1.0)
    raise NumericalFailure("resonances: the slope of the curve did not come to zero")


# ----------------------------------------------------------------------------
# The highest of peaks that stand between two speeds of a sweep, where kinks part them.
#
# A peak over the cycle is the highest of many curves, one for each angle. Where two of them cross
# the curve has a kink, and two peaks may stand side by side within one step of the sweep.
# ----------------------------------------------------------------------------

#: value (r, k) of each one's own curve at speeds (r, k)
Value = Callable[[FloatArray], FloatArray]

#: relative height by which a refined maximum may miss the one that was seen
CORNER = 1e-11
#: relative distances at which a refined maximum is examined, and steps (each a quarter) of a
#: search by values
NEARBY = np.array([1e-9, 3e-8, 1e-6, 3e-5])
CLIMBS = 12
#: parts of a step in which it is examined, and how high, over the highest, a peak among these
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
    peaks of the same height that at the lowest speed counts.
    """
    row, brackets = _twins(make(section), low, at, high)
    left, middle, right = (np.concatenate(pair) for pair in zip((low, at, high), brackets,
                                                               strict=True))  # fmt: skip
    owner = np.concatenate([np.arange(len(at)), row])
    owners = section[owner]
    top, error = _climbed(make, owners, *refined(make(owners), left, middle, right), left, right)
    if not len(row):
        return top, error
    value = make(owners)(top[:, None])[:, 0]
    best = np.arange(len(at))
    for place in range(len(at), len(top)):
        known = best[owner[place]]
        over = value[place] / value[known] - 1.0
        if over > CORNER or (over >= -CORNER and top[place] < top[known]):
            best[owner[place]] = place
    return top[best], error[best]


def _twins(
    value: Value, low: FloatArray, at: FloatArray, high: FloatArray
) -> tuple[IntArray, tuple[FloatArray, FloatArray, FloatArray]]:
    """Rows, and brackets (low, middle, high), of steps in which more than one peak shows."""
    where = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, PARTS + 1)
    values = value(where)
    inside = values[:, 1:-1]
    top = (inside > values[:, :-2]) & (inside >= values[:, 2:])
    top &= inside >= EQUAL * np.max(values, axis=1, keepdims=True)
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
    """Places (r,) of maxima, and errors, where a kink of the curve lies next to a slope of zero.

    The slope is one of values about a place; where the greatest angle changes among them it is
    that of neither side, and a place a little further on is higher.
    """
    offset = at[:, None] * np.array([0.0, *-NEARBY, *NEARBY])
    nearby = make(section)(np.clip(at[:, None] + offset, low[:, None], high[:, None]))
    higher = nearby[:, 1:] > nearby[:, :1] * (1.0 + CORNER)
    off = np.flatnonzero(np.any(higher, axis=1))
    if not len(off):
        return at, error
    reach = 100.0 * np.max(np.where(higher, np.tile(NEARBY, 2), 0.0), axis=1)[off] * at[off]
    value_of, row = make(section[off]), np.arange(len(off))
    left, right = np.maximum(at[off] - reach, low[off]), np.minimum(at[off] + reach, high[off])
    for _ in range(CLIMBS):
        where = left[:, None] + (right - left)[:, None] * np.linspace(0.0, 1.0, 9)
        best = np.clip(np.argmax(value_of(where), axis=1), 1, 7)
        left, middle, right = where[row, best - 1], where[row, best], where[row, best + 1]
    at, error = at.copy(), error.copy()
    at[off], error[off] = middle, right - left + 1e-8 * middle
    return at, error


# ----------------------------------------------------------------------------
# The largest values of many curves over a range of speeds, found between the speeds of a sweep.
# ----------------------------------------------------------------------------

#: maxima of one curve that are reported
MOST = 12

#: curves whose largest value is searched between the speeds of the sweep, highest first
REFINED = 32

#: part of the largest value among the speeds that a maximum there has at least, to be examined
#: closer (and `EQUAL` of it then, to be refined as well); how many of a curve
RIVAL, FEW = 0.7, 4
#: places between a side and the middle where a maximum is examined
QUARTERS = np.array([0.0, 0.25, 0.5, 0.75])

#: parts of the first and last step at which a curve that is highest at an end is examined
INWARDS = np.array([0.0, 1e-6, 1e-4, 1e-3, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0])


class Maxima(NamedTuple):
    """By section (r,): speed in rad/s with its error, and value; infinite where undamped."""

    section: IntArray
    speed: FloatArray
    speed_error: FloatArray
    value: FloatArray


def maxima(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    place: IntArray,
    undamped: FloatArray,
) -> Maxima:
    """Refine the values of `curve` (s, e) at (place, section) of the speeds (s,) in rad/s.

    What is no maximum, as at an end of the range, stays; so does what stands next to one of the
    speeds `undamped` (u,), towards which a curve grows without end.
    """
    values = curve[place, section]
    at, error = speed[place].copy(), np.zeros(len(place))
    inner = (place > 0) & (place < len(speed) - 1) & np.isfinite(values) & (values > 0.0)
    sides = np.clip(place[:, None] + np.array([-1, 1]), 0, len(speed) - 1)
    inner &= np.all(np.isfinite(curve[sides, section[:, None]]), axis=1)
    inner &= np.all(curve[sides, section[:, None]] <= values[:, None], axis=1)
    # where a limit begins to say something, a use drops to nothing
    inner &= np.all(curve[sides, section[:, None]] > 0.0, axis=1)
    between = (undamped >= speed[sides[:, :1]]) & (undamped <= speed[sides[:, 1:]])
    inner &= ~np.any(between, axis=1)
    if np.any(inner):
        value_of = make(section[inner])
        low, high = speed[place[inner] - 1], speed[place[inner] + 1]
        at[inner], error[inner] = highest(make, section[inner], low, at[inner], high)
        there, sampled = value_of(at[inner][:, None])[:, 0], values[inner]
        # next to a corner the slope says nothing: what was seen stays
        corner = there < sampled * (1.0 - CORNER)
        known = speed[place[inner]]
        error[inner] = np.where(corner, np.abs(at[inner] - known), error[inner])
        at[inner] = np.where(corner, known, at[inner])
        values[inner] = np.maximum(there, sampled)
    return Maxima(section, at, error, values)


def largest(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    undamped: FloatArray,
    endless: FloatArray,
) -> Maxima:
    """The largest of each section's curve (s, e), (e,); past `REFINED` of them that of the sweep.

    Every maximum among the speeds that may be the highest is refined. `endless` (e,) is the speed
    in the range at which a section's curve has no end, NaN for none.
    """
    place = np.argmax(curve, axis=0)
    value = curve[place, np.arange(curve.shape[1])]
    at, uncertainty = speed[place].copy(), np.zeros(len(place))
    section = np.sort(np.argsort(-value, kind="stable")[:REFINED])
    rivals, owner = _rivals(make, curve, speed, section, value)
    near = maxima(
        make,
        curve,
        speed,
        np.concatenate([section, owner]),
        np.concatenate([place[section], rivals]),
        undamped,
    )
    ends = _nearby_ends(make, curve, speed, section, value, undamped)
    near = Maxima(*(np.concatenate(part) for part in zip(near, ends, strict=True)))
    # what comes first is kept where two are alike
    for k in np.lexsort((np.arange(len(near.value)), -near.value))[::-1].tolist():
        of_section = near.section[k]
        if near.value[k] >= value[of_section]:
            at[of_section], uncertainty[of_section], value[of_section] = (
                near.speed[k],
                near.speed_error[k],
                near.value[k],
            )
    highest_of = Maxima(np.arange(len(place)), at, uncertainty, value)
    no_end = ~np.isnan(endless)
    at, value = (
        np.where(no_end, endless, highest_of.speed),
        np.where(no_end, np.inf, highest_of.value),
    )
    return Maxima(
        highest_of.section, at, np.where(no_end, 1e-10 * at, highest_of.speed_error), value
    )


def _rivals(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    best: FloatArray,
) -> tuple[IntArray, IntArray]:
    """Places and sections (r,) of maxima but the highest that may be the highest between speeds."""
    curves = curve[:, section]
    inside = curves[1:-1]
    high = (inside > curves[:-2]) & (inside >= curves[2:]) & np.isfinite(curves[:-2] + curves[2:])
    high &= (inside >= RIVAL * best[section]) & (inside < best[section]) & (inside > 0.0)
    place, column = np.nonzero(high)
    place, owner = place + 1, section[column]
    if not len(place):
        return place, owner
    top = narrowed(make(owner), speed[place - 1], speed[place], speed[place + 1])
    # of each section no more than the first few
    ascending = np.lexsort((-top, owner))
    rank = np.arange(len(ascending)) - np.searchsorted(owner[ascending], owner[ascending])
    chosen = ascending[(top[ascending] >= EQUAL * best[owner[ascending]]) & (rank < FEW)]
    return place[chosen], owner[chosen]


def _nearby_ends(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    best: FloatArray,
    undamped: FloatArray,
) -> Maxima:
    """Maxima (r,) inside the first and the last step, where a curve falls towards its high end."""
    parts = []
    for end, nearby in ((0, 1), (-1, -2)) if len(speed) > 1 else ():
        top, inner = curve[end, section], curve[nearby, section]
        high = np.isfinite(top) & (top > 0.0) & (top >= RIVAL * best[section])
        rows = section[high & np.isfinite(inner) & (inner > 0.0) & (inner < top)]
        low, far = sorted((speed[end], speed[nearby]))
        if np.any((undamped >= low) & (undamped <= far)):
            continue
        where = speed[end] + (speed[nearby] - speed[end]) * np.tile(INWARDS[:2], (len(rows), 1))
        if not len(rows):
            continue
        inwards = make(rows)(where)
        rows = rows[inwards[:, 1] > inwards[:, 0]]
        if not len(rows):
            continue
        where = speed[end] + (speed[nearby] - speed[end]) * np.tile(INWARDS, (len(rows), 1))
        row, made = np.arange(len(rows)), make(rows)
        place = np.clip(np.argmax(made(where), axis=1), 1, len(INWARDS) - 2)
        sides = np.sort(np.stack([where[row, place - 1], where[row, place + 1]]), axis=0)
        at, error = refined(made, sides[0], where[row, place], sides[1])
        at = np.clip(at, *sides)
        parts.append(Maxima(rows, at, error, made(at[:, None])[:, 0]))
    if not parts:
        return Maxima(np.zeros(0, dtype=np.int64), *np.zeros((3, 0)))
    return Maxima(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def narrowed(value: Value, low: FloatArray, at: FloatArray, high: FloatArray) -> FloatArray:
    """Heights (r,) of maxima between `low` and `high`, to about a hundredth from below."""
    best, row = np.zeros(len(at)), np.arange(len(at))
    for _ in range(2):
        # both sides of the middle are divided alike, for a side may be far away
        where = np.concatenate(
            [low[:, None] + (at - low)[:, None] * QUARTERS, at[:, None],
             high[:, None] + (at - high)[:, None] * QUARTERS[::-1]], axis=1,
        )  # fmt: skip
        found = value(where)
        top = np.clip(np.argmax(found, axis=1), 1, where.shape[1] - 2)
        best = np.maximum(best, found.max(axis=1))
        low, at, high = where[row, top - 1], where[row, top], where[row, top + 1]
    return best


def peaks(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    section: int,
    undamped: FloatArray,
) -> Maxima:
    """The highest maxima of one section inside the range, by rising speed, without endless ones."""
    curves = curve[:, section]
    inside = curves[1:-1]
    place = np.flatnonzero((inside > curves[:-2]) & (inside >= curves[2:])) + 1
    near = (undamped >= speed[place - 1, None]) & (undamped <= speed[place + 1, None])
    place = place[~np.any(near, axis=1)]
    place = np.sort(place[np.argsort(-curves[place], kind="stable")][:MOST])
    return maxima(make, curve, speed, np.full(len(place), section), place, undamped)


def highest_maxima(curve: FloatArray, count: int) -> float:
    """Height (of a curve (s,)) of that many of its maxima; 0 where it has fewer."""
    inside = curve[1:-1]
    high = inside[(inside > curve[:-2]) & (inside >= curve[2:]) & np.isfinite(inside)]
    return float(np.sort(high)[-count]) if len(high) >= count else 0.0


def telling_speeds(speed: FloatArray, curve: FloatArray, undamped: FloatArray) -> FloatArray:
    """Speeds (r,), of those (s,) of a curve (s, e), at which its errors are largest.

    Those of the largest finite values, and of each of the speeds `undamped` (u,), at which the line
    has no bound, the nearest on both sides.
    """
    clear = np.all(np.isfinite(curve), axis=1)
    nearby = speed[clear]
    if not len(nearby):
        return nearby
    parts = [nearby[np.argmax(curve[clear], axis=0)]]
    if len(undamped):
        place = np.searchsorted(nearby, undamped)[:, None] + np.array([-1, 0])
        parts.append(nearby[np.clip(place, 0, len(nearby) - 1)].ravel())
    return distinct(np.concatenate(parts))


# ----------------------------------------------------------------------------
# Speeds between those of a sweep at which a resonance too narrow for its steps may stand.
# ----------------------------------------------------------------------------

#: steps of the sweep that half a resonance is wide when its points show it
SHOWN = 1.5
#: places about a resonance, in half its width
NEARBY_NARROW_RESONANCE = np.array([-3.0, -1.0, 0.0, 1.0, 3.0])
#: what orders near by may add to the height of a resonance
MARGIN = 2.0
#: part of a curve below which a resonance on it is nothing
FAINT = 1e-9


class NarrowResonances(NamedTuple):
    """Resonances (r,): speed and half the width at half the power, rad/s; heights (r, e) alone."""

    speed: FloatArray
    width: FloatArray
    height: FloatArray


def narrow_resonance_speeds(
    speed: FloatArray,
    curve: FloatArray,
    resonances: NarrowResonances,
    levels: tuple[FloatArray, ...] = (),
) -> FloatArray:
    """Speeds (k,) in rad/s, next to those of a sweep (s,) of curves (s, e), to evaluate as well.

    Those about a resonance that is narrower than the steps and may reach, on what the curve is
    next to it, the largest value of some curve or one of the `levels`, each (e,) or (s, e).
    """
    step = np.diff(speed)
    place = np.clip(np.searchsorted(speed, resonances.speed) - 1, 0, len(step) - 1)
    nearby = np.maximum(curve[:-1], curve[1:])
    reach = np.zeros_like(nearby)
    np.add.at(reach, place, resonances.height)
    reach = nearby + MARGIN * reach
    best = np.max(curve, axis=0, initial=0.0, where=np.isfinite(curve))
    near = np.any(reach >= best, axis=1)
    for level in levels:
        least = np.minimum(level[:-1], level[1:]) if level.ndim > 1 else level
        near |= np.any(reach >= least, axis=1)
    counts = np.any(MARGIN * resonances.height >= FAINT * nearby[place], axis=1)
    chosen = near[place] & (resonances.width < SHOWN * step[place]) & counts
    if not np.any(chosen):
        return np.zeros(0)
    extra = (
        resonances.speed[chosen, None] + resonances.width[chosen, None] * NEARBY_NARROW_RESONANCE
    )
    return distinct(extra[~np.isin(extra, speed)])


# ----------------------------------------------------------------------------
# Barred ranges: the speeds at which a curve exceeds its limit.
# ----------------------------------------------------------------------------


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
