"""A result along one key: where it has a wanted value, and its extremes."""

import bisect
import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import groupby, pairwise
from typing import NamedTuple

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# A result along one key of a case, as far as it has been computed.
# ----------------------------------------------------------------------------

#: value of the key in SI -> result and its absolute error; NumericalFailure where there is none
Evaluate = Callable[[float], tuple[float, float]]

#: bounds further apart than this, relatively, are walked in equal ratios
WIDE = 4.0
#: halvings towards the end of a stretch without results
HALVINGS = 6


class Sample(NamedTuple):
    """One value of the key: where it lies on the search, and the result there or why none."""

    place: float
    key: float
    value: float = math.nan
    error: float = math.inf
    failure: str = ""


class SampledCurve:
    """Samples between two bounds, in order; no value of the key is evaluated twice.

    Places are values of the key in SI, or their logarithms where both bounds are positive and
    far apart (`log`).
    """

    def __init__(self, evaluate: Evaluate, lower: float, upper: float):
        self._evaluate = evaluate
        self._ends = (lower, upper)
        self.log = lower > 0.0 and upper / lower > WIDE
        self.first, self.last = self.place_of(lower), self.place_of(upper)
        self.samples: list[Sample] = []
        self.evaluations = 0

    def place_of(self, key: float) -> float:
        """Place of a value of the key."""
        return math.log(key) if self.log else key

    def key_of(self, place: float) -> float:
        """Value of the key at a place, never outside the bounds."""
        lower, upper = self._ends
        if place <= self.first or place >= self.last:
            return lower if place <= self.first else upper
        return min(max(math.exp(place) if self.log else place, lower), upper)

    def resolution(self, place: float) -> float:
        """Distance of places that are still distinguished."""
        span = max(abs(place), 1.0 if self.log else 1e-6 * (self.last - self.first))
        return 4.0 * math.ulp(span)

    def know(self, key: float, value: float, error: float) -> None:
        """Take a result that is known already, if its key lies between the bounds."""
        if self._ends[0] <= key <= self._ends[1]:
            self._take(Sample(self.place_of(key), key, value, error))

    def at(self, place: float) -> Sample:
        """The sample at a place; NumericalFailure where there is no result."""
        place = float(place)
        position = bisect.bisect_left(self.samples, (place,))
        known = self.samples[position : position + 1]
        if not known or known[0].place != place:
            known = [self._computed(place)]
        if known[0].failure:
            raise NumericalFailure(known[0].failure)
        return known[0]

    def sample(self, points: int) -> None:
        """Sample evenly spread places, then close in on stretches without results."""
        step = (self.last - self.first) / (points - 1)
        for number in range(points):
            place = self.first + number * step if number < points - 1 else self.last
            self._try(place)
        for _ in range(HALVINGS):
            for one, other in list(pairwise(self.samples)):
                if bool(one.failure) != bool(other.failure):
                    self._try(0.5 * (one.place + other.place))

    def stretches(self) -> Iterator[list[Sample]]:
        """Samples with a result, cut where there is none between two of them."""
        for failed, group in groupby(self.samples, key=lambda sample: bool(sample.failure)):
            if not failed:
                yield list(group)

    def failed(self) -> list[Sample]:
        """Samples without a result."""
        return [sample for sample in self.samples if sample.failure]

    def spread(self, centre: Sample, *nearby: Sample) -> float:
        """Largest distance from a sample to others, in the unit of the key, with its rounding."""
        far = max((abs(one.key - centre.key) for one in nearby), default=0.0)
        return far + 4.0 * math.ulp(centre.key)

    def _try(self, place: float) -> None:
        with suppress(NumericalFailure):  # kept with its words
            self.at(place)

    def _computed(self, place: float) -> Sample:
        key = self.key_of(place)
        self.evaluations += 1
        try:
            value, error = self._evaluate(key)
            sample = Sample(place, key, value, error)
            if not math.isfinite(value):
                sample = Sample(place, key, failure="the result is not a finite number there")
        except NumericalFailure as failure:
            sample = Sample(place, key, failure=str(failure))
        self._take(sample)
        return sample

    def _take(self, sample: Sample) -> None:
        bisect.insort(self.samples, sample, key=lambda one: one.place)


class Solution(NamedTuple):
    """A sample that is what was sought, and the absolute error of its key."""

    sample: Sample
    error: float


# ----------------------------------------------------------------------------
# Extremes of a result along one key: valleys between samples, then Brent's parabolas.
#
# Brent, Algorithms for Minimization without Derivatives (1973), chapter 5. A minimum between two
# samples that are certainly higher lies between them, whatever the curve does there: that, closed
# in as far as the error of the result allows, is the error of its place. On a flat top it goes with
# the root of the result's error.
# ----------------------------------------------------------------------------

Height = Callable[[Sample], float]
Valley = tuple[Sample, Sample, Sample]

#: a failure inside a valley cuts it, and what is left is examined again
ROUNDS = 4
_FINEST = 1e-9
_NARROWINGS = 12


def extremes(curve: SampledCurve, sign: float) -> list[Solution]:
    """All minima (sign 1) or maxima (-1) between the bounds, best first; bounds are none."""

    def height(sample: Sample) -> float:
        return sign * sample.value

    done: list[Valley] = []
    for _ in range(ROUNDS):
        new = [valley for valley in valleys(curve, height) if not _within(valley, done)]
        if not new:
            break
        for valley in new:
            try:
                bottom(curve, height, valley)
            except NumericalFailure:
                continue
            done.append(valley)
    solutions = [_solution(curve, height, valley) for valley in done]
    return sorted(solutions, key=lambda solution: height(solution.sample))


def valleys(curve: SampledCurve, height: Height) -> Iterator[Valley]:
    """A lowest sample between the nearest ones that are certainly higher, on both sides."""
    for stretch in curve.stretches():
        known: set[tuple[float, float]] = set()
        for position, low in enumerate(stretch):
            left = _wall(height, low, stretch[:position][::-1])
            right = _wall(height, low, stretch[position + 1 :])
            if left is None or right is None or (left.place, right.place) in known:
                continue
            known.add((left.place, right.place))
            inside = [one for one in stretch if left.place < one.place < right.place]
            yield left, min(inside, key=height), right


def bottom(
    curve: SampledCurve, height: Height, valley: Valley, enough: float = -math.inf
) -> Sample | None:
    """Close in on the bottom of a valley; ends early below `enough`. NumericalFailure inside it."""
    from scipy.optimize import minimize_scalar

    left, low, right = valley
    span = right.place - left.place
    # places from 1 to 2, so that a relative tolerance counts along the valley
    middle = 1.0 + (low.place - left.place) / span
    known = {1.0: left, middle: low, 2.0: right}

    def function(scaled: float) -> float:
        at = known.get(scaled) or curve.at(left.place + (scaled - 1.0) * span)
        if height(at) < enough:
            raise _LowEnough
        return height(at)

    depth = min(height(left), height(right)) - height(low)
    tolerance = max(_FINEST, 0.02 * math.sqrt(min(1.0, _uncertainty(low, low) / depth)))
    try:
        minimize_scalar(function, bracket=(1.0, middle, 2.0), method="brent", tol=tolerance)
    except _LowEnough:
        return None
    return _lowest(curve, height, valley)


class _LowEnough(Exception):
    """Low enough."""


def _within(valley: Valley, done: list[Valley]) -> bool:
    return any(one[0].place <= valley[0].place and valley[2].place <= one[2].place for one in done)


def _wall(height: Height, low: Sample, others: list[Sample]) -> Sample | None:
    """The first that is certainly higher, if none before it is lower."""
    for other in others:
        increase = height(other) - height(low)
        if increase > _uncertainty(low, other):
            return other
        if increase < 0.0:
            return None
    return None


def _uncertainty(one: Sample, other: Sample) -> float:
    """What a difference of two results may be without being one."""
    return one.error + other.error + 4.0 * EPSILON * max(abs(one.value), abs(other.value))


def _lowest(curve: SampledCurve, height: Height, valley: Valley) -> Sample:
    left, _, right = valley
    inside = [
        one for one in curve.samples if left.place <= one.place <= right.place and not one.failure
    ]
    return min(inside, key=height)


def _solution(curve: SampledCurve, height: Height, valley: Valley) -> Solution:
    low = _lowest(curve, height, valley)
    (stretch,) = [stretch for stretch in curve.stretches() if low in stretch]
    position = stretch.index(low)
    walls = []
    for others, end in (
        (stretch[:position][::-1], valley[0]),
        (stretch[position + 1 :], valley[2]),
    ):
        wall = _wall(height, low, others)
        walls.append(end if wall is None else _narrowed(curve, height, low, wall))
    # a lower sample may have turned up while the walls were moved
    lowest = _lowest(curve, height, valley)
    return Solution(lowest, curve.spread(lowest, *walls))


def _narrowed(curve: SampledCurve, height: Height, low: Sample, wall: Sample) -> Sample:
    """A nearer sample that is certainly higher, as a parabola through both has it."""
    factor = 1.25
    for _ in range(_NARROWINGS):
        distance = wall.place - low.place
        share = factor * math.sqrt(_uncertainty(low, wall) / (height(wall) - height(low)))
        step = max(share * abs(distance), curve.resolution(low.place))
        if step > 0.6 * abs(distance):
            break
        try:
            nearer = curve.at(low.place + math.copysign(step, distance))
        except NumericalFailure:
            break
        if height(nearer) - height(low) > _uncertainty(low, nearer):
            wall = nearer
        else:
            factor *= 1.5
    return wall


# ----------------------------------------------------------------------------
# Where a result along one key has a wanted value: brackets between samples, then Brent's method.
#
# Brent, Algorithms for Minimization without Derivatives (1973), chapter 4. The error of a solution
# is the distance to the nearest samples on both sides that are certainly off the wanted value,
# closed in as far as the error of the result allows: that error over the slope, where the curve is
# steep.
# ----------------------------------------------------------------------------

#: a value this far off after closing in, over those at the bracket, is a jump and no crossing
_JUMP = 1e-6


class Level(NamedTuple):
    """The wanted value and its own error."""

    wanted: float
    uncertainty: float

    def off(self, sample: Sample) -> float:
        """How far a result is above the wanted value."""
        return sample.value - self.wanted

    def unsure(self, sample: Sample) -> float:
        """What that may be without being anything."""
        rounding = 2.0 * EPSILON * (abs(sample.value) + abs(self.wanted))
        return sample.error + self.uncertainty + rounding

    def side(self, sample: Sample) -> int:
        """1 where a result is certainly above the wanted value, -1 below, 0 where neither is."""
        off = self.off(sample)
        return 0 if abs(off) <= self.unsure(sample) else int(math.copysign(1.0, off))


class Roots(NamedTuple):
    """Solutions along the key, and samples next to which the result jumps past the wanted value."""

    solutions: list[Solution]
    jumps: list[Sample]


def roots(curve: SampledCurve, level: Level) -> Roots:
    """All places between the samples of `curve` where the result has the wanted value.

    Two solutions closer together than samples are found where the curve between them shows; what
    lies next to or between failed samples is not claimed. NumericalFailure where all samples are
    solutions.
    """
    if all(level.side(one) == 0 for stretch in curve.stretches() for one in stretch):
        raise NumericalFailure("the result has the wanted value everywhere between the bounds")
    if not list(_crossings(curve, level)):
        _nearest_dip(curve, level)
    _dips(curve, level)
    done: list[tuple[Sample, Sample]] = []
    ends: list[Solution] = []
    jumps: list[Sample] = []
    for _ in range(ROUNDS):
        for one, other in [pair for pair in _crossings(curve, level) if not _tried(pair, done)]:
            try:
                end = _closed_in(curve, level, one, other)
            except NumericalFailure:
                continue  # a sample without a result now cuts the bracket
            done.append((one, other))
            size = _JUMP * (abs(level.off(one)) + abs(level.off(other)))
            if abs(level.off(end)) > max(size, 8.0 * level.unsure(end)):
                jumps.append(end)
            elif level.side(end) != 0:
                near = [pair for pair in _crossings(curve, level) if end in pair]
                nearby = [sample for pair in near for sample in pair]
                if nearby:  # else a sample next to it is a solution, and stands for both
                    ends.append(Solution(end, curve.spread(end, *nearby)))
    groups = [group for stretch in curve.stretches() for group in _groups(stretch, level)]
    ends += [_root(curve, level, group) for group in groups]
    return Roots(_merged(sorted(ends, key=lambda solution: solution.sample.place), level), jumps)


def _crossings(curve: SampledCurve, level: Level) -> Iterator[tuple[Sample, Sample]]:
    """Neighbours on different sides of the wanted value, both certainly."""
    for stretch in curve.stretches():
        for one, other in pairwise(stretch):
            if level.side(one) * level.side(other) < 0:
                yield one, other


def _tried(pair: tuple[Sample, Sample], done: list[tuple[Sample, Sample]]) -> bool:
    return any(one.place <= pair[0].place and pair[1].place <= other.place for one, other in done)


def _closed_in(curve: SampledCurve, level: Level, one: Sample, other: Sample) -> Sample:
    from scipy.optimize import brentq

    def function(place: float) -> float:
        sample = curve.at(place)
        off = level.off(sample)
        return 0.0 if abs(off) <= 0.25 * level.unsure(sample) else off

    tolerance = curve.resolution(one.place)
    place = brentq(function, one.place, other.place, xtol=tolerance, rtol=4.0 * EPSILON)
    return curve.at(float(place))


def _dips(curve: SampledCurve, level: Level) -> None:
    """Look between samples where the curve turns so near the wanted value that it may pass it."""
    for dip in _turning(curve, level):
        left, low, right = (abs(level.off(one)) for one in dip)
        if level.side(dip[1]) == 0 or _vertex(dip, left, low, right) <= max(left, right) - low:
            _look_into(curve, level, dip)


def _nearest_dip(curve: SampledCurve, level: Level) -> None:
    dips = list(_turning(curve, level))
    if dips:
        _look_into(curve, level, min(dips, key=lambda dip: abs(level.off(dip[1]))))


def _turning(curve: SampledCurve, level: Level) -> list[Valley]:
    """Three samples on one side of the wanted value, the middle one nearest to it or there."""
    return [
        dip
        for dip in valleys(curve, lambda sample: abs(level.off(sample)))
        if level.side(dip[0]) == level.side(dip[2]) != 0
        and level.side(dip[1]) != -level.side(dip[0])
    ]


def _look_into(curve: SampledCurve, level: Level, dip: Valley) -> None:
    side, beyond = level.side(dip[0]), -2.0 * level.unsure(dip[1])
    with suppress(NumericalFailure):  # kept among the samples with its words
        bottom(curve, lambda sample: side * level.off(sample), dip, enough=beyond)


def _vertex(dip: Valley, left: float, low: float, right: float) -> float:
    """Lowest value of the parabola through three samples."""
    before, after = dip[1].place - dip[0].place, dip[2].place - dip[1].place
    falling, rising = (low - left) / before, (right - low) / after
    curvature = (rising - falling) / (before + after)
    slope = (falling * after + rising * before) / (before + after)
    return low - slope * slope / (4.0 * curvature)


def _groups(stretch: list[Sample], level: Level) -> Iterator[list[Sample]]:
    """Neighbours that are all solutions, with the certain samples next to them, if any."""
    sides = [level.side(one) for one in stretch]
    start = 0
    for zero, members in groupby(sides, key=lambda side: side == 0):
        stop = start + len(list(members))
        if zero:
            yield stretch[max(start - 1, 0) : stop + 1]
        start = stop


def _merged(ends: list[Solution], level: Level) -> list[Solution]:
    """One solution where errors overlap, as they do where a curve touches the wanted value."""
    merged: list[Solution] = []
    for end in ends:
        last = merged[-1] if merged else end
        if last is not end and end.sample.key - last.sample.key <= end.error + last.error:
            low = min(one.sample.key - one.error for one in (last, end))
            high = max(one.sample.key + one.error for one in (last, end))
            best = min((last, end), key=lambda one: abs(level.off(one.sample))).sample
            merged[-1] = Solution(best, max(high - best.key, best.key - low))
        else:
            merged.append(end)
    return merged


def _root(curve: SampledCurve, level: Level, group: list[Sample]) -> Solution:
    best = min(group, key=lambda sample: abs(level.off(sample)))
    nearby = [
        _root_narrowed(curve, level, best, one) for one in (group[0], group[-1]) if one is not best
    ]
    return Solution(best, curve.spread(best, *nearby))


def _root_narrowed(curve: SampledCurve, level: Level, best: Sample, beyond: Sample) -> Sample:
    """A nearer sample that is certainly off the wanted value, as the slope has it."""
    factor, side = 2.0, level.side(beyond)
    for _ in range(_NARROWINGS if side else 0):
        distance = beyond.place - best.place
        off = level.unsure(best) + abs(level.off(best))
        step = factor * off / abs(level.off(beyond)) * abs(distance)
        step = max(step, curve.resolution(best.place))
        if step > 0.6 * abs(distance):
            break
        try:
            nearer = curve.at(best.place + math.copysign(step, distance))
        except NumericalFailure:
            break
        if level.side(nearer) == side:
            beyond = nearer
        else:
            factor *= 2.0
    return beyond
