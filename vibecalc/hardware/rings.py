"""Mass and polar inertia of seismic masses made of rings of rectangular section.

A ring with a groove or a counter bore is a ring less a ring: add `Inertia` values with sign.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError


class Inertia(NamedTuple):
    """Mass in kg, moment about the axis and about a diameter through the mass centre in kg m^2."""

    mass: WithError
    polar: WithError
    diametral: WithError


def ring_inertia(
    density: ArrayLike, outer_radius: ArrayLike, inner_radius: ArrayLike, width: ArrayLike
) -> Inertia:
    """Ring of density kg/m^3 with outer and inner radius and width in m; inner radius 0: a disc.

    m = pi rho b (Ro^2 - Ri^2), Jp = m (Ro^2 + Ri^2) / 2, Jd = Jp / 2 + m b^2 / 12.
    """
    heavy, outer, inner, wide = floats(density, outer_radius, inner_radius, width)
    mass = math.pi * heavy * wide * (outer - inner) * (outer + inner)
    polar = 0.5 * mass * (outer * outer + inner * inner)
    return Inertia(
        closed_form(mass, 7.0),
        closed_form(polar, 11.0),
        closed_form(0.5 * polar + mass * wide * wide / 12.0, 14.0),
    )


def inner_radius_for(
    polar: ArrayLike, density: ArrayLike, outer_radius: ArrayLike, width: ArrayLike
) -> WithError:
    """Inner radius in m of the ring with a given polar inertia in kg m^2.

    Raises NumericalFailure where even the full disc has less.
    """
    wanted, heavy, outer, wide = floats(polar, density, outer_radius, width)
    missing = 1.0 - wanted / (0.5 * math.pi * heavy * wide * outer**4)
    if np.any(missing < 0.0):
        full = np.max(wanted / (1.0 - missing))
        raise NumericalFailure(
            f"a full disc of these dimensions has a polar inertia of {full:.6g} kg m^2 only"
        )
    value = outer * missing**0.25
    safe = np.where(missing > 0.0, missing, 1.0)
    share = np.where(missing > 0.0, 0.25 / safe, 1.0)
    found = closed_form(value, 4.0)
    return found._replace(
        error=np.asarray(found.error + value * share * closed_form(1.0, 12).error)
    )
