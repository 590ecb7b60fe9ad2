"""Speeds that matter on a curve: peaks between samples, narrow resonances, barred ranges."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.maxima import CORNER, by_values
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray
from vibecalc.numerics.synthesis import BLOCK, SINGLE, Cycles, cycle_of, sampled_roughly, synthesis

# ----------------------------------------------------------------------------
# The largest values of many curves over a range of speeds, found between the speeds of a sweep.
# ----------------------------------------------------------------------------

#: values (r, k) of curves (r,) at speeds (r, k) of their own
Value = Callable[[IntArray, FloatArray], FloatArray]

#: maxima of one curve that are reported
MOST = 12

#: part of the largest value among the speeds that a maximum there has at least, to be examined
RIVAL = 0.7

#: part of the first and last step at which a curve that is highest at an end is examined
INWARDS = 1e-6


class Maxima(NamedTuple):
    """By curve (r,): speed in rad/s and value with their errors; infinite where undamped.

    The error of the value is that of the place: rounding of the curve is not in it.
    """

    section: IntArray
    speed: FloatArray
    speed_error: FloatArray
    value: FloatArray
    value_error: FloatArray


def maxima(
    value: Value,
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
    ends = speed[place[inner] - 1], speed[place[inner]], speed[place[inner] + 1]
    found = by_values(lambda row, where: value(own[row], where), np.arange(len(inner)), *ends)
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
    line: IntArray | None = None,
) -> BoolArray:
    """Which values are maxima among speeds of their line, away from those without damping."""
    values = curve[place, section]
    inner = (place > 0) & (place < len(speed) - 1) & np.isfinite(values) & (values > 0.0)
    sides = np.clip(place[:, None] + np.array([-1, 1]), 0, len(speed) - 1)
    if line is not None:
        inner &= np.all(line[sides] == line[place, None], axis=1)
    beside = curve[sides, section[:, None]]
    # where a limit begins to say something, a use drops to nothing
    inner &= np.all(np.isfinite(beside) & (beside <= values[:, None]) & (beside > 0.0), axis=1)
    between = (undamped >= speed[sides[:, :1]]) & (undamped <= speed[sides[:, 1:]])
    return np.asarray(inner & ~np.any(between, axis=1))


def largest(
    value: Value,
    curve: FloatArray,
    speed: FloatArray,
    undamped: FloatArray,
    endless: FloatArray,
    line: IntArray | None = None,
    group: IntArray | None = None,
) -> Maxima:
    """The largest of each curve (s, e), (e,), between the speeds too.

    Every maximum among the speeds that may be the highest is refined, and one between the last
    speed and the one before it. `endless` (e,) is the speed in the range at which a curve has no
    end, NaN for none. The speeds may be those of one `line` (s,) of p after the other: then there
    are the largest of each line (p e,), and `value` takes such numbers. Of curves of one `group`
    (p e,) only those are refined that may be the highest of all of them.
    """
    line = np.zeros(len(speed), dtype=np.int64) if line is None else line
    first = np.flatnonzero(np.diff(line, prepend=-1))
    seen = np.maximum.reduceat(curve, first, axis=0)
    # of equal ones that at the lowest speed
    highest = np.where(curve == seen[line], np.arange(len(speed))[:, None], len(speed))
    place, best = np.minimum.reduceat(highest, first, axis=0).ravel(), seen.ravel().copy()
    at, uncertainty, lost = speed[place].copy(), *np.zeros((2, len(place)))
    most = np.where(np.isfinite(best), best, 0.0)
    if group is not None:
        of_group = np.zeros(int(group.max(initial=-1)) + 1)
        np.maximum.at(of_group, group, most)
        most = of_group[group]
    seen_at = _Seen(curve, speed, line, first, RIVAL * most.reshape(seen.shape))
    brackets, ends = _rivals(seen_at, undamped), _nearby_ends(value, seen_at, undamped)
    row, low, top, high = (np.concatenate(pair) for pair in zip(brackets, ends, strict=True))
    found = by_values(value, row, low, top, high, most)
    which, height = found.row, found.height.value
    higher = height >= best[which] * (1.0 - CORNER)
    # next to a corner what was seen may be higher than what was found in its step
    moved = np.abs(found.place.value - at[which])
    steps = np.maximum(np.diff(speed, prepend=speed[0]), np.diff(speed, append=speed[-1]))
    off = np.where(moved <= steps[place[which]], moved, 0.0)
    uncertainty[which] = np.where(higher, found.place.error, off)
    at[which] = np.where(higher, found.place.value, at[which])
    best[which] = np.maximum(height, best[which])
    lost[which] = found.height.error
    endless = np.broadcast_to(endless, seen.shape).ravel()
    no_end = ~np.isnan(endless)
    at, best = np.where(no_end, endless, at), np.where(no_end, np.inf, best)
    uncertainty = np.where(no_end, 1e-10 * at, uncertainty)
    return Maxima(np.arange(len(place)), at, uncertainty, best, np.where(no_end, 0.0, lost))


class _Seen(NamedTuple):
    """Curves (s, e) at speeds (s,) of lines (s,) from places `first` (p,) on.

    `least` (p, e) is what a maximum has at least that may be the highest.
    """

    curve: FloatArray
    speed: FloatArray
    line: IntArray
    first: IntArray
    least: FloatArray


#: curve, by its number among those of all lines, and a place between two others that is higher
#: than both
_Brackets = tuple[IntArray, FloatArray, FloatArray, FloatArray]


def _rivals(seen: _Seen, undamped: FloatArray) -> _Brackets:
    """Steps about maxima among the speeds that may be the highest between them."""
    curve, speed, line = seen.curve, seen.speed, seen.line
    place, section = np.nonzero(curve >= seen.least[line])
    inner = _stands_alone(curve, speed, section, place, undamped, line)
    place, section = place[inner], section[inner]
    row = line[place] * curve.shape[1] + section
    return row, speed[place - 1], speed[place], speed[place + 1]


def _nearby_ends(value: Value, seen: _Seen, undamped: FloatArray) -> _Brackets:
    """The first and the last step, where a curve rises from its high end inwards, and falls."""
    curve, speed, first = seen.curve, seen.speed, seen.first
    parts = [(np.zeros(0, dtype=np.int64), *np.zeros((3, 0)))]
    last = np.append(first[1:], len(speed)) - 1
    for end, nearby in ((first, first + 1), (last, last - 1)) if len(speed) > 1 else ():
        top, inner = curve[end], curve[nearby]
        high = np.isfinite(top) & (top > 0.0) & (top >= seen.least)
        of, section = np.nonzero(high & np.isfinite(inner) & (inner > 0.0) & (inner < top))
        start, stop = speed[end[of], None], speed[nearby[of], None]
        low, far = np.minimum(start, stop), np.maximum(start, stop)
        clear = ~np.any((undamped >= low) & (undamped <= far), axis=1)
        if not np.any(clear):
            continue
        where = start + (stop - start) * np.array([0.0, INWARDS])
        rows = of * curve.shape[1] + section
        rising = np.flatnonzero(clear)
        inwards = value(rows[rising], where[rising])
        rising = rising[inwards[:, 1] > inwards[:, 0]]
        parts.append((rows[rising], low[rising, 0], where[rising, 1], far[rising, 0]))
    row, begin, middle, stop = (np.concatenate(part) for part in zip(*parts, strict=True))
    return row, begin, middle, stop


def peaks(
    value: Value,
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
    return maxima(value, curve, speed, np.full(len(place), section), place, undamped)


def by_machine(machine: IntArray | int, speed: FloatArray) -> ComplexArray:
    """Speeds (...) of lines (...) as one number each, which sort by line, then by speed."""
    pair: ComplexArray = np.empty(np.shape(speed), dtype=np.complex128)
    pair.real, pair.imag = machine, speed
    return pair


def machine_and_speed(pair: ComplexArray) -> tuple[IntArray, FloatArray]:
    """Both (...) of what `by_machine` gives."""
    return pair.real.astype(np.int64), np.ascontiguousarray(pair.imag)


# ----------------------------------------------------------------------------
# Barred ranges: the speeds at which a curve exceeds its limit.
# ----------------------------------------------------------------------------


class BarredRanges(NamedTuple):
    """By rising speed (b,): ends in rad/s, where the curve crosses its limit or the speeds end."""

    start: FloatArray
    end: FloatArray


def barred_ranges(excess: Callable[[FloatArray], FloatArray], speed: ArrayLike) -> BarredRanges:
    """Ranges in which `excess`, curve minus limit at speeds (s,), is above zero.

    `speed` (s,) rising must be close enough that no range lies between two of them: put the
    resonances of the curve among them. Ends are brought to neighbouring numbers: each round tries
    both sides of where a straight line crosses, as near to it as its curvature lets, and next to
    a jump the middle and places near both ends.
    Infinite excess (an undamped resonance) is inside a range.

    Raises
    ------
    NumericalFailure
        The excess is not a number somewhere.
    """
    speeds = np.asarray(speed, dtype=float)
    values = _known(excess, speeds)
    above = values > 0.0
    change = np.flatnonzero(above[1:] != above[:-1])
    place, value = (np.stack([one[change], one[change + 1]]) for one in (speeds, values))
    rising, whole = above[change + 1], place[1] - place[0]
    open_ = np.arange(len(change))
    for _ in range(70):
        open_ = open_[np.ptp(place[:, open_], axis=0) > 2.0 * EPSILON * place[1, open_]]
        if not len(open_):
            break
        (low, high), (first, last) = place[:, open_], value[:, open_]
        width = high - low
        with np.errstate(invalid="ignore", divide="ignore"):
            share = first / (first - last)
        guess = low + np.where(np.isfinite(share), share, 0.5) * width
        off, step = 0.25 * width * (width / whole[open_]) + EPSILON * high, width / 64.0
        inner = np.sort([low + step, 0.5 * (low + high), high - step, guess - off, guess + off],
                        axis=0)  # fmt: skip
        inner = np.clip(inner, low, high)
        here = _known(excess, inner.ravel()).reshape(inner.shape)
        tried = np.concatenate([low[None], inner, high[None]])
        found = np.concatenate([first[None], here, last[None]])
        upper = np.argmax((found[1:] > 0.0) == rising[open_], axis=0) + 1
        column = np.arange(len(open_))
        for side in (0, 1):
            place[side, open_] = tried[upper - 1 + side, column]
            value[side, open_] = found[upper - 1 + side, column]
    low, high = place
    # the side inside the range counts, so that both ends are within it
    starts, ends = high[rising], low[~rising]
    if len(above) and above[0]:
        starts = np.concatenate([speeds[:1], starts])
    if len(above) and above[-1]:
        ends = np.concatenate([ends, speeds[-1:]])
    return BarredRanges(starts, ends)


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


def _known(excess: Callable[[FloatArray], FloatArray], speeds: FloatArray) -> FloatArray:
    """The excess at speeds; NumericalFailure where it is not a number."""
    values = excess(speeds) if len(speeds) else np.zeros(0)
    if np.any(np.isnan(values)):
        raise NumericalFailure("barred ranges: curve minus limit is not a number at some speed")
    return np.asarray(values)


# ----------------------------------------------------------------------------
# Of sums over a cycle of which only the largest count, the bounds tell which these can be.
#
# Between two samples a signal exceeds both by no more than its largest curvature times an eighth of
# the square of their distance; a sum x(t) = Re sum X_q exp(i q t) has the curvature sum q^2 |X_q|.
# ----------------------------------------------------------------------------


def rough_range(order: FloatArray, amplitude: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Bounds (...) below and above the half ranges of sums over the cycle.

    Parameters
    ----------
    order : array (m,)
        Orders above 0; those that are no multiples of 1/2 leave nothing but 0 and infinity.
    amplitude : complex array (..., m)
        0-to-peak, finite.
    """
    shape = amplitude.shape[:-1]
    doubled = np.rint(2.0 * order).astype(np.int64)
    if np.any(doubled != 2.0 * order) or np.any(doubled < 1):
        return np.zeros(shape), np.full(shape, np.inf)
    number = doubled if np.any(doubled % 2) else doubled // 2
    rows = amplitude.reshape(-1, len(order))
    cycle = cycle_of(tuple(number.tolist()))
    low, high = np.empty((2, len(rows)))
    step = math.pi / cycle.samples  # half of one
    block = max(1, BLOCK // cycle.samples)
    for start in range(0, len(rows), block):
        part = slice(start, start + block)
        size = np.abs(rows[part])
        most = size.sum(axis=1)
        unit = np.where(most > 0.0, most, 1.0)
        scaled = rows[part] / unit[:, None]
        sampled = sampled_roughly(scaled, cycle)
        half = 0.5 * (sampled.max(axis=1).astype(float) - sampled.min(axis=1))
        bend = 0.5 * step**2 * (size @ np.square(number.astype(float)))
        low[part] = np.maximum(half - SINGLE, 0.0) * most
        high[part] = (half + SINGLE) * most + bend
    return low.reshape(shape), high.reshape(shape)


def near_the_largest(
    cycles: Cycles,
    amplitude: ComplexArray,
    group: IntArray,
    best: FloatArray,
    seeds: int = 0,
) -> FloatArray:
    """Half ranges (r,) of sums (r, m): of what is not near the largest of its `group` (r,),
    something that is not below it and less than `RIVAL` of that.

    `best` (g,) is what the largest of each group is not below; it is raised here. The so many
    `seeds` with the largest magnitudes of each, as long as the others, are bounded first.
    """
    high: FloatArray = np.abs(amplitude) @ np.ones(amplitude.shape[1])

    def bounded(chosen: IntArray) -> None:
        low, high[chosen] = rough_range(cycles.own, amplitude[chosen])
        np.maximum.at(best, group[chosen], low)

    if seeds:
        each = len(high) // len(best)
        few = min(each, seeds)
        most = np.argpartition(high.reshape(-1, each), each - few, axis=1)[:, each - few :]
        bounded((most + each * np.arange(len(most))[:, None]).ravel())
    bounded(np.flatnonzero(high >= RIVAL * best[group]))
    chosen = np.flatnonzero(high >= RIVAL * best[group])
    high[chosen] = synthesis(cycles, amplitude[chosen]).half_range
    np.maximum.at(best, group[chosen], high[chosen])
    return high
