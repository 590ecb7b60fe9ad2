"""Extremes of a result along one key: valleys between samples, then Brent's parabolas.

Brent, Algorithms for Minimization without Derivatives (1973), chapter 5. A minimum between two
samples that are certainly higher lies between them, whatever the curve does there: that, closed in
as far as the error of the result allows, is the error of its place. On a flat top it goes with the
root of the result's error.
"""

import math
from collections.abc import Callable, Iterator

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.study.find_course import Course, Sample, Solution

Height = Callable[[Sample], float]
Valley = tuple[Sample, Sample, Sample]

#: a failure inside a valley cuts it, and what is left is looked at again
ROUNDS = 4
_FINEST = 1e-9
_NARROWINGS = 12


def extremes(course: Course, sign: float) -> list[Solution]:
    """All minima (sign 1) or maxima (-1) between the bounds, best first; bounds are none."""

    def height(sample: Sample) -> float:
        return sign * sample.value

    done: list[Valley] = []
    for _ in range(ROUNDS):
        new = [valley for valley in valleys(course, height) if not _within(valley, done)]
        if not new:
            break
        for valley in new:
            try:
                bottom(course, height, valley)
            except NumericalFailure:
                continue
            done.append(valley)
    found = [_solution(course, height, valley) for valley in done]
    return sorted(found, key=lambda solution: height(solution.sample))


def valleys(course: Course, height: Height) -> Iterator[Valley]:
    """A lowest sample between the nearest ones that are certainly higher, on both sides."""
    for stretch in course.stretches():
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
    course: Course, height: Height, valley: Valley, enough: float = -math.inf
) -> Sample | None:
    """Close in on the bottom of a valley; ends early below `enough`. NumericalFailure inside it."""
    from scipy.optimize import minimize_scalar

    left, low, right = valley
    span = right.place - left.place
    # places from 1 to 2, so that a relative tolerance counts along the valley
    middle = 1.0 + (low.place - left.place) / span
    known = {1.0: left, middle: low, 2.0: right}

    def function(scaled: float) -> float:
        at = known.get(scaled) or course.at(left.place + (scaled - 1.0) * span)
        if height(at) < enough:
            raise _Enough
        return height(at)

    depth = min(height(left), height(right)) - height(low)
    tolerance = max(_FINEST, 0.02 * math.sqrt(min(1.0, _doubt(low, low) / depth)))
    try:
        minimize_scalar(function, bracket=(1.0, middle, 2.0), method="brent", tol=tolerance)
    except _Enough:
        return None
    return _lowest(course, height, valley)


class _Enough(Exception):
    """Low enough."""


def _within(valley: Valley, done: list[Valley]) -> bool:
    return any(one[0].place <= valley[0].place and valley[2].place <= one[2].place for one in done)


def _wall(height: Height, low: Sample, others: list[Sample]) -> Sample | None:
    """The first that is certainly higher, if none before it is lower."""
    for other in others:
        rise = height(other) - height(low)
        if rise > _doubt(low, other):
            return other
        if rise < 0.0:
            return None
    return None


def _doubt(one: Sample, other: Sample) -> float:
    """What a difference of two results may be without being one."""
    return one.error + other.error + 4.0 * EPSILON * max(abs(one.value), abs(other.value))


def _lowest(course: Course, height: Height, valley: Valley) -> Sample:
    left, _, right = valley
    inside = [
        one for one in course.samples if left.place <= one.place <= right.place and not one.failure
    ]
    return min(inside, key=height)


def _solution(course: Course, height: Height, valley: Valley) -> Solution:
    low = _lowest(course, height, valley)
    (stretch,) = [stretch for stretch in course.stretches() if low in stretch]
    position = stretch.index(low)
    walls = []
    for others, end in (
        (stretch[:position][::-1], valley[0]),
        (stretch[position + 1 :], valley[2]),
    ):
        wall = _wall(height, low, others)
        walls.append(end if wall is None else _narrowed(course, height, low, wall))
    # a lower sample may have turned up while the walls were moved
    lowest = _lowest(course, height, valley)
    return Solution(lowest, course.spread(lowest, *walls))


def _narrowed(course: Course, height: Height, low: Sample, wall: Sample) -> Sample:
    """A nearer sample that is certainly higher, as a parabola through both has it."""
    factor = 1.25
    for _ in range(_NARROWINGS):
        distance = wall.place - low.place
        share = factor * math.sqrt(_doubt(low, wall) / (height(wall) - height(low)))
        step = max(share * abs(distance), course.resolution(low.place))
        if step > 0.6 * abs(distance):
            break
        try:
            nearer = course.at(low.place + math.copysign(step, distance))
        except NumericalFailure:
            break
        if height(nearer) - height(low) > _doubt(low, nearer):
            wall = nearer
        else:
            factor *= 1.5
    return wall
