"""A result along one key of a case, as far as it has been computed."""

import bisect
import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import groupby, pairwise
from typing import NamedTuple

from vibecalc.errors import NumericalFailure

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


class Course:
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
        """Distance of places that are still told apart."""
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

    def look(self, points: int) -> None:
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

    def spread(self, centre: Sample, *beside: Sample) -> float:
        """Largest distance from a sample to others, in the unit of the key, with its rounding."""
        far = max((abs(one.key - centre.key) for one in beside), default=0.0)
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
