"""What the textbook leaves out: forces at constant speed in a shell that stands still.

Herold (1977) concludes that these assumptions cost little in the forces; here by how much.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.roll.inertia import inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.readings import piston_forces
from vibecalc.response.roll.torques import gas_forces
from vibecalc.response.roll.turn import Turn, harmonics


class Classical(NamedTuple):
    """Forces (..., k, c) of one turn at constant speed, and their harmonics (..., c, orders), N."""

    rod_force: FloatArray
    wall_force: FloatArray
    rod_harmonics: ComplexArray
    wall_harmonics: ComplexArray


def constant_speed(turn: Turn) -> Turn:
    """The turn with the same mean speed held all the time, and the shell at rest."""
    speed = 2.0 * np.pi / turn.period[..., None]
    still = np.zeros_like(turn.shell_speed)
    return turn._replace(
        time=turn.crank_angle / speed,
        crank_speed=np.broadcast_to(speed, turn.crank_speed.shape),
        shell_speed=still,
        shell_angle=still,
    )


def classical(machine: RollMachine, drive: RollDrive, turn: Turn, orders: FloatArray) -> Classical:
    """Forces in rods and on walls under the textbook's assumptions, at the points of `turn`."""
    held = constant_speed(turn)
    moved = inertia(machine, held.crank_angle)
    still = np.zeros_like(held.crank_speed)
    rod, wall = piston_forces(
        machine,
        held,
        moved,
        gas_forces(machine, drive, held.crank_angle),
        shell_acceleration=still,
        acceleration=still,
    )
    return Classical(rod, wall, by_cylinder(held, rod, orders), by_cylinder(held, wall, orders))


def by_cylinder(turn: Turn, values: FloatArray, orders: FloatArray) -> ComplexArray:
    """Harmonics (..., c, orders) of what has one column for each cylinder, (..., k, c)."""
    each = [harmonics(turn, values[..., place], orders) for place in range(values.shape[-1])]
    return np.stack(each, axis=-2)
