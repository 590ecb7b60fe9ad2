"""What a start-up carries along in time, and the names of its columns."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray

#: the states of a member; the last four are work done, in J
ANGLE, SPEED, SHELL_ANGLE, SHELL_SPEED, MOTOR_WORK, GAS_WORK, FRICTION_WORK, MOUNT_WORK = range(8)
STATES = 8

#: columns of `piece`
SLOT, CURVE, WAY, LOAD = range(4)


class Load(NamedTuple):
    """Factor on the gas forces: `factor`[i] from `time`[i] (s) on; the first time is 0."""

    time: FloatArray
    factor: FloatArray


FULL_LOAD = Load(np.zeros(1), np.ones(1))


class Torques(NamedTuple):
    """Torques of b members in N m: on the crankshaft motor, gas, friction; of the mounts."""

    motor: FloatArray
    gas: FloatArray
    viscous: FloatArray
    dry: FloatArray
    mounts: FloatArray


class Section(NamedTuple):
    """Members that pass crank angle 2 pi `turn` going forward, at their times in s."""

    member: IntArray
    turn: IntArray
    time: FloatArray
