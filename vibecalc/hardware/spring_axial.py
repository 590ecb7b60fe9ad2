"""Springs between two rings: how an axial shift and a twist of the mass share their stiffness.

A spring runs from a point of the casing to a point of the mass; the mass shifts by z along the axis
and turns by t about it. The length is

    l(z, t)^2 = a^2 + b^2 - 2 a b cos(d + t) + (h + z)^2,

a and b the radii of the two ends, d the angle between them and h how far the end on the mass stands
above the other. The stiffness matrix is the Hessian of sum K (l - l_free)^2 / 2 at z = t = 0:
K l' l'^T + F l'', with the tension F at rest. Springs that lie in a plane across the axis (h = 0)
couple nothing, whatever their tension; so do springs in pairs of +h and -h.

Twist and extension of the coil about the *spring's own* axis are coupled in any helix too. That
axis is a chord across the damper: the couple that a stretched coil puts on its hooks acts about the
chord, and only its share h / l reaches the axis of the damper. It is left out: hooks are pivots and
bear no couple. A damper whose single coil is coaxial with the shaft is another machine, and
`coaxial_coupling` gives its matrix.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray


class Springs(NamedTuple):
    """Springs (..., n): rates in N/m, tensions at rest in N, ends as in the module's words."""

    rate: FloatArray
    casing_radius: FloatArray
    mass_radius: FloatArray
    angle: FloatArray
    rise: FloatArray
    tension: FloatArray


def axial_torsional_stiffness(springs: Springs) -> WithError:
    """Matrix (..., 2, 2) for (z, t): N/m, N/rad, N m/rad; symmetric.

    Raises NumericalFailure where a spring has no length.
    """
    rate, first, second, angle, rise, tension = np.broadcast_arrays(*floats(*springs))
    # a^2 + b^2 - 2 a b cos d without cancellation for a short spring
    chord = np.square(second - first) + 4.0 * first * second * np.square(np.sin(0.5 * angle))
    length = np.sqrt(chord + np.square(rise))
    if np.any(length <= 0.0):
        raise NumericalFailure("a spring whose two ends meet has no direction and no stiffness")
    along, lever = rise / length, first * second * np.sin(angle) / length
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
