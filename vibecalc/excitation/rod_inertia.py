"""What a connecting rod does to the body beyond the two point masses that stand for it.

Two point masses at the bearings keep the rod's mass m and its mass centre, at l1 from the crank
pin and l2 from the wrist pin, and so every force. Their moment about that centre is m l1 l2; the
rod's own, J, differs from it by dJ = J - m l1 l2.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.inertia_forces import Excitation, order_phasors
from vibecalc.kinematics.rod_angle import largest_rod_acceleration
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON


def split_inertia(
    rod_mass: ArrayLike, crank_pin_to_mass_centre: ArrayLike, rod_length: ArrayLike
) -> Bounded:
    """Moment m l1 l2 of the two point masses about the rod's mass centre, kg m^2, and its error.

    Parameters
    ----------
    rod_mass, crank_pin_to_mass_centre, rod_length : arrays that broadcast
        m in kg, l1 and L = l1 + l2 in m.
    """
    first, length = (np.asarray(v, float) for v in (crank_pin_to_mass_centre, rod_length))
    value = np.asarray(np.asarray(rod_mass, dtype=float) * first * (length - first))
    return Bounded(value, 3.0 * EPSILON * np.abs(value))


def rod_inertia_excitation(
    rod_acceleration: ArrayLike,
    *,
    inertia_difference: ArrayLike,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    axis: ArrayLike,
    motion_error: ArrayLike = 0.0,
    inertia_error: ArrayLike = 0.0,
) -> Excitation:
    """Couple about the crankshaft of c rods for the orders 1 .. n, per crank speed squared.

    The crank pin at 90 degrees has drawn the rod's lower end to its side; about the wrist pin that
    is a turn against the crank's sense of rotation, so the rod turns by -phi. Beyond its two point
    masses it has the angular momentum -dJ phi' w about the axis. The body has to change it and
    feels the couple (d'Alembert)

        dJ (phi'' w^2 + phi' dw/dt),

    at constant speed the first term. It is a couple: no force, the same about every point.

    Parameters
    ----------
    rod_acceleration
        Harmonics (..., n + 1) of phi'' from order 0, see `kinematics.rod_angle`.
    inertia_difference
        dJ (..., c) in kg m^2; zero for a rod that stands still.
    crank_phase, bank_angle
        (..., c) in rad; cylinder i stands at angle + crank_phase - bank_angle.
    axis
        (3,) unit vector along the crankshaft.
    motion_error, inertia_error
        Absolute errors of the harmonics and of dJ; zero takes them as exact.

    Returns
    -------
    Excitation
        Forces of zero, couples (..., n, 3) in kg m^2, errors of both.
    """
    return _about_axis(
        rod_acceleration,
        motion_error,
        inertia_difference,
        inertia_error,
        crank_phase,
        bank_angle,
        axis,
    )


def rod_torque_reaction(
    rod_product: ArrayLike,
    *,
    inertia_difference: ArrayLike,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    axis: ArrayLike,
    motion_error: ArrayLike = 0.0,
    inertia_error: ArrayLike = 0.0,
) -> Excitation:
    """Couple on the body, next to that above, by the torque of the rods on the crankshaft.

    The energy dJ phi'^2 w^2 / 2 comes from the crankshaft: it feels T = -dJ phi' phi'' w^2. As in
    `inertia_torque.torque_reaction` the body has -T. `rod_product` holds the harmonics
    (..., n + 1) of phi' phi'' from order 0; all else as in `rod_inertia_excitation`.
    """
    return _about_axis(
        rod_product,
        motion_error,
        inertia_difference,
        inertia_error,
        crank_phase,
        bank_angle,
        axis,
    )


def rod_couple_peak(
    inertia_difference: ArrayLike,
    crank_radius: ArrayLike,
    rod_length: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
    *,
    inertia_error: ArrayLike = 0.0,
) -> Bounded:
    """Largest couple |dJ| max |phi''| of one rod over a turn, all orders, per speed squared.

    With dJ = m l1 l2 (`split_inertia`) it bounds the couple of every rod of that mass and mass
    centre whose material lies along the line between its bearing centres: then 0 <= J <= m l1 l2,
    because a mass spread over [-l1, l2] about its mean has a variance of at most l1 l2 (Bhatia and
    Davis 2000, A better bound on the variance). Wide eyes around the bearings can exceed it.
    Arrays in kg m^2 and m that broadcast.

    Raises
    ------
    NumericalFailure
        The crank does not turn over: R + |e| >= L.
    """
    largest = largest_rod_acceleration(crank_radius, rod_length, wrist_pin_offset)
    size = np.abs(np.asarray(inertia_difference, dtype=float))
    value = size * largest.value
    error = size * largest.error + np.asarray(inertia_error) * largest.value + EPSILON * value
    return Bounded(value, error)


def _about_axis(
    harmonics: ArrayLike,
    motion_error: ArrayLike,
    inertia: ArrayLike,
    inertia_error: ArrayLike,
    crank_phase: ArrayLike,
    bank_angle: ArrayLike,
    axis: ArrayLike,
) -> Excitation:
    """Sum over the cylinders of moment times harmonic times phasor, along the axis."""
    motion = Bounded(np.asarray(harmonics, dtype=complex), np.asarray(motion_error))[..., 1:, None]
    moment = Bounded(np.asarray(inertia, dtype=float), np.asarray(inertia_error))[..., None, :]
    angle = np.asarray(crank_phase, dtype=float) - np.asarray(bank_angle, dtype=float)
    phasor = Bounded(*order_phasors(angle, np.arange(1, motion.shape[-2] + 1)))
    couple = (moment * motion * phasor).sum()[..., None] * np.asarray(axis, dtype=float)
    none = np.zeros(couple.shape)
    return Excitation(none.astype(complex), couple.value, none, couple.error)
