"""Claim: growth and its borders are those of Hill's equation, and of Hamilton's equations."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from variable_inertia_lines import modes_of, one_freedom, ship_engine, ship_torque

from vibecalc.torsion.line import chain
from vibecalc.torsion.variable_inertia.motion import inertia_at, steady_response, variable_line
from vibecalc.torsion.variable_inertia.stability import (
    Stability,
    stability,
    unstable_ranges,
    wedges,
)


def on_unit_circle(found: Stability) -> np.ndarray:
    return np.abs(np.abs(found.multiplier) - 1.0) <= found.error


@pytest.mark.parametrize(("change", "speed"), [(0.4, 1.02), (0.3, 0.6), (0.4, 0.52)])
def test_multipliers_are_those_of_the_reduced_equation(change: float, speed: float) -> None:
    """psi = sqrt(J) d turns the equation into psi'' + (K / J + (w J' / 2 J)^2) psi = 0."""
    system = one_freedom(change, damping=0.0)

    def rates(t, y):
        inertia = inertia_at(system, np.array([speed * t]))
        spring = 1.0 / inertia.value[0] + (0.5 * speed * inertia.slope[0] / inertia.value[0]) ** 2
        return np.r_[y[2:], -spring * y[:2]]

    end = solve_ivp(rates, (0.0, 2.0 * np.pi / speed), np.array([1.0, 0.0, 0.0, 1.0]),
                    method="DOP853", rtol=3e-13, atol=1e-13).y[:, -1]  # fmt: skip
    found = stability(system, speed)
    assert found.multiplier.sum().real == pytest.approx(end[0] + end[3], abs=1e-10)
    assert np.prod(found.multiplier).real == pytest.approx(1.0, abs=1e-12)
    assert found.unstable == (abs(end[0] + end[3]) > 2.0)


def test_small_variation_gives_the_first_wedges_of_pairs_and_their_cure() -> None:
    system = ship_engine(0.004, damping=0.0)
    line = system.line
    frequency, shape = modes_of(line)
    found = wedges(system, frequency, shape, np.ones(4))
    assert found.first[0] != found.second[0]
    for row in range(2):
        speed, half, slack = found.speed[row], found.half_width[row], found.error[row]
        near = speed + half * np.array([-2.0, 0.0, 2.0])
        ((low, high, _, growth),) = unstable_ranges(system, near)
        assert abs(low - speed + half) < slack + 0.02 * half
        assert abs(high - speed - half) < slack + 0.02 * half
        assert growth == pytest.approx(found.growth[row], rel=0.01)
        # damping like inertia: every mode decays at half of C / J
        for share in (0.98, 1.02):
            braking = 2.0 * share * found.growth[row] * line.inertia
            damped = system._replace(line=line._replace(absolute_damping=braking))
            assert stability(damped, speed).unstable == (share < 1.0)


def test_drift_of_an_exact_motion_has_the_multiplier_one_and_does_not_count() -> None:
    """Nothing depends on the time alone, so that a later start is a motion as well."""
    system, none = ship_engine(damping=0.0), np.zeros((1, 4))
    motion = steady_response(system, 200.0, none, 30, exact=True)
    found = stability(system, 200.0, angle=motion.angle[0], angle_error=motion.error[0])
    near = np.argsort(np.abs(found.multiplier - 1.0))[:2]
    assert np.all(np.abs(found.multiplier[near] - 1.0) <= found.error[near])
    assert np.all(found.error[near] < 1e-2) and np.all(found.common[near] > 0.5)
    assert not found.unstable and on_unit_circle(found).all()


def test_error_of_truncation_is_honest() -> None:
    system, torque = ship_engine(), ship_torque()
    true = steady_response(system, [60.0, 200.0], torque, 40)
    for highest in (14, 22):
        found = steady_response(system, [60.0, 200.0], torque, highest)
        gap = np.abs(found.angle - true.angle[:, : 2 * highest + 1]).max(axis=(1, 2))
        error = found.error.max(axis=(1, 2))
        assert np.all(gap <= error) and np.all(error <= 30.0 * gap)


def test_gauss_collocation_needs_no_equal_scales() -> None:
    """A graded line, stable and undamped: every multiplier stays on the circle."""
    line = chain(np.array([1e-2, 1.0, 1e3]), np.array([1e4, 1e5]))
    system = variable_line(line, [[0.0, 2e-3], [0.0, 0.2], [0.0, 0.0]], turns=2)
    found = stability(system, 150.0)
    vibration = found.common < 0.5
    assert not found.unstable and on_unit_circle(found)[vibration].all()


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9])
def test_error_of_round_off_is_honest_next_to_a_critical(distance: float) -> None:
    speed = 1.0 + distance
    found = steady_response(one_freedom(0.0), speed, np.array([[0.0], [1.0]]), 2)
    true = float(1 / (1 - Fraction(speed) ** 2))
    assert abs(found.angle[0, 1, 0] - true) <= found.error[0, 1, 0] < 1e-4 * abs(true)
