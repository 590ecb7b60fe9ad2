"""Axial force of a rotor whose conductors are skewed, from the harmonics of its torque."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.cycle_peak import cycle_peak


class AxialForce(NamedTuple):
    """Force of the torque on the rotor along its axis, N.

    `harmonics` (..., n) belong to the `orders` (n,) above 0, complex 0-peak amplitudes F with
    f(t) = Re(F exp(i order angle)). `mean` (...,) is the force of order 0, in none of the others:
    `sum_of_amplitudes` bounds the `peak` of the signal over a turn, and `rms` is its effective
    value.
    """

    orders: np.ndarray
    harmonics: Bounded
    mean: Bounded
    sum_of_amplitudes: Bounded
    peak: Bounded
    rms: Bounded


def axial_force(
    orders: ArrayLike,
    cosine: ArrayLike,
    sine: ArrayLike,
    *,
    rotor_diameter: ArrayLike,
    skew_angle: ArrayLike,
) -> AxialForce:
    """Axial force (2 T / D) tan(beta) of a torque T on conductors skewed by beta.

    The torque needs the tangential force 2 T / D at the conductors. The force on a conductor is
    normal to it, so that a skewed one, held to the same torque, is pushed along the rotor by the
    tangential force times tan(beta). (Ong 2000, eqs. 6.1 to 6.6, write sin(beta), as if 2 T / D
    were the normal force; and give the sum of amplitudes as the force.)

    The stator has the opposite force, and the thrust bearing carries it from the rotor. Where both
    sit in one housing it is internal to the body: it loads the bearing and does not shake the body,
    hence is no part of the excitation.

    Parameters
    ----------
    orders
        (n,) distinct multiples of the crank speed, 0 or above, in any sequence.
    cosine, sine
        (..., n) in N m, the torque on the rotor is sum cosine cos(n a) + sine sin(n a). The sine
        of order 0 is nothing.
    rotor_diameter, skew_angle
        D in m, beta in rad within a quarter of a turn, scalars or of the leading axes. A positive
        beta leans the conductors back against the crank's sense of rotation, seen along the axis;
        then a torque in that sense pushes the rotor along the axis.

    Returns
    -------
    AxialForce
        Orders sorted.

    Raises
    ------
    NumericalFailure
        A force is not a finite number.
    """
    order = np.asarray(orders, dtype=np.int64)
    sequence = np.argsort(order, kind="stable")
    torque = np.asarray(cosine, dtype=float) - 1j * np.asarray(sine, dtype=float)
    beta, diameter = np.asarray(skew_angle, dtype=float), np.asarray(rotor_diameter, dtype=float)
    with np.errstate(over="ignore", invalid="ignore"):
        force = np.asarray(torque * (2.0 * np.tan(beta) / diameter)[..., None])[..., sequence]
    if not np.isfinite(force).all():
        raise NumericalFailure(
            "the axial force of the motor is not a finite number: its torque, the skew angle or "
            "the diameter of its rotor is out of range"
        )
    order = order[sequence]
    bounded = rounded(force, 8)
    harmonics, steady = bounded[..., order > 0], bounded[..., order == 0].real.sum()
    largest = np.abs(force).max(axis=-1, initial=0.0)
    scale = np.where(largest > 0.0, largest, 1.0)  # free of overflow
    peak = cycle_peak(np.where(order > 0, force, 0.0), order)
    return AxialForce(
        orders=order[order > 0],
        harmonics=harmonics,
        mean=steady,
        sum_of_amplitudes=abs(harmonics).sum(),
        peak=Bounded(peak.value, peak.error + harmonics.error.sum(-1)),
        rms=(harmonics * (np.sqrt(0.5) / scale)[..., None]).norm() * scale,
    )
