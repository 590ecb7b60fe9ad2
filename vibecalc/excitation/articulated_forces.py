"""Inertia forces and torque of pistons on slave rods, per order and per crank speed squared."""

from typing import NamedTuple

import numpy as np

from vibecalc.kinematics.articulated_rod import (
    FIRST_SAMPLES,
    SlaveRods,
    harmonics_of_turn,
    slave_motion,
)
from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.rounding import FloatArray

# ----------------------------------------------------------------------------
# A slave rod is two point masses: one goes with the piston along its cylinder, one with the knuckle
# pin in the plane of the crank. By d'Alembert both push the body with -m times their acceleration;
# their moment about the crank axis reaches the body as it is, and so does, the shaft being turned
# at constant speed, the change of their kinetic energy:
#
#     f = -m s'' exp(i b) - m_k z'',   M = o m s'' - m_k Im(conj(z) z''),
#     -T = dE/dt,  E = (m s'^2 + m_k |z'|^2) / 2,
#
# all times the speed squared. What the rod's moment of inertia has beyond that of both masses, dJ,
# adds -dJ chi'' to M and dJ chi'^2 / 2 to E, chi the angle of the rod. With r = 0 the knuckle mass
# pulls as one at the crank pin does and has no moment.
# ----------------------------------------------------------------------------


class SlaveMasses(NamedTuple):
    """Masses (k, 1) in kg, with each piston and with each knuckle pin; places (k, 3) in m.

    `place` is where the plane of the cylinder meets the crank axis, from the body's reference
    point; `rod_difference` (k, 1) in kg m^2, with its error, is the moment of inertia of the rods
    beyond that of these masses.
    """

    reciprocating: FloatArray
    knuckle: FloatArray
    place: FloatArray
    rod_difference: Bounded = Bounded(np.zeros(()), np.zeros(()))


def slave_excitation(
    rods: SlaveRods,
    masses: SlaveMasses,
    *,
    axis: FloatArray,
    stroke: FloatArray,
    across: FloatArray,
    highest_order: int,
    with_torque: bool = False,
) -> Bounded:
    """Loads (n, 6) in kg m and kg m^2 of k slaves for the orders 1 .. highest_order.

    `with_torque`: the body bears minus the torque of these masses on the crankshaft.

    Raises NumericalFailure where no number of crank angles resolves the motion.
    """

    def signals(angle: FloatArray) -> FloatArray:
        motion = slave_motion(rods, angle)
        along, knuckle = motion.acceleration, motion.knuckle_acceleration
        mass, pin, rod = masses.reciprocating, masses.knuckle, masses.rod_difference.value
        force = -mass * along * np.exp(1j * rods.bank) - pin * knuckle
        moment = rods.wrist_pin_offset * mass * along
        moment = moment - pin * (np.conj(motion.knuckle) * knuckle).imag
        moment = moment - rod * motion.bend
        if with_torque:
            moment = moment + mass * motion.velocity * along
            moment = moment + pin * (np.conj(motion.knuckle_velocity) * knuckle).real
            moment = moment + rod * motion.turn * motion.bend
        return np.stack([force.real, force.imag, moment], axis=-2)

    found = reshaped(
        harmonics_of_turn(signals, highest_order)[..., 1:], lambda part: np.swapaxes(part, -1, -2)
    )
    both = np.stack([stroke, -np.asarray(across)])
    levers = np.cross(masses.place[:, None, :], both)
    pulls = (
        found[..., :2] @ np.concatenate([np.broadcast_to(both, levers.shape), levers], -1)
    ).sum(0)
    moments = found[..., 2].sum(0)
    swing = slave_motion(rods, np.linspace(0.0, 2.0 * np.pi, FIRST_SAMPLES))
    slip = masses.rod_difference.error * np.abs(swing.bend) * (1.0 + np.abs(swing.turn))
    moments = Bounded(moments.value, moments.error + slip.max(axis=-1).sum())
    return pulls + moments[:, None] * np.concatenate([np.zeros(3), axis])
