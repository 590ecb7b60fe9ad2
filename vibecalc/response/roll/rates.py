"""How the state of the machine changes with the crank angle: what a periodic motion solves.

While the crank turns one way, the crank angle b can stand for time: a motion that repeats every
turn is then a solution of dy/db = f(b, y) of period 2 pi, with the period in time as a result and
no phase left open. A free shell drops out with its angular momentum H:

    mu w dw/db + mu' w^2 / 2 - H^2 J' / (2 J^2) = torque,   mu = Q - N^2 / J,   s = (H - N w) / J,

one equation for the speed w of the crank. With mounts the state is w, the angle of the shell and s.
(Own derivation; inertias as in `inertia.py`.)
"""

from typing import NamedTuple

import numpy as np

from vibecalc.excitation.slip_torque import Torque
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.roll.inertia import Inertia, accelerations, inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.torques import friction_torque, gas_forces, gas_torque, motor_torque


class Place(NamedTuple):
    """What depends on the crank angle alone, at angles (..., k)."""

    moved: Inertia
    load: FloatArray
    drag: FloatArray


def place_at(machine: RollMachine, drive: RollDrive, crank_angle: FloatArray) -> Place:
    """Inertia, and torque of gas and dry friction, N m, at crank angles (..., k)."""
    moved = inertia(machine, crank_angle)
    load = gas_torque(moved, gas_forces(machine, drive, crank_angle))
    if machine.friction_torque.any() or machine.piston_friction.any():
        dry = machine._replace(friction_damping=np.zeros_like(machine.friction_damping))
        load = load + friction_torque(dry, moved, np.ones(1))
    return Place(moved, load, machine.friction_damping[..., None])


class Rates(NamedTuple):
    """dy/db (..., k, n) and its Jacobian (..., k, n, n)."""

    value: FloatArray
    jacobian: FloatArray


def free_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: Place,
    momentum: FloatArray,
    speed: FloatArray,
    piece: IntArray | None = None,
    driving: Torque | None = None,
) -> tuple[FloatArray, FloatArray]:
    """dw/db and its derivative by w (..., k) for a free shell with angular momentum (...,).

    `driving` replaces the steady torque of the motor at the slip.
    """
    moved = place.moved
    motor, slope = driving or motor_torque(machine, drive, speed, piece)
    share = moved.coupling / moved.shell
    effective = moved.determinant / moved.shell
    steep = (
        moved.crank_slope - 2.0 * share * moved.coupling_slope + share * share * moved.shell_slope
    )
    drift = momentum[..., None] / moved.shell
    torque = motor + place.load - place.drag * speed + 0.5 * drift * drift * moved.shell_slope
    rate = (torque / speed - 0.5 * steep * speed) / effective
    change = (-torque / speed - slope - place.drag) / speed - 0.5 * steep
    return rate, change / effective


def mounted_rates(
    machine: RollMachine,
    drive: RollDrive,
    place: Place,
    state: FloatArray,
    piece: IntArray | None = None,
    driving: Torque | None = None,
) -> Rates:
    """dy/db for y = (w, shell angle, s) (..., k, 3), the shell held by mounts; see `free_rates`."""
    speed, angle, shell = state[..., 0], state[..., 1], state[..., 2]
    moved = place.moved
    motor, slope = driving or motor_torque(machine, drive, speed, piece)
    stiffness, damping = machine.shell_stiffness[..., None], machine.shell_damping[..., None]
    outer = -stiffness * angle - damping * shell
    inner = motor + place.load - place.drag * speed
    found = accelerations(moved, speed, shell, outer, inner)
    value = np.stack([found.crank, shell, found.shell], axis=-1) / speed[..., None]

    # derivatives of the two torques by w, angle, s
    outer_by = np.stack(
        [
            -moved.shell_slope * shell - 2.0 * moved.coupling_slope * speed,
            np.broadcast_to(-stiffness, speed.shape),
            -damping - moved.shell_slope * speed,
        ],
        axis=-1,
    )
    inner_by = np.stack(
        [
            -slope - place.drag - moved.crank_slope * speed,
            np.zeros_like(speed),
            moved.shell_slope * shell,
        ],
        axis=-1,
    )
    j, n, q, over = (
        np.asarray(part)[..., None]
        for part in (moved.shell, moved.coupling, moved.crank, moved.determinant * speed)
    )
    jacobian = np.zeros((*speed.shape, 3, 3))
    jacobian[..., 0, :] = (j * inner_by - n * outer_by) / over
    jacobian[..., 1, 2] = 1.0 / speed
    jacobian[..., 2, :] = (q * outer_by - n * inner_by) / over
    jacobian[..., :, 0] -= value / speed[..., None]
    return Rates(value, jacobian)


def shell_speed(place: Place, momentum: FloatArray, speed: FloatArray) -> FloatArray:
    """Angular speed s of a free shell with angular momentum (...,), at crank speeds (..., k)."""
    return np.asarray((momentum[..., None] - place.moved.coupling * speed) / place.moved.shell)
