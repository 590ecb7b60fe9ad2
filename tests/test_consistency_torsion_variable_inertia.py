"""Claim: the response with variable inertias is that of the Lagrangian system, order by order."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from variable_inertia_lines import one_freedom, piston_variation, ship_engine

from vibecalc.kinematics.harmonics import motion_harmonics
from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.torsion.line import stiffness_matrix
from vibecalc.torsion.variable_inertia.motion import acceleration, inertia_at, steady_response


def marched(system, speed, angle, rate, torque_at, duration):
    """DOP853 on the exact nonlinear system."""
    n = len(angle)

    def rates(t, y):
        torque = torque_at(speed * t, y[:n])
        return np.r_[y[n:], acceleration(system, speed, speed * t, y[:n], y[n:], torque)]

    start = np.r_[angle, rate]
    found = solve_ivp(rates, (0.0, duration), start, method="DOP853", rtol=1e-11, atol=1e-13)
    return found.y[:n, -1], found.y[n:, -1]


def test_variation_is_that_of_the_slider_crank() -> None:
    crank = np.linspace(0.0, 2.0 * np.pi, 17)
    true = piston_path(crank, 1.0, 1.0 / 0.28).velocity ** 2
    order = np.arange(1, 13)
    series = (np.exp(1j * np.outer(crank, order)) @ piston_variation(0.28, 12)).real
    mean = 0.5 * np.sum((np.arange(25) * np.abs(motion_harmonics(0.28, 24))) ** 2)
    assert np.abs(mean + series - true).max() < 1e-8  # orders from 13 on
    system = ship_engine()
    step = 1e-4
    at = 0.3 + step * np.array([-1.0, 0.0, 1.0])[:, None]
    inertia = inertia_at(system, at)
    slope = (inertia.value[2] - inertia.value[0]) / (2.0 * step)
    curvature = (inertia.slope[2] - inertia.slope[0]) / (2.0 * step)
    assert np.abs(slope - inertia.slope[1]).max() < 1e-5
    assert np.abs(curvature - inertia.curvature[1]).max() < 1e-5


def test_undamped_unforced_motion_keeps_its_energy() -> None:
    system = ship_engine(damping=0.0)
    start, rate = np.array([0.1, -0.05, 0.02, 0.0]), np.array([3.0, 0.0, -5.0, 1.0])
    end = marched(system, 60.0, start, rate, lambda a, x: np.zeros(4), 0.05)

    def energy(crank_angle, angle, rate):
        turning = inertia_at(system, crank_angle + angle).value @ (60.0 + rate) ** 2
        return 0.5 * (turning + angle @ stiffness_matrix(system.line) @ angle)

    assert np.abs(end[0] - start).max() > 0.01
    assert energy(3.0, *end) == pytest.approx(energy(0.0, start, rate), rel=1e-9)


def test_linear_response_is_the_exact_one_to_the_third_power_of_the_variation() -> None:
    gaps = []
    for scale in (0.1, 0.05):
        system = ship_engine(scale)
        both = [steady_response(system, 90.0, np.zeros((1, 4)), 8, exact=e) for e in (0, 1)]
        gaps.append(np.abs(both[0].angle - both[1].angle).max())
    assert gaps[0] / gaps[1] == pytest.approx(8.0, rel=0.1)


def test_secondary_order_of_one_freedom_in_closed_form() -> None:
    """Order 2 of the inertia torque makes order 4, near its resonance much more than itself."""
    change, speed = 1e-4, 0.249
    angle = steady_response(one_freedom(change), speed, np.zeros((1, 1)), 12).angle[0, :, 0]
    second = -1j * change * speed**2 / (1.0 - 4.0 * speed**2)
    fourth = 0.25 * speed**2 * change * 20.0 * second / (1.0 - 16.0 * speed**2)
    assert angle[2] == pytest.approx(second, rel=1e-5)
    assert angle[4] == pytest.approx(fourth, rel=1e-5)
