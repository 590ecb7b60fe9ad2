"""Do energy and angular momentum balance over a turn? The check that a found motion has to pass."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.inertia import inertia
from vibecalc.response.roll.machine import RollMachine, is_mounted
from vibecalc.response.roll.readings import Readings
from vibecalc.response.roll.turn import Turn


class Balance(NamedTuple):
    """Work over a turn (...,) in J, and what is left over; angular momentum in N m s.

    `gas`, `friction` and `mounts` are what these take up. `residual` is the work of the motor less
    all of them and would be zero. `momentum` is the mean angular momentum about the crank axis,
    `momentum_residual` how far it strays in the turn from what the torque of the mounts explains.
    """

    motor: FloatArray
    gas: FloatArray
    friction: FloatArray
    mounts: FloatArray
    residual: FloatArray
    momentum: FloatArray
    momentum_residual: FloatArray


def balance(machine: RollMachine, turn: Turn, read: Readings) -> Balance:
    """Work of every torque and the course of the angular momentum, from the points of a turn."""
    moved = inertia(machine, turn.crank_angle)
    motor = np.sum(turn.weight * read.motor_torque, axis=-1)
    gas = -np.sum(turn.weight * read.gas_torque, axis=-1)
    friction = -np.sum(turn.weight * read.friction_torque, axis=-1)
    rate = turn.weight / turn.crank_speed
    mounts = -np.sum(rate * read.mount_torque * turn.shell_speed, axis=-1)
    momentum = moved.shell * turn.shell_speed + moved.coupling * turn.crank_speed
    middle = np.sum(rate * momentum, axis=-1) / turn.period
    if is_mounted(machine):
        # over a turn the mounts may not change it
        strayed = np.abs(np.sum(rate * read.mount_torque, axis=-1))
    else:
        strayed = np.max(np.abs(momentum - middle[..., None]), axis=-1)
    return Balance(
        motor, gas, friction, mounts, motor - gas - friction - mounts, middle, np.asarray(strayed)
    )
