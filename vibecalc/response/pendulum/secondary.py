"""A pendulum, for small swings, as a secondary system on the rotor.

Written for swings p and a small motion t of the rotor on its mean rotation W, the equations are

    A t'' + B p'' = torque,    B t'' + C p'' + b p' + n^2 W^2 C p = 0

with the coefficients of the kinetic energy at the vertex. With theta_2 = t + (C / B) p they are
those of an inertia J2 = B^2 / C that hangs on the rotor by K2 = n^2 W^2 J2 and c2 = b (B / C)^2,
while J1 = A - J2 turns with the rotor. A point on an arm has J2 = m c^2 and leaves J1 the rotor's
alone.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.pendulum.model import Pendulum, terms
from vibecalc.response.pendulum.order import tuning_order


class Secondary(NamedTuple):
    """Inertias in kg m^2, stiffness in N m/rad, damping in N m s/rad; swing over relative angle.

    The swing angle is `swing_per_twist` (theta_2 - theta_1). `error` is relative, of every one.
    """

    primary_inertia: FloatArray
    inertia: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    swing_per_twist: FloatArray
    error: FloatArray


def as_secondary(
    pendulum: Pendulum, rotor_inertia: ArrayLike, speed: ArrayLike, damping: ArrayLike = 0.0
) -> Secondary:
    """The secondary system that small swings at a rotor speed (rad/s) amount to. Broadcasts.

    `damping` in N m s/rad acts on the swing angle.
    """
    rotor, turning, drag = floats(rotor_inertia, speed, damping)
    at_rest = terms(pendulum, np.zeros(()))
    order = tuning_order(pendulum)
    ratio = at_rest.coupling / at_rest.swing
    inertia = at_rest.coupling * ratio
    left = rotor + at_rest.carried - inertia
    # what turns with the rotor is what the pendulum has beyond J2: it may cancel
    size = (np.abs(rotor) + at_rest.carried + inertia) / np.abs(left)
    error = 16.0 * UNIT_ROUNDOFF * (1.0 + size) + 2.0 * order.error / order.value
    square = np.square(order.value * turning)
    return Secondary(left, inertia, square * inertia, drag * ratio**2, ratio, error)


def as_absorber(
    secondary: Secondary, primary_stiffness: ArrayLike, primary_damping: ArrayLike = 0.0
) -> Absorber:
    """The ratios of `response.absorber`, for a rotor held by a stiffness in N m/rad.

    `primary_damping` is c1 / (2 sqrt(K1 J1)). The stiffness ratio grows with the square of the
    rotor speed: a pendulum follows its order where a spring stays at its frequency.
    """
    (stiff,) = floats(primary_stiffness)
    return Absorber(
        primary_damping=np.asarray(primary_damping, dtype=float),
        mass_ratio=secondary.inertia / secondary.primary_inertia,
        stiffness_ratio=secondary.stiffness / stiff,
        secondary_damping=secondary.damping / (2.0 * np.sqrt(stiff * secondary.primary_inertia)),
    )


class SmallMotion(NamedTuple):
    """Complex amplitudes in rad, 0-to-peak, of rotor and swing angle for a torque amplitude."""

    rotor: ComplexArray
    swing: ComplexArray
    rotor_error: FloatArray
    swing_error: FloatArray


def small_motion(
    secondary: Secondary, frequency: ArrayLike, torque: ArrayLike, stiffness: ArrayLike = 0.0
) -> SmallMotion:
    """Response to a torque (N m, complex, 0-to-peak) on the rotor at an angular frequency (rad/s).

    `stiffness` (N m/rad) holds the rotor, 0 leaves it free. Infinite on an undamped resonance. At
    the order of an undamped pendulum the rotor rests and the swing carries all the torque.
    """
    first, second, stiff, drag, per_twist, relative = secondary
    w, load, hold = (np.asarray(value) for value in (frequency, torque, stiffness))
    link = stiff + 1j * w * drag
    own = link - second * w * w
    whole = (hold - first * w * w) * own - second * w * w * link
    own_size = np.abs(link) + second * w * w
    size = (np.abs(hold) + first * w * w) * own_size + second * w * w * np.abs(link)
    with np.errstate(divide="ignore", invalid="ignore"):
        rotor = np.where(whole == 0.0, np.inf, load * own / whole)
        swing = np.where(whole == 0.0, np.inf, load * per_twist * second * w * w / whole)
        doubt = (relative + 8.0 * UNIT_ROUNDOFF) * (1.0 + 2.0 * size / np.abs(whole))
        rotor_error = np.abs(load) * own_size / np.abs(whole) * doubt
        swing_error = np.abs(swing) * doubt
    return SmallMotion(rotor, swing, rotor_error, swing_error)
