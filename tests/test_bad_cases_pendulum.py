"""Claim: pendulums that do not swing, and swings that leave the path, are refused in words."""

import numpy as np
import pytest

from vibecalc.absorber.pendulum_order import (
    Pendulum,
    detuning_coefficient,
    largest_swing,
    order_of_swing,
    path_exponent,
    radius_for_order_with_rollers,
    tuning_order,
)
from vibecalc.absorber.pendulum_steady import as_secondary, jump, small_motion, steady_motion
from vibecalc.errors import NumericalFailure

POINT = Pendulum(1.3, 0.12, 0.02)
EPICYCLOID = POINT._replace(path_exponent=float(path_exponent("epicycloidal", POINT)))


@pytest.mark.parametrize("radius", [0.12, 0.2])
def test_nothing_pulls_a_pendulum_about_the_axis(radius):
    with pytest.raises(NumericalFailure, match="nothing pulls the pendulum outwards"):
        tuning_order(POINT._replace(path_radius=radius))


def test_unknown_paths_get_the_list():
    with pytest.raises(NumericalFailure, match="paths: circular, cycloidal, epicycloidal"):
        path_exponent("elliptic", POINT)


def test_an_arm_runs_on_a_circle():
    arm = POINT._replace(swing_inertia=1e-4)
    with pytest.raises(NumericalFailure, match="runs on a circle"):
        path_exponent("epicycloidal", arm)
    with pytest.raises(NumericalFailure, match="runs on a circle"):
        detuning_coefficient(arm._replace(path_exponent=0.5))
    assert detuning_coefficient(arm).value == -1.0 / 16.0


def test_an_arm_too_heavy_to_turn_for_an_order():
    with pytest.raises(NumericalFailure, match="no arm tunes it"):
        radius_for_order_with_rollers(POINT._replace(swing_inertia=0.1), 4.0)


@pytest.mark.parametrize("share", [1.0, 1.2])
def test_swings_past_the_cusp(share):
    end = float(largest_swing(EPICYCLOID))
    assert end == pytest.approx(np.pi / (2.0 * EPICYCLOID.path_exponent))
    with pytest.raises(NumericalFailure, match=r"leaves the path, which ends at 1\.7207"):
        order_of_swing(EPICYCLOID, share * end)
    assert order_of_swing(EPICYCLOID, 0.99 * end).value == pytest.approx(np.sqrt(5.0), rel=1e-12)


def test_half_a_turn_of_a_circle_has_no_period():
    with pytest.raises(NumericalFailure, match="leaves the path"):
        order_of_swing(POINT, np.pi)
    with pytest.raises(NumericalFailure, match="too near to the end of the path"):
        order_of_swing(POINT, np.pi - 1e-6)


def test_steady_motions_that_do_not_exist():
    with pytest.raises(NumericalFailure, match=r"no steady motion|leaves the path|stops the rotor"):
        steady_motion(EPICYCLOID, 0.1, np.sqrt(5.0), 1.75)


def test_a_path_that_does_not_soften_does_not_jump():
    with pytest.raises(NumericalFailure, match="no jump: the torque grows"):
        jump(EPICYCLOID, 0.1, float(np.sqrt(5.0)))


def test_an_undamped_resonance_is_infinite():
    """A free rotor with a pendulum resonates above the order, where n^2 W^2 (1 + J2/J1) = w^2."""
    system = as_secondary(POINT, 4.0 * 1.3 * 0.12**2, 2.0)
    ratio = system.inertia / system.primary_inertia
    found = small_motion(system, 2.0 * np.sqrt(5.0 * (1.0 + ratio)), 1.0)
    assert np.isinf(found.rotor) or found.rotor_error >= 0.05 * abs(found.rotor)
