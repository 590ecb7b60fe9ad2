"""What a turn of the machine means: accelerations, torques, and the forces at each piston."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.inertia import Inertia, accelerations, inertia
from vibecalc.response.roll.machine import RollDrive, RollMachine
from vibecalc.response.roll.torques import (
    friction_torque,
    gas_forces,
    gas_torque,
    motor_torque,
    mount_torque,
)
from vibecalc.response.roll.turn import Turn


class Readings(NamedTuple):
    """Values (..., k) at the points of a turn; SI. Those of cylinders are (..., k, c).

    Accelerations and speeds are positive in the crank's sense of rotation; `rotor_acceleration` is
    against the ground, `crank_speed` against the shell. `motor_torque`, `gas_torque` and
    `friction_torque` act on the crankshaft, `mount_torque` on the shell. `rod_force` is positive in
    compression. `wall_force` is that of a piston on its wall, positive where it turns the shell in
    the crank's sense; `gas_force` pushes the piston towards the crank.
    """

    shell_acceleration: FloatArray
    rotor_acceleration: FloatArray
    crank_speed: FloatArray
    slip: FloatArray
    motor_torque: FloatArray
    gas_torque: FloatArray
    friction_torque: FloatArray
    mount_torque: FloatArray
    rod_force: FloatArray
    wall_force: FloatArray
    gas_force: FloatArray


def readings(
    machine: RollMachine,
    drive: RollDrive,
    turn: Turn,
    driving: FloatArray | None = None,
    *,
    pistons: bool = True,
) -> Readings:
    """Everything that follows from angles and speeds; `driving` replaces the motor's torque.

    Without `pistons` the forces in rods and on walls are left out (zero).
    """
    moved = inertia(machine, turn.crank_angle)
    speed, shell = turn.crank_speed, turn.shell_speed
    forces = gas_forces(machine, drive, turn.crank_angle)
    motor = turn.motor_torque if driving is None else driving
    if motor is None:
        motor = motor_torque(machine, drive, speed).value
    gas = gas_torque(moved, forces)
    friction = friction_torque(machine, moved, speed)
    mounts = mount_torque(machine, turn.shell_angle, shell)
    found = accelerations(moved, speed, shell, mounts, motor + gas + friction)
    rod = wall = np.zeros_like(forces)
    if pistons:
        rod, wall = piston_forces(
            machine, turn, moved, forces, shell_acceleration=found.shell, acceleration=found.crank
        )
    return Readings(
        found.shell,
        found.shell + found.crank,
        speed,
        drive.synchronous_speed[..., None] - speed,
        motor,
        gas,
        friction,
        mounts,
        rod,
        wall,
        forces,
    )


def piston_forces(
    machine: RollMachine,
    turn: Turn,
    moved: Inertia,
    gas: FloatArray,
    *,
    shell_acceleration: FloatArray,
    acceleration: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Force along each rod and of each piston on its wall (..., k, c), N.

    Newton's law for the piston in the turning shell (Herold 1977, equations 71 to 77), with a wrist
    pin offset, friction, and the moment of the rod beyond its two point masses.
    """
    speed, shell = turn.crank_speed[..., None], turn.shell_speed[..., None]
    turning, crank = shell_acceleration[..., None], acceleration[..., None]
    offset = machine.wrist_pin_offset[..., None, None]
    mass = machine.reciprocating_mass[..., None, :]
    angle = turn.crank_angle[..., None] + machine.crank_angle_offset[..., None, :]
    radius = machine.crank_radius[..., None, None]
    length = machine.rod_length[..., None, None]
    outward = moved.stroke * crank + moved.curvature * speed * speed
    along = mass * (outward - moved.position * shell * shell - offset * turning)
    along = along + gas
    along = along + machine.piston_friction[..., None, None] * np.sign(moved.stroke * speed)
    across = mass * (
        moved.position * turning + 2.0 * moved.stroke * speed * shell - offset * shell * shell
    )
    projection = moved.position - radius * np.cos(angle)
    sine, cosine = (radius * np.sin(angle) - offset) / length, projection / length
    difference = machine.rod_inertia_difference[..., None, :]
    twist: FloatArray | float = 0.0
    if np.any(difference):
        lever = radius * np.cos(angle)
        turn_ = -lever / projection
        bend = radius * np.sin(angle) / projection - sine * length * lever**2 / projection**3
        twist = -difference * (turning + turn_ * crank + bend * speed * speed) / length
    rod = (along - twist * sine) / cosine
    return np.asarray(rod), np.asarray(-across - rod * sine + twist * cosine)
