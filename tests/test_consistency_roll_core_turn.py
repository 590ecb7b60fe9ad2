"""Claim: readings, balances and harmonics of a turn are those of an independent integration.

Truth is `exact_roll`: energy over the crank angle by scipy, with formulas of its own.
"""

from functools import cache

import numpy as np
import pytest
from exact_roll import ExactTurn, as_turn, exact_harmonics, exact_levels, exact_turn
from long_but import long_but
from roll_machines import ROTOR, SYNCHRONOUS, source_drive, source_machine

from vibecalc.roll.mechanism import RollDrive, RollMachine, friction_torque, inertia, mount_torque
from vibecalc.roll.steady import steady_state
from vibecalc.roll.turn import balance, classical, constant_speed, harmonics, level, mean, readings

ORDERS = np.arange(1, 11)
ODD = {
    "wrist_pin_offset": 0.012,
    "crank_angle_offset": [0.4, 2.9],
    "rod_inertia_difference": [-0.02, -0.01],
}
RUBBING = {"friction_torque": 11.0, "friction_damping": 0.3, "piston_friction": 120.0}
MACHINES = {
    "source": ({}, {}),
    "offset, rods": (ODD, {"gas": "cubic", "motor": "monotone"}),
    "friction": (ODD | RUBBING, {"motor": "parabola"}),
    "trigonometric": ({}, {"gas": "trigonometric", "motor": "monotone"}),
}
#: each machine costs a reference of its own
SOME = long_but(MACHINES, "offset, rods")


@cache
def found(name: str) -> tuple[RollMachine, RollDrive, ExactTurn]:
    fields, curves = MACHINES[name]
    machine, drive = source_machine(**fields), source_drive(**curves)
    return machine, drive, exact_turn(machine, drive, started_at=SYNCHRONOUS)


@pytest.mark.parametrize("name", SOME)
def test_readings_are_those_of_the_energy_equation(name: str) -> None:
    machine, drive, exact = found(name)
    read = readings(machine, drive, as_turn(exact))
    size = np.max(np.abs(exact.crank_acceleration))
    pairs = {
        "shell_acceleration": exact.shell_acceleration,
        "rotor_acceleration": exact.shell_acceleration + exact.crank_acceleration,
        "crank_speed": exact.crank_speed,
        "slip": SYNCHRONOUS - exact.crank_speed,
        "motor_torque": exact.motor_torque,
        "gas_torque": exact.gas_torque,
    }
    for field, truth in pairs.items():
        scale = size if "acceleration" in field else np.max(np.abs(truth))
        np.testing.assert_allclose(getattr(read, field), truth, rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("name", SOME)
def test_energy_and_momentum_balance(name: str) -> None:
    machine, drive, exact = found(name)
    turn = as_turn(exact)
    checked = balance(machine, turn, readings(machine, drive, turn))
    assert checked.motor > 1800.0
    assert abs(checked.residual) < 1e-10 * checked.motor
    assert checked.mounts == 0.0
    assert checked.momentum == pytest.approx(exact.momentum, rel=1e-12)
    assert checked.momentum_residual < 1e-12 * exact.momentum
    assert checked.motor == pytest.approx(
        float(np.sum(exact.weight * exact.motor_torque)), rel=1e-12
    )
    fields = MACHINES[name][0]
    if "friction_torque" in fields:
        stroke = np.abs(inertia(machine, exact.crank_angle).stroke).sum(axis=-1)
        speeds = 2.0 * np.pi * 0.3 * np.average(exact.crank_speed, weights=exact.weight)
        slid = 120.0 * np.sum(exact.weight * stroke)
        assert checked.friction == pytest.approx(2.0 * np.pi * 11.0 + speeds + slid, rel=1e-12)
    else:
        assert checked.friction == 0.0


def test_the_balance_of_energy_sees_a_torque_that_is_not_there() -> None:
    """A wrong torque between shell and crank keeps the momentum: energy has to be examined."""
    machine, drive, exact = found("offset, rods")
    turn = as_turn(exact)
    read = readings(machine, drive, turn)
    wrong = balance(machine, turn, read._replace(gas_torque=1.01 * read.gas_torque))
    assert abs(wrong.residual) == pytest.approx(0.01 * wrong.gas / 1.01, rel=1e-6)
    assert wrong.momentum_residual < 1e-12 * exact.momentum


def test_harmonics_of_any_function_of_time() -> None:
    _, _, exact = found("offset, rods")
    turn = as_turn(exact)
    values = exact.shell_acceleration
    truth = exact_harmonics(exact, values, ORDERS)
    np.testing.assert_allclose(harmonics(turn, values, ORDERS), truth, rtol=1e-13)
    np.testing.assert_allclose(level(truth), exact_levels(exact, ORDERS), rtol=1e-13)
    phase = 2.0 * np.pi / exact.period * exact.time
    signal = 0.7 + 2.0 * np.cos(3.0 * phase - 0.4) - 5.0 * np.sin(8.0 * phase)
    amplitudes = harmonics(turn, signal, np.arange(11))
    expected = np.zeros(11, dtype=complex)
    expected[0], expected[3], expected[8] = 0.7, 2.0 * np.exp(-0.4j), 5.0j
    np.testing.assert_allclose(amplitudes, expected, atol=1e-12)
    assert mean(turn, signal) == pytest.approx(0.7, abs=1e-13)


def test_classical_forces_are_those_of_a_constant_speed() -> None:
    machine, drive, exact = found("offset, rods")
    turn = as_turn(exact)
    simple = classical(machine, drive, turn, ORDERS)
    held = constant_speed(turn)
    speed = 2.0 * np.pi / exact.period
    np.testing.assert_allclose(held.crank_speed, speed)
    assert np.max(np.abs(held.shell_speed)) == 0.0
    # the work of rod and wall: along the cylinder the piston needs gas and its own acceleration
    moved = inertia(machine, turn.crank_angle)
    read = readings(machine, drive, turn)
    angle = turn.crank_angle[:, None] + machine.crank_angle_offset
    sine = (machine.crank_radius * np.sin(angle) - machine.wrist_pin_offset) / machine.rod_length
    cosine = np.sqrt(1.0 - sine * sine)
    lever = machine.crank_radius * np.cos(angle)
    turning = np.gradient(-np.arcsin(sine[:, 0]), turn.crank_angle, edge_order=2)
    np.testing.assert_allclose(
        turning[5:-5], (-lever / (cosine * machine.rod_length))[5:-5, 0], atol=2e-3
    )
    bend = (
        machine.crank_radius * np.sin(angle) / (cosine * machine.rod_length)
        - sine * lever**2 / (cosine * machine.rod_length) ** 2 / cosine
    )
    twist = -machine.rod_inertia_difference * bend * speed**2 / machine.rod_length
    pull = machine.reciprocating_mass * moved.curvature * speed**2
    # both components on the piston: along the cylinder, then across it
    along = simple.rod_force * cosine + twist * sine
    np.testing.assert_allclose(along, pull + read.gas_force, rtol=1e-11, atol=1e-9)
    across = -simple.rod_force * sine + twist * cosine - simple.wall_force
    assert np.max(np.abs(across)) < 1e-11 * np.max(np.abs(simple.rod_force))
    assert simple.rod_harmonics.shape == simple.wall_harmonics.shape == (2, 10)
    np.testing.assert_allclose(
        simple.wall_harmonics[1], harmonics(held, simple.wall_force[:, 1], ORDERS), rtol=1e-12
    )


def test_mounts_take_up_what_their_damping_dissipates() -> None:
    machine = source_machine(rotor_inertia=[ROTOR], shell_stiffness=[2.0e6], shell_damping=[900.0])
    drive = source_drive(synchronous_speed=np.full(1, SYNCHRONOUS))
    turn = steady_state(machine, drive, 10).turn
    checked = balance(machine, turn, readings(machine, drive, turn))
    rate = turn.weight / turn.crank_speed
    dissipated = 900.0 * np.sum(rate * turn.shell_speed**2)
    # the springs give back what they take
    assert checked.mounts[0] == pytest.approx(dissipated, rel=1e-9)
    assert abs(checked.residual[0]) < 1e-10 * checked.motor[0]
    assert checked.momentum_residual[0] < 1e-10 * np.max(np.abs(checked.momentum))


def test_every_resistance_opposes_its_motion() -> None:
    machine = source_machine(**(RUBBING | {"shell_stiffness": 5.0, "shell_damping": 7.0}))
    angle = np.array([1.0, 1.0])
    moved = inertia(machine, angle)
    dry = 11.0 + 120.0 * np.sum(np.abs(moved.stroke[0]))
    found = friction_torque(machine, moved, np.array([90.0, -90.0]))
    np.testing.assert_allclose(found, [-dry - 27.0, dry + 27.0], rtol=1e-14)
    held = mount_torque(machine, np.array([0.1, 0.0]), np.array([0.0, -2.0]))
    np.testing.assert_allclose(held, [-0.5, 14.0], rtol=1e-15)
