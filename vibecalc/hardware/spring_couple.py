"""Torsional stiffness of springs between a casing and a mass that turns in it.

A spring hooked to the mass at radius R, whose line makes the angle A with the tangent there, lies
at the distance R cos A from the axis. A small turn lengthens it by R cos A per radian, and its
force acts on the mass with that same lever, so that the stiffness of n springs is n K R^2 cos^2 A.
The two projections are one number, used twice: by virtual work the lever of the force *is* the
extension per radian. With one of them (Baca 2007, eq. 3.15) energy would not be kept.

A spring under tension adds a part of its own: see `tension_stiffness`.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError


def couple_stiffness(
    rate: ArrayLike, count: ArrayLike, radius: ArrayLike, angle: ArrayLike
) -> WithError:
    """n K R^2 cos^2 A in N m/rad: rate K in N/m, R in m, A in rad from the tangent at the hook."""
    stiff, number, far, tilt = floats(rate, count, radius, angle)
    return closed_form(number * stiff * np.square(far * np.cos(tilt)), 8.0)


def rate_for_couple(
    stiffness: ArrayLike, count: ArrayLike, radius: ArrayLike, angle: ArrayLike
) -> WithError:
    """Rate in N/m of each of n springs that together give a torsional stiffness in N m/rad."""
    stiff, number, far, tilt = floats(stiffness, count, radius, angle)
    return closed_form(stiff / (number * np.square(far * np.cos(tilt))), 8.0)


def published_rate_for_couple(
    stiffness: ArrayLike, count: ArrayLike, radius: ArrayLike, angle: ArrayLike
) -> WithError:
    """The same with one projection, n K R^2 cos A, as Baca (2007) prints it in eq. 3.15.

    Too small by 1 / cos A: springs chosen by it give cos A of the stiffness that was wanted.
    """
    found = rate_for_couple(stiffness, count, radius, angle)
    slip = np.cos(np.asarray(angle, dtype=float))
    return WithError(np.asarray(found.value * slip), np.asarray(2.0 * found.error))


def tension_stiffness(
    tension: ArrayLike, count: ArrayLike, near_end: ArrayLike, far_end: ArrayLike
) -> WithError:
    """What a tension adds to the torsional stiffness of n springs, in N m/rad.

    Draw the line of a spring and drop the perpendicular from the axis on it. The ends lie at
    `near_end` and `far_end` (m, with sign) from its foot, and the part added is
    n F a b / |b - a|: it softens where the foot lies between the ends and stiffens otherwise.
    Tension F in N, 0 where the springs are slack at rest.
    """
    pull, number, first, second = floats(tension, count, near_end, far_end)
    return closed_form(number * pull * first * second / np.abs(second - first), 6.0)
