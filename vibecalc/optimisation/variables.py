"""Variables between bounds, scaled to the unit cube."""

from dataclasses import dataclass

import numpy as np

#: a variable whose positive bounds are further apart than this ratio is scaled by its logarithm
LOGARITHMIC_RATIO = 10.0


@dataclass(frozen=True)
class Box:
    """Bounds of n variables and the map between them and the unit cube.

    A stiffness between 1e3 and 1e6 N/m is as likely to be wanted near either end: variables with
    positive bounds a factor of 10 or more apart run logarithmically, all others linearly. Both
    ends of the unit interval give the bounds themselves, to the last bit.
    """

    lower: np.ndarray
    upper: np.ndarray

    @property
    def logarithmic(self) -> np.ndarray:
        """(n,) whether a variable is scaled by its logarithm."""
        return (self.lower > 0) & (self.upper >= LOGARITHMIC_RATIO * self.lower)

    def values(self, unit: np.ndarray) -> np.ndarray:
        """Variables, (..., n), at points of the unit cube, (..., n)."""
        log = self.logarithmic
        lower = np.where(log, self.lower, 1.0)
        ratio = np.where(log, self.upper, 1.0) / lower
        linear = self.lower + (self.upper - self.lower) * unit
        inside = np.clip(np.where(log, lower * ratio**unit, linear), self.lower, self.upper)
        return np.where(unit <= 0, self.lower, np.where(unit >= 1, self.upper, inside))

    def unit(self, values: np.ndarray) -> np.ndarray:
        """Points of the unit cube at the given variables; a variable without room gives 0."""
        width = self.upper - self.lower
        linear = np.where(width > 0, (values - self.lower) / np.where(width > 0, width, 1.0), 0.0)
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
        return np.where(log, values * np.log(ratio), self.upper - self.lower)
