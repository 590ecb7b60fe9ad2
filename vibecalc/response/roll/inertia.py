"""Inertia of rotor, pistons and shell as the crank turns, and the accelerations that follow.

With theta the angle of the shell, s its rate, and w the speed of the crank against the shell, the
kinetic energy is (J s^2 + 2 N s w + Q w^2) / 2. All three depend on the crank angle b. Lagrange's
equations (docs/theory.md) are, with primes for d/db,

    J ds/dt + N dw/dt + J' w s + N' w^2   = torque of the mounts on the shell,
    N ds/dt + Q dw/dt - J' s^2/2 + Q' w^2/2 = torque between shell and crankshaft.

They are what equations 81 and 88 of Herold (1977) become with their misprints corrected and the
motion of the pistons exact.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.roll.machine import RollMachine


class Inertia(NamedTuple):
    """Inertia at crank angles (..., k), kg m^2, and its derivatives by the angle.

    `shell`, `coupling` and `crank` are J, N and Q, `determinant` is J Q - N^2 without its
    cancellation. `stroke` (..., k, c) is d r/d b of each piston in m, `position` (..., k, c) is r.
    """

    shell: FloatArray
    coupling: FloatArray
    crank: FloatArray
    shell_slope: FloatArray
    coupling_slope: FloatArray
    crank_slope: FloatArray
    determinant: FloatArray
    position: FloatArray
    stroke: FloatArray
    curvature: FloatArray


def inertia(machine: RollMachine, crank_angle: FloatArray) -> Inertia:
    """Inertia of the machines (...,) at the angles (..., k) or (k,), rad."""
    angle = np.asarray(crank_angle)[..., None] + machine.crank_angle_offset[..., None, :]
    offset = machine.wrist_pin_offset[..., None, None]
    radius = machine.crank_radius[..., None, None]
    position, stroke, curvature, rod = piston_path(
        angle, radius, machine.rod_length[..., None, None], offset
    )
    mass = machine.reciprocating_mass[..., None, :]
    rotor = machine.rotor_inertia[..., None]
    moving = mass * stroke
    shell = machine.shell_inertia[..., None] + np.vecdot(mass * position, position)
    crank = np.vecdot(moving, stroke)
    shell_slope = 2.0 * np.vecdot(moving, position)
    crank_slope = 2.0 * np.vecdot(moving, curvature)
    coupling = np.zeros_like(shell)
    coupling_slope = coupling
    if machine.wrist_pin_offset.any():
        shell = shell + np.sum(mass * offset * offset, axis=-1)
        coupling = -np.sum(offset * moving, axis=-1)
        coupling_slope = -np.sum(offset * mass * curvature, axis=-1)
    if machine.rod_inertia_difference.any():
        difference = machine.rod_inertia_difference[..., None, :]
        turn, bend = _rod_turn(machine, angle, rod)
        shell = shell + np.sum(difference, axis=-1)
        coupling = coupling + np.sum(difference * turn, axis=-1)
        coupling_slope = coupling_slope + np.sum(difference * bend, axis=-1)
        crank = crank + np.sum(difference * turn * turn, axis=-1)
        crank_slope = crank_slope + 2.0 * np.sum(difference * turn * bend, axis=-1)
    # the rotor is in J, N and Q alike: formed with it, J Q - N^2 would lose what a light shell has
    determinant = rotor * (shell + crank - 2.0 * coupling) + shell * crank - coupling * coupling
    return Inertia(
        shell + rotor,
        coupling + rotor,
        crank + rotor,
        shell_slope,
        coupling_slope,
        crank_slope,
        determinant,
        position,
        stroke,
        curvature,
    )


def _rod_turn(
    machine: RollMachine, angle: FloatArray, rod: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """First and second derivative of the rod's angle, in the crank's sense, by the crank angle."""
    radius = machine.crank_radius[..., None, None]
    lever = radius * np.cos(angle)
    height = radius * np.sin(angle)
    sine = height - machine.wrist_pin_offset[..., None, None]
    # sin(phi) = sine / L and the rod turns by -phi
    turn = -lever / rod
    return turn, height / rod - sine * lever * lever / rod**3


class Accelerations(NamedTuple):
    """Accelerations of the shell and of the crank against it, rad/s^2."""

    shell: FloatArray
    crank: FloatArray


def accelerations(
    moved: Inertia,
    crank_speed: FloatArray,
    shell_speed: FloatArray,
    shell_torque: FloatArray,
    crank_torque: FloatArray,
) -> Accelerations:
    """Accelerations under a torque on the shell from outside and one between shell and crank, N m.

    All arrays broadcast to the shape of `moved`. The determinant is positive for every machine.
    """
    square = crank_speed * crank_speed
    outer = (
        shell_torque - moved.shell_slope * crank_speed * shell_speed - moved.coupling_slope * square
    )
    inner = crank_torque + 0.5 * (
        moved.shell_slope * shell_speed * shell_speed - moved.crank_slope * square
    )
    return Accelerations(
        (moved.crank * outer - moved.coupling * inner) / moved.determinant,
        (moved.shell * inner - moved.coupling * outer) / moved.determinant,
    )
