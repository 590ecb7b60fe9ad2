"""Stiffness and section modulus of round shafts in torsion: plain, hollow, tapered.

Saint-Venant torsion of each slice; the extra give of a fillet is not counted.
Lengths and diameters in m, shear modulus in Pa, stiffness in N m/rad.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray

#: points of the two Gauss rules whose difference bounds the error of the shorter one
_COARSE, _FINE = 20, 30
#: share of the stiffness above which they disagree too much
_SETTLED = 1e-13


def section_modulus(diameter: ArrayLike, bore: ArrayLike = 0.0) -> WithError:
    """Polar section modulus pi (D^4 - d^4) / (16 D) in m^3: torque over largest shear stress."""
    outer, inner = floats(diameter, bore)
    return closed_form(math.pi / 16.0 * _fourth_powers(outer, inner) / outer, 10.0)


def shaft_stiffness(
    shear_modulus: ArrayLike,
    length: ArrayLike,
    diameter: ArrayLike,
    bore: ArrayLike = 0.0,
    end_diameter: ArrayLike | None = None,
    end_bore: ArrayLike | None = None,
) -> WithError:
    """Stiffness of one part: G I_p / L, or of a cone when an end differs.

    With `end_diameter` or `end_bore` both diameters run straight from one end to the other. A solid
    cone is closed, 1/k = 32 L (D1^2 + D1 D2 + D2^2) / (3 pi G D1^3 D2^3); a hollow one is
    integrated, and NumericalFailure says where its wall is too thin at an end for that.
    """
    modulus, long, outer, inner = floats(shear_modulus, length, diameter, bore)
    if end_diameter is None and end_bore is None:
        return closed_form(math.pi / 32.0 * modulus * _fourth_powers(outer, inner) / long, 12.0)
    last = outer if end_diameter is None else np.asarray(end_diameter, dtype=float)
    bore_last = inner if end_bore is None else np.asarray(end_bore, dtype=float)
    if not np.any(inner) and not np.any(bore_last):
        mixed = (outer**2 + outer * last + last**2) / (3.0 * outer**3 * last**3)
        return closed_form(math.pi / 32.0 * modulus / (long * mixed), 20.0)
    coarse = _mean_flexibility(outer, last, inner, bore_last, _COARSE)
    fine = _mean_flexibility(outer, last, inner, bore_last, _FINE)
    off = np.abs(fine - coarse) / fine
    if np.any(off > _SETTLED):
        raise NumericalFailure("a hollow cone runs out to a wall too thin for its stiffness")
    value = np.asarray(math.pi / 32.0 * modulus / (long * fine))
    # nodes near a thin wall: the difference of the diameters loses what they have in common
    wall = np.minimum((outer - inner) / outer, (last - bore_last) / last)
    return WithError(value, value * (off + UNIT_ROUNDOFF * (40.0 + 6.0 / wall)))


def _mean_flexibility(
    outer: FloatArray, last: FloatArray, inner: FloatArray, bore_last: FloatArray, points: int
) -> FloatArray:
    """Mean of 1 / (D^4 - d^4) along the part, by a Gauss rule."""
    rule = gauss_rule(points)
    at = rule.nodes
    wide = outer[..., None] * (1.0 - at) + last[..., None] * at
    hole = inner[..., None] * (1.0 - at) + bore_last[..., None] * at
    return np.asarray(np.sum(rule.weights / _fourth_powers(wide, hole), axis=-1))


def _fourth_powers(outer: FloatArray, inner: FloatArray) -> FloatArray:
    """D^4 - d^4 as a product, which keeps its digits for a thin tube."""
    return np.asarray((outer - inner) * (outer + inner) * (outer * outer + inner * inner))
