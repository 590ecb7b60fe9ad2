"""Highest points of many curves at once: brackets, refinement, errors of place and height."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, BoolArray, FloatArray, IntArray

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
        return Maxima(*(part[which] for part in self))


def joined(parts: Sequence[Maxima]) -> Maxima:
    """Those of different curves, by curve and rising place."""
    row = np.concatenate([part.row for part in parts])
    place, height = (concatenate([part[i] for part in parts]) for i in (1, 2))
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
    plain = [np.concatenate(column) for column in zip(*(part[:3] for part in parts), strict=True)]
    jets = [
        Jet(*(np.concatenate(column) for column in zip(*side, strict=True)))
        for side in zip(*(part[3:] for part in parts), strict=True)
    ]
    return _Steps(*plain, *jets)


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
