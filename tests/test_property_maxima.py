"""Claim: the search for maxima finds every peak that its seeds can show, with place and height as
near as it says, against formulas and many digits."""

from collections.abc import Callable

import mpmath
import numpy as np
import pytest

from vibecalc.numerics.maxima import Jet, by_slopes, by_values
from vibecalc.numerics.rounding import FloatArray, IntArray


def resonance(p: float, z: float, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """|p^2 - x^2 + 2 i z p x|^2 with two derivatives; its differences keep their digits."""
    away, drag = (p - x) * (p + x), 2 * z * p
    first = -4 * x * away + 2 * drag * drag * x
    return away * away + (drag * x) ** 2, first, -4 * away + 8 * x * x + 2 * drag * drag


def curve(place: FloatArray, damping: FloatArray, x: FloatArray) -> Jet:
    """Sum of the reciprocals."""
    value, slope, bend = np.zeros((3, len(x)))
    for p, z in zip(place.tolist(), damping.tolist(), strict=True):
        below, first, second = resonance(p, z, x)
        value += 1.0 / below
        slope += -first / below**2
        bend += 2.0 * first**2 / below**3 - second / below**2
    return Jet(value, 8e-16 * value, slope, bend)


def seeds_of(place: FloatArray, damping: FloatArray) -> FloatArray:
    about = place[:, None] * (1.0 + damping[:, None] * np.array([-3.0, -1.0, 0.0, 1.0, 3.0]))
    return np.concatenate([about.ravel(), [0.1 * place.min(), 10.0 * place.max()]])


@pytest.mark.parametrize(("place", "damping", "count"), [
    ([1.0], [0.1], 1),
    ([1.0], [1e-6], 1),
    ([1.0], [1e-12], 1),
    ([1.0, 2.0], [1e-6, 0.1], 2),
    ([1.0, 1.0001], [1e-6, 1e-6], 2),
    ([1.0, 1.001], [1e-2, 1e-6], 1),
    ([1.0, 1.5, 40.0], [0.02, 1e-6, 0.05], 3),
])  # fmt: skip
def test_resonances_are_found_as_in_forty_digits(
    place: list[float], damping: list[float], count: int
) -> None:
    places, dampings = np.array(place), np.array(damping)
    found = by_slopes(lambda _, x: curve(places, dampings, x), seeds_of(places, dampings)[None])
    assert len(found.row) == count
    with mpmath.workdps(60):
        held = [(mpmath.mpf(p), mpmath.mpf(z)) for p, z in zip(place, damping, strict=True)]

        def exact(x: mpmath.mpf) -> list[mpmath.mpf]:
            parts = [resonance(p, z, x) for p, z in held]
            return [mpmath.fsum(1 / below for below, _, _ in parts),
                    mpmath.fsum(-first / below**2 for below, first, _ in parts)]  # fmt: skip

        for i in range(count):
            at = mpmath.mpf(float(found.place.value[i]))
            near, level = (at, at + min(damping) * at / 1000), exact(at)[0]
            true = mpmath.findroot(lambda x, unit=level: exact(x)[1] / unit, near, tol=1e-50)
            assert abs(true - at) <= found.place.error[i]
            height = mpmath.mpf(float(found.height.value[i]))
            assert abs(exact(true)[0] - height) <= found.height.error[i]
            assert abs(true / at - 1) < 1e-15


def test_a_kink_upwards_a_flat_top_and_ends() -> None:
    def kink(_: IntArray, x: FloatArray) -> Jet:
        value = 2.0 - np.abs(x - np.pi) - 0.1 * (x - np.pi) ** 2
        slope = -np.sign(x - np.pi) - 0.2 * (x - np.pi)
        return Jet(value, 1e-16 * np.abs(value), slope, np.full(len(x), -0.2))

    found = by_slopes(kink, np.array([[0.0, 1.0, 5.0]]))
    assert found.place.value == pytest.approx([np.pi], abs=1e-14)
    assert np.all(np.abs(found.place.value - np.pi) <= found.place.error + 1e-15)

    def flat(_: IntArray, x: FloatArray) -> Jet:
        y = x - 2.0
        return Jet(1.0 - y**4, 2e-16 * np.ones(len(x)), -4.0 * y**3, -12.0 * y**2)

    found = by_slopes(flat, np.array([[0.5, 1.0, 3.3]]))
    assert len(found.row) == 1
    assert abs(found.place.value[0] - 2.0) < 1e-3
    assert found.height.value[0] == pytest.approx(1.0, abs=1e-15)

    # a curve that rises, falls or stays throughout has its highest value at an end
    for slope in (1.0, -1.0, 0.0):
        line = by_slopes(
            lambda _, x, s=slope: Jet(3.0 + s * x, 0.0 * x, s + 0.0 * x, 0.0 * x),  # type: ignore[misc]
            np.array([[0.0, 1.0, 2.0, np.nan]]),
        )
        assert len(line.row) == 0


def test_a_pair_of_extremes_between_two_seeds_is_looked_for() -> None:
    # a cubic slope with three zeros, all between two seeds
    def curve_of(_: IntArray, x: FloatArray) -> Jet:
        y = x - 1.6
        slope, bend = -(y**3) + 0.25 * y, 0.25 - 3.0 * y * y
        value = 5.0 - y**4 / 4 + 0.125 * y**2
        return Jet(value, 1e-15 * value, slope, bend)

    found = by_slopes(curve_of, np.array([[0.9, 2.3]]))
    assert found.place.value == pytest.approx([1.1, 2.1], abs=1e-12)


# ----------------------------------------------------------------------------
# Curves that give values only.
# ----------------------------------------------------------------------------


@pytest.mark.parametrize("damping", [0.2, 1e-2, 1e-6, 1e-9])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.97])
def test_a_resonance_by_values_is_where_it_is(damping: float, share: float) -> None:
    width = 0.7 * damping
    low, high = 1.0 - share * width, 1.0 + (1.0 - share) * width

    def values_at(_: IntArray, x: FloatArray) -> FloatArray:
        return 1.0 / np.sqrt(resonance(1.0, damping, x)[0])

    # highest at x^2 = 1 - 2 z^2
    true = np.sqrt(1.0 - 2.0 * damping**2)
    low, high = low + true - 1.0, high + true - 1.0
    at = np.array([true + 0.1 * (low - true)])
    found = by_values(values_at, np.array([0]), np.array([low]), at, np.array([high]))
    close = 1e-10 * width + 4e-15 + 1e-20 / width
    assert abs(found.place.value[0] - true) <= found.place.error[0] <= close
    top = 1.0 / (2.0 * damping * np.sqrt(1.0 - damping**2))
    assert abs(found.height.value[0] - top) <= found.height.error[0] + 1e-14 * top


@pytest.mark.parametrize("centre", [0.0, 1.0])
def test_by_values_ends_at_a_corner_and_where_a_curve_is_flat(centre: float) -> None:
    ends = np.array([centre - 0.3]), np.array([centre + 0.01]), np.array([centre + 0.5])

    def corner(_: IntArray, x: FloatArray) -> FloatArray:
        return np.asarray(2.0 - np.abs(x - centre))

    found = by_values(corner, np.array([0]), *ends)
    assert abs(found.place.value[0] - centre) <= found.place.error[0] < 1e-11

    def flat(_: IntArray, x: FloatArray) -> FloatArray:
        return np.asarray(2.0 - (x - centre) ** 8)

    found = by_values(flat, np.array([0]), *ends)
    assert found.height.value[0] == pytest.approx(2.0, abs=1e-14)
    assert abs(found.place.value[0] - centre) < 0.02


# ----------------------------------------------------------------------------
# Of two peaks that a kink parts within one step of a sweep the higher one is found.
# ----------------------------------------------------------------------------


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
