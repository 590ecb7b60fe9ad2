"""The motor's curve as a straight line through the slip at which the machine runs."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.excitation.slip_torque import SlipCurve, slip_torque
from vibecalc.response.roll.demand import demand
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.torques import motor_torque

_HALVINGS = 80
_STEPS = 8


class Tangent(NamedTuple):
    """Torque = gain slip + offset near `slip` (rad/s); `gain` N m s/rad, `offset` N m."""

    slip: float
    gain: float
    offset: float


def tangent(machine: RollMachine, drive: RollDrive) -> Tangent:
    """Tangent of the motor's curve of one machine (B = 1) where it meets the mean demand.

    Raises NumericalFailure where the motor never gives what gas and friction ask for.
    """
    need = demand(machine, drive)
    if not need.possible[0]:
        raise NumericalFailure(
            f"control: no running state exists: gas and friction ask for {need.torque[0]:.6g} N*m "
            f"on average, more than the motor gives ({need.breakdown[0]:.6g} N*m at breakdown)"
        )
    sync = float(np.max(drive.synchronous_speed))
    drag = float(machine.friction_damping[0])

    def spare(slip: float) -> float:
        at = motor_torque(machine, drive, np.array([[sync - slip]]))
        return float(at.value[0, 0]) - drag * (sync - slip) - float(need.torque[0])

    slip = _rising_zero(spare, float(need.slip[0]), sync)
    found = slip_torque(drive.motor, np.array([slip]))
    scale = float(machine.motor_scale[0])
    gain, torque = scale * float(found.slope[0]), scale * float(found.value[0])
    if gain <= 0.0:
        raise NumericalFailure(
            f"control: the motor's torque does not rise with the slip at {slip:.6g} rad/s, where "
            "the machine runs: give motor_gain"
        )
    return Tangent(slip, gain, torque - gain * slip)


def straight(gain: float, offset: float = 0.0) -> SlipCurve:
    """The curve of such a line, for any slip."""
    return SlipCurve(np.empty(0), np.zeros(1), np.array([[offset, gain]]), np.inf)


def _rising_zero(spare: Callable[[float], float], near: float, size: float) -> float:
    """Where a function rises through zero, by halving a bracket around a guess."""
    width = 1e-6 * size
    low, high = near - width, near + width
    for _ in range(_STEPS):
        if spare(low) <= 0.0 <= spare(high):
            break
        width *= 10.0
        low, high = near - width, near + width
    else:
        return near
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if spare(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)
