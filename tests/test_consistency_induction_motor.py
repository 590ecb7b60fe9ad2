"""Claim: torque, slope, sensitivities and transients agree with circuits written another way."""

import mpmath
import numpy as np
import pytest
from induction_motors import LINE, MOTORS, ONE_CAGE, TWO_CAGES, exact_torque, random_motor
from scipy.integrate import solve_ivp

from vibecalc.excitation.induction_motor import steady_torque, torque_slope
from vibecalc.excitation.induction_motor_flux import (
    eigenvalues,
    flux_rates,
    flux_system,
    flux_torque,
    steady_flux,
    time_constants,
    torque_answer,
)
from vibecalc.excitation.induction_motor_identify import transient_inductance, with_stator_leakage

SLIPS = np.array([-95.0, -3.0, -1e-6, 0.0, 1e-9, 0.3, 0.9, 7.0, 17.0, 94.2, 200.0])
both = pytest.mark.parametrize("motor", MOTORS.values(), ids=MOTORS)


@both
def test_torque_of_the_circuit_in_many_digits(motor):
    ours = steady_torque(motor, SLIPS)
    exact = np.array([float(exact_torque(motor, slip)) for slip in SLIPS])
    assert np.all(np.abs(ours.value - exact) <= ours.error)
    assert np.all(ours.error <= 1e-13 * np.abs(exact))


def test_torque_error_is_honest_for_any_motor():
    rng = np.random.default_rng(7)
    for _ in range(40):
        motor = random_motor(rng, int(rng.integers(1, 4)))
        slip = float(motor.synchronous_speed) * rng.uniform(-2, 2) * 10.0 ** rng.uniform(-3, 0)
        ours, exact = steady_torque(motor, slip), exact_torque(motor, slip)
        assert abs(float(mpmath.mpf(float(ours.value)) - exact)) <= ours.error
        assert ours.error <= 1e-11 * abs(ours.value)


@both
def test_slope_is_the_derivative(motor):
    ours = torque_slope(motor, SLIPS)
    with mpmath.workdps(40):
        step = mpmath.mpf(2) ** -40
        exact = np.array([
            float((_exact(motor, slip + step) - _exact(motor, slip - step)) / (2 * step))
            for slip in map(mpmath.mpf, SLIPS.tolist())
        ])  # fmt: skip
    assert np.all(np.abs(ours - exact) <= 1e-13 * ours[3])


def _exact(motor, slip):
    """`exact_torque` for a slip beyond double precision: Im Y / |D|^2 summed directly."""
    line, p, voltage, stator, leakage, magnetising = (mpmath.mpf(float(x)) for x in motor[:6])
    x = mpmath.mpc(0, p * slip)
    rotor = zip(motor.rotor_resistance.tolist(), motor.rotor_leakage.tolist(), strict=True)
    y = 1 / magnetising + sum(x / (mpmath.mpf(r) + x * mpmath.mpf(ll)) for r, ll in rotor)
    d = mpmath.mpc(0, line) + (stator + mpmath.mpc(0, line * leakage)) * y
    return mpmath.mpf(3) / 2 * p * voltage**2 * y.imag / abs(d) ** 2


@both
def test_steady_fluxes_stand_still_and_give_the_torque_of_the_circuit(motor):
    system = flux_system(motor)
    flux = steady_flux(motor, SLIPS)
    speed = motor.synchronous_speed - SLIPS
    found = flux_rates(system, flux.value, speed)
    allowed = np.einsum("sij,sj->si", np.abs(found.by_flux), flux.error + 1e-15)
    assert np.all(np.abs(found.rates) <= allowed + 1e-14 * motor.phase_voltage)
    torque, circuit = flux_torque(system, flux.value), steady_torque(motor, SLIPS)
    moved = np.einsum("si,si->s", np.abs(torque.by_flux), flux.error)
    assert np.all(np.abs(torque.value - circuit.value) <= torque.error + moved + circuit.error)
    assert np.all(torque.error + moved < 1e-11 * np.max(np.abs(circuit.value)))


def test_answer_to_speed_is_the_one_of_a_small_oscillation_in_time():
    motor, slip, rate, size = TWO_CAGES, 0.9, 94.0, 1e-3
    system = flux_system(motor)
    speed = motor.synchronous_speed - slip
    wave = lambda t: speed + size * np.cos(rate * t)  # noqa: E731
    turns = 24
    times = (turns - 1 + np.arange(64) / 64) * 2 * np.pi / rate
    run = solve_ivp(
        lambda t, f: flux_rates(system, f, wave(t)).rates,
        (0, times[-1]), steady_flux(motor, slip).value, "DOP853", times, rtol=1e-11, atol=1e-11,
    )  # fmt: skip
    torque = flux_torque(system, run.y.T).value
    harmonic = 2.0 * np.mean(torque * np.exp(-1j * rate * times)) / size
    answer, _ = torque_answer(motor, slip, rate)
    # the slowest transient has decayed to exp(-15), the second order of the oscillation is 1e-3
    assert abs(harmonic - answer.value) < 1e-4 * abs(answer.value)


def test_three_phase_windings_give_the_same_torque():
    """Phase voltages and currents of coils on a turning rotor: no space vectors, no frame."""
    motor, speed = ONE_CAGE, 88.0
    line, p, voltage, stator, leakage, magnetising = motor[:6]
    rotor, rotor_leakage = motor.rotor_resistance[0], motor.rotor_leakage[0]
    angles = 2.0 * np.pi / 3.0 * np.arange(3)
    apart = angles[None, :] - angles[:, None]
    own = 2.0 / 3.0 * magnetising * np.cos(apart)
    resistance = np.repeat([stator, rotor], 3)

    def inductance(turn):
        mutual = 2.0 / 3.0 * magnetising * np.cos(p * turn + apart)
        return np.block([
            [leakage * np.eye(3) + own, mutual],
            [mutual.T, rotor_leakage * np.eye(3) + own],
        ])  # fmt: skip

    def rates(t, linkage):
        supply = np.concatenate([voltage * np.cos(line * t - angles), np.zeros(3)])
        return supply - resistance * np.linalg.solve(inductance(speed * t), linkage)

    times = np.linspace(0.005, 0.06, 12)
    run = solve_ivp(rates, (0, 0.06), np.zeros(6), "DOP853", times, rtol=1e-11, atol=1e-12)
    torque = []
    for t, linkage in zip(times, run.y.T, strict=True):
        current = np.linalg.solve(inductance(speed * t), linkage)
        turned = -2.0 / 3.0 * magnetising * p * np.sin(p * speed * t + apart)
        torque.append(current[:3] @ turned @ current[3:])
    system = flux_system(motor)
    ours = solve_ivp(
        lambda t, f: flux_rates(system, f, speed).rates,
        (0, 0.06), np.zeros(4), "DOP853", times, rtol=1e-11, atol=1e-12,
    )  # fmt: skip
    assert np.allclose(flux_torque(system, ours.y.T).value, torque, rtol=0, atol=1e-6)
    assert np.ptp(torque) > 500.0


@both
def test_eigenvalues_and_time_constants_where_each_is_known(motor):
    # standstill seen from the stator: without stator resistance its flux turns against the frame
    free = motor._replace(stator_resistance=0.0)
    found = eigenvalues(free, 0.9)
    assert np.min(np.abs(found.value + 1j * LINE)) <= found.error[0]
    # and what remains are the rotor's modes with shorted stator, turning at the slip frequency
    times = time_constants(free)
    assert np.isinf(times.stator.value)
    others = found.value[np.argsort(np.abs(found.value + 1j * LINE))[1:]]
    expected = -1.0 / times.rotor_short.value - 3.6j
    if others.size == 1:
        assert abs(others[0] - expected[0]) < 0.02 * abs(expected[0] + 3.6j)
    assert np.all(times.rotor_short.value < times.rotor_open.value)
    # the trace of the matrix is the sum of its eigenvalues
    system = flux_system(motor)
    ours = eigenvalues(motor, 0.9)
    trace = np.trace(system.constant) / 2.0
    assert ours.value.real.sum() == pytest.approx(trace, rel=1e-12)
    assert ours.value.imag.sum() == pytest.approx(-LINE - 3.6 * motor.rotor_leakage.size, rel=1e-12)
    assert np.all(ours.error < 1e-8)


@both
@pytest.mark.parametrize("share", [0.0, 0.2, 0.7])
def test_moved_leakage_changes_nothing_outside(motor, share):
    other = with_stator_leakage(motor, share * transient_inductance(motor))
    assert float(other.stator_leakage) == pytest.approx(share * transient_inductance(motor))
    here, there = steady_torque(motor, SLIPS), steady_torque(other, SLIPS)
    assert np.all(np.abs(here.value - there.value) <= 1e-13 * np.max(here.value))
    assert np.allclose(
        np.sort_complex(eigenvalues(motor, 5.0).value),
        np.sort_complex(eigenvalues(other, 5.0).value), rtol=0, atol=1e-9,
    )  # fmt: skip
    waves = np.array([10.0, 94.0, 400.0])
    one, two = torque_answer(motor, 0.9, waves)[0], torque_answer(other, 0.9, waves)[0]
    assert np.allclose(one.value, two.value, rtol=0, atol=1e-9 * np.max(np.abs(one.value)))
    back = with_stator_leakage(other, motor.stator_leakage)
    assert np.allclose(back.rotor_resistance, motor.rotor_resistance, rtol=1e-12)
    assert np.allclose(back.rotor_leakage, motor.rotor_leakage, rtol=1e-12)
