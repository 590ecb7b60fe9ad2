"""The order to which a pendulum is tuned, and how to tune it.

For small swings p'' + n^2 W^2 p = 0 at a rotor speed W: the frequency is n times the speed, at any
speed. A point on an arm r about a centre at R has n^2 = R / r. Rollers of mass M (centres of their
cutouts at the mean distance R' of the axis, inertia I about their own axes, diameter d) add to the
pull and to the motion, and so does an inertia that turns with the arm:

    n^2 = r (m R + M R' / 2) / ((m + M / 4 + I / d^2) r^2 + swing inertia).

A solid roller has I / d^2 = M / 8. In a bifilar mount r is the diameter of the cutouts less that of
the roller, and both cutouts must be equal, or the rollers slide.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.pendulum.model import Pendulum

#: names of paths whose exponent does not depend on the pendulum
_FIXED = {"circular": 0.0, "cycloidal": 1.0}

#: paths by name
PATHS = (*_FIXED, "epicycloidal")


def tuning_order(pendulum: Pendulum) -> WithError:
    """n, of small swings. Broadcasts.

    Raises NumericalFailure where nothing pulls the mass back (centre of the path at the axis or
    beyond it).
    """
    mass, far, near, _, own, rolling, across, diameter, roller_own = floats(*pendulum)
    pull = near * (mass * (far - near) + 0.5 * rolling * (across - 0.5 * near))
    if np.any(pull <= 0.0):
        raise NumericalFailure(
            "nothing pulls the pendulum outwards: the centre of curvature of its path has to lie "
            "between the axis and the mass"
        )
    moved = (mass + 0.25 * rolling + roller_own / diameter**2) * near**2 + own
    value = np.sqrt(pull / moved)
    lost = near * (mass * (far + near) + 0.5 * rolling * (across + 0.5 * near)) / pull
    return WithError(value, (8.0 + 4.0 * lost) * UNIT_ROUNDOFF * value)


def radius_for_order(vertex_distance: ArrayLike, order: ArrayLike) -> WithError:
    """Path radius r in m of a point pendulum at the distance c: r = c / (1 + n^2)."""
    far, number = floats(vertex_distance, order)
    return closed_form(far / (1.0 + number * number), 4.0)


def radius_for_order_with_rollers(pendulum: Pendulum, order: ArrayLike) -> WithError:
    """Path radius in m that tunes a pendulum with rollers or a swing inertia to an order.

    `path_radius` of the pendulum is not looked at; vertex distances of mass and rollers stay. The
    radius solves a quadratic, of which the larger root is taken. Raises NumericalFailure where
    there is none: the swing inertia is too large for the order.
    """
    mass, far, _, _, own, rolling, across, diameter, roller_own = floats(*pendulum)
    square = np.square(np.asarray(order, dtype=float))
    heavy = mass + 0.25 * rolling
    a = heavy + square * (heavy + roller_own / diameter**2)
    b = mass * far + 0.5 * rolling * across
    room = b * b - 4.0 * a * square * own
    if np.any(room <= 0.0):
        raise NumericalFailure(
            "the inertia that turns with the arm is too large: no arm tunes it to this order"
        )
    value = (b + np.sqrt(room)) / (2.0 * a)
    return WithError(value, UNIT_ROUNDOFF * value * (12.0 + 8.0 * b * b / room))


def path_exponent(path: str, pendulum: Pendulum) -> np.ndarray:
    """Exponent q of a path by name; "epicycloidal" is the one of equal times for this pendulum.

    On it the force along the path grows with the way: 1 - q^2 = r / (c + M b / (2 m + M / 2)) with
    b the distance from the axis of the rollers' centres less c / 2; without rollers
    q^2 = n^2 / (1 + n^2). Raises NumericalFailure for an unknown name, and for a path of equal
    times where a swing inertia forbids it.
    """
    if path in _FIXED:
        return np.asarray(_FIXED[path])
    if path not in PATHS:
        raise NumericalFailure(f"no path {path!r} of a pendulum; paths: {', '.join(PATHS)}")
    mass, far, near, _, own, rolling, across, _, _ = floats(*pendulum)
    if np.any(own != 0.0):
        raise NumericalFailure("a mass that turns with an arm runs on a circle, not on a cycloid")
    centre = far + 0.5 * rolling * (across - 0.5 * far) / (mass + 0.25 * rolling)
    return np.asarray(np.sqrt((centre - near) / centre))


def detuning_coefficient(pendulum: Pendulum) -> WithError:
    """e in n(P) = n (1 + e P^2 + ...) for swings of angle +-P of the tangent.

    e = -(1 - q^2 / q0^2) / 16, q0 the exponent of equal times: a circle softens by P^2 / 16, a
    cycloid hardens by P^2 / (16 n^2) without rollers.
    """
    bend = np.asarray(pendulum.path_exponent, dtype=float)
    if np.any((bend != 0.0) & (np.asarray(pendulum.swing_inertia) != 0.0)):
        raise NumericalFailure("a mass that turns with an arm runs on a circle, not on a cycloid")
    even = path_exponent("epicycloidal", pendulum._replace(swing_inertia=0.0))
    share = np.square(bend / even)
    return WithError(-(1.0 - share) / 16.0, UNIT_ROUNDOFF * (1.0 + 16.0 * share / even**2))


def largest_swing(pendulum: Pendulum) -> np.ndarray:
    """Angle (rad) of the tangent at which the path ends: a cusp at pi / (2 q), at most pi."""
    bend = np.asarray(pendulum.path_exponent, dtype=float)
    return np.asarray(math.pi / np.maximum(2.0 * bend, 1.0))
