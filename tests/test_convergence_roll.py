"""Claim: every way to the running state comes to the same one, at the order that is its own, and
plain marches are the methods they are called.

Truth: collocation with 14 points on each panel, which two ways hold to a billionth of a decibel.
"""

from functools import cache

import numpy as np
import pytest
from roll_machines import SYNCHRONOUS, source_drive, source_machine, straight_drive

from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.roll.march import march_to_repeat
from vibecalc.roll.mechanism import (
    RollDrive,
    RollMachine,
    as_batch,
)
from vibecalc.roll.methods import fourier_state, shooting_state
from vibecalc.roll.steady import SteadyTurn, started_momentum, steady_state
from vibecalc.roll.turn import Turn, harmonics, readings

START = 30.0 * np.pi


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


@pytest.mark.long
def test_a_method_without_a_solution_says_so() -> None:
    machine = as_batch(source_machine(gas_scale=[3.2, 3.2]))
    drive = source_drive(holds=True)
    momentum = started_momentum(machine, SYNCHRONOUS)
    with pytest.raises(NumericalFailure, match="finds no running state"):
        fourier_state(machine, drive, 181, momentum)
    with pytest.raises(NumericalFailure, match="shooting"):
        shooting_state(machine, drive, 4, momentum)
