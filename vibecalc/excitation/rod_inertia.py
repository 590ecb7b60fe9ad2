"""What a connecting rod does to the body beyond the two point masses that stand for it.

Two point masses at the bearings keep the rod's mass m and its mass centre, at l1 from the crank
pin and l2 from the wrist pin, and so every force. Their moment about that centre is m l1 l2; the
rod's own, J, differs from it by dJ = J - m l1 l2.

The crank pin at 90 degrees has drawn the rod's lower end to its side; about the wrist pin that is a
turn against the crank's sense of rotation, so the rod turns by -phi. Beyond its two point masses it
has the angular momentum -dJ phi' w about the axis. The body has to change it and feels the couple
(d'Alembert)

    dJ (phi'' w^2 + phi' dw/dt),

at constant speed the first term: no force, the same about every point. The energy dJ phi'^2 w^2 / 2
comes from the crankshaft, which feels T = -dJ phi' phi'' w^2.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.kinematics.rod_angle import largest_rod_acceleration
from vibecalc.numerics.bounded import Bounded, Operand, bounded, rounded


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
    return rounded(np.asarray(rod_mass, dtype=float) * first * (length - first), 6)


def rod_couple_peak(
    inertia_difference: Operand,
    crank_radius: ArrayLike,
    rod_length: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
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
    return abs(bounded(inertia_difference)) * largest
