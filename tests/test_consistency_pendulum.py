"""Claim: order, detuning, small and large motions of a centrifugal pendulum are those of the exact
equations, which are those of the energy of its parts.
"""

import math

import mpmath as mp
import numpy as np
import pytest
from exact_pendulum import kinetic_energy, rates
from long_but import long_but
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from two_masses import amplitude

from vibecalc.absorber.pendulum_order import (
    Pendulum,
    detuning_coefficient,
    order_of_swing,
    path_exponent,
    radius_for_order_with_rollers,
    terms,
    tuning_order,
)
from vibecalc.absorber.pendulum_steady import as_secondary, jump, small_motion, steady_motion
from vibecalc.absorber.transfer import Absorber

POINT = Pendulum(1.3, 0.12, 0.02)
ROLLERS = Pendulum(1.3, 0.12, 0.02, 0.0, 0.0, 0.2, 0.115, 0.03, 0.2 * 0.03**2 / 8.0)
ARM = Pendulum(1.3, 0.12, 0.02, 0.0, 2e-4)
ROTOR = 0.1


def on(name, pendulum=POINT):
    return pendulum._replace(path_exponent=float(path_exponent(name, pendulum)))


EPICYCLOID, CYCLOID = on("epicycloidal"), on("cycloidal")
KINDS = [POINT, ROLLERS, ARM, EPICYCLOID, CYCLOID, on("epicycloidal", ROLLERS)]


@pytest.mark.parametrize("pendulum", long_but(KINDS, ROLLERS, CYCLOID))
def test_terms_are_the_energy_of_the_parts(pendulum):
    for angle in (-0.9, 0.0, 0.4, 1.3):
        found = terms(pendulum, np.asarray(angle))
        with mp.workdps(40):
            whole = [kinetic_energy(pendulum, mp.mpf(angle), a, b) for a, b in
                     ((1, 0), (0, 1), (1, 1))]  # fmt: skip
        carried, swing = 2 * float(whole[0]), 2 * float(whole[1])
        coupling = float(whole[2] - whole[0] - whole[1])
        assert found.carried == pytest.approx(carried, rel=1e-13)
        assert found.swing == pytest.approx(swing, rel=1e-13)
        assert found.coupling == pytest.approx(coupling, rel=1e-12)


@pytest.mark.parametrize("pendulum", KINDS)
def test_slopes_are_derivatives(pendulum):
    angle = np.array([-1.2, -0.3, 0.0, 0.7])
    aside = terms(pendulum, angle + 1e-30j)
    found = terms(pendulum, angle)
    for name in ("carried", "coupling", "swing"):
        slope = getattr(aside, name).imag / 1e-30
        np.testing.assert_allclose(getattr(found, f"{name}_slope"), slope, rtol=1e-12, atol=1e-18)


def swing_order(pendulum, angle):
    """Order of free swings on a rotor so heavy that its speed stays, by integration in time."""
    heavy = 1e14

    def slow(_, state):
        return state[3]

    slow.terminal, slow.direction = 4, -1
    found = solve_ivp(
        lambda t, y: rates(pendulum, heavy, y), [0.0, 100.0], [0.0, angle, 1.0, 0.0],
        method="DOP853", rtol=1e-12, atol=1e-14, events=slow,
    )  # fmt: skip
    tops = found.t_events[0]
    return 2.0 * math.pi * (len(tops) - 1) / (tops[-1] - tops[0])


@pytest.mark.parametrize("pendulum", long_but(KINDS, ROLLERS, CYCLOID))
def test_order_of_large_swings_by_integration_of_the_exact_equations(pendulum):
    found = order_of_swing(pendulum, 1.1)
    assert found.value == pytest.approx(swing_order(pendulum, 1.1), rel=1e-9)


def test_order_of_small_swings():
    assert tuning_order(POINT).value == pytest.approx(math.sqrt(5.0), rel=1e-15)
    for pendulum in KINDS:
        small = order_of_swing(pendulum, 0.0)
        tuned = tuning_order(pendulum)
        assert abs(small.value - tuned.value) <= small.error + tuned.error
    # a solid roller counts 3/8 in the motion and half in the pull
    expected = (1.3 * 0.1 + 0.1 * (0.115 - 0.01)) / (0.02 * (1.3 + 0.2 * 3.0 / 8.0))
    assert tuning_order(ROLLERS).value ** 2 == pytest.approx(expected, rel=1e-14)
    assert tuning_order(ARM).value ** 2 == pytest.approx(
        0.1 * 0.02 / (0.02**2 + 2e-4 / 1.3), rel=1e-14
    )


@pytest.mark.parametrize("order", [0.5, 1.0, 3.0, 6.0])
def test_radius_for_an_order_and_back(order):
    near = 0.12 / (1.0 + order**2)
    assert tuning_order(POINT._replace(path_radius=near)).value == pytest.approx(order, rel=1e-14)
    near = radius_for_order_with_rollers(ROLLERS, order).value
    tuned = tuning_order(ROLLERS._replace(path_radius=near))
    assert tuned.value == pytest.approx(order, rel=1e-13)


def test_a_circle_is_an_elliptic_integral():
    angle = np.array([1e-9, 0.1, 1.0, 2.0, 3.0, 3.1])
    found = order_of_swing(POINT, angle)
    with mp.workdps(30):
        for i, a in enumerate(angle):
            exact = mp.sqrt(5) * mp.pi / 2 / mp.ellipk(mp.sin(mp.mpf(a) / 2) ** 2)
            # c - r and r are rounded: sqrt(5) to a few units
            assert abs(found.value[i] - float(exact)) <= found.error[i]
    assert np.all(found.error < 1e-13)


def test_a_circle_softens_an_epicycloid_keeps_and_a_cycloid_hardens():
    angle = np.array([0.2, 0.6, 1.0, 1.3])
    order = tuning_order(POINT).value
    soft, even, hard = (order_of_swing(p, angle) for p in (POINT, EPICYCLOID, CYCLOID))
    assert np.all(np.diff(soft.value) < 0.0) and np.all(np.diff(hard.value) > 0.0)
    np.testing.assert_array_less(np.abs(even.value - order), even.error)
    rollers = on("epicycloidal", ROLLERS)
    even = order_of_swing(rollers, angle)
    np.testing.assert_array_less(np.abs(even.value - tuning_order(rollers).value), even.error)
    # an epicycloid that leaves out the rollers is not one of equal times
    wrong = ROLLERS._replace(path_exponent=EPICYCLOID.path_exponent)
    assert abs(order_of_swing(wrong, 1.0).value / tuning_order(wrong).value - 1.0) > 1e-5


@pytest.mark.parametrize("pendulum", [*KINDS, POINT._replace(path_exponent=0.5)])
def test_detuning_is_the_second_term_of_the_period(pendulum):
    expected = detuning_coefficient(pendulum)
    angle = np.array([0.02, 0.04])
    share = (order_of_swing(pendulum, angle).value / tuning_order(pendulum).value - 1.0) / angle**2
    # the next term falls with the square: Richardson
    assert (4.0 * share[0] - share[1]) / 3.0 == pytest.approx(float(expected.value), abs=1e-7)


@pytest.mark.parametrize("pendulum", KINDS)
def test_small_motion_is_that_of_the_exact_equations(pendulum):
    """Linearised by complex steps about steady rotation, and solved for one harmonic."""
    speed, frequency, torque, damping = 30.0, 55.0, 0.4 - 0.3j, 0.002
    steps = []
    for i in range(4):
        state = np.array([0.0, 0.0, speed, 0.0], dtype=complex)
        state[i] += 1e-30j
        steps.append(rates(pendulum, ROTOR, state, 0.0, damping).imag / 1e-30)
    push = rates(pendulum, ROTOR, np.array([0.0, 0.0, speed, 0.0]), 1.0, damping)
    push = push - np.array([speed, 0.0, 0.0, 0.0])
    exact = np.linalg.solve(1j * frequency * np.eye(4) - np.stack(steps, axis=1), push * torque)
    system = as_secondary(pendulum, ROTOR, speed, damping)
    found = small_motion(system, frequency, torque)
    assert abs(found.rotor - exact[0]) <= 1e-12 * abs(exact[0])
    assert abs(found.swing - exact[1]) <= 1e-12 * abs(exact[1])
    assert 0.0 < found.swing_error < 1e-12 * abs(found.swing)


def test_a_rotor_on_a_shaft_with_a_pendulum_is_the_two_mass_system():
    """The response of the absorber room, with a stiffness ratio that grows with the speed."""
    shaft, damping = 900.0, 0.003
    speed = np.array([5.0, 20.0, 60.0])
    system = as_secondary(ROLLERS, ROTOR, speed, damping)
    natural = np.sqrt(shaft / system.primary_inertia)
    ratios = Absorber(
        0.0,
        system.inertia / system.primary_inertia,
        system.stiffness / shaft,
        system.damping / (2.0 * natural * system.primary_inertia),
    )
    frequency = np.array([30.0, 70.0, 140.0])
    expected = amplitude(ratios, frequency / natural) * 2.0 / shaft
    found = small_motion(system, frequency, 2.0, shaft)
    np.testing.assert_allclose(found.rotor, expected, rtol=1e-12)
    np.testing.assert_allclose(
        ratios.stiffness_ratio / ratios.mass_ratio,
        (tuning_order(ROLLERS).value * speed / natural) ** 2, rtol=1e-13,
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Steady motions repeat, start as small motions, and fold where the pendulum jumps.
# ----------------------------------------------------------------------------


ORDER = math.sqrt(5.0)


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
