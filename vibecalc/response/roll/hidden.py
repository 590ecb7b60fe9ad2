"""Harmonics that are there but smaller than what the points leave open of them."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.roll.classical import by_cylinder
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.readings import Readings, readings
from vibecalc.response.roll.turn import Turn, harmonics

#: values at the points of which no spectrum is shown
_NOT_SHOWN = frozenset({"friction_torque", "gas_force"})
#: those with an entry for each cylinder
_OF_PISTONS = frozenset({"rod_force", "wall_force"})
_SAFE = 2.0


def rounding_left(machine: RollMachine, read: Readings, name: str) -> float:
    """What rounding leaves in the harmonics of one reading of one machine (B = 1), its own unit."""
    size = float(np.max(np.abs(getattr(read, name)), initial=0.0))
    if name.endswith("_acceleration"):
        # the torques balance each other before anything is left
        crank = float(np.max(np.abs(read.motor_torque)) + np.max(np.abs(read.gas_torque)))
        size += crank / float(machine.shell_inertia[0])
    return 32.0 * EPSILON * size


def hides(machine: RollMachine, drive: RollDrive, one: Turn, other: Turn, orders: int) -> bool:
    """Whether a harmonic above rounding is smaller than about the difference of the two turns.

    It would pass for zero, and be none.
    """
    both = [readings(machine, drive, turn) for turn in (one, other)]
    numbers = np.arange(1.0, orders + 1)
    for name in Readings._fields:
        if name in _NOT_SHOWN:
            continue
        by_order = by_cylinder if name in _OF_PISTONS else harmonics
        first, second = (
            by_order(turn, np.asarray(getattr(read, name)), numbers)
            for turn, read in zip((one, other), both, strict=True)
        )
        rounding = rounding_left(machine, both[1], name)
        size, apart = np.abs(second), np.abs(second - first)
        if np.any((size > _SAFE * rounding) & (size <= _SAFE * apart + rounding)):
            return True
    return False
