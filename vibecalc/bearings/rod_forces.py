"""Forces of the rods on crank pins, wrist pins and cylinder walls, at given crank angles."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.kinematics.slider_crank import piston_path
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray
from vibecalc.parts.geometry import CrankGeometry

# ----------------------------------------------------------------------------
# Newton and Euler for piston and rod of a crank that turns steadily.
#
# In the plane of a cylinder, e outwards along its axis and q a quarter of a turn ahead of it in the
# sense of rotation, forces are complex numbers e + i q. The crank stands at the angle t from e; the
# wrist pin at s(t) e + o q, o the offset. The rod is a mass at each of its ends and what its moment
# of inertia has beyond theirs, dJ. With G the gas force towards the crank and m all the mass that
# goes with the piston,
#
#     piston and rod along e:         F   = -G - m s'' w^2
#     moments on the rod about
#     the crank pin:                  W_q = ((o - R sin t) F + dJ w^2 theta'') / p
#
# with p the rod's projection on e, and theta its angle, tan theta = (o - R sin t) / p. F + i W_q is
# what the rod hands on to the crank pin, besides the centrifugal force of its big end; the piston
# presses on the wall with -W_q, and on the wrist pin with W = F + m_rod s'' w^2 + i W_q, m_rod the
# rod's share of m. (Own derivation; cf. Biezeno and Grammel, Technische Dynamik, ch. XI.)
# ----------------------------------------------------------------------------

#: roundings of the formulas above, of the largest term of each
FORMULA_ROUNDINGS = 48.0


class RunningGear(NamedTuple):
    """c cylinders: angle of each throw from its cylinder at crank angle zero, masses in kg.

    `reciprocating_mass` (c,) is all that goes with a piston, `small_end` (c,) the rod's share of
    it, `big_end` (c,) the mass of the rod at the crank pin; `rod_difference` (c,) in kg m^2 is the
    rod's moment of inertia less that of these two.
    """

    geometry: CrankGeometry
    angle: FloatArray
    reciprocating_mass: FloatArray
    small_end: FloatArray
    big_end: FloatArray
    rod_difference: FloatArray


class RodForces(NamedTuple):
    """Forces (..., c) in N along e + i q of each cylinder, with one absolute error for all.

    `crank_pin`: of the rod on the crank pin, with its big end; `without_big_end`: the same without
    the centrifugal force of that; `wrist_pin`: of the piston on the rod; `wall`: of the piston on
    the cylinder, positive ahead (q).
    """

    crank_pin: ComplexArray
    without_big_end: ComplexArray
    wrist_pin: ComplexArray
    wall: FloatArray
    error: FloatArray


def rod_forces(
    gear: RunningGear, gas_force: Bounded, crank_angle: ArrayLike, speed: ArrayLike
) -> RodForces:
    """Forces of c cylinders at crank angles (...) in rad and speeds (...) in rad/s.

    `gas_force` (..., c) in N pushes towards the crank where it is positive.
    """
    radius, length, offset = gear.geometry[0], gear.geometry[1], gear.geometry[3]
    angle = np.asarray(crank_angle, dtype=float)[..., None] + gear.angle
    square = np.square(np.asarray(speed, dtype=float))[..., None]
    path = piston_path(angle, radius, length, offset)
    aside = offset - radius * np.sin(angle)
    turning = -radius * np.cos(angle) / path.rod
    bending = (radius * np.sin(angle) + aside * turning**2) / path.rod
    inertia = gear.reciprocating_mass * path.acceleration * square
    along = -gas_force.value - inertia
    across = (aside * along + gear.rod_difference * bending * square) / path.rod
    pin = along + 1j * across
    centrifugal = gear.big_end * radius * square * np.exp(1j * angle)
    small_end = gear.small_end * path.acceleration * square
    size = (
        np.abs(gas_force.value)
        + gear.reciprocating_mass * radius * (1.0 + (length * np.cos(angle)) ** 2
                                              * radius / path.rod**3) * square
        + np.abs(centrifugal)
        + np.abs(gear.rod_difference) * (radius + np.abs(aside)) / path.rod**2 * square
    )  # fmt: skip
    turned = 1.0 + np.abs(np.asarray(crank_angle, dtype=float))[..., None] + np.abs(gear.angle)
    slanted = length / path.rod
    error = slanted * (gas_force.error + FORMULA_ROUNDINGS * EPSILON * turned * size)
    return RodForces(pin + centrifugal, pin, pin + small_end, -across, error)


def mixed(parts: list[Bounded], weights: Any) -> Bounded:
    """Values (..., c) of k cards in the shares `weights` (..., k)."""
    share = np.asarray(weights, dtype=float)
    total = [share[..., k, None] * part for k, part in enumerate(parts)]
    found: Bounded = sum(total[1:], total[0])
    return found
