"""Forces of unbalances that turn at constant speed, per crank speed squared."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.sums import Excitation, cross_magnitude
from vibecalc.numerics.rounding import EPSILON


def rotating_excitation(
    *,
    unbalance: ArrayLike,
    speed_ratio: ArrayLike,
    phase: ArrayLike,
    position: ArrayLike,
    origin: ArrayLike,
    stroke: ArrayLike,
    across: ArrayLike,
    highest_order: int,
) -> Excitation:
    """Forces and couples of m unbalances U for the orders 1 .. highest_order.

    A shaft at `speed_ratio` q has its unbalance at the angle `phase + q * crank angle` from the
    stroke, in the crank's sense of rotation, and pulls the body with U q^2 outwards: a vector that
    turns, stroke + i across at order q, or stroke - i across with the phase reversed at order -q.
    At constant speed its angular momentum about its own axis is constant, so that the couple is
    r x F with r on that axis. A shaft faster than `highest_order` is left out, as are the pistons'
    harmonics above it.

    Parameters
    ----------
    unbalance, speed_ratio, phase
        (..., m) in kg m, integers other than zero, rad.
    position
        (..., m, 3) in m from the train's origin along x, y, z.
    origin, stroke, across
        (3,) the train's origin from the body's reference point in m, and unit vectors.

    Returns
    -------
    Excitation
        Forces (..., highest_order, 3) in kg m, couples in kg m^2, errors of both.
    """
    ratio = np.asarray(speed_ratio)
    sense = np.sign(ratio)
    strength = np.asarray(unbalance, dtype=float) * ratio**2
    angle = sense * np.asarray(phase, dtype=float)
    pull = strength * (np.cos(angle) + 1j * np.sin(angle))

    stroke, across = np.asarray(stroke, dtype=float), np.asarray(across, dtype=float)
    turning = stroke + 1j * sense[..., None] * across
    centre = np.asarray(origin, dtype=float) + np.asarray(position, dtype=float)
    centre_size = np.abs(origin) + np.abs(position)
    arm, arm_size = np.cross(centre, turning), cross_magnitude(centre_size, turning)

    orders = np.arange(1, highest_order + 1)
    at_order = (np.abs(ratio)[..., None, :] == orders[:, None]).astype(float)
    pulls = at_order * pull[..., None, :]
    sizes = at_order * np.abs(strength)[..., None, :]
    return Excitation(
        pulls @ turning,
        pulls @ arm,
        3.0 * EPSILON * (sizes @ np.abs(turning)),
        4.0 * EPSILON * (sizes @ arm_size),
    )
