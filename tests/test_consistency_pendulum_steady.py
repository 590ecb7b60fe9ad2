"""Claim: steady motions of rotor and pendulum repeat when the exact equations are integrated, start
as small motions, and fold where the pendulum jumps.
"""

import math

import numpy as np
import pytest
from exact_pendulum import rates
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vibecalc.absorber.pendulum_order import Pendulum, path_exponent
from vibecalc.absorber.pendulum_steady import as_secondary, jump, small_motion, steady_motion

POINT = Pendulum(1.3, 0.12, 0.02)
ROLLERS = Pendulum(1.3, 0.12, 0.02, 0.0, 0.0, 0.2, 0.115, 0.03, 0.2 * 0.03**2 / 8.0)
ROTOR = 0.1
ORDER = math.sqrt(5.0)


def on(name, pendulum=POINT):
    return pendulum._replace(path_exponent=float(path_exponent(name, pendulum)))


def one_cycle(pendulum, order, torque, speed, slope):
    """State after one period of the torque, from T = 0 and p = 0; time taken and largest swing."""

    def through(_, state):
        return state[0] - 2.0 * math.pi / order

    through.terminal = True
    found = solve_ivp(
        lambda t, y: rates(pendulum, ROTOR, y, torque * np.sin(order * y[0])),
        [0.0, 60.0], [0.0, 0.0, speed, slope * speed],
        method="DOP853", rtol=1e-12, atol=1e-14, events=through, max_step=0.04,
    )  # fmt: skip
    return found.y[:, -1], found.t[-1], np.max(np.abs(found.y[1]))


@pytest.mark.long
@pytest.mark.parametrize(
    ("pendulum", "order"),
    [
        (on("epicycloidal", ROLLERS), ORDER),
        *(
            (pendulum, order)
            for pendulum in (
                POINT,
                on("epicycloidal"),
                on("cycloidal"),
                on("epicycloidal", ROLLERS),
            )
            for order in (ORDER, 1.03 * ORDER)
        ),
    ],
)
def test_a_steady_motion_repeats(pendulum, order):
    found = steady_motion(pendulum, ROTOR, order, 0.6)
    sines = found.swing.value
    slope = order * np.sum(np.arange(1, len(sines) + 1) * sines)
    torque = float(found.torque.value)

    def mean_speed(start):
        return 2.0 * math.pi / order / one_cycle(pendulum, order, torque, start, slope)[1] - 1.0

    start = brentq(mean_speed, 0.8, 1.2, xtol=1e-13)
    state, _, largest = one_cycle(pendulum, order, torque, start, slope)
    assert state[1] == pytest.approx(0.0, abs=1e-9)
    assert state[2] == pytest.approx(start, rel=1e-9)
    assert state[3] == pytest.approx(slope * start, rel=1e-9)
    assert largest == pytest.approx(float(found.largest.value), rel=2e-3)


def test_small_steady_motions_are_linear():
    swing = 1e-4
    found = steady_motion(POINT, ROTOR, 2.0, swing)
    system = as_secondary(POINT, ROTOR, 1.0)
    linear = small_motion(system, 2.0, float(found.torque.value))
    assert linear.swing.real == pytest.approx(swing, rel=1e-6)
    acceleration = -4.0 * linear.rotor.real
    assert found.acceleration.value[0] == pytest.approx(acceleration, rel=1e-5)


@pytest.mark.parametrize("name", ["circular", "epicycloidal", "cycloidal"])
def test_a_tuned_pendulum_leaves_harmonics_of_its_swing(name):
    """The rotor's first harmonic falls with the cube of the swing on every path, the second with
    its square: the pendulum couples to the rotor by its whole way."""
    rotor = steady_motion(on(name), ROTOR, ORDER, [0.01, 0.02]).acceleration.value
    np.testing.assert_allclose(rotor[1, :2] / rotor[0, :2], [8.0, 4.0], rtol=1e-2)


@pytest.mark.long
def test_estimates_hold_against_many_harmonics():
    swing = np.array([0.2, 0.7, 1.1])
    rough = steady_motion(POINT, ROTOR, ORDER, swing, 8)
    fine = steady_motion(POINT, ROTOR, ORDER, swing, 40)
    for name in ("torque", "largest"):
        one, two = getattr(rough, name), getattr(fine, name)
        np.testing.assert_array_less(np.abs(one.value - two.value), one.error + two.error)
    np.testing.assert_array_less(
        np.abs(rough.swing.value - fine.swing.value[:, :8]),
        rough.swing.error + fine.swing.error[:, :8],
    )


def test_a_circle_jumps_where_its_torque_is_greatest():
    found = jump(POINT, ROTOR, ORDER)
    around = np.abs(
        steady_motion(POINT, ROTOR, ORDER, found.first_sine.value + np.array([-1e-3, 0.0, 1e-3]))
        .torque.value
    )  # fmt: skip
    assert around[1] > around[0] and around[1] > around[2]
    assert found.torque.value == pytest.approx(around[1], rel=1e-10)
    before, top, after = around
    shift = 0.5e-3 * (after - before) / (2.0 * top - before - after)
    assert abs(shift) < 1e-5
    assert found.torque.value == pytest.approx(0.0063953, abs=1e-7)
    # the largest angle is less than the first sine, by what the other sines take away
    assert float(found.first_sine.value) - float(found.swing.value) > 2e-3


@pytest.mark.long
def test_the_swing_of_a_jump_is_the_largest_angle_in_time():
    """Dense output of the exact equations over a cycle at the fold, not the first sine of it."""
    found = jump(POINT, ROTOR, ORDER)
    motion = steady_motion(POINT, ROTOR, ORDER, found.first_sine.value)
    sines, torque = motion.swing.value, float(motion.torque.value)
    slope = ORDER * np.sum(np.arange(1, len(sines) + 1) * sines)

    def mean_speed(start):
        return 2.0 * math.pi / ORDER / one_cycle(POINT, ORDER, torque, start, slope)[1] - 1.0

    start = brentq(mean_speed, 0.8, 1.2, xtol=1e-13)
    course = solve_ivp(
        lambda t, y: rates(POINT, ROTOR, y, torque * np.sin(ORDER * y[0])),
        [0.0, 2.0 * math.pi / ORDER], [0.0, 0.0, start, slope * start],
        method="DOP853", rtol=1e-12, atol=1e-14, dense_output=True,
    )  # fmt: skip
    largest = np.max(np.abs(course.sol(np.linspace(0.0, course.t[-1], 40_001))[1]))
    # at the fold itself the motion drifts away slowly, as the square root of its rounding
    assert float(found.swing.value) == pytest.approx(largest, abs=2e-6)
    assert float(found.swing.error) < 1e-6
