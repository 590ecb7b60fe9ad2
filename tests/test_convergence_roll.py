"""Claim: every way to the running state comes to the same one, at the order that is its own, and
plain marches are the methods they are called.

Truth: collocation with 14 points on each panel, which two ways hold to a billionth of a decibel.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from roll_machines import SYNCHRONOUS, source_drive, source_machine, straight_drive

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.excitation.slip_torque import linear_motor
from vibecalc.roll.between_kinks import running
from vibecalc.roll.march import METHODS, March, march_to_repeat
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    accelerations,
    as_batch,
    friction_torque,
    gas_forces,
    gas_torque,
    inertia,
    motor_torque,
    mount_torque,
)
from vibecalc.roll.methods import Settings, find, fourier_state, shooting_state
from vibecalc.roll.steady import SteadyTurn, started_momentum, steady_state
from vibecalc.roll.turn import Turn, harmonics, level, readings

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


ORDERS = np.arange(1, 11)
MOUNTED = {"shell_stiffness": 3e5, "shell_damping": 3e3}


@cache
def parts(mounted: bool = False, smooth: bool = False) -> tuple[RollMachine, RollDrive]:
    machine = as_batch(source_machine(**(MOUNTED if mounted else {})))
    return machine, source_drive("trigonometric", "monotone") if smooth else source_drive()


@cache
def truth(mounted: bool = False, smooth: bool = False) -> SteadyTurn:
    machine, drive = parts(mounted, smooth)
    started_at = None if mounted else SYNCHRONOUS
    return steady_state(machine, drive, 14, started_at=started_at)


def spectrum(turn: Turn, mounted: bool, smooth: bool) -> np.ndarray:
    machine, drive = parts(mounted, smooth)
    read = readings(machine, drive, turn, pistons=False)
    return harmonics(turn, read.shell_acceleration, ORDERS)[0]


def off(turn: Turn, mounted: bool = False, smooth: bool = False) -> float:
    """Largest error of ten harmonics over the largest one."""
    exact = spectrum(truth(mounted, smooth).turn, mounted, smooth)
    return float(np.abs(spectrum(turn, mounted, smooth) - exact).max() / np.abs(exact).max())


@pytest.mark.parametrize("mounted", [False, pytest.param(True, marks=pytest.mark.long)])
def test_collocation_gains_with_every_point(mounted: bool) -> None:
    machine, drive = parts(mounted)
    started_at = None if mounted else SYNCHRONOUS
    errors = [
        off(steady_state(machine, drive, points, started_at=started_at).turn, mounted)
        for points in (1, 2, 3, 4, 5, 6)
    ]
    for one, other in pairwise(errors):
        assert other < 0.1 * one
    assert errors[-1] < 1e-11


@pytest.mark.parametrize(
    "mounted",
    [pytest.param(False, marks=pytest.mark.long), pytest.param(True, marks=pytest.mark.long)],
)
def test_without_splitting_kinks_cost_the_order(mounted: bool) -> None:
    """With curves that are smooth but at a few nodes of the motor's, Fourier's points gain more."""
    machine, drive = parts(mounted, smooth=False)
    momentum = truth(mounted).momentum
    rough = [off(fourier_state(machine, drive, n, momentum).turn, mounted) for n in (61, 241)]
    # about second order
    assert rough[0] / 40.0 < rough[1] < rough[0] / 6.0
    machine, drive = parts(mounted, smooth=True)
    momentum = truth(mounted, True).momentum
    smooth = [
        off(fourier_state(machine, drive, n, momentum).turn, mounted, True) for n in (61, 241)
    ]
    assert smooth[1] < 0.05 * rough[1]


@pytest.mark.parametrize("mounted", [False, pytest.param(True, marks=pytest.mark.long)])
def test_shooting_is_of_second_order_past_kinks(mounted: bool) -> None:
    machine, drive = parts(mounted)
    momentum = truth(mounted).momentum
    errors = [off(shooting_state(machine, drive, n, momentum).turn, mounted) for n in (2, 8)]
    assert errors[0] / 40.0 < errors[1] < errors[0] / 8.0


@pytest.mark.parametrize(
    ("method", "step", "bound", "gain"),
    [("euler", 2e-4, 0.05, (1.7, 2.4)), ("rk4", 5e-4, 1e-2, (3.0, 40.0))],
)
def test_marches_gain_with_the_step(
    method: str, step: float, bound: float, gain: tuple[float, float]
) -> None:
    found = find(method, *parts(), Settings(None, step, SYNCHRONOUS, truth().momentum))
    assert off(found.turn) < bound
    assert gain[0] < off(found.turn) / off(found.finer) < gain[1]


@pytest.mark.long
def test_a_method_without_a_solution_says_so() -> None:
    machine = as_batch(source_machine(gas_scale=[3.2, 3.2]))
    drive = source_drive(holds=True)
    momentum = started_momentum(machine, SYNCHRONOUS)
    with pytest.raises(NumericalFailure, match="finds no running state"):
        fourier_state(machine, drive, 181, momentum)
    with pytest.raises(NumericalFailure, match="shooting"):
        shooting_state(machine, drive, 4, momentum)
