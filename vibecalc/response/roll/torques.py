"""Torques between shell and crankshaft: motor, gas, friction; and of the mounts on the shell."""

import numpy as np

from vibecalc.excitation.gas_tables import TURN, force_at
from vibecalc.excitation.induction_motor_flux import circuit_torque
from vibecalc.excitation.slip_torque import Torque, slip_torque
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.roll.inertia import Inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine


def gas_forces(machine: RollMachine, drive: RollDrive, crank_angle: FloatArray) -> FloatArray:
    """Force of the gas on each piston (..., k, c), N towards the crank, at angles (..., k)."""
    lead = np.broadcast_shapes(np.shape(crank_angle), (*machine.crank_radius.shape, 1))
    found = np.zeros((*lead, len(drive.gas)))
    for place, gas in enumerate(drive.gas):
        if gas is not None:
            own = crank_angle + machine.crank_angle_offset[..., None, place]
            found[..., place] = machine.gas_scale[..., None, place] * force_at(gas, own)
    return found


def gas_torque(moved: Inertia, forces: FloatArray) -> FloatArray:
    """Torque of the gas on the crankshaft (..., k), N m; over a turn it does the gas's work."""
    return np.asarray(-np.vecdot(forces, moved.stroke))


def motor_torque(
    machine: RollMachine,
    drive: RollDrive,
    crank_speed: FloatArray,
    piece: IntArray | None = None,
) -> Torque:
    """Steady torque of the motor (..., k), N m, and its slope by slip; `piece`: `slip_torque`."""
    slip = drive.synchronous_speed[..., None] - crank_speed
    value, slope = steady_curve(drive, slip, piece)
    scale = machine.motor_scale[..., None]
    return Torque(scale * value, scale * slope)


def steady_curve(drive: RollDrive, slip: FloatArray, piece: IntArray | None = None) -> Torque:
    """Torque in N m at steady slips (...,), rad/s, of one motor, by its circuit or its table."""
    if drive.circuit is not None:
        return circuit_torque(drive.circuit, slip)
    return slip_torque(drive.motor, slip, piece)


def friction_torque(machine: RollMachine, moved: Inertia, crank_speed: FloatArray) -> FloatArray:
    """Torque of friction on the crankshaft (..., k), N m, against its motion."""
    dry = machine.friction_torque[..., None] + machine.piston_friction[..., None] * np.sum(
        np.abs(moved.stroke), axis=-1
    )
    return np.asarray(
        -dry * np.sign(crank_speed) - machine.friction_damping[..., None] * crank_speed
    )


def mount_torque(
    machine: RollMachine, shell_angle: FloatArray, shell_speed: FloatArray
) -> FloatArray:
    """Torque of the mounts on the shell (..., k), N m."""
    return np.asarray(
        -machine.shell_stiffness[..., None] * shell_angle
        - machine.shell_damping[..., None] * shell_speed
    )


#: rad, the widest panel; where the crank stands across a cylinder, narrower ones if R/L is near 1
WIDEST = np.pi / 18.0
_LONG_RODS = 0.8
#: rad of the highest order on one panel
_OF_A_WAVE = 4.0


def smooth_angles(machine: RollMachine, drive: RollDrive, widest: float = WIDEST) -> FloatArray:
    """Crank angles from 0 to 2 pi (m,) between which all that hangs on the angle alone is smooth.

    Nodes of the gas tables, and with friction of the pistons their dead centres (of many machines,
    those of the first). No two are further apart than `widest`, rad; towards the angles at which a
    short rod lies across its cylinder they crowd together.
    """
    offsets = machine.crank_angle_offset.reshape(-1, len(drive.gas))[0]
    found = [np.array([0.0, TURN])]
    for gas, offset in zip(drive.gas, offsets, strict=True):
        if gas is not None:
            found.append(np.mod(gas.node - offset, TURN))
        if np.any(machine.piston_friction):
            found.append(np.mod(dead_centres(machine).reshape(-1, 2)[0] - offset, TURN))
        found.append(np.mod(_steep(machine) - offset, TURN))
    every = np.sort(np.concatenate(found))
    kept = every[np.concatenate([[True], np.diff(every) > 1e-9])]
    kept[-1] = TURN
    parts = np.ceil(np.diff(kept) / (widest * (1.0 + 1e-9))).astype(int)
    start = np.repeat(kept[:-1], parts)
    place = np.arange(len(start)) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.append(start + place * np.repeat(np.diff(kept) / parts, parts), TURN)


def widest_panel(orders: int) -> float:
    """Width of panels, rad, on which the highest of the `orders` has less than one wave."""
    return min(WIDEST, _OF_A_WAVE / orders)


def dead_centres(machine: RollMachine) -> FloatArray:
    """Own angles (..., 2) at which crank and rod lie along one line."""
    radius, length = machine.crank_radius[..., None], machine.rod_length[..., None]
    reach = length + radius * np.array([1.0, -1.0])
    tilt = np.arcsin(machine.wrist_pin_offset[..., None] / reach)
    return np.asarray(tilt + np.array([0.0, np.pi]))


def _steep(machine: RollMachine) -> FloatArray:
    """Own angles around which the motion of a piston with a short rod changes quickly."""
    reach = np.max((machine.crank_radius + np.abs(machine.wrist_pin_offset)) / machine.rod_length)
    if reach < _LONG_RODS:
        return np.empty(0)
    width = float(np.sqrt(2.0 * (1.0 - reach)))
    steps = width * 2.0 ** np.arange(0, max(1, int(np.ceil(np.log2(WIDEST / width) + 1))))
    away = np.concatenate([-steps, [0.0], steps])
    return np.concatenate([0.5 * np.pi + away, 1.5 * np.pi + away])
