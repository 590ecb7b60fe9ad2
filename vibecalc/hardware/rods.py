"""Torsional stiffness, mass and bending stiffness of a round rod."""

import math

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError


def torsional_stiffness(
    shear_modulus: ArrayLike, diameter: ArrayLike, length: ArrayLike, bore: ArrayLike = 0.0
) -> WithError:
    """G J / L in N m/rad of a rod with J = pi (D^4 - d^4) / 32 (Baca 2007, section 3.7).

    Shear modulus in Pa, diameters and length in m, bore < diameter. All broadcast.
    """
    modulus, outer, long, inner = floats(shear_modulus, diameter, length, bore)
    return closed_form(math.pi / 32.0 * modulus * _fourth_powers(outer, inner) / long, 12.0)


def bending_stiffness(
    elastic_modulus: ArrayLike, diameter: ArrayLike, bore: ArrayLike = 0.0
) -> WithError:
    """E I in N m^2 with I = pi (D^4 - d^4) / 64."""
    modulus, outer, inner = floats(elastic_modulus, diameter, bore)
    return closed_form(math.pi / 64.0 * modulus * _fourth_powers(outer, inner), 11.0)


def mass_per_length(density: ArrayLike, diameter: ArrayLike, bore: ArrayLike = 0.0) -> WithError:
    """Mass of one metre of rod in kg/m."""
    heavy, outer, inner = floats(density, diameter, bore)
    return closed_form(0.25 * math.pi * heavy * (outer - inner) * (outer + inner), 7.0)


def _fourth_powers(outer: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """D^4 - d^4 as a product, which keeps its digits for a thin tube."""
    return np.asarray((outer - inner) * (outer + inner) * (outer * outer + inner * inner))
