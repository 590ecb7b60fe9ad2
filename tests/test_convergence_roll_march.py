"""Claim: the plain marches are the methods they are called, on the machine of the array kernels."""

import numpy as np
import pytest
from roll_machines import source_machine, straight_drive

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.excitation.slip_torque import linear_motor
from vibecalc.roll.between_kinks import running
from vibecalc.roll.march import METHODS, March, march_to_repeat
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    accelerations,
    friction_torque,
    gas_forces,
    gas_torque,
    inertia,
    motor_torque,
    mount_torque,
)
from vibecalc.roll.turn import harmonics, level

START = 30.0 * np.pi
#: the levels of the shell's acceleration that the source prints, dB against 1 rad/s^2
PRINTED = [4.3, 8.9, 0.2, 0.4, -22.2, -15.0, -18.2, -20.0, -25.1, -26.6]
FULL = source_machine(
    wrist_pin_offset=0.01,
    rod_inertia_difference=[-0.01, -0.02],
    piston_friction=50.0,
    friction_torque=5.0,
    friction_damping=0.1,
    shell_stiffness=1e5,
    shell_damping=100.0,
)


def smooth_drive() -> RollDrive:
    return straight_drive("trigonometric")._replace(motor=linear_motor(120.0))


def levels(found: March) -> np.ndarray:
    return level(harmonics(found.turn, found.shell_acceleration, np.arange(1.0, 11.0)))


@pytest.mark.parametrize("machine", [source_machine(), FULL], ids=["source", "full"])
@pytest.mark.parametrize("table", ["linear", "parabola", "cubic", "trigonometric"])
def test_plain_floats_agree_with_the_arrays(machine: RollMachine, table: str) -> None:
    drive, rng = straight_drive(table), np.random.default_rng(3)
    rates = running(machine, drive)
    b, w, theta, s = rng.uniform([0, 40, -0.01, -0.2], [30, 97, 0.01, 0.2], (60, 4)).T
    moved = inertia(machine, b)
    crankshaft = motor_torque(machine, drive, w).value + friction_torque(machine, moved, w)
    crankshaft = crankshaft + gas_torque(moved, gas_forces(machine, drive, b))
    right = accelerations(moved, w, s, mount_torque(machine, theta, s), crankshaft)
    found = np.array(
        [
            rates(*row)
            for row in zip(b.tolist(), w.tolist(), theta.tolist(), s.tolist(), strict=True)
        ]
    )
    assert np.max(np.abs(found[:, 0] - right.crank)) < 1e-12 * np.max(np.abs(right.crank))
    assert np.max(np.abs(found[:, 1] - right.shell)) < 1e-12 * np.max(np.abs(right.shell))


@pytest.mark.parametrize(("method", "order"), [("euler", 1.0), ("rk4", 4.0)])
def test_orders_on_a_smooth_machine(method: str, order: float) -> None:
    steps = [0.4e-3, 0.2e-3, 0.1e-3] if method == "euler" else [2e-3, 1e-3, 0.5e-3]
    period = [
        float(
            march_to_repeat(
                source_machine(), smooth_drive(), method, started_at=START, step=step, turns=2
            ).turn.period
        )
        for step in steps
    ]
    ratio = abs(period[0] - period[1]) / abs(period[1] - period[2])
    assert np.log2(ratio) == pytest.approx(order, abs=0.7)


def test_the_published_method_gives_the_printed_levels() -> None:
    """Euler at .5 ms, three turns; the exact period in place of the source's own."""
    found = march_to_repeat(
        source_machine(), straight_drive("parabola"), "euler", started_at=START, turns=3
    )
    assert found.turns == 3 and 400 < found.evaluations < 412
    assert np.max(np.abs(levels(found) - PRINTED)) < 0.25
    assert 1.0 / found.turn.period == pytest.approx(14.8, abs=0.05)


@pytest.mark.parametrize("method", METHODS)
def test_a_turn_is_a_turn(method: str) -> None:
    found = march_to_repeat(source_machine(), straight_drive(), method, started_at=START)
    turn = found.turn
    assert found.change <= 1e-5 and found.turns >= 2
    assert turn.crank_angle[[0, -1]] == pytest.approx([0.0, 2.0 * np.pi], abs=1e-7)
    assert np.sum(turn.weight / turn.crank_speed) == pytest.approx(float(turn.period), rel=1e-12)
    # the shell at rest at the start sets the angular momentum; it is kept
    start = inertia(source_machine(), np.zeros(1))
    moved = inertia(source_machine(), turn.crank_angle)
    momentum = moved.shell * turn.shell_speed + moved.coupling * turn.crank_speed
    # Euler drifts in the fifth digit; so does what the source prints
    close = {"euler": 1e-4, "rk4": 1e-6, "dop853": 1e-7}[method]
    assert np.max(np.abs(momentum / (start.coupling[0] * START) - 1.0)) < close


def test_no_running_state_is_said_in_words() -> None:
    with pytest.raises(NumericalFailure, match="comes to a standstill"):
        march_to_repeat(
            source_machine(gas_scale=[3.5, 3.5]), straight_drive(), "rk4", started_at=START
        )
    with pytest.raises(NumericalFailure, match="beyond the last of the motor's table"):
        march_to_repeat(
            source_machine(), straight_drive(holds=False), "euler", started_at=2.5 * START
        )
    with pytest.raises(NumericalFailure, match="not come to a periodic state in 5 turns"):
        march_to_repeat(
            source_machine(), straight_drive(), "euler", started_at=START, repeats=1e-14, most=5
        )
    with pytest.raises(UsageError, match="euler, rk4, dop853"):
        march_to_repeat(source_machine(), straight_drive(), "heun", started_at=START)
