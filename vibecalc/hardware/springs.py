"""Rate and stress of a close-coiled helical spring of round wire.

The spring index is coil diameter over wire diameter, with the mean diameter of the coil (centre of
wire to centre of wire). The rate counts the twist of the wire alone; what its bending and its
shear force add is of the order of the pitch angle squared and of 1 / index^2.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.closed_form import closed_form, floats
from vibecalc.numerics.rounding import WithError
from vibecalc.numerics.typing import FloatArray


def spring_rate(
    shear_modulus: ArrayLike, wire: ArrayLike, coil: ArrayLike, turns: ArrayLike
) -> WithError:
    """G d^4 / (8 D^3 N) in N/m; modulus in Pa, wire d and mean coil diameter D in m, N turns."""
    modulus, thin, wide, number = floats(shear_modulus, wire, coil, turns)
    return closed_form(modulus * thin**4 / (8.0 * wide**3 * number), 10.0)


def turns_for_rate(
    shear_modulus: ArrayLike, wire: ArrayLike, coil: ArrayLike, rate: ArrayLike
) -> WithError:
    """Number of active turns that gives a rate in N/m: `spring_rate` solved for them."""
    return spring_rate(shear_modulus, wire, coil, rate)


def shear_stress(force: ArrayLike, wire: ArrayLike, coil: ArrayLike) -> WithError:
    """Largest shear stress in Pa under an axial force in N, at the inside of the coil.

    8 F D / (pi d^3) times Wahl's factor (4 C - 1) / (4 C - 4) + 0.615 / C, C = D / d > 1.
    """
    load, thin, wide = floats(force, wire, coil)
    return closed_form(8.0 * load * wide / (math.pi * thin**3) * _wahl(wide / thin), 20.0)


def largest_extension(
    rate: ArrayLike,
    wire: ArrayLike,
    coil: ArrayLike,
    allowed_stress: ArrayLike,
    initial_tension: ArrayLike = 0.0,
) -> WithError:
    """Extension in m at which the wire reaches a stress in Pa.

    An extension spring wound with an initial tension (N) opens only when pulled harder than that;
    the rate holds beyond. Zero where the initial tension alone reaches the stress.
    """
    stiff, thin, wide, stress, first = floats(rate, wire, coil, allowed_stress, initial_tension)
    force = stress * math.pi * thin**3 / (8.0 * wide * _wahl(wide / thin))
    spare = (force - first) * (force > first)
    found = closed_form(spare / stiff, 2.0)
    return found._replace(error=found.error + 20.0 * closed_form(force / stiff, 1.0).error)


def _wahl(index: FloatArray) -> FloatArray:
    return np.asarray((4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index)
