"""Stiffness and mass of rods, rings and helical springs."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, floats

# ----------------------------------------------------------------------------
# Torsional stiffness, mass and bending stiffness of a round rod.
# ----------------------------------------------------------------------------


def torsional_stiffness(
    shear_modulus: ArrayLike, diameter: ArrayLike, length: ArrayLike, bore: ArrayLike = 0.0
) -> Bounded:
    """G J / L in N m/rad of a rod with J = pi (D^4 - d^4) / 32 (Baca 2007, section 3.7).

    Shear modulus in Pa, diameters and length in m, bore < diameter. All broadcast.
    """
    modulus, outer, long, inner = floats(shear_modulus, diameter, length, bore)
    return rounded(math.pi / 32.0 * modulus * _fourth_powers(outer, inner) / long, 12.0)


def bending_stiffness(
    elastic_modulus: ArrayLike, diameter: ArrayLike, bore: ArrayLike = 0.0
) -> Bounded:
    """E I in N m^2 with I = pi (D^4 - d^4) / 64."""
    modulus, outer, inner = floats(elastic_modulus, diameter, bore)
    return rounded(math.pi / 64.0 * modulus * _fourth_powers(outer, inner), 11.0)


def mass_per_length(density: ArrayLike, diameter: ArrayLike, bore: ArrayLike = 0.0) -> Bounded:
    """Mass of one metre of rod in kg/m."""
    heavy, outer, inner = floats(density, diameter, bore)
    return rounded(0.25 * math.pi * heavy * (outer - inner) * (outer + inner), 7.0)


def _fourth_powers(outer: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """D^4 - d^4 as a product, which keeps its digits for a thin tube."""
    return np.asarray((outer - inner) * (outer + inner) * (outer * outer + inner * inner))


# ----------------------------------------------------------------------------
# Mass and polar inertia of seismic masses made of rings of rectangular section.
#
# A ring with a groove or a counter bore is a ring less a ring: add `BodyInertia` values with sign.
# ----------------------------------------------------------------------------


class BodyInertia(NamedTuple):
    """Mass in kg, moment about the axis and about a diameter through the mass centre in kg m^2."""

    mass: Bounded
    polar: Bounded
    diametral: Bounded


def ring_inertia(
    density: ArrayLike, outer_radius: ArrayLike, inner_radius: ArrayLike, width: ArrayLike
) -> BodyInertia:
    """Ring of density kg/m^3 with outer and inner radius and width in m; inner radius 0: a disc.

    m = pi rho b (Ro^2 - Ri^2), Jp = m (Ro^2 + Ri^2) / 2, Jd = Jp / 2 + m b^2 / 12.
    """
    heavy, outer, inner, wide = floats(density, outer_radius, inner_radius, width)
    mass = math.pi * heavy * wide * (outer - inner) * (outer + inner)
    polar = 0.5 * mass * (outer * outer + inner * inner)
    return BodyInertia(
        rounded(mass, 7.0),
        rounded(polar, 11.0),
        rounded(0.5 * polar + mass * wide * wide / 12.0, 14.0),
    )


# ----------------------------------------------------------------------------
# A rod on two supports that overhangs the second one, and a body on its free end.
# ----------------------------------------------------------------------------


class OverhungRod(NamedTuple):
    """Uniform rod, both supports letting it tilt freely (self-aligning bearings).

    Bending stiffness E I in N m^2, mass per length in kg/m, distance of the supports and length
    beyond the second one in m. One end of the rod is at the first support.
    """

    bending_stiffness: ArrayLike
    mass_per_length: ArrayLike
    span: ArrayLike
    overhang: ArrayLike


class EndBody(NamedTuple):
    """Body fixed to the free end: mass in kg, moments in kg m^2 about its mass centre.

    `diametral_inertia` about a line across the rod, `polar_inertia` about the rod. `offset` is how
    far, in m, the mass centre lies beyond the end of the rod (negative: back over it).
    """

    mass: ArrayLike
    diametral_inertia: ArrayLike = 0.0
    polar_inertia: ArrayLike = 0.0
    offset: ArrayLike = 0.0


# ----------------------------------------------------------------------------
# Rate and stress of a close-coiled helical spring of round wire.
#
# The spring index is coil diameter over wire diameter, with the mean diameter of the coil (centre
# of wire to centre of wire). The rate counts the twist of the wire alone; what its bending and its
# shear force add is of the order of the pitch angle squared and of 1 / index^2.
# ----------------------------------------------------------------------------


def spring_rate(
    shear_modulus: ArrayLike, wire: ArrayLike, coil: ArrayLike, turns: ArrayLike
) -> Bounded:
    """G d^4 / (8 D^3 N) in N/m; modulus in Pa, wire d and mean coil diameter D in m, N turns."""
    modulus, thin, wide, number = floats(shear_modulus, wire, coil, turns)
    return rounded(modulus * thin**4 / (8.0 * wide**3 * number), 10.0)


def largest_extension(
    rate: ArrayLike,
    wire: ArrayLike,
    coil: ArrayLike,
    allowed_stress: ArrayLike,
    initial_tension: ArrayLike = 0.0,
) -> Bounded:
    """Extension in m at which the wire reaches a stress in Pa.

    An extension spring wound with an initial tension (N) opens only when pulled harder than that;
    the rate holds beyond. Zero where the initial tension alone reaches the stress.
    """
    stiff, thin, wide, stress, first = floats(rate, wire, coil, allowed_stress, initial_tension)
    force = stress * math.pi * thin**3 / (8.0 * wide * _wahl(wide / thin))
    spare = (force - first) * (force > first)
    return Bounded(spare / stiff, UNIT_ROUNDOFF * (2.0 * spare + 20.0 * force) / stiff)


def _wahl(index: FloatArray) -> FloatArray:
    return np.asarray((4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index)


# ----------------------------------------------------------------------------
# Torsional stiffness of springs between a casing and a mass that turns in it.
#
# A spring hooked to the mass at radius R, whose line makes the angle A with the tangent there, lies
# at the distance R cos A from the axis. A small turn lengthens it by R cos A per radian, and its
# force acts on the mass with that same lever, so that the stiffness of n springs is n K R^2 cos^2
# A. The two projections are one number, used twice: by virtual work the lever of the force *is* the
# extension per radian. With one of them (Baca 2007, eq. 3.15) energy would not be kept.
# ----------------------------------------------------------------------------


def couple_stiffness(
    rate: ArrayLike, count: ArrayLike, radius: ArrayLike, angle: ArrayLike
) -> Bounded:
    """n K R^2 cos^2 A in N m/rad: rate K in N/m, R in m, A in rad from the tangent at the hook."""
    stiff, number, far, tilt = floats(rate, count, radius, angle)
    return rounded(number * stiff * np.square(far * np.cos(tilt)), 8.0)


def rate_for_couple(
    stiffness: ArrayLike, count: ArrayLike, radius: ArrayLike, angle: ArrayLike
) -> Bounded:
    """Rate in N/m of each of n springs that together give a torsional stiffness in N m/rad."""
    stiff, number, far, tilt = floats(stiffness, count, radius, angle)
    return rounded(stiff / (number * np.square(far * np.cos(tilt))), 8.0)
