"""Stiffness and mass of rods, rings and helical springs, with the nearest springs in stock."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import (
    UNIT_ROUNDOFF,
    FloatArray,
    IntArray,
    WithError,
    closed_form,
    floats,
)

# ----------------------------------------------------------------------------
# Torsional stiffness, mass and bending stiffness of a round rod.
# ----------------------------------------------------------------------------


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


# ----------------------------------------------------------------------------
# Mass and polar inertia of seismic masses made of rings of rectangular section.
#
# A ring with a groove or a counter bore is a ring less a ring: add `BodyInertia` values with sign.
# ----------------------------------------------------------------------------


class BodyInertia(NamedTuple):
    """Mass in kg, moment about the axis and about a diameter through the mass centre in kg m^2."""

    mass: WithError
    polar: WithError
    diametral: WithError


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
    radius = closed_form(value, 4.0)
    return radius._replace(
        error=np.asarray(radius.error + value * share * closed_form(1.0, 12).error)
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


# ----------------------------------------------------------------------------
# Torsional stiffness of springs between a casing and a mass that turns in it.
#
# A spring hooked to the mass at radius R, whose line makes the angle A with the tangent there, lies
# at the distance R cos A from the axis. A small turn lengthens it by R cos A per radian, and its
# force acts on the mass with that same lever, so that the stiffness of n springs is n K R^2 cos^2
# A. The two projections are one number, used twice: by virtual work the lever of the force *is* the
# extension per radian. With one of them (Baca 2007, eq. 3.15) energy would not be kept.
#
# A spring under tension adds a part of its own: see `tension_stiffness`.
# ----------------------------------------------------------------------------


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


# ----------------------------------------------------------------------------
# Springs between two rings: how an axial shift and a twist of the mass share their stiffness.
#
# A spring runs from a point of the casing to a point of the mass; the mass shifts by z along the
# axis and turns by t about it. The length is
#
#     l(z, t)^2 = a^2 + b^2 - 2 a b cos(d + t) + (h + z)^2,
#
# a and b the radii of the two ends, d the angle between them and h how far the end on the mass
# stands above the other. The stiffness matrix is the Hessian of sum K (l - l_free)^2 / 2 at z = t =
# 0: K l' l'^T + F l'', with the tension F at rest. Springs that lie in a plane across the axis (h =
# 0) couple nothing, whatever their tension; so do springs in pairs of +h and -h.
#
# Twist and extension of the coil about the *spring's own* axis are coupled in any helix too. That
# axis is a chord across the damper: the couple that a stretched coil puts on its hooks acts about
# the chord, and only its share h / l reaches the axis of the damper. It is left out: hooks are
# pivots and bear no couple. A damper whose single coil is coaxial with the shaft is another
# machine, and `coaxial_coupling` gives its matrix.
# ----------------------------------------------------------------------------


class Springs(NamedTuple):
    """Springs (..., n): rates in N/m, tensions at rest in N, ends as in the module's words."""

    rate: FloatArray
    casing_radius: FloatArray
    mass_radius: FloatArray
    angle: FloatArray
    axial_offset: FloatArray
    tension: FloatArray


def axial_torsional_stiffness(springs: Springs) -> WithError:
    """Matrix (..., 2, 2) for (z, t): N/m, N/rad, N m/rad; symmetric.

    Raises NumericalFailure where a spring has no length.
    """
    rate, first, second, angle, axial_offset, tension = np.broadcast_arrays(*floats(*springs))
    # a^2 + b^2 - 2 a b cos d without cancellation for a short spring
    chord = np.square(second - first) + 4.0 * first * second * np.square(np.sin(0.5 * angle))
    length = np.sqrt(chord + np.square(axial_offset))
    if np.any(length <= 0.0):
        raise NumericalFailure("a spring whose two ends meet has no direction and no stiffness")
    along, lever = axial_offset / length, first * second * np.sin(angle) / length
    direction = np.stack([along, lever], axis=-1)
    square = direction[..., :, None] * direction[..., None, :]
    bend = np.zeros_like(square)
    bend[..., 0, 0] = 1.0 / length
    bend[..., 1, 1] = first * second * np.cos(angle) / length
    bend = bend - square / length[..., None, None]
    stiff, pull = rate[..., None, None], tension[..., None, None]
    size = np.abs(stiff * square) + np.abs(pull) * (
        np.abs(square) / length[..., None, None] + np.abs(bend)
    )
    value = np.sum(stiff * square + pull * bend, axis=-3)
    count = square.shape[-3]
    return WithError(value, (24.0 + count) * UNIT_ROUNDOFF * np.sum(size, axis=-3))


def coupled_frequencies(stiffness: FloatArray, mass: ArrayLike, inertia: ArrayLike) -> WithError:
    """Two natural frequencies (..., 2) in rad/s, ascending, of a mass on such springs.

    `stiffness` (..., 2, 2) as above, mass in kg, inertia about the axis in kg m^2. Raises
    NumericalFailure where the stiffness is not positive: the mass does not stay where it is.
    """
    heavy, turning = floats(mass, inertia)
    one = np.asarray(stiffness)[..., 0, 0] / heavy
    two = np.asarray(stiffness)[..., 1, 1] / turning
    cross = np.asarray(stiffness)[..., 0, 1] / np.sqrt(heavy * turning)
    product = one * two - cross * cross
    if np.any(product <= 0.0) or np.any(one <= 0.0):
        raise NumericalFailure(
            "the springs do not hold the mass: their stiffness for an axial shift and a twist is "
            "not positive (springs in a plane give no axial stiffness without tension)"
        )
    high = 0.5 * (one + two) + np.hypot(0.5 * (one - two), cross)
    low = product / high
    value = np.sqrt(np.stack([low, high], axis=-1))
    spread = 8.0 * UNIT_ROUNDOFF * (one * two + cross * cross) / product
    error = value * np.stack([spread, np.full_like(spread, 8.0 * UNIT_ROUNDOFF)], axis=-1)
    return WithError(value, error)


def coaxial_coupling(
    shear_modulus: ArrayLike,
    elastic_modulus: ArrayLike,
    wire: ArrayLike,
    coil: ArrayLike,
    turns: ArrayLike,
    pitch_angle: ArrayLike,
) -> WithError:
    """Matrix (..., 2, 2) of a coil about the axis itself, for extension z and winding up t.

    Kirchhoff's rod in a helix of pitch angle p and radius r (Love, Mathematical Theory of
    Elasticity, section 271), linear: a force F along the axis and a couple M about it twist the
    wire by F r cos p + M sin p and bend it by M cos p - F r sin p. Off the diagonal it falls with
    sin p: a close coil hardly couples.
    """
    shear, elastic, thin, wide, number, pitch = floats(
        shear_modulus, elastic_modulus, wire, coil, turns, pitch_angle
    )
    sine, cosine, radius = np.sin(pitch), np.cos(pitch), 0.5 * wide
    length = 2.0 * np.pi * number * radius / cosine
    area_moment = np.pi * thin**4 / 64.0
    twist, bend = 2.0 * shear * area_moment, elastic * area_moment
    # the inverse of the 2 x 2 flexibility has a determinant without differences: 1 / (twist bend)
    axial = (twist * cosine**2 + bend * sine**2) / (radius**2 * length)
    angular = (twist * sine**2 + bend * cosine**2) / length
    cross = sine * cosine * (twist - bend) / (radius * length)
    value = np.stack([np.stack([axial, cross], -1), np.stack([cross, angular], -1)], -2)
    size = sine * cosine * (twist + bend) / (radius * length)
    sizes = np.stack([np.stack([axial, size], -1), np.stack([size, angular], -1)], -2)
    return WithError(value, 24.0 * UNIT_ROUNDOFF * np.abs(sizes))


# ----------------------------------------------------------------------------
# The parts of a list in the order of how near they come to a value that is wanted.
# ----------------------------------------------------------------------------


class Ranking(NamedTuple):
    """Positions in the list, nearest first; what each offers over what is wanted, in that order."""

    order: IntArray
    ratio: FloatArray


def rank(offered: ArrayLike, wanted: float) -> Ranking:
    """Parts by |log(offered / wanted)|, equals in the order of the list.

    A part that offers nothing stands last with ratio 0. Raises NumericalFailure for an empty list
    or a value that is not above zero.
    """
    (values,) = floats(offered)
    if values.size == 0 or wanted <= 0.0:
        raise NumericalFailure("the nearest part needs a list of parts and a value above zero")
    ratio = values / wanted
    distance = np.where(ratio > 0.0, np.abs(np.log(np.where(ratio > 0.0, ratio, 1.0))), np.inf)
    order = np.argsort(distance, kind="stable")
    return Ranking(order, ratio[order])


def nearest_springs(
    rates: ArrayLike, stiffness: float, count: float, radius: float, angle: float
) -> Ranking:
    """Springs of rates (n,) in N/m by the torsional stiffness in N m/rad of `count` of them."""
    return rank(couple_stiffness(rates, count, radius, angle).value, stiffness)
