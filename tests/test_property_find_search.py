"""Claim: along one key all solutions and extremes between samples are found, within their errors;
what is no solution (a jump, a pole, what lies next to failed points) is not taken for one.
"""

import math
from collections.abc import Callable

import pytest

from vibecalc.core.study.find_solutions import Level, SampledCurve, Solution, extremes, roots
from vibecalc.errors import NumericalFailure

Curve = Callable[[float], float]


def sampled_curve(
    curve: Curve, lower: float, upper: float, *, points: int = 33, error: float = 1e-13,
    rough: bool = False,
) -> SampledCurve:  # fmt: skip
    """A sampled curve; a rough one is off by its whole error, now up, now down."""

    def evaluate(key: float) -> tuple[float, float]:
        noise = error * (1.0 if math.sin(1e6 * key) > 0.0 else -1.0) if rough else 0.0
        return curve(key) + noise, error

    sampled = SampledCurve(evaluate, lower, upper)
    sampled.sample(points)
    return sampled


def found(curve: Curve, lower: float, upper: float, wanted: float, **more) -> list[Solution]:
    return roots(sampled_curve(curve, lower, upper, **more), Level(wanted, 0.0))[0]


def within(solutions: list[Solution], places: list[float]) -> None:
    assert [one.sample.key for one in solutions] == pytest.approx(places, rel=1e-2, abs=1e-3)
    for one, place in zip(solutions, places, strict=True):
        assert abs(one.sample.key - place) <= one.error


@pytest.mark.parametrize("rough", [False, True])
@pytest.mark.parametrize("error", [0.0, 1e-13, 1e-8, 1e-4])
def test_every_crossing_of_a_wave(error: float, rough: bool) -> None:
    places = [math.asin(0.5) + turn for turn in (0.0, 2.0 * math.pi / 3.0, 2.0 * math.pi)]
    places += [math.pi - math.asin(0.5) + 2.0 * math.pi]
    solutions = found(math.sin, 0.0, 10.0, 0.5, error=error, rough=rough)
    within(solutions, places)
    for one in solutions:  # steeper than 0.8 there
        assert one.error <= 10.0 * error + 1e-13


def test_a_bound_that_is_a_solution() -> None:
    within(found(lambda x: x * x, 1.0, 3.0, 1.0), [1.0])
    within(found(lambda x: x * x, 0.5, 3.0, 9.0), [3.0])


@pytest.mark.parametrize("middle", [1.501, 1.3])  # a sample is a solution, or none is near
def test_two_solutions_closer_than_samples(middle: float) -> None:
    def curve(x: float) -> float:
        return (x - middle) ** 2

    within(found(curve, 0.0, 4.0, 1e-6, points=9), [middle - 1e-3, middle + 1e-3])
    within(found(lambda x: -curve(x), 0.0, 4.0, -1e-6, points=9), [middle - 1e-3, middle + 1e-3])


@pytest.mark.parametrize("error", [1e-12, 1e-6])
def test_a_curve_that_only_touches(error: float) -> None:
    (one,) = found(lambda x: 2.0 + (x - 1.37) ** 2, 0.0, 4.0, 2.0, error=error, rough=True)
    assert abs(one.sample.key - 1.37) <= one.error <= 10.0 * math.sqrt(error)


def test_a_turn_that_stays_off_is_no_solution() -> None:
    sampled = sampled_curve(lambda x: 2.0 + (x - 1.37) ** 2, 0.0, 4.0)
    assert roots(sampled, Level(1.999, 0.0)) == ([], [])
    nearest = min(sampled.samples, key=lambda one: one.value)
    assert nearest.value == pytest.approx(2.0, abs=1e-9)


def test_jumps_and_poles_are_no_solutions() -> None:
    solutions, jumps = roots(sampled_curve(lambda x: math.floor(x), 0.3, 2.9), Level(1.5, 0.0))
    assert not solutions
    assert [one.key for one in jumps] == pytest.approx([2.0], abs=1e-9)

    def pole(x: float) -> float:
        return 1.0 / (x - 1.2345678 - 1e-20)

    solutions, jumps = roots(sampled_curve(pole, 0.0, 3.0), Level(0.7, 0.0))
    within(solutions, [1.2345678 + 1.0 / 0.7])
    assert [one.key for one in jumps] == pytest.approx([1.2345678], abs=1e-9)


def with_hole(low: float, high: float, curve: Curve) -> Curve:
    def broken(x: float) -> float:
        if low < x < high:
            raise NumericalFailure("nothing here")
        return curve(x)

    return broken


def test_a_solution_nearby_failed_points_counts_and_one_across_does_not() -> None:
    broken = with_hole(1.0, 2.0, lambda x: x**3)
    sampled = sampled_curve(broken, 0.0, 4.0, points=9)
    within(roots(sampled, Level(0.999**3, 0.0))[0], [0.999])
    within(roots(sampled, Level(2.003**3, 0.0))[0], [2.003])
    assert roots(sampled, Level(3.0, 0.0)) == ([], [])
    assert {one.failure for one in sampled.failed()} == {"nothing here"}


def test_a_failure_inside_a_bracket_leaves_the_rest_of_it() -> None:
    broken = with_hole(1.45, 1.55, lambda x: x**3)
    sampled = sampled_curve(broken, 0.0, 4.0, points=5)
    assert not sampled.failed()
    within(roots(sampled, Level(1.7**3, 0.0))[0], [1.7])
    assert not roots(sampled, Level(1.5**3, 0.0))[0]
    assert sampled.failed()


def test_not_a_number_and_infinity_are_failed_points() -> None:
    for bad in (math.nan, math.inf, -math.inf):
        sampled = sampled_curve(lambda x, bad=bad: bad if x > 2.0 else x, 0.0, 4.0)
        within(roots(sampled, Level(1.3, 0.0))[0], [1.3])
        assert "not a finite number" in sampled.failed()[0].failure


def test_all_values_are_solutions() -> None:
    with pytest.raises(NumericalFailure, match="everywhere between the bounds"):
        found(lambda x: 1.0, 0.0, 4.0, 1.0)


@pytest.mark.parametrize("rough", [False, True])
@pytest.mark.parametrize("error", [0.0, 1e-12, 1e-6])
def test_every_extreme_of_a_wave(error: float, rough: bool) -> None:
    sampled = sampled_curve(lambda x: math.sin(x) + 0.01 * x, 0.0, 15.0, error=error, rough=rough)
    place = math.acos(-0.01)
    lows = [2.0 * math.pi - place, 4.0 * math.pi - place]
    highs = [place, place + 2.0 * math.pi, place + 4.0 * math.pi]
    within(extremes(sampled, 1.0), lows)
    answer = extremes(sampled, -1.0)
    within(answer, highs[::-1])
    for one in answer:
        assert one.error <= 8.0 * math.sqrt(error) + 1e-6


def test_a_kink_and_a_fourth_power() -> None:
    (one,) = extremes(
        sampled_curve(lambda x: abs(x - 0.777), 0.0, 4.0, error=1e-9, rough=True), 1.0
    )
    assert abs(one.sample.key - 0.777) <= one.error <= 1e-5
    (one,) = extremes(sampled_curve(lambda x: (x - 0.777) ** 4, 0.0, 4.0, error=1e-12), 1.0)
    assert abs(one.sample.key - 0.777) <= one.error <= 0.02


@pytest.mark.parametrize("place", [0.003, 0.05, 0.1, 3.93, 3.997])
def test_an_extreme_between_a_bound_and_the_next_sample(place: float) -> None:
    for sign in (1.0, -1.0):
        sampled = sampled_curve(lambda x, sign=sign: sign * (x - place) ** 2, 0.0, 4.0)
        within(extremes(sampled, sign), [place])


def test_two_solutions_between_a_bound_and_the_next_sample() -> None:
    within(found(lambda x: (x - 0.05) ** 2, 0.0, 4.0, 1e-4), [0.04, 0.06])


def test_bounds_and_ends_of_stretches_are_no_extremes() -> None:
    assert not extremes(sampled_curve(lambda x: x, 0.0, 4.0), 1.0)
    broken = with_hole(1.0, 2.0, lambda x: (x - 1.5) ** 2)
    assert not extremes(sampled_curve(broken, 0.0, 4.0), 1.0)
    broken = with_hole(0.0, 1.4, lambda x: (x - 1.5) ** 2)
    within(extremes(sampled_curve(broken, -1.0, 4.0), 1.0), [1.5])
