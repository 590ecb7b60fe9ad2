"""The exact motion of a line with variable inertias: its terms, its linearisation, its energy.

Linearised about a motion phi(t), small deviations d obey

    (J d')' + C d' + (K + S) d = 0,   S = J' phi'' + 1/2 J'' (w + phi')^2 - dT/dtheta,

with J at theta = w t + phi; about uniform turning (phi = 0) S is 1/2 w^2 J'' - dT/dtheta, and what
is missing there, T - 1/2 w^2 J', is gas and inertia torque as usual.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.line import damping_matrix, stiffness_matrix
from vibecalc.response.torsion.variable_inertia import VariableLine, inertia_at


class Terms(NamedTuple):
    """At crank angles (S,): what multiplies d'', d' and d, and the torque left over, each (S, n).

    `gap` is T - J phi'' - 1/2 J' (w + phi')^2, without the terms of shafts and dampers.
    """

    inertia: FloatArray
    inertia_rate: FloatArray
    stiffness: FloatArray
    gap: FloatArray


class Course(NamedTuple):
    """Twist of every freedom against uniform turning (S, n), its rate and acceleration."""

    angle: FloatArray
    rate: FloatArray
    acceleration: FloatArray


def course(harmonics: ComplexArray, turns: int, speed: float, crank_angle: FloatArray) -> Course:
    """Values at w t = crank_angle (S,) of harmonics (N + 1, n), orders k / turns, 0-to-peak."""
    order = np.arange(len(harmonics)) / turns
    phase = np.exp(1j * np.asarray(crank_angle)[:, None] * order)
    turn = (1j * speed * order)[:, None]
    parts = (harmonics, turn * harmonics, turn**2 * harmonics)
    return Course(*((phase @ part).real for part in parts))


def terms(
    system: VariableLine,
    speed: float,
    crank_angle: FloatArray,
    angle: ComplexArray,
    torque: ComplexArray,
    *,
    follows: bool,
) -> Terms:
    """Terms about the motion `angle` (N + 1, n) at w t = crank_angle (S,).

    `torque` (T, n) holds the gas torque's orders k / turns, 0-to-peak (order 0 its real part); with
    `follows` it is a function of each throw's own angle, else of w t alone.
    """
    motion = course(angle, system.turns, speed, crank_angle)
    place = np.asarray(crank_angle)[:, None] + motion.angle
    inertia = inertia_at(system, place)
    order = np.arange(len(torque))[:, None] / system.turns
    at = place if follows else np.broadcast_to(np.asarray(crank_angle)[:, None], place.shape)
    turned = np.exp(1j * at[:, None, :] * order) * torque
    slope = -(order * turned.imag).sum(axis=1) if follows else 0.0
    turning = speed + motion.rate
    gap = turned.real.sum(axis=1)
    gap = gap - inertia.value * motion.acceleration - 0.5 * inertia.slope * turning**2
    stiffness = inertia.slope * motion.acceleration + 0.5 * inertia.curvature * turning**2 - slope
    return Terms(inertia.value, inertia.slope * turning, stiffness, gap)


def acceleration(
    system: VariableLine,
    speed: float,
    crank_angle: float,
    angle: FloatArray,
    rate: FloatArray,
    torque: FloatArray,
) -> FloatArray:
    """phi'' (..., n) of the exact equations for phi and phi' (..., n) and torques (..., n), N m.

    Shafts act through their stiffness and damping; loss factors have no form in time.
    """
    inertia = inertia_at(system, crank_angle + angle)
    shafts = angle @ stiffness_matrix(system.line) + rate @ damping_matrix(system.line)
    return np.asarray((torque - shafts - 0.5 * inertia.slope * (speed + rate) ** 2) / inertia.value)


def energy(
    system: VariableLine, speed: float, crank_angle: float, angle: FloatArray, rate: FloatArray
) -> FloatArray:
    """Kinetic energy of the turning line and potential energy of its shafts (...,), J."""
    inertia = inertia_at(system, crank_angle + angle).value
    kinetic = 0.5 * (inertia * (speed + rate) ** 2).sum(axis=-1)
    stored = 0.5 * (angle * (angle @ stiffness_matrix(system.line))).sum(axis=-1)
    return np.asarray(kinetic + stored)
