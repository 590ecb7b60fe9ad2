"""A result along one key: where it has a wanted value, and its extremes."""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import groupby, pairwise
from typing import NamedTuple, TypeVar

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# A result along one key of a case, as far as it has been computed.
# ----------------------------------------------------------------------------

#: value of the key in SI -> result and its absolute error; NumericalFailure where there is none
Evaluate = Callable[[float], tuple[float, float]]
#: told of values of the key that are about to be evaluated, it may compute them at once
Ahead = Callable[[list[float]], None]

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


class Solution(NamedTuple):
    """A sample that is what was sought, and the absolute error of its key."""

    sample: Sample
    error: float


class SampledCurve:
    """Samples between two bounds, in order; no value of the key is evaluated twice.

    Places are values of the key in SI, or their logarithms where both bounds are positive and
    far apart.
    """

    def __init__(
        self, evaluate: Evaluate, lower: float, upper: float, ahead: Ahead = lambda keys: None
    ):
        self._evaluate, self._ahead, self._ends = evaluate, ahead, (lower, upper)
        self._log = lower > 0.0 and upper / lower > WIDE
        self.first, self.last = (math.log(end) if self._log else end for end in self._ends)
        self._known: dict[float, Sample] = {}
        self.evaluations = 0

    def resolution(self, place: float) -> float:
        """Distance of places that are still distinguished."""
        span = max(abs(place), 1.0 if self._log else 1e-6 * (self.last - self.first))
        return 4.0 * math.ulp(span)

    def know(self, key: float, value: float, error: float) -> None:
        """Take a result that is known already, if its key lies between the bounds."""
        if self._ends[0] <= key <= self._ends[1]:
            place = math.log(key) if self._log else key
            self._known[place] = Sample(place, key, value, error)

    @property
    def samples(self) -> list[Sample]:
        """All samples, in order."""
        return [self._known[place] for place in sorted(self._known)]

    def look(self, place: float) -> Sample:
        """The sample at a place, with its words where there is no result."""
        if place not in self._known:
            key, value, error = self._key(place), math.nan, math.inf
            self.evaluations += 1
            try:
                value, error = self._evaluate(key)
                why = "" if math.isfinite(value) else "the result is not a finite number there"
            except NumericalFailure as failure:
                why = str(failure)
            self._known[place] = Sample(place, key, value, error, why)
        return self._known[place]

    def _key(self, place: float) -> float:
        (lower, upper), key = self._ends, math.exp(place) if self._log else place
        if place <= self.first or place >= self.last:
            key = lower if place <= self.first else upper
        return min(max(key, lower), upper)

    def at(self, place: float) -> Sample:
        """The sample at a place; NumericalFailure where there is no result."""
        sample = self.look(float(place))
        if sample.failure:
            raise NumericalFailure(sample.failure)
        return sample

    def sample(self, points: int) -> None:
        """Sample evenly spread places, then close in on stretches without results."""
        step = (self.last - self.first) / (points - 1)
        places = [self.first + number * step for number in range(points - 1)] + [self.last]
        self._ahead([self._key(place) for place in places if place not in self._known])
        for place in places:
            self.look(place)
        for _ in range(HALVINGS):
            for one, other in pairwise(self.samples):
                if bool(one.failure) != bool(other.failure):
                    self.look(0.5 * (one.place + other.place))

    def stretches(self) -> Iterator[list[Sample]]:
        """Samples with a result, cut where there is none between two of them."""
        for failed, group in groupby(self.samples, key=lambda sample: bool(sample.failure)):
            if not failed:
                yield list(group)

    def computed(self) -> list[Sample]:
        """Samples with a result."""
        return [sample for sample in self.samples if not sample.failure]

    def failed(self) -> list[Sample]:
        """Samples without a result."""
        return [sample for sample in self.samples if sample.failure]

    def between(self, left: Sample, right: Sample) -> list[Sample]:
        """Samples with a result from one to another."""
        return [one for one in self.computed() if left.place <= one.place <= right.place]


class Level(NamedTuple):
    """A value of the result and its own error: one that is wanted, or, with the `sense` of 1 or -1,
    a minimum or a maximum, which what is lower, or higher, is not off."""

    wanted: float
    uncertainty: float
    sense: float = 0.0

    def off(self, sample: Sample) -> float:
        """How far a result is from it."""
        apart = sample.value - self.wanted
        return self.sense * apart if self.sense else abs(apart)

    def unsure(self, sample: Sample) -> float:
        """What that may be without being anything."""
        rounding = 2.0 * EPSILON * (abs(sample.value) + abs(self.wanted))
        return sample.error + self.uncertainty + rounding

    def side(self, sample: Sample) -> int:
        """1 where a result is certainly above it, -1 below, 0 where neither is."""
        certain = self.off(sample) > self.unsure(sample)
        return int(math.copysign(certain, sample.value - self.wanted))

    def groups(self, stretch: list[Sample]) -> Iterator[list[Sample]]:
        """Neighbours that may all be there, with the certain samples next to them, if any."""
        start = 0
        for there, members in groupby(stretch, key=lambda one: self.side(one) == 0):
            stop = start + len(list(members))
            if there:
                yield stretch[max(start - 1, 0) : stop + 1]
            start = stop


# ----------------------------------------------------------------------------
# Valleys between samples, and what is certain about them.
# ----------------------------------------------------------------------------

Height = Callable[[Sample], float]
Valley = tuple[Sample, Sample, Sample]
#: first and last sample of what is looked into, and what else belongs to it
Bracket = TypeVar("Bracket", Valley, tuple[Sample, Sample])

#: a failure inside a valley cuts it, and what is left is examined again
ROUNDS = 4
_FINEST = 1e-9
_NARROWINGS = 12
#: of the way from a bound to the next sample, where it shows whether the curve falls from there
_NEXT = 1e-3


def valleys(curve: SampledCurve, height: Height) -> Iterator[Valley]:
    """A lowest sample between the nearest ones that are certainly higher, on both sides."""
    for stretch in curve.stretches():
        for position, low in enumerate(stretch):
            left = _wall(height, low, stretch[:position][::-1])
            right = _wall(height, low, stretch[position + 1 :])
            if left is not None and right is not None:
                inside = [one for one in stretch if left.place < one.place < right.place]
                yield left, min(inside, key=height), right


def bottom(curve: SampledCurve, height: Height, valley: Valley) -> None:
    """Close in on the bottom of a valley. NumericalFailure inside it."""
    from scipy.optimize import minimize_scalar

    left, low, right = valley
    span = right.place - left.place
    # places from 1 to 2, so that a relative tolerance counts along the valley
    middle = 1.0 + (low.place - left.place) / span
    known = {1.0: left, middle: low, 2.0: right}
    depth = min(height(left), height(right)) - height(low)
    minimize_scalar(
        lambda at: height(known.get(at) or curve.at(left.place + (at - 1.0) * span)),
        bracket=(1.0, middle, 2.0),
        method="brent",
        tol=max(
            _FINEST, 0.02 * math.sqrt(min(1.0, Level(low.value, low.error).unsure(low) / depth))
        ),
    )


def look_next_to_ends(curve: SampledCurve, height: Height) -> None:
    """Sample where a curve falls from the end of a stretch on: the end is then a higher neighbour.

    Without it a valley between a bound and the next sample would have no wall on that side.
    """
    for stretch in list(curve.stretches()):
        for end, other in ((stretch[0], stretch[1:2]), (stretch[-1], stretch[-2:-1])):
            if other and height(end) <= height(other[0]):
                curve.look(end.place + _NEXT * (other[0].place - end.place))


def _wall(height: Height, low: Sample, others: list[Sample]) -> Sample | None:
    """The first that is certainly higher, if none before it is lower."""
    level = Level(low.value, low.error)
    for other in others:
        increase = height(other) - height(low)
        if increase > level.unsure(other):
            return other
        if increase < 0.0:
            return None
    return None


def _solution(
    curve: SampledCurve, group: list[Sample], level: Level, power: float = 1.0
) -> Solution:
    """The sample of a group nearest to a level, as uncertain as those on both sides that are
    certainly off are far.

    From the ends of the group steps go towards it, as long as what they meet is certainly off:
    shares of the way as the slope has it, or a parabola, of which the `power` is 1/2.
    """
    off, unsure = level.off, level.unsure
    best, walls = min(group, key=off), []
    for wall in (group[0], group[-1]):
        factor = 1.5
        for _ in range(_NARROWINGS):
            distance = wall.place - best.place
            if off(wall) <= unsure(wall):
                break
            share = ((unsure(wall) + off(best)) / off(wall)) ** power
            step = max(factor * share * abs(distance), curve.resolution(best.place))
            if step > 0.6 * abs(distance):
                break
            nearer = curve.look(best.place + math.copysign(step, distance))
            if nearer.failure:
                break
            if off(nearer) > unsure(nearer):
                wall = nearer
            else:
                factor *= 2.0
        walls.append(wall)
    best = min(curve.between(*walls), key=off)  # a better one may have turned up
    far = max(abs(wall.key - best.key) for wall in walls)
    return Solution(best, far + 4.0 * math.ulp(best.key))


def _each(found: Callable[[], Iterator[Bracket]], work: Callable[[Bracket], None]) -> list[Bracket]:
    """All brackets that could be worked on; a sample without a result cuts one, and what is left of
    it is found again."""
    done: list[Bracket] = []
    for _ in range(ROUNDS):
        for one in list(found()):
            inside = (a[0].place <= one[0].place and one[-1].place <= a[-1].place for a in done)
            if not any(inside):
                with suppress(NumericalFailure):
                    work(one)
                    done.append(one)
    return done


# ----------------------------------------------------------------------------
# Extremes of a result along one key: valleys between samples, then Brent's parabolas.
#
# Brent, Algorithms for Minimization without Derivatives (1973), chapter 5. A minimum between two
# samples that are certainly higher lies between them, whatever the curve does there: that, closed
# in as far as the error of the result allows, is the error of its place. On a flat top it goes with
# the root of the result's error.
# ----------------------------------------------------------------------------


def extremes(curve: SampledCurve, sign: float) -> list[Solution]:
    """All minima (sign 1) or maxima (-1) between the bounds, best first; bounds are none."""

    def height(sample: Sample) -> float:
        return sign * sample.value

    look_next_to_ends(curve, height)
    found = []
    for left, _, right in _each(
        lambda: valleys(curve, height), lambda valley: bottom(curve, height, valley)
    ):
        inside = curve.between(left, right)
        low = min(inside, key=height)
        level = Level(low.value, low.error, sign)
        group = next(group for group in level.groups(inside) if low in group)
        found.append(_solution(curve, group, level, 0.5))
    return sorted(found, key=lambda solution: height(solution.sample))


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


def roots(curve: SampledCurve, level: Level) -> tuple[list[Solution], list[Sample]]:
    """All places between the samples of `curve` where the result has the wanted value, and samples
    next to which it jumps past that.

    Two solutions closer together than samples are found where the curve between them shows; what
    lies next to or between failed samples is not claimed. NumericalFailure where all samples are
    solutions.
    """
    from scipy.optimize import brentq

    if all(level.side(one) == 0 for one in curve.computed()):
        raise NumericalFailure("the result has the wanted value everywhere between the bounds")
    _look_into_dips(curve, level)
    groups: list[list[Sample]] = []
    jumps: list[Sample] = []

    def height(place: float) -> float:
        sample = curve.at(place)
        return 0.0 if level.off(sample) <= 0.25 * level.unsure(sample) else (
            sample.value - level.wanted
        )  # fmt: skip

    def close_in(pair: tuple[Sample, Sample]) -> None:
        (left, right), fine = (one.place for one in pair), curve.resolution(pair[0].place)
        end = curve.at(float(brentq(height, left, right, xtol=fine, rtol=4.0 * EPSILON)))
        if level.off(end) > max(_JUMP * sum(map(level.off, pair)), 8.0 * level.unsure(end)):
            jumps.append(end)
        elif level.side(end) != 0:  # else it is one of the samples that are solutions
            groups.extend(list(pair) for pair in _crossings(curve, level) if end in pair)

    _each(lambda: _crossings(curve, level), close_in)
    groups += [group for stretch in curve.stretches() for group in level.groups(stretch)]
    found = [_solution(curve, group, level) for group in groups]
    return _merged(sorted(found, key=lambda one: one.sample.place), level), jumps


def _crossings(curve: SampledCurve, level: Level) -> Iterator[tuple[Sample, Sample]]:
    """Neighbours on different sides of the wanted value, both certainly."""
    for stretch in curve.stretches():
        for one, other in pairwise(stretch):
            if level.side(one) * level.side(other) < 0:
                yield one, other


def _look_into_dips(curve: SampledCurve, level: Level) -> None:
    """Look between samples where the curve turns so near the wanted value that it may pass it.

    Three samples on one side of it, the middle one nearest or there, show that where the middle
    one is nearer to it than to its neighbours. Where nothing crosses, the nearest of all is looked
    into: it says how near the result comes.
    """

    def towards(side: int) -> Height:
        return lambda one: side * (one.value - level.wanted)

    look_next_to_ends(curve, level.off)
    dips = [
        (left, low, right)
        for left, low, right in dict.fromkeys(valleys(curve, level.off))
        if level.side(left) == level.side(right) != 0 and level.side(low) != -level.side(left)
    ]
    dips.sort(key=lambda dip: level.off(dip[1]))
    crossed = any(True for _ in _crossings(curve, level))
    for number, dip in enumerate(dips):
        left, low, right = map(level.off, dip)
        if low <= max(left, right) - low or (number == 0 and not crossed):
            with suppress(NumericalFailure):  # kept among the samples with its words
                bottom(curve, towards(level.side(dip[0])), dip)


def _merged(ends: list[Solution], level: Level) -> list[Solution]:
    """One solution where errors overlap, as they do where a curve touches the wanted value."""
    merged: list[Solution] = []
    for end in ends:
        last = merged[-1] if merged else end
        if last is not end and end.sample.key - last.sample.key <= end.error + last.error:
            low = min(one.sample.key - one.error for one in (last, end))
            high = max(one.sample.key + one.error for one in (last, end))
            best = min((last, end), key=lambda one: level.off(one.sample)).sample
            merged[-1] = Solution(best, max(high - best.key, best.key - low))
        else:
            merged.append(end)
    return merged
