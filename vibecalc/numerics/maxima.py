"""Highest points of many curves at once: brackets, refinement, errors of place and height."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.rounding import (
    EPSILON,
    UNIT_ROUNDOFF,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
)

# ----------------------------------------------------------------------------
# Maxima of curves that give their derivatives.
#
# Between two seeds a curve that rises at the first and falls at the second has a maximum. Where
# seeds stand at poles (natural frequencies, and a few widths beside them) and kinks, none is
# missed; where slopes and second derivatives of two seeds let a pair of extremes hide between them,
# the place where it may be is looked at as well. Newton's method, on the slope of
# the reciprocal, which is a parabola at a resonance of a squared magnitude, is kept within each
# bracket, all of them in one batch; each one ends by itself, so that its last bit does not depend
# on the others.
# ----------------------------------------------------------------------------

#: rounds in which pairs of extremes between seeds are searched; rounds of Newton's method
LOOKS, ROUNDS = 6, 120
#: seeds about a pole, in half widths of its resonance
HALF_WIDTHS = np.array([0.0, -1.0, 1.0, -2.5, 2.5, -8.0, 8.0])
#: share of the lower slope of both ends below which a slope between them is looked at
NEAR_ZERO = 0.6
_PARTS = np.arange(1, 8) / 8.0
_HERMITE = np.stack([
    (1.0 + 2.0 * _PARTS) * (1.0 - _PARTS) ** 2, _PARTS * (1.0 - _PARTS) ** 2,
    _PARTS**2 * (3.0 - 2.0 * _PARTS), _PARTS**2 * (_PARTS - 1.0),
], axis=1)  # fmt: skip
#: maxima no farther apart than this many times their errors are one
ALIKE = 4.0
#: ratio of the ends of a bracket from which it is halved in its logarithm
WIDE = 4.0


class Jet(NamedTuple):
    """Curves at one place each (n,): value with its error, slope and second derivative."""

    value: FloatArray
    error: FloatArray
    slope: FloatArray
    bend: FloatArray

    def some(self, which: BoolArray | IntArray) -> "Jet":
        """At the places that an index names."""
        return Jet(*(part[which] for part in self))


class Maxima(NamedTuple):
    """Maxima (m,) by curve, `row`, and rising place, with the second derivative there."""

    row: IntArray
    place: Bounded
    height: Bounded
    bend: FloatArray

    def some(self, which: BoolArray | IntArray) -> "Maxima":
        """The maxima that an index names."""
        place, height = self.place[which], self.height[which]
        return Maxima(self.row[which], place, height, self.bend[which])


def joined(parts: Sequence[Maxima]) -> Maxima:
    """Those of different curves, by curve and rising place."""
    row = np.concatenate([part.row for part in parts])
    place = concatenate([part.place for part in parts])
    height = concatenate([part.height for part in parts])
    bend = np.concatenate([part.bend for part in parts])
    return Maxima(row, place, height, bend).some(np.lexsort((place.value, row)))


#: curves `row` (n,) at places (n,)
JetAt = Callable[[IntArray, FloatArray], Jet]


class _Steps(NamedTuple):
    """Steps (n,) between two places of one curve, and what it does at both."""

    row: IntArray
    low: FloatArray
    high: FloatArray
    left: Jet
    right: Jet

    def some(self, which: BoolArray | IntArray) -> "_Steps":
        left, right = self.left.some(which), self.right.some(which)
        return _Steps(self.row[which], self.low[which], self.high[which], left, right)


def seeds_about(poles: ComplexArray, stationary: FloatArray) -> FloatArray:
    """Seeds (rows, n) at frequencies that are stationary (rows, k), about as well as rounding lets
    them be known, between them, and in half widths about poles s (rows, p); NaN for none.

    A top next to a zero stands off the pole, by about its half width.
    """
    swings = poles.imag > 0.0
    about = poles.imag[..., None] - poles.real[..., None] * HALF_WIDTHS
    about = np.where(swings[..., None], about, np.nan).reshape(len(poles), -1)
    known = np.concatenate([about, np.abs(poles), stationary], axis=1)
    known = np.sort(np.where(known > 0.0, known, np.nan), axis=1)
    known = known[:, np.any(np.isfinite(known), axis=0)]
    between = np.sqrt(known[:, 1:]) * np.sqrt(known[:, :-1])
    beyond = 2.0 * np.nanmax(known, axis=1, keepdims=True, initial=0.0)
    return np.concatenate([0.5 * known[:, :1], known, between, beyond], axis=1)


def by_slopes(jet_at: JetAt, seed: FloatArray) -> Maxima:
    """All maxima of curves that stand between their seeds (curves, n), in any order, NaN for none.

    Ends of the range are no maxima here: the signs of the slopes there tell the caller of them.
    """
    with np.errstate(all="ignore"):
        return _parted(_closed_in(jet_at, _brackets(jet_at, np.sort(seed, axis=1))))


def _brackets(jet_at: JetAt, seed: FloatArray) -> _Steps:
    """Steps between seeds (curves, n), rising, at whose ends a curve rises and falls."""
    used = np.isfinite(seed)
    used[:, 1:] &= seed[:, 1:] != seed[:, :-1]
    row, which = np.nonzero(used)
    place = seed[row, which]
    jet = jet_at(row, place)
    first = np.flatnonzero(row[1:] == row[:-1])
    steps = _Steps(row[first], place[first], place[first + 1], jet.some(first), jet.some(first + 1))
    brackets = []
    for look in range(LOOKS + 1):
        suspect, where = _suspected(steps)
        suspect &= look < LOOKS
        holds = ~suspect & (steps.left.slope > 0.0) & (steps.right.slope <= 0.0)
        brackets.append(steps.some(holds))
        if not np.any(suspect):
            break
        split, at = steps.some(suspect), where[suspect]
        there = jet_at(split.row, at)
        halves = split._replace(high=at, right=there), split._replace(low=at, left=there)
        steps = _joined(halves)
    return _joined(brackets)


def _joined(parts: Sequence[_Steps]) -> _Steps:
    row, low, high = (
        np.concatenate(part) for part in zip(*(one[:3] for one in parts), strict=True)
    )
    left, right = (
        Jet(*(np.concatenate(column) for column in zip(*side, strict=True)))
        for side in zip(*(one[3:] for one in parts), strict=True)
    )
    return _Steps(row, low, high, left, right)


def _suspected(steps: _Steps) -> tuple[BoolArray, FloatArray]:
    """Steps (n,) in which the cubic through slopes and second derivatives of both ends comes near
    zero, or through it more often than the ends tell, and the places to look at in them.

    Slopes are those of the logarithm of what is positive, in wide steps by the logarithm of the
    place, so that powers have none that change.
    """
    positive = (steps.left.value > 0.0) & (steps.right.value > 0.0)
    wide = positive & (steps.low > 0.0) & (steps.high > WIDE * steps.low)
    width = np.where(wide, np.log(steps.high / steps.low), steps.high - steps.low)
    first, first_bend = _logarithmic(steps.low, steps.left, positive, wide)
    last, last_bend = _logarithmic(steps.high, steps.right, positive, wide)
    ends = np.stack([first, first_bend * width, last, last_bend * width])
    side = np.sign(first)
    cubic = _HERMITE @ np.where(np.isfinite(ends), side * ends, 0.0)
    least = np.argmin(cubic, axis=0)
    alike = side * last > 0.0
    near = np.min(cubic, axis=0) < NEAR_ZERO * np.minimum(np.abs(first), np.abs(last))
    # of slopes of two signs, what comes back to the first one
    crossed = np.logical_or.accumulate(cubic < 0.0, axis=0)
    back = np.where(crossed, cubic, -np.inf)
    suspect = np.where(alike, near, np.max(back, axis=0) > 0.0)
    part = _PARTS[np.where(alike, least, np.argmax(back, axis=0))]
    where = np.where(wide, steps.low * np.exp(width * part), steps.low + width * part)
    suspect &= (where > steps.low) & (where < steps.high)
    return suspect, where


def _logarithmic(
    place: FloatArray, jet: Jet, positive: BoolArray, wide: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Slope and second derivative, of the logarithm where `positive`, by that of the place where
    `wide`."""
    value = np.where(positive, jet.value, 1.0)
    slope, bend = jet.slope / value, jet.bend / value
    bend = np.where(positive, bend - slope * slope, bend)
    factor = np.where(wide, place, 1.0)
    return factor * slope, factor * (factor * bend + np.where(wide, slope, 0.0))


def _closed_in(jet_at: JetAt, steps: _Steps) -> Maxima:
    """Maxima (m,) of steps at whose ends the curve rises and falls."""
    row, low, high = steps.row, steps.low.copy(), steps.high.copy()
    moves = _newton(steps.left), _newton(steps.right)
    nearer = np.abs(moves[1]) < np.abs(moves[0])
    at = np.where(nearer, high + moves[1], low + moves[0])
    at = np.where((at > low) & (at < high), at, _middle(low, high))
    before, live = high - low, np.arange(len(row))
    for _ in range(ROUNDS):
        if not len(live):
            break
        place, here = at[live], jet_at(row[live], at[live])
        rises = here.slope > 0.0
        low[live], high[live] = (
            np.where(rises, place, low[live]), np.where(rises, high[live], place)
        )  # fmt: skip
        step, last = _newton(here), before[live]
        target, size = place + step, np.abs(step)
        inside = (target >= low[live]) & (target <= high[live])
        fast = inside & (size <= 0.5 * last)
        rounding = UNIT_ROUNDOFF * np.abs(place)
        # Newton's steps square: the next one would be below rounding
        settled = fast & (size <= 1e-3 * last) & (size * size <= 0.5 * rounding * last)
        settled |= (size <= rounding) | (here.slope == 0.0)
        # steps that no longer shrink are those of rounding
        settled |= (size <= _blur(here)) & (size > 0.25 * last)
        settled |= high[live] - low[live] <= 4.0 * rounding
        at[live] = np.where(fast | (settled & inside), target, np.where(
            settled, place, _middle(low[live], high[live])))  # fmt: skip
        before[live] = np.where(fast, size, high[live] - low[live])
        live = live[~settled]
    top = jet_at(row, at)
    # rounding of the slope makes tops of what is none
    ends = np.maximum(steps.left.value, steps.right.value)
    real = np.flatnonzero((top.bend < 0.0) | (top.value > ends + top.error))
    return _found(row[real], at[real], (high - low)[real], top.some(real))


def _parted(found: Maxima) -> Maxima:
    """By curve and rising place, of those that errors do not tell apart the higher one."""
    found = found.some(np.lexsort((found.place.value, found.row)))
    while len(found.row) > 1:
        place, error = found.place
        alike = np.diff(place) <= ALIKE * (error[1:] + error[:-1])
        twice = np.flatnonzero(alike & (found.row[1:] == found.row[:-1]))
        if not len(twice):
            break
        # of each crowd the first pair, the others in the next round
        twice = twice[np.diff(twice, prepend=-2) > 1]
        lower = found.height.value[twice] < found.height.value[twice + 1]
        found = found.some(np.delete(np.arange(len(found.row)), np.where(lower, twice, twice + 1)))
    return found


def _sharpness(jet: Jet) -> FloatArray:
    """Second derivative of the reciprocal in the curve's own measure, else of the curve."""
    positive = np.where(jet.value > 0.0, jet.value, np.inf)
    return np.asarray(jet.bend - 2.0 * np.square(jet.slope) / positive)


def _newton(jet: Jet) -> FloatArray:
    """Step to the top; not finite where there is none."""
    sharp = _sharpness(jet)
    return np.asarray(np.where(sharp < 0.0, -jet.slope / sharp, np.inf))


def _blur(jet: Jet) -> FloatArray:
    """How far the place is off by errors of the slope: those of the value over a peak's width."""
    off = jet.error / np.sqrt(np.abs(jet.value * _sharpness(jet)))
    return np.asarray(np.where(np.isfinite(off), off, 0.0))


def _middle(low: FloatArray, high: FloatArray) -> FloatArray:
    wide = (low > 0.0) & (high > WIDE * low)
    return np.asarray(np.where(wide, np.sqrt(np.where(wide, low, 1.0)) * np.sqrt(np.where(
        wide, high, 1.0)), 0.5 * (low + high)))  # fmt: skip


def _found(row: IntArray, at: FloatArray, left: FloatArray, jet: Jet) -> Maxima:
    """Errors from the slope and bracket that are left, and from the rounding of curve and place."""
    down = jet.bend < 0.0
    off = np.where(down, np.abs(jet.slope / jet.bend) + _blur(jet), left)
    rounding = 4.0 * UNIT_ROUNDOFF * np.abs(at)
    # on a very sharp peak the last bit of the place is felt
    short = np.where(down, 0.5 * np.square(jet.slope / jet.bend), np.square(left))
    lost = np.abs(jet.bend) * (short + 0.5 * np.square(rounding))
    return Maxima(row, Bounded(at, off + rounding), Bounded(jet.value, jet.error + lost), jet.bend)


# ----------------------------------------------------------------------------
# The highest maxima of curves that give values only.
#
# A bracket is divided until its ends are little lower than its highest value; then a polynomial
# through places close about the top, of which the highest coefficients tell whether it is that of
# a smooth curve, has its maximum. Where a kink is too near, the bracket is divided on. What cannot
# reach the highest value of its curve is dropped on the way.
# ----------------------------------------------------------------------------

#: parts in which a bracket is divided at first (two tops may stand in it), and later on
FIRST_PARTS, PARTS = 16, 8
#: share of the highest value of a curve that tops among these places have, to be divided on
EQUAL = 0.97
#: relative height of two tops below which they are alike, fall to the ends of a bracket below which
#: a polynomial is tried, and share of the bracket's width at which the next one is
CORNER, FLAT, FINER = 1e-11, 0.02, 1.0 / 8.0
#: fall below which tops next to each other are those of rounding
NOISE = 1e-6
#: half range of the polynomial over the width of the top, and its coefficients that count as smooth
REACH, SMOOTH = 0.03, 1e-13
#: roundings of values that are granted to the slope of the polynomial
SHIFT = 16.0

_NODES = -np.cos(np.pi * np.arange(9) / 8.0)
_POWERS = np.linalg.inv(_NODES[:, None] ** np.arange(9)).T

#: curves `row` (n,) at places (n, k)
ValuesAt = Callable[[IntArray, FloatArray], FloatArray]


class _Tops(NamedTuple):
    """Brackets (n,) with a place `at` in each that is higher than both ends, the top of the
    parabola through the three with its second derivative over its height, by how much the ends are
    lower, relative, the width of the last bracket in which a polynomial was tried, the whole
    bracket, and the best place so far, with its error."""

    row: IntArray
    low: FloatArray
    at: FloatArray
    high: FloatArray
    vertex: FloatArray
    bend: FloatArray
    fall: FloatArray
    tried: FloatArray
    least: FloatArray
    most: FloatArray
    place: FloatArray
    off: FloatArray

    def some(self, which: BoolArray | IntArray) -> "_Tops":
        return _Tops(self.row[which], *(part[which] for part in self[1:]))


def by_values(
    values_at: ValuesAt, row: IntArray, low: FloatArray, at: FloatArray, high: FloatArray,
    floor: FloatArray | None = None,
) -> Maxima:  # fmt: skip
    """The highest maximum between `low` and `high` of each curve, of several brackets (n,) one.

    At `at` a curve is higher than at both ends. Of maxima of one height that at the lowest place
    counts. `floor` (curves,): tops lower than about that are left out, and curves that have no
    other. The error of the height is that of the place; rounding of the curve is not in it.
    """
    room = (low < at) & (at < high)
    row, low, at, high = row[room], low[room], at[room], high[room]
    best = np.zeros(int(np.max(row, initial=-1)) + 1) if floor is None else floor.copy()
    one, never = np.ones(len(row)), np.full(len(row), np.inf)
    tops = _Tops(row, low, at, high, at, one, one, never, low, high, at, never)
    found, parts = [], FIRST_PARTS
    while len(tops.row):
        where = _divided(tops, parts)
        values = values_at(tops.row, where)
        np.maximum.at(best, tops.row, np.max(values, axis=1))
        tops, parts = _highest_among(tops, where, values, best), PARTS
        width = tops.high - tops.low
        ready = np.flatnonzero(
            ((tops.fall <= FLAT) & (width <= FINER * tops.tried)) | _narrow(tops)
        )
        if len(ready):
            fit, told = _fitted(values_at, tops.some(ready))
            found.append(fit.some(told))
            tops.place[ready], tops.off[ready] = fit.place
            tops.tried[ready] = width[ready]
            tops = tops.some(np.delete(np.arange(len(tops.row)), ready[told]))
    return first_highest(found)


def _divided(tops: _Tops, parts: int) -> FloatArray:
    """Places (n, parts + 1): both sides of the top alike, closer to it where a side is far away."""
    share = np.arange(parts // 2 + 1) / (parts // 2)
    before, after = tops.at - tops.low, tops.high - tops.at
    # a top next to an end of a wide bracket may be a thousand times as narrow
    far = np.maximum(before, after) > 30.0 * np.minimum(before, after)
    share = np.where(far[:, None], share**5, share)
    left = tops.at[:, None] - before[:, None] * share[:, ::-1]
    return np.concatenate([left, tops.at[:, None] + after[:, None] * share[:, 1:]], axis=1)


def _highest_among(tops: _Tops, where: FloatArray, values: FloatArray, best: FloatArray) -> _Tops:
    """Tops among places (n, k) that may be the highest of their curve."""
    inner = values[:, 1:-1]
    top = (inner > values[:, :-2]) & (inner >= values[:, 2:])
    # none shows where the curve is flat to rounding, and many where that is all that is left
    one = ~np.any(top, axis=1) | (tops.fall < NOISE)
    top[one] = False
    top[one, np.clip(np.argmax(values[one], axis=1), 1, values.shape[1] - 2) - 1] = True
    top &= inner >= EQUAL * best[tops.row, None]
    bracket, place = np.nonzero(top)
    spots = where[bracket[:, None], place[:, None] + np.arange(3)]
    three = values[bracket[:, None], place[:, None] + np.arange(3)]
    low, at, high = spots.T
    step = np.diff(spots, axis=1)
    # no slope where an end is within roundings of the top
    rise, drop = np.divide(np.diff(three, axis=1), step, out=np.zeros_like(step), where=step > 0).T
    width = np.where(high > low, high - low, 1.0)  # of neighbouring numbers there is none between
    bend = 2.0 * (drop - rise) / width
    safe = np.where(bend < 0.0, bend, -1.0)
    slope = (rise * (high - at) + drop * (at - low)) / width
    vertex = np.clip(np.where(bend < 0.0, at - slope / safe, at), low, high)
    fall = 1.0 - np.minimum(three[:, 0], three[:, 2]) / three[:, 1]
    same = tops.some(bracket)
    return same._replace(
        low=low, at=at, high=high, vertex=vertex, bend=-bend / three[:, 1], fall=fall
    )


def _fitted(values_at: ValuesAt, tops: _Tops) -> tuple[Maxima, BoolArray]:
    """Maxima (n,) of polynomials about tops, and which of them tell where the maximum is."""
    room = 0.5 * (tops.high - tops.low)
    # at first as wide as serves; where a kink was too near, within what is left
    first = np.isinf(tops.tried)
    low, high = np.where(first, tops.least, tops.low), np.where(first, tops.most, tops.high)
    most = 0.5 * (high - low)
    half = np.minimum(REACH / np.sqrt(np.maximum(tops.bend, np.square(REACH / most))), most)
    centre = np.clip(tops.vertex, low + half, high - half)
    values = values_at(tops.row, centre[:, None] + half[:, None] * _NODES)
    scale = np.max(values, axis=1)
    power = (values / scale[:, None] - 1.0) @ _POWERS
    x = np.zeros(len(half))
    for _ in range(6):
        slope, second = _slopes(power, x)
        step = np.where(second < 0.0, slope / np.where(second < 0.0, second, 1.0), 0.0)
        x = np.clip(x - step, -1.0, 1.0)
    second = np.minimum(_slopes(power, x)[1], -1e-300)
    rough = np.max(np.abs(power[:, 7:]) / np.array([64.0, 128.0]), axis=1)
    # across a kink all coefficients are alike
    smooth = (rough <= -1e-3 * second) & (np.abs(x) < 1.0)
    told = smooth & (rough <= SMOOTH)
    off = half * (8.0 * rough + SHIFT * EPSILON) / -second
    place, off = centre + half * x, np.where(smooth, np.minimum(off, 2.0 * room), 2.0 * room)
    # next to a kink as near as values tell; where rounding is more, what was better before
    near = ~told & _narrow(tops)
    place = np.where(smooth, place, tops.at)
    worse = ~told & (off >= tops.off)
    place, off = np.where(worse, tops.place, place), np.where(worse, tops.off, off)
    height, bend = values_at(tops.row, place[:, None])[:, 0], second * scale / np.square(half)
    # of what is not smooth, all that the values close about the top differ by
    lost = np.where(told, 0.5 * np.abs(bend) * np.square(off), scale - np.min(values, axis=1))
    found = Bounded(place, off + 8.0 * EPSILON * np.abs(place))
    return Maxima(tops.row, found, Bounded(height, lost), bend), told | near | worse


def _narrow(tops: _Tops) -> BoolArray:
    """Brackets within which values tell no more."""
    room = 1e-12 * np.maximum(np.abs(tops.at), tops.most - tops.least)
    return np.asarray((tops.fall <= 1e-13) | (tops.high - tops.low <= 2.0 * room))


def _slopes(power: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of polynomials (n, 9) at one place each."""
    first, second = np.zeros((2, len(x)))
    for k in range(8, 0, -1):
        second = second * x + first
        first = first * x + k * power[:, k]
    return first, second


def first_highest(found: Sequence[Maxima]) -> Maxima:
    """Of each curve one; of maxima that are alike the one at the lowest place, whose error holds
    what the highest of them has more."""
    none = np.zeros(0)
    nothing = Maxima(np.zeros(0, dtype=np.int64), Bounded(none, none), Bounded(none, none), none)
    every = joined([nothing, *found])
    height, error = every.height
    best = np.zeros(int(np.max(every.row, initial=-1)) + 1)
    np.maximum.at(best, every.row, height)
    alike = np.flatnonzero(height >= best[every.row] * (1.0 - CORNER))
    every = every._replace(height=Bounded(height, error + best[every.row] - height))
    # by rising place, so that the first one counts
    return every.some(alike[np.unique(every.row[alike], return_index=True)[1]])


# ----------------------------------------------------------------------------
# Where the maximum of a curve may be that is uncertain itself.
#
# It is at one of the places at which the curve and its error come up to the highest value less its
# error. Where that error is small these places lie close about the top, and what the slope of the
# error makes of it there says more, as long as no other top is among them.
# ----------------------------------------------------------------------------

#: relative error of a height that moves no maximum to another top, and one up to which the
#: curvature of a top holds for all places about it
SURE, FEW = 1e-8, 1e-2


def top_errors(
    place: Bounded, height: Bounded, at: FloatArray, curve: Bounded, alone: bool = False
) -> tuple[float, float]:
    """Errors of place and height of the maximum of a curve (n,), known with its error at places
    `at` (n,), rising.

    Those of `place` and `height` are of the top itself. `alone`: of a local maximum, which other
    ones take the place of only where the curve does not fall by its error in between.
    """
    if not height.error > SURE * height.value:
        return float(place.error), float(height.error)
    own = int(np.searchsorted(at, place.value))
    where = np.insert(at, own, place.value)
    value = np.insert(curve.value, own, height.value)
    upper = np.insert(curve.value + curve.error, own, height.value + height.error)
    level = height.value - height.error
    within = upper >= level
    if alone:
        within[own:] = np.logical_and.accumulate(within[own:])
        within[own::-1] = np.logical_and.accumulate(within[own::-1])
    few = height.error <= FEW * height.value
    if few:
        falls, rounding = np.ones(len(where), dtype=bool), CORNER * height.value
        falls[own + 1 :] = np.logical_and.accumulate(np.diff(value[own:]) <= rounding)
        falls[:own] = np.logical_and.accumulate(np.diff(value[own::-1]) <= rounding)[::-1]
        within &= ~falls
    reach = float(place.error) if few else 4.0 * UNIT_ROUNDOFF * abs(float(place.value))
    ends = np.flatnonzero(within)[[0, -1]].tolist() if np.any(within) else []
    for end, side in zip(ends, (-1, 1), strict=False):
        beside = min(max(end + side, 0), len(where) - 1)
        # on the way down from a top the level is farther away than a straight line says
        share = (upper[end] - level) / max(upper[end] - min(upper[beside], level), 1e-300)
        edge = where[end] + (where[beside] - where[end]) * np.sqrt(share)
        reach = max(reach, abs(float(edge - place.value)))
    highest = height.error if alone else np.max(upper) - height.value
    return reach, float(highest)
