"""The viscosity formula of Baca (2007), eqs. 3.16 and 3.17, in SI, and what it stands for.

    nu = c h (1 - 1/(1 + 2 b/R)) / (1.019e-8 * 2 pi b R^3)      (cSt; kg cm s, cm)

The bracket is 2 b / (R + 2 b), so that c = 1.019e-8 * 2 pi nu (b R^3 + R^4/2) / h: the thin film at
the rim, 2 pi b R^3 / h, and on both sides of a *full* disc, pi R^4 / h, all with one clearance. In
kg(force) s/cm^2, 1 cSt of an oil of 1 g/cm^3 is 1.0197e-8: the number in front is a density of 999
kg/m^3. The viscosity found is therefore the dynamic one in mPa s; an oil of 870 kg/m^3 needs 15 per
cent more centistokes, and the hole in the ring asks for more again.
"""

import math

from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError

#: kg/m^3: 1.019e-8 kg s/cm^2 for each centistoke, with 9.80665 m/s^2
PUBLISHED_DENSITY = 1.019e-8 * 9.80665e4 / 1e-6


def published_shares(radius: ArrayLike, width: ArrayLike, clearance: ArrayLike) -> WithError:
    """2 pi (b R^3 + R^4 / 2) / h in m^3, all in m: damping over dynamic viscosity."""
    far, wide, thin = floats(radius, width, clearance)
    return closed_form(2.0 * math.pi * far**3 * (wide + 0.5 * far) / thin, 9.0)


def published_damping(
    kinematic_viscosity: ArrayLike, radius: ArrayLike, width: ArrayLike, clearance: ArrayLike
) -> WithError:
    """Damping in N m s/rad of a kinematic viscosity in m^2/s, with the density of the formula."""
    (thick,) = floats(kinematic_viscosity)
    found = published_shares(radius, width, clearance)
    return closed_form(PUBLISHED_DENSITY * thick * found.value, 12.0)


def published_viscosity(
    damping: ArrayLike, radius: ArrayLike, width: ArrayLike, clearance: ArrayLike
) -> WithError:
    """Kinematic viscosity in m^2/s of a damping in N m s/rad, with the density of the formula."""
    (wanted,) = floats(damping)
    found = published_shares(radius, width, clearance)
    return closed_form(wanted / (PUBLISHED_DENSITY * found.value), 12.0)
