"""Speeds that matter on a curve: peaks between samples, narrow resonances, barred ranges."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.maxima import CORNER, by_values
from vibecalc.numerics.rounding import (
    EPSILON,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    distinct,
)

# ----------------------------------------------------------------------------
# The largest values of many curves over a range of speeds, found between the speeds of a sweep.
# ----------------------------------------------------------------------------

#: value (r, k) of each one's own curve at speeds (r, k)
Value = Callable[[FloatArray], FloatArray]

#: maxima of one curve that are reported
MOST = 12

#: curves whose largest value is searched between the speeds of the sweep, highest first
REFINED = 32

#: part of the largest value among the speeds that a maximum there has at least, to be examined
RIVAL = 0.7

#: part of the first and last step at which a curve that is highest at an end is examined
INWARDS = 1e-6


class Maxima(NamedTuple):
    """By section (r,): speed in rad/s and value with their errors; infinite where undamped.

    The error of the value is that of the place: rounding of the curve is not in it.
    """

    section: IntArray
    speed: FloatArray
    speed_error: FloatArray
    value: FloatArray
    value_error: FloatArray


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
    at, error, off = speed[place].copy(), *np.zeros((2, len(place)))
    inner = np.flatnonzero(_stands_alone(curve, speed, section, place, undamped))
    own = section[inner]

    def values_at(row: IntArray, where: FloatArray) -> FloatArray:
        return make(own[row])(where)

    ends = speed[place[inner] - 1], speed[place[inner]], speed[place[inner] + 1]
    found = by_values(values_at, np.arange(len(inner)), *ends)
    which = inner[found.row]
    # next to a corner what was seen may be higher
    higher = found.height.value >= values[which] * (1.0 - CORNER)
    moved = np.abs(found.place.value - at[which])
    error[which] = np.where(higher, found.place.error, moved)
    at[which] = np.where(higher, found.place.value, at[which])
    values[which] = np.maximum(found.height.value, values[which])
    off[which] = found.height.error
    return Maxima(section, at, error, values, off)


def _stands_alone(
    curve: FloatArray,
    speed: FloatArray,
    section: IntArray,
    place: IntArray,
    undamped: FloatArray,
    machine: IntArray | None = None,
) -> BoolArray:
    """Which values are maxima among speeds of their machine, away from those without damping."""
    values = curve[place, section]
    inner = (place > 0) & (place < len(speed) - 1) & np.isfinite(values) & (values > 0.0)
    sides = np.clip(place[:, None] + np.array([-1, 1]), 0, len(speed) - 1)
    if machine is not None:
        inner &= np.all(machine[sides] == machine[place, None], axis=1)
    beside = curve[sides, section[:, None]]
    # where a limit begins to say something, a use drops to nothing
    inner &= np.all(np.isfinite(beside) & (beside <= values[:, None]) & (beside > 0.0), axis=1)
    between = (undamped >= speed[sides[:, :1]]) & (undamped <= speed[sides[:, 1:]])
    return np.asarray(inner & ~np.any(between, axis=1))


def largest(
    make: Callable[[IntArray], Value],
    curve: FloatArray,
    speed: FloatArray,
    undamped: FloatArray,
    endless: FloatArray,
    machine: IntArray | None = None,
) -> Maxima:
    """The largest of each section's curve (s, e), (e,); past `REFINED` of them that of the sweep.

    Every maximum among the speeds that may be the highest is refined, and one between the last
    speed and the one before it. `endless` (e,) is the speed in the range at which a section's curve
    has no end, NaN for none. The speeds may be those of one `machine` (s,) of p after the other:
    then there are the largest of each machine (p e,), and `make` takes such numbers.
    """
    machine = np.zeros(len(speed), dtype=np.int64) if machine is None else machine
    first = np.flatnonzero(np.diff(machine, prepend=-1))
    best = np.maximum.reduceat(curve, first, axis=0)
    # of equal ones that at the lowest speed
    highest = np.where(curve == best[machine], np.arange(len(speed))[:, None], len(speed))
    place, value = np.minimum.reduceat(highest, first, axis=0).ravel(), best.ravel().copy()
    at, uncertainty, lost = speed[place].copy(), *np.zeros((2, len(place)))
    examined = np.zeros(best.shape, dtype=bool)
    loaded = np.argsort(-best, axis=1, kind="stable")[:, :REFINED]
    np.put_along_axis(examined, loaded, True, axis=1)
    seen_at = _Seen(curve, speed, machine, first, best, examined)
    brackets, ends = _rivals(seen_at, undamped), _nearby_ends(make, seen_at, undamped)
    row, low, top, high = (np.concatenate(pair) for pair in zip(brackets, ends, strict=True))
    floor = np.where(np.isfinite(value), value, 0.0)

    def values_at(rows: IntArray, where: FloatArray) -> FloatArray:
        return make(rows)(where)

    found = by_values(values_at, row, low, top, high, floor)
    which, height = found.row, found.height.value
    seen = value[which]
    higher = height >= seen * (1.0 - CORNER)
    # next to a corner what was seen may be higher than what was found in its step
    moved = np.abs(found.place.value - at[which])
    steps = np.maximum(np.diff(speed, prepend=speed[0]), np.diff(speed, append=speed[-1]))
    near = moved <= steps[place[which]]
    off = np.where(near, moved, 0.0)
    uncertainty[which] = np.where(higher, found.place.error, off)
    at[which] = np.where(higher, found.place.value, at[which])
    value[which] = np.maximum(height, seen)
    lost[which] = found.height.error
    no_end = np.broadcast_to(~np.isnan(endless), best.shape).ravel()
    endless = np.broadcast_to(endless, best.shape).ravel()
    at, value = np.where(no_end, endless, at), np.where(no_end, np.inf, value)
    uncertainty = np.where(no_end, 1e-10 * at, uncertainty)
    return Maxima(np.arange(len(place)), at, uncertainty, value, np.where(no_end, 0.0, lost))


class _Seen(NamedTuple):
    """Curves (s, e) at speeds (s,) of machines (s,) from places `first` (p,) on.

    `best` (p, e) is the largest of each, `examined` whether there is more to be searched.
    """

    curve: FloatArray
    speed: FloatArray
    machine: IntArray
    first: IntArray
    best: FloatArray
    examined: BoolArray


#: curve, by its number among those of all machines, and a place between two others that is higher
#: than both
_Brackets = tuple[IntArray, FloatArray, FloatArray, FloatArray]


def _rivals(seen: _Seen, undamped: FloatArray) -> _Brackets:
    """Steps about maxima among the speeds that may be the highest between them."""
    curve, speed, machine = seen.curve, seen.speed, seen.machine
    least = np.where(seen.examined, RIVAL * seen.best, np.inf)
    place, section = np.nonzero((curve >= least[machine]) & seen.examined[machine])
    inner = _stands_alone(curve, speed, section, place, undamped, machine)
    place, section = place[inner], section[inner]
    row = machine[place] * curve.shape[1] + section
    return row, speed[place - 1], speed[place], speed[place + 1]


def _nearby_ends(make: Callable[[IntArray], Value], seen: _Seen, undamped: FloatArray) -> _Brackets:
    """The first and the last step, where a curve rises from its high end inwards, and falls."""
    curve, speed, first = seen.curve, seen.speed, seen.first
    parts = [(np.zeros(0, dtype=np.int64), *np.zeros((3, 0)))]
    last = np.append(first[1:], len(speed)) - 1
    for end, nearby in ((first, first + 1), (last, last - 1)) if len(speed) > 1 else ():
        top, inner = curve[end], curve[nearby]
        high = np.isfinite(top) & (top > 0.0) & (top >= RIVAL * seen.best) & seen.examined
        of, section = np.nonzero(high & np.isfinite(inner) & (inner > 0.0) & (inner < top))
        start, stop = speed[end[of], None], speed[nearby[of], None]
        low, far = np.minimum(start, stop), np.maximum(start, stop)
        clear = ~np.any((undamped >= low) & (undamped <= far), axis=1)
        if not np.any(clear):
            continue
        where = start + (stop - start) * np.array([0.0, INWARDS])
        rows = of * curve.shape[1] + section
        rising = np.flatnonzero(clear)
        inwards = make(rows[rising])(where[rising])
        rising = rising[inwards[:, 1] > inwards[:, 0]]
        parts.append((rows[rising], low[rising, 0], where[rising, 1], far[rising, 0]))
    row, begin, middle, stop = (np.concatenate(part) for part in zip(*parts, strict=True))
    return row, begin, middle, stop


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
    """Resonances (r,): speed and half the width at half the power, rad/s; heights (r, e) alone.

    `machine` (r,) is whose they are.
    """

    speed: FloatArray
    width: FloatArray
    height: FloatArray
    machine: IntArray


def by_machine(machine: IntArray | int, speed: FloatArray) -> ComplexArray:
    """Speeds (...) of machines (...) as one number each, which sort by machine, then by speed."""
    pair: ComplexArray = np.empty(np.shape(speed), dtype=np.complex128)
    pair.real, pair.imag = machine, speed
    return pair


def machine_and_speed(pair: ComplexArray) -> tuple[IntArray, FloatArray]:
    """Both (...) of what `by_machine` gives."""
    return pair.real.astype(np.int64), np.ascontiguousarray(pair.imag)


def narrow_resonance_speeds(
    speed: FloatArray,
    curve: FloatArray,
    resonances: NarrowResonances,
    levels: tuple[FloatArray, ...] = (),
) -> ComplexArray:
    """Speeds (k,) `by_machine` in rad/s, next to those of a sweep (s,), to evaluate as well.

    Those about a resonance that is narrower than the steps and may reach, on what the curves
    (p, s, e) of its machine are next to it, the largest value of some curve or one of the `levels`,
    each (e,) or (s, e).
    """
    step = np.diff(speed)
    place = np.clip(np.searchsorted(speed, resonances.speed) - 1, 0, len(step) - 1)
    at = (resonances.machine, place)
    nearby = np.maximum(curve[:, :-1], curve[:, 1:])
    reach = np.zeros_like(nearby)
    np.add.at(reach, at, resonances.height)
    reach = nearby + MARGIN * reach
    best = np.max(curve, axis=1, initial=0.0, where=np.isfinite(curve), keepdims=True)
    near = np.any(reach >= best, axis=-1)
    for level in levels:
        least = np.minimum(level[:-1], level[1:]) if level.ndim > 1 else level
        near |= np.any(reach >= least, axis=-1)
    counts = np.any(MARGIN * resonances.height >= FAINT * nearby[at], axis=1)
    chosen = near[at] & (resonances.width < SHOWN * step[place]) & counts
    extra = (
        resonances.speed[chosen, None] + resonances.width[chosen, None] * NEARBY_NARROW_RESONANCE
    )
    extra_of = np.broadcast_to(resonances.machine[chosen, None], extra.shape)
    fresh = ~np.isin(extra, speed)
    # without the index numpy imports its masked arrays
    return np.unique(by_machine(extra_of[fresh], extra[fresh]), return_index=True)[0]


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


#: of a speed, the step by which the slope of a curve at an end of a range is taken
SLOPE_STEP = 1e-7


def slopes(
    curve: Callable[[FloatArray], FloatArray], at: FloatArray, first: float, last: float
) -> FloatArray:
    """Magnitudes of slopes of a curve at speeds (r,) from `first` to `last`, one-sided at both.

    Infinite or not a number where the curve is unbounded, or the range a single speed.
    """
    step = SLOPE_STEP * at
    before, after = np.maximum(at - step, first), np.minimum(at + step, last)
    values = curve(np.concatenate([before, after])).reshape(2, -1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.abs(values[1] - values[0]) / (after - before))


def _above(excess: Callable[[FloatArray], FloatArray], speeds: FloatArray) -> BoolArray:
    values = excess(speeds) if len(speeds) else np.zeros(0)
    if np.any(np.isnan(values)):
        raise NumericalFailure("barred ranges: curve minus limit is not a number at some speed")
    return np.asarray(values > 0.0)
