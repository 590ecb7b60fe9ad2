"""Severity of a vibration: grades, and zones between boundaries of r.m.s. values."""

import numpy as np

from vibecalc.numerics.bounded import Bounded, maximum
from vibecalc.numerics.rounding import FloatArray, IntArray

# ----------------------------------------------------------------------------
# Grades of reciprocating machines (ISO 10816-6:1995).
#
# A grade is one r.m.s. velocity between 10 and 250 Hz, one displacement below and one acceleration
# above, so that the three meet at these two frequencies. Grades go in steps of 10^(1/5) from
# 1.12 mm/s on; with d = v / (2 pi 10 Hz) and a = v 2 pi 250 Hz that is 17.8 um and 1.76 m/s^2.
# ----------------------------------------------------------------------------

#: rad/s, where displacement, velocity and acceleration of a grade meet
LOWER, UPPER = 2.0 * np.pi * 10.0, 2.0 * np.pi * 250.0
#: velocity of the lowest grade, r.m.s., m/s, and the ratio of each to the one before
LOWEST, RATIO = 1.12e-3, 10.0**0.2
#: names of the zones between three boundaries, and between two
_ZONES = {3: ("A", "B", "C", "D"), 2: ("A/B", "C", "D")}
_ROUNDING = 1e-9


def grade(number: int) -> dict[str, float]:
    """R.m.s. values by quantity, in m, m/s and m/s^2, of the grade with so many below it."""
    level = LOWEST * RATIO**number
    return {"displacement": level / LOWER, "velocity": level, "acceleration": level * UPPER}


def severity(displacement: Bounded, velocity: Bounded, acceleration: Bounded) -> Bounded:
    """Velocity, m/s, whose displacement and acceleration as of a grade are not exceeded either."""
    return maximum(maximum(velocity, displacement * LOWER), acceleration * (1.0 / UPPER))


def grade_number(severity: float) -> int:
    """Number of the lowest grade that a velocity as `severity` gives it, m/s, does not exceed."""
    steps = np.log(max(severity, LOWEST) / LOWEST) / np.log(RATIO)
    return int(np.ceil(steps - _ROUNDING))


def zones(values: FloatArray, boundaries: FloatArray) -> IntArray:
    """How many of the boundaries (b,), rising, each value (...) exceeds: 0 in the best zone."""
    return np.asarray(np.sum(np.asarray(values)[..., None] > boundaries, axis=-1))


def zone_names(boundaries: int) -> tuple[str, ...]:
    """Names of the zones between so many boundaries, the best first."""
    return _ZONES[boundaries]
