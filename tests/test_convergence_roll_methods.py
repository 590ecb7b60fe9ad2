"""Claim: every way to the running state comes to the same one, at the order that is its own.

Truth: collocation with 14 points on each panel, which two ways hold to a billionth of a decibel.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from roll_machines import SYNCHRONOUS, source_drive, source_machine

from vibecalc.errors import NumericalFailure
from vibecalc.roll.mechanism import RollDrive, RollMachine, as_batch
from vibecalc.roll.methods import Settings, find, fourier_state, shooting_state
from vibecalc.roll.steady import SteadyTurn, started_momentum, steady_state
from vibecalc.roll.turn import Turn, harmonics, readings

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


def test_a_method_without_a_solution_says_so() -> None:
    machine = as_batch(source_machine(gas_scale=[3.2, 3.2]))
    drive = source_drive(holds=True)
    momentum = started_momentum(machine, SYNCHRONOUS)
    with pytest.raises(NumericalFailure, match="finds no running state"):
        fourier_state(machine, drive, 181, momentum)
    with pytest.raises(NumericalFailure, match="shooting"):
        shooting_state(machine, drive, 4, momentum)
