"""Viscous damping of a ring that turns in a casing, from the gaps around it.

Between two walls that slide past each other the film is sheared evenly, so that every part of the
ring adds dynamic viscosity times a length cubed. For radii Ro > Ri, width b, clearances h:

- rim, between cylinders Ro and Ro + h: 4 pi b / (1/Ro^2 - 1/(Ro + h)^2), exact for any h (Couette);
- two sides: 2 * integral of 2 pi r^3 / h from Ri to Ro = pi (Ro^4 - Ri^4) / h;
- bore, between cylinders Ri - h and Ri: 4 pi b / (1/(Ri - h)^2 - 1/Ri^2).

What holds it: a full, concentric gap and a Newtonian oil; films much thinner than the ring is wide
(corners are left out, a share of about h/b); motion slow enough that the film follows at once (see
`gap_oscillation`). Off centre by e in a gap h, the film alone drags 1/sqrt(1 - (e/h)^2) as much at
the rim, and pressure adds to that.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray


class RingGap(NamedTuple):
    """A ring in its casing, all in m. `inner_radius` 0 is a disc; `bore_clearance` inf: no bore."""

    outer_radius: ArrayLike
    inner_radius: ArrayLike
    width: ArrayLike
    rim_clearance: ArrayLike
    side_clearance: ArrayLike
    bore_clearance: ArrayLike = math.inf


class GapShares(NamedTuple):
    """Damping over dynamic viscosity, in m^3: of rim, sides and bore, and their sum."""

    rim: FloatArray
    sides: FloatArray
    bore: FloatArray
    total: WithError


def gap_shares(gap: RingGap) -> GapShares:
    """Where the damping of a gap comes from.

    Raises NumericalFailure where a clearance is not below the width of the ring, or the bore
    clearance (if finite) not below the inner radius: no such film exists.
    """
    outer, inner, wide, rim, side, bore = np.broadcast_arrays(*floats(*gap))
    _check(wide, rim, side, bore, inner)
    grown = outer + rim
    # 1/Ro^2 - 1/(Ro + h)^2 = h (2 Ro + h) / (Ro (Ro + h))^2
    at_rim = 4.0 * math.pi * wide * np.square(outer * grown) / (rim * (2.0 * outer + rim))
    at_sides = math.pi * (outer - inner) * (outer + inner) * (outer**2 + inner**2) / side
    there = np.isfinite(bore)
    play = np.where(there, bore, 0.0)
    shrunk = inner - play
    below = np.where(there, play * (2.0 * inner - play), 1.0)
    in_bore = np.where(there, 4.0 * math.pi * wide * np.square(inner * shrunk) / below, 0.0)
    return GapShares(at_rim, at_sides, in_bore, closed_form(at_rim + at_sides + in_bore, 16.0))


def gap_damping(gap: RingGap, dynamic_viscosity: ArrayLike) -> WithError:
    """Torque per unit of relative angular speed in N m s/rad; dynamic viscosity in Pa s."""
    total = gap_shares(gap).total
    return closed_form(np.asarray(dynamic_viscosity) * total.value, 18.0)


def viscosity_for_damping(gap: RingGap, damping: ArrayLike) -> WithError:
    """Dynamic viscosity in Pa s that gives a damping in N m s/rad."""
    return closed_form(np.asarray(damping) / gap_shares(gap).total.value, 18.0)


def _check(
    wide: FloatArray, rim: FloatArray, side: FloatArray, bore: FloatArray, inner: FloatArray
) -> None:
    widest = np.maximum(np.maximum(rim, side), np.where(np.isfinite(bore), bore, 0.0))
    if np.any(widest >= wide):
        worst = np.unravel_index(np.argmax(widest - wide), wide.shape)
        raise NumericalFailure(
            f"a gap of {1e3 * widest[worst]:.4g} mm is not a film beside a mass "
            f"{1e3 * wide[worst]:.4g} mm wide: the damping of a gap has to be that of a thin film"
        )
    if np.any(np.isfinite(bore) & (bore >= inner)):
        raise NumericalFailure("the gap in the bore is as wide as the bore itself")
