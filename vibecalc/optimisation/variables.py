"""Variables between bounds, scaled to the unit cube; angles that go all the way around."""

from dataclasses import dataclass

import numpy as np

from vibecalc.numerics.rounding import EPSILON

#: share of a period that bounds may fall short of it and still hold all of it
_WHOLE = 1e-9
#: a variable whose positive bounds are further apart than this ratio is scaled by its logarithm
LOGARITHMIC_RATIO = 10.0


@dataclass(frozen=True)
class Box:
    """Bounds of n variables and the map between them and the unit cube.

    A stiffness between 1e3 and 1e6 N/m is as likely to be wanted near either end: variables with
    positive bounds a factor of 10 or more apart run logarithmically, all others linearly. Both
    ends of the unit interval give the bounds themselves, to the last bit.

    A variable that repeats itself after `period` (n,; 0: it does not) and whose bounds hold all of
    one has no bounds: the unit interval then runs through three periods, of which the middle one,
    from `lower` on, is where points are told (`fold`). A search that leaves it by one side goes on.
    """

    lower: np.ndarray
    upper: np.ndarray
    period: np.ndarray | None = None

    @property
    def around(self) -> np.ndarray:
        """(n,) whether a variable goes all the way around."""
        if self.period is None:
            return np.zeros(self.lower.size, dtype=bool)
        whole = self.upper - self.lower >= (1.0 - _WHOLE) * self.period
        return np.asarray((self.period > 0.0) & whole)

    def only(self, chosen: np.ndarray) -> "Box":
        """The box of some of the variables."""
        period = None if self.period is None else self.period[chosen]
        return Box(self.lower[chosen], self.upper[chosen], period)

    def start(self, unit: np.ndarray) -> np.ndarray:
        """Points spread over the unit cube as such that are spread over the bounds."""
        return np.where(self.around, (1.0 + unit) / 3.0, unit)

    def fold(self, unit: np.ndarray) -> np.ndarray:
        """The same points, with angles in the middle one of their three periods."""
        around = self.around
        if not np.any(around):
            return unit
        return np.where(around, (1.0 + self._turned(unit)) / 3.0, unit)

    def apart(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The shortest way from one point of the unit cube to the other, whole periods dropped."""
        way = np.asarray(other - one)
        return np.where(self.around, way - np.round(3.0 * way) / 3.0, way)

    @staticmethod
    def _turned(unit: np.ndarray) -> np.ndarray:
        """Share of a period; what rounding leaves just below a whole one is none."""
        share = (3.0 * unit) % 1.0
        return np.where(1.0 - share < 16.0 * EPSILON, 0.0, share)

    @property
    def logarithmic(self) -> np.ndarray:
        """(n,) whether a variable is scaled by its logarithm."""
        wide = (self.lower > 0) & (self.upper >= LOGARITHMIC_RATIO * self.lower)
        return np.asarray(wide & ~self.around)

    def values(self, unit: np.ndarray) -> np.ndarray:
        """Variables, (..., n), at points of the unit cube, (..., n)."""
        log = self.logarithmic
        lower = np.where(log, self.lower, 1.0)
        ratio = np.where(log, self.upper, 1.0) / lower
        linear = self.lower + (self.upper - self.lower) * unit
        inside = np.clip(np.where(log, lower * ratio**unit, linear), self.lower, self.upper)
        ends = np.where(unit <= 0, self.lower, np.where(unit >= 1, self.upper, inside))
        around = self.around
        if self.period is None or not np.any(around):
            return ends
        return np.where(around, self.lower + self.period * self._turned(unit), ends)

    def unit(self, values: np.ndarray) -> np.ndarray:
        """Points of the unit cube at the given variables; a variable without room gives 0."""
        width = self.upper - self.lower
        linear = np.where(width > 0, (values - self.lower) / np.where(width > 0, width, 1.0), 0.0)
        if self.period is not None:
            period = np.where(self.around, self.period, 1.0)
            turned = (1.0 + (values - self.lower) / period % 1.0) / 3.0
            linear = np.where(self.around, turned, linear)
        if not np.any(self.logarithmic):
            return np.clip(linear, 0.0, 1.0)
        log = self.logarithmic
        lower = np.where(log, self.lower, 1.0)
        ratio = np.where(log, self.upper, 2.0) / lower
        scaled = np.log(np.where(log, np.maximum(values, lower), lower) / lower) / np.log(ratio)
        return np.clip(np.where(log, scaled, linear), 0.0, 1.0)

    def slope(self, values: np.ndarray) -> np.ndarray:
        """Derivative of the variables by the coordinates of the unit cube, (n,)."""
        log = self.logarithmic
        ratio = np.where(log, self.upper, 1.0) / np.where(log, self.lower, 1.0)
        linear = self.upper - self.lower
        if self.period is not None:
            linear = np.where(self.around, 3.0 * self.period, linear)
        return np.where(log, values * np.log(ratio), linear)
