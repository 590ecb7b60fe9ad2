"""Where a result along one key has a wanted value: brackets between samples, then Brent's method.

Brent, Algorithms for Minimization without Derivatives (1973), chapter 4. The error of a solution is
the distance to the nearest samples on both sides that are certainly off the wanted value, closed in
as far as the error of the result allows: that error over the slope, where the curve is steep.
"""

import math
from collections.abc import Iterator
from contextlib import suppress
from itertools import groupby, pairwise
from typing import NamedTuple

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.study.find_course import Course, Sample, Solution
from vibecalc.study.find_extremes import ROUNDS, Valley, bottom, valleys

_NARROWINGS = 12
#: a value this far off after closing in, over those at the bracket, is a jump and no crossing
_JUMP = 1e-6


class Level(NamedTuple):
    """The wanted value and its own error."""

    wanted: float
    doubt: float

    def off(self, sample: Sample) -> float:
        """How far a result is above the wanted value."""
        return sample.value - self.wanted

    def unsure(self, sample: Sample) -> float:
        """What that may be without being anything."""
        rounding = 2.0 * EPSILON * (abs(sample.value) + abs(self.wanted))
        return sample.error + self.doubt + rounding

    def side(self, sample: Sample) -> int:
        """1 where a result is certainly above the wanted value, -1 below, 0 where neither is."""
        off = self.off(sample)
        return 0 if abs(off) <= self.unsure(sample) else int(math.copysign(1.0, off))


class Roots(NamedTuple):
    """Solutions along the key, and samples beside which the result jumps past the wanted value."""

    solutions: list[Solution]
    jumps: list[Sample]


def roots(course: Course, level: Level) -> Roots:
    """All places between the samples of `course` where the result has the wanted value.

    Two solutions closer together than samples are found where the curve between them shows; what
    lies beside or between failed samples is not claimed. NumericalFailure where all samples are
    solutions.
    """
    if all(level.side(one) == 0 for stretch in course.stretches() for one in stretch):
        raise NumericalFailure("the result has the wanted value everywhere between the bounds")
    if not list(_crossings(course, level)):
        _nearest_dip(course, level)
    _dips(course, level)
    done: list[tuple[Sample, Sample]] = []
    ends: list[Solution] = []
    jumps: list[Sample] = []
    for _ in range(ROUNDS):
        for one, other in [pair for pair in _crossings(course, level) if not _within(pair, done)]:
            try:
                end = _closed_in(course, level, one, other)
            except NumericalFailure:
                continue  # a sample without a result now cuts the bracket
            done.append((one, other))
            size = _JUMP * (abs(level.off(one)) + abs(level.off(other)))
            if abs(level.off(end)) > max(size, 8.0 * level.unsure(end)):
                jumps.append(end)
            elif level.side(end) != 0:
                near = [pair for pair in _crossings(course, level) if end in pair]
                beside = [sample for pair in near for sample in pair]
                if beside:  # else a sample beside it is a solution, and stands for both
                    ends.append(Solution(end, course.spread(end, *beside)))
    groups = [group for stretch in course.stretches() for group in _groups(stretch, level)]
    ends += [_solution(course, level, group) for group in groups]
    return Roots(_merged(sorted(ends, key=lambda solution: solution.sample.place), level), jumps)


def _crossings(course: Course, level: Level) -> Iterator[tuple[Sample, Sample]]:
    """Neighbours on different sides of the wanted value, both certainly."""
    for stretch in course.stretches():
        for one, other in pairwise(stretch):
            if level.side(one) * level.side(other) < 0:
                yield one, other


def _within(pair: tuple[Sample, Sample], done: list[tuple[Sample, Sample]]) -> bool:
    return any(one.place <= pair[0].place and pair[1].place <= other.place for one, other in done)


def _closed_in(course: Course, level: Level, one: Sample, other: Sample) -> Sample:
    from scipy.optimize import brentq

    def function(place: float) -> float:
        sample = course.at(place)
        off = level.off(sample)
        return 0.0 if abs(off) <= 0.25 * level.unsure(sample) else off

    tolerance = course.resolution(one.place)
    place = brentq(function, one.place, other.place, xtol=tolerance, rtol=4.0 * EPSILON)
    return course.at(float(place))


def _dips(course: Course, level: Level) -> None:
    """Look between samples where the curve turns so near the wanted value that it may pass it."""
    for dip in _turning(course, level):
        left, low, right = (abs(level.off(one)) for one in dip)
        if level.side(dip[1]) == 0 or _vertex(dip, left, low, right) <= max(left, right) - low:
            _look_into(course, level, dip)


def _nearest_dip(course: Course, level: Level) -> None:
    dips = list(_turning(course, level))
    if dips:
        _look_into(course, level, min(dips, key=lambda dip: abs(level.off(dip[1]))))


def _turning(course: Course, level: Level) -> list[Valley]:
    """Three samples on one side of the wanted value, the middle one nearest to it or there."""
    return [
        dip
        for dip in valleys(course, lambda sample: abs(level.off(sample)))
        if level.side(dip[0]) == level.side(dip[2]) != 0
        and level.side(dip[1]) != -level.side(dip[0])
    ]


def _look_into(course: Course, level: Level, dip: Valley) -> None:
    side, beyond = level.side(dip[0]), -2.0 * level.unsure(dip[1])
    with suppress(NumericalFailure):  # kept among the samples with its words
        bottom(course, lambda sample: side * level.off(sample), dip, enough=beyond)


def _vertex(dip: Valley, left: float, low: float, right: float) -> float:
    """Lowest value of the parabola through three samples."""
    before, after = dip[1].place - dip[0].place, dip[2].place - dip[1].place
    falling, rising = (low - left) / before, (right - low) / after
    curvature = (rising - falling) / (before + after)
    slope = (falling * after + rising * before) / (before + after)
    return low - slope * slope / (4.0 * curvature)


def _groups(stretch: list[Sample], level: Level) -> Iterator[list[Sample]]:
    """Neighbours that are all solutions, with the certain samples beside them, if any."""
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


def _solution(course: Course, level: Level, group: list[Sample]) -> Solution:
    best = min(group, key=lambda sample: abs(level.off(sample)))
    beside = [
        _narrowed(course, level, best, one) for one in (group[0], group[-1]) if one is not best
    ]
    return Solution(best, course.spread(best, *beside))


def _narrowed(course: Course, level: Level, best: Sample, beyond: Sample) -> Sample:
    """A nearer sample that is certainly off the wanted value, as the slope has it."""
    factor, side = 2.0, level.side(beyond)
    for _ in range(_NARROWINGS if side else 0):
        distance = beyond.place - best.place
        rest = level.unsure(best) + abs(level.off(best))
        step = factor * rest / abs(level.off(beyond)) * abs(distance)
        step = max(step, course.resolution(best.place))
        if step > 0.6 * abs(distance):
            break
        try:
            nearer = course.at(best.place + math.copysign(step, distance))
        except NumericalFailure:
            break
        if level.side(nearer) == side:
            beyond = nearer
        else:
            factor *= 2.0
    return beyond
