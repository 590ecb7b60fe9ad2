"""Claim: no power is lost, and passivity holds, for any motor at any fluxes and speed."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from induction_motors import random_motor

from vibecalc.excitation.induction_motor import steady_torque, torque_curve
from vibecalc.excitation.induction_motor_flux import (
    flux_rates,
    flux_system,
    power_flow,
)

seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=50, deadline=None)
@given(seeds, st.integers(1, 3))
def test_power_in_is_heat_work_and_field(seed, cages):
    rng = np.random.default_rng(seed)
    motor = random_motor(rng, cages)
    speed = float(motor.synchronous_speed) * rng.uniform(-2.0, 2.0)
    rated = motor.phase_voltage / motor.line_frequency
    flux = rated * rng.normal(size=(5, 2 + 2 * cages))
    flow = power_flow(motor, flux, speed)
    left = (
        flow.electrical - flow.stator_copper - flow.rotor_copper
        - flow.mechanical - flow.magnetic_rate
    )  # fmt: skip
    assert np.all(np.abs(left) <= flow.error)
    scale = np.abs(flow.electrical) + flow.stator_copper + flow.rotor_copper
    assert np.all(flow.error <= 1e-9 * scale.max())
    # the rate of the energy is its derivative along the motion: exact for a quadratic
    rates = flux_rates(flux_system(motor), flux, speed).rates
    step = rated / np.linalg.norm(rates)
    ahead = power_flow(motor, flux + step * rates, speed).magnetic_energy
    behind = power_flow(motor, flux - step * rates, speed).magnetic_energy
    slope = (ahead - behind) / (2.0 * step)
    allowed = 1e-12 * (ahead + behind) / step + flow.error
    assert np.all(np.abs(slope - flow.magnetic_rate) <= allowed)
    assert np.all(flow.magnetic_energy > 0.0) and np.all(flow.rotor_copper > 0.0)


@settings(max_examples=15, deadline=None)
@given(seeds, st.integers(1, 3))
def test_curve_has_no_higher_point_than_its_breakdown(seed, cages):
    rng = np.random.default_rng(seed)
    motor = random_motor(rng, cages)
    curve = torque_curve(motor)
    unit = motor.rotor_resistance / motor.rotor_leakage / motor.pole_pairs
    slips = np.geomspace(1e-4 * unit.min(), 1e4 * unit.max(), 4001)
    torque = steady_torque(motor, slips).value
    top = curve.breakdown_torque.value
    assert np.all(torque <= top * (1.0 + 1e-12))
    assert torque.max() > 0.9999 * top
