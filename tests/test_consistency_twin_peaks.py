"""Claim: of two peaks that a kink parts within one step of a sweep the higher one is found."""

from collections.abc import Callable

import numpy as np
import pytest

from vibecalc.numerics.maxima import by_values
from vibecalc.numerics.rounding import FloatArray

Value = Callable[[FloatArray], FloatArray]
LOW, HIGH = np.array([99.0]), np.array([101.5])


def twins(first: float, second: float, rise: float) -> Value:
    """The higher of two resonances at `first` and `second`, the second one by `rise` higher."""

    def value(speed: np.ndarray) -> np.ndarray:
        one = 1.0 / (1.0 + ((speed - first) / 0.9) ** 2)
        other = (1.0 + rise) / (1.0 + ((speed - second) / 0.9) ** 2)
        return np.asarray(np.maximum(one, other))

    return value


def found(value: Value, at: float) -> tuple[float, float]:
    top = by_values(lambda _, where: value(where), np.array([0]), LOW, np.array([at]), HIGH)
    return float(top.place.value[0]), float(top.place.error[0])


@pytest.mark.parametrize("rise", [-3e-3, -1e-6, 1e-6, 2e-4, 3e-3])
@pytest.mark.parametrize("gap", [0.5, 0.8, 1.3])
def test_the_higher_one_is_found_from_either_side(gap: float, rise: float) -> None:
    first, second = 100.1 - 0.3 * gap, 100.1 + 0.7 * gap
    wanted = second if rise > 0.0 else first
    for at in (first, second):
        place, error = found(twins(first, second, rise), at)
        assert abs(place - wanted) <= error < 1e-6


def test_of_equal_ones_that_at_the_lowest_speed_counts() -> None:
    value = twins(99.8, 100.6, 0.0)
    for at in (99.7, 99.8, 100.6):
        assert abs(found(value, at)[0] - 99.8) < 1e-6
