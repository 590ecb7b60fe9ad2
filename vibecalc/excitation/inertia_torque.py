"""The torque of the pistons on the crankshaft, and what of it reaches the body."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.reciprocating import order_phasors
from vibecalc.excitation.sums import Complex, Excitation, Real
from vibecalc.numerics.rounding import EPSILON


class TorqueHarmonics(NamedTuple):
    """Orders 0 .. n (..., n + 1) of the inertia torque over m R^2 w^2; order 0 is zero."""

    harmonics: Complex
    error: Real


def inertia_torque(
    motion_harmonics: ArrayLike,
    highest_order: int,
    *,
    dropped_acceleration: ArrayLike = 0.0,
    motion_error: ArrayLike = 0.0,
) -> TorqueHarmonics:
    """Harmonics of -s' s'', the torque of one piston on the crank over m R^2 w^2.

    At constant speed the kinetic energy m s'^2 w^2 / 2 changes at the rate of the torque the crank
    gives away, hence T = -m w^2 s' s''. The product of two series is a convolution of their
    coefficients, taken over all motion harmonics that are given: (ab)_n is half the sum of
    a_j b_k over j + k = n, of a_j conj(b_k) over j - k = n and of conj(a_j) b_k over k - j = n.

    Parameters
    ----------
    motion_harmonics
        C_n (..., h + 1) of s / R from order 0, with h >= highest_order.
    dropped_acceleration
        Sum of n^2 |C_n| over the orders above h that the motion has and the array has not. An
        order above h meets only partners above h - n, whence the bound on what is cut.
    motion_error
        Absolute errors (..., h + 1) of the harmonics; zero takes them as exact.

    Raises
    ------
    ValueError
        If there are fewer motion harmonics than orders asked for.
    """
    motion = np.asarray(motion_harmonics, dtype=complex)
    highest = motion.shape[-1] - 1
    if highest_order > highest:
        raise ValueError(f"order {highest_order} of the torque needs as many motion harmonics")
    index = np.arange(highest + 1)
    slip = np.broadcast_to(np.asarray(motion_error, dtype=float), motion.shape)
    velocity, acceleration = 1j * index * motion, -(index**2) * motion
    speed, force = np.abs(velocity), np.abs(acceleration)
    speed_slip, force_slip = index * slip, index**2 * slip
    dropped = np.asarray(dropped_acceleration, dtype=float)

    harmonics = np.zeros((*motion.shape[:-1], highest_order + 1), dtype=complex)
    error = np.zeros(harmonics.shape)
    for order in range(1, highest_order + 1):
        low, high = slice(None, highest + 1 - order), slice(order, None)
        up, down = slice(None, order + 1), slice(order, None, -1)
        total = (
            (velocity[..., up] * acceleration[..., down]).sum(-1)
            + (velocity[..., high] * acceleration[..., low].conj()).sum(-1)
            + (velocity[..., low].conj() * acceleration[..., high]).sum(-1)
        )
        harmonics[..., order] = -0.5 * total
        rounding = sum(
            (speed[..., a] * (4.0 * EPSILON * force[..., b] + force_slip[..., b])).sum(-1)
            + (speed_slip[..., a] * force[..., b]).sum(-1)
            for a, b in ((up, down), (high, low), (low, high))
        )
        tail = slice(max(0, highest + 1 - order), None)
        partner_speed = np.maximum(speed[..., tail].max(-1), dropped / (highest + 1))
        partner_force = np.maximum(force[..., tail].max(-1), dropped)
        cut = dropped * (partner_speed + partner_force / (highest + 1))
        error[..., order] = 0.5 * rounding + cut
    return TorqueHarmonics(harmonics, error)


def mean_inertia(
    motion_harmonics: ArrayLike, crank_radius: ArrayLike, reciprocating_mass: ArrayLike
) -> Real:
    """Mean over a turn (...) of what the pistons add to the inertia at the crank, kg m^2.

    That is the sum of m s'^2 over the cylinders: m R^2 sum n^2 |C_n|^2 / 2 each. Arrays as in
    `torque_reaction`, `motion_harmonics` (..., h + 1) from order 0.
    """
    motion = np.asarray(motion_harmonics)
    velocity = np.arange(motion.shape[-1]) * np.abs(motion)
    square = 0.5 * np.square(velocity).sum(-1) * np.square(np.asarray(crank_radius, dtype=float))
    return np.asarray(np.asarray(reciprocating_mass, dtype=float).sum(-1) * square)


def rotor_share(rotor_inertia: ArrayLike, moving_inertia: ArrayLike) -> Real:
    """Share of the torque at constant speed that reaches a rotor of finite inertia.

    The rotor follows J phi'' = T - m phi'', m the mean inertia of what moves with the pistons: it
    takes T J / (J + m), and the body has minus that. What the fluctuation of the speed mixes
    between the orders is of relative size m / J and left out.
    """
    rotor = np.asarray(rotor_inertia, dtype=float)
    return np.asarray(rotor / (rotor + np.asarray(moving_inertia, dtype=float)))


def torque_reaction(
    torque: TorqueHarmonics,
    *,
    crank_radius: ArrayLike,
    reciprocating_mass: ArrayLike,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    axis: ArrayLike,
) -> Excitation:
    """Couple on the body about the crankshaft by the torque of its masses.

    The side thrusts of the pistons turn the body with -T, in addition to r x F. T goes into the
    speed of a large rotor, whose angular momentum changes by it; a stator that gives a constant
    torque adds nothing that alternates, wherever it stands.

    Arrays as in `reciprocating_excitation`; (..., n, 3) per crank speed squared, without force.
    """
    harmonics = torque.harmonics[..., 1:]
    orders = np.arange(1, harmonics.shape[-1] + 1)
    square = np.asarray(crank_radius, dtype=float)[..., None] ** 2
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    phasor, phasor_error = order_phasors(angle, orders)
    mass = np.asarray(reciprocating_mass, dtype=float)[..., None, :]
    turn = mass * (square * harmonics)[..., None] * phasor
    turn_error = (
        np.abs(turn) * (3.0 * EPSILON + phasor_error)
        + mass * (square * torque.error[..., 1:])[..., None]
    )
    axis = np.asarray(axis, dtype=float)
    couple = -turn.sum(-1)[..., None] * axis
    none = np.zeros(couple.shape)
    return Excitation(
        none.astype(complex), couple, none, turn_error.sum(-1)[..., None] * np.abs(axis)
    )
