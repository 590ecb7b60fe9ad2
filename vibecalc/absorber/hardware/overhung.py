"""Bending and whirling frequencies of an overhung rod with a body on its end."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.hardware.rods_and_springs import EndBody, OverhungRod
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, rounded
from vibecalc.numerics.errors import with_errors
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray, floats

# ----------------------------------------------------------------------------
# What an overhung rod and the body on its end ask of a frequency.
#
# Euler and Bernoulli's beam. On the span, pinned at both ends, the deflection is a multiple C of
# sin bx sinh bL - sinh bx sin bL, b^4 = m w^2 / (E I); beyond the second support it continues with
# slope and curvature, and with a jump of the shear that is the second unknown. At the free end
#
#     E I w''  =  w^2 [J w' + M e (w + e w')],      E I w''' = -w^2 M (w + e w'),
#
# M the mass of the body, e how far its mass centre lies beyond the end, and J = Jd - Jp W / w for a
# spin W of the body about the rod and whirl with the angular frequency w (w < 0: against the spin).
# The determinant of these two equations in the two unknowns is zero.
# ----------------------------------------------------------------------------


def determinant(
    rod: OverhungRod, body: EndBody, spin: FloatArray, frequency: FloatArray
) -> FloatArray:
    """Determinant at frequencies (...); all broadcasts."""
    stiff, line, span, overhang, mass, diametral, polar, offset, turning, w = floats(
        *rod, *body, spin, frequency
    )
    b = np.sqrt(w * np.sqrt(line / stiff))
    # shape on the span over exp(bL): slope and curvature at the second support, with length 1/b
    decay = np.exp(-2.0 * b * span)
    sinh, cosh = 0.5 * (1.0 - decay), 0.5 * (1.0 + decay)
    sine, cosine = np.sin(b * span), np.cos(b * span)
    tilt, bent = cosine * sinh - cosh * sine, -2.0 * sine * sinh
    k = _krylov(b * overhang)
    # deflection at the end and its derivatives over b, for the two unknowns
    first = [k[(1 - j) % 4] * tilt + k[(2 - j) % 4] * bent for j in range(4)]
    force, arm = mass * w * w / (stiff * b**3), offset * b
    turn = (diametral * w * w - polar * turning * w) / (stiff * b)

    def at_end(end: list[FloatArray]) -> tuple[FloatArray, FloatArray]:
        moved = force * (end[0] + arm * end[1])
        return end[2] - turn * end[1] - arm * moved, end[3] + moved

    (top, low), (other_top, other_low) = at_end(first), at_end(k[::-1])
    return np.asarray(top * other_low - other_top * low)


def _krylov(x: FloatArray) -> list[FloatArray]:
    """Half sums and differences of cosh, cos and sinh, sin, over exp(x), none by cancellation."""
    fade = np.exp(-x)
    sinh, cosh = -0.5 * np.expm1(-2.0 * x), 0.5 * (1.0 + fade**2)
    half = 0.5 * x
    between = np.square(-0.5 * np.expm1(-x)) + np.square(np.sin(half)) * fade
    short = np.minimum(x, 1.0)
    power = short**4
    series = 1.0 + power / 840.0 * (
        1.0 + power / 7920.0 * (1.0 + power / 32760.0 * (1.0 + power / 93024.0))
    )
    last = np.where(x < 1.0, short**3 / 6.0 * series * fade, 0.5 * (sinh - np.sin(x) * fade))
    return [0.5 * (cosh + np.cos(x) * fade), 0.5 * (sinh + np.sin(x) * fade), between, last]


# ----------------------------------------------------------------------------
# Whirling frequencies of an overhung rod by beam elements with cubic shapes.
#
# Deflections in the two planes across the axis make one complex number; a body that spins with W
# about the rod then has the real equation (K + w W G - w^2 M) v = 0, with G the polar inertia at
# the slope of the end. With M = L L^T, C = W L^-1 G L^-T and L^-1 K L^-T = R R^T it is the
# symmetric eigenvalue problem of [[C, R], [R^T, 0]]: all w are real, as many above zero (whirl in
# the sense of the spin) as below (against it). Errors of the frequencies fall with the fourth power
# of the length of an element.
# ----------------------------------------------------------------------------

#: stiffness and mass of an element of length 1, E I = 1 and mass per length 1
_STIFFNESS = np.array(
    [
        [12.0, 6.0, -12.0, 6.0],
        [6.0, 4.0, -6.0, 2.0],
        [-12.0, -6.0, 12.0, -6.0],
        [6.0, 2.0, -6.0, 4.0],
    ]
)
_MASS = np.array(
    [[156.0, 22.0, 54.0, -13.0], [22.0, 4.0, 13.0, -3.0], [54.0, 13.0, 156.0, -22.0],
     [-13.0, -3.0, -22.0, 4.0]]
) / 420.0  # fmt: skip


def element_frequencies(
    rod: OverhungRod,
    body: EndBody,
    spin: FloatArray | float = 0.0,
    span_elements: int = 16,
    end_elements: int = 4,
) -> tuple[FloatArray, FloatArray]:
    """Angular frequencies (..., modes) of whirl with and against the spin, each ascending and > 0.

    Everything broadcasts; spin in rad/s. The overhang must be longer than zero.
    """
    stiff, line, span, overhang = floats(*rod)
    mass, diametral, polar, offset = floats(*body)
    turning = np.asarray(spin, dtype=float)
    shape = np.broadcast_shapes(
        *(a.shape for a in (stiff, line, span, overhang, mass, diametral, polar, offset, turning))
    )
    lengths = np.concatenate(
        [
            np.repeat(np.broadcast_to(span, shape)[..., None] / span_elements, span_elements, -1),
            np.repeat(np.broadcast_to(overhang, shape)[..., None] / end_elements, end_elements, -1),
        ],
        axis=-1,
    )
    size = 2 * (lengths.shape[-1] + 1)
    bend, move = np.zeros((*shape, size, size)), np.zeros((*shape, size, size))
    for place in range(lengths.shape[-1]):
        long = lengths[..., place]
        scale = np.stack([np.ones_like(long), long, np.ones_like(long), long], axis=-1)
        both = scale[..., :, None] * scale[..., None, :]
        part = slice(2 * place, 2 * place + 4)
        bend[..., part, part] += (stiff / long**3)[..., None, None] * both * _STIFFNESS
        move[..., part, part] += (line * long)[..., None, None] * both * _MASS
    move[..., -2, -2] += mass
    move[..., -2, -1] += mass * offset
    move[..., -1, -2] += mass * offset
    move[..., -1, -1] += diametral + mass * offset**2
    free = np.delete(np.arange(size), [0, 2 * span_elements])
    bend, move = bend[..., free[:, None], free], move[..., free[:, None], free]
    gyroscopic = np.zeros_like(move)
    gyroscopic[..., -1, -1] = polar * turning
    # slopes times the span: entries of one size
    level = np.ones((*shape, len(free)))
    level[..., free % 2 == 1] = 1.0 / np.broadcast_to(span, shape)[..., None]
    both = level[..., :, None] * level[..., None, :]
    whirl = _whirl(bend * both, move * both, gyroscopic * both)
    count = len(free)
    return whirl[..., count:], -whirl[..., count - 1 :: -1]


def _whirl(bend: FloatArray, move: FloatArray, gyroscopic: FloatArray) -> FloatArray:
    factor = np.linalg.cholesky(move)
    inner = np.linalg.solve(factor, gyroscopic)
    inner = np.linalg.solve(factor, np.swapaxes(inner, -1, -2))
    root = np.linalg.solve(factor, np.linalg.cholesky(bend))
    count = bend.shape[-1]
    both = np.zeros((*bend.shape[:-2], 2 * count, 2 * count))
    both[..., :count, :count] = 0.5 * (inner + np.swapaxes(inner, -1, -2))
    both[..., :count, count:] = root
    both[..., count:, :count] = np.swapaxes(root, -1, -2)
    return np.asarray(np.linalg.eigvalsh(both))


# ----------------------------------------------------------------------------
# Bending and whirling frequencies of an overhung rod with a body on its end, without elements.
#
# Euler and Bernoulli's beam, by the determinant of `overhung_determinant`; its roots are bracketed
# around those of beam elements.
#
# A rod that *oscillates* about its axis, as that of a rig for torsional vibration, has no mean
# spin: its gyroscopic moments are products of two small motions, and the frequencies are those at W
# = 0. The spin is a parameter for shafts that turn.
#
# Left out: shear and the rotary inertia of the rod itself, which lower the frequency of mode n by
# some (n pi r / L)^2, r the radius of gyration; flexible supports; axial forces.
# ----------------------------------------------------------------------------

_MOST_MODES = 6
#: first half width of a bracket over its start
_FIRST_WIDTH = 1e-4

#: overhang over span below which the elements that start the search are made this long
_SHORT = 1e-3


class Whirl(NamedTuple):
    """Angular frequencies (..., modes) in rad/s, ascending: whirl with and against the spin."""

    forward: Bounded
    backward: Bounded


def bending_frequencies(rod: OverhungRod, body: EndBody, modes: int = 2) -> Bounded:
    """Natural frequencies (..., modes) in rad/s of the rod that does not spin. Broadcasts.

    Raises NumericalFailure as `whirl_frequencies`.
    """
    return whirl_frequencies(rod, body, 0.0, modes).forward


def whirl_frequencies(rod: OverhungRod, body: EndBody, spin: ArrayLike, modes: int = 2) -> Whirl:
    """Frequencies of the first modes with the body spinning at `spin` (rad/s, >= 0). Broadcasts.

    Raises NumericalFailure for more than six modes, or where a root cannot be distinguished from
    its neighbour.
    """
    if modes > _MOST_MODES:
        raise NumericalFailure(f"{modes} modes of a rod asked for; {_MOST_MODES} are computed")
    turning = np.asarray(spin, dtype=float)
    span = np.asarray(rod.span, dtype=float)
    longer = rod._replace(overhang=np.maximum(np.asarray(rod.overhang), _SHORT * span))
    # elements that follow one mode more than asked for, whose gap tells how far to look
    starts = element_frequencies(longer, body, turning, 2 * modes, modes)
    forward, backward = (start[..., : modes + 1] for start in starts)
    with_spin = _roots(rod, body, turning, forward)
    if not np.any(turning * np.asarray(body.polar_inertia)):
        return Whirl(with_spin, with_spin)
    return Whirl(with_spin, _roots(rod, body, -turning, backward))


def _roots(rod: OverhungRod, body: EndBody, spin: FloatArray, starts: FloatArray) -> Bounded:
    """Roots w > 0 of the determinant next to `starts` (..., modes + 1), without the last."""
    from scipy.optimize.elementwise import bracket_root, find_root

    start, gap = starts[..., :-1], np.diff(starts, axis=-1)
    below = np.concatenate([start[..., :1], gap[..., :-1]], axis=-1)
    reach = 0.5 * np.minimum(below, gap)
    width = np.minimum(_FIRST_WIDTH * start, 0.5 * reach)
    given = floats(*(one[..., None] for one in floats(*rod, *body, spin)))
    given = tuple(np.broadcast_to(one, start.shape) for one in given)

    def value(frequency: FloatArray, *given: FloatArray) -> FloatArray:
        return determinant(OverhungRod(*given[:4]), EndBody(*given[4:8]), given[8], frequency)

    ends = bracket_root(
        value, start - width, start + width, xmin=start - reach, xmax=start + reach, args=given
    )
    if not np.all(ends.success):
        raise NumericalFailure(
            "two bending frequencies of the rod lie too close to be distinguished"
        )
    tolerances = {"xatol": 0.0, "xrtol": 4.0 * UNIT_ROUNDOFF, "fatol": 0.0, "frtol": 0.0}
    root = find_root(value, ends.bracket, args=given, tolerances=tolerances).x
    step = np.minimum(1e-5 * root, np.minimum(root - start + reach, start + reach - root))
    slope = np.abs(value(root + step, *given) - value(root - step, *given)) / (2.0 * step)
    noise = with_errors(value, root, *given).error
    return Bounded(root, 2.0 * noise / slope + 8.0 * UNIT_ROUNDOFF * root)


# ----------------------------------------------------------------------------
# Rayleigh's quotient for the bending of a rod on two supports with a mass on its free end.
#
# The rod is assumed to bend as b(x) = sin(pi x / L), L the distance of the supports, beyond the
# second one too (Baca 2007, section 3.16):
#
#     w^2 = E I int b''^2 dx / (m int b^2 dx + M b(e)^2 [+ Jd b'(e)^2])
#
# with integrals from 0 to the end e = L + a, and m the mass of the rod *per length*. The printed
# frequencies come from the whole mass of the rod in its place, which has another dimension. A
# quotient lies above the lowest frequency; this shape is bent at the free end, where a rod with a
# point mass is straight, and how far above is not known from the quotient: see `overhung_rod`.
# ----------------------------------------------------------------------------


def rayleigh_frequency(rod: OverhungRod, body: EndBody) -> Bounded:
    """Angular frequency in rad/s; broadcasts. With the rotary inertia of the body if it has one.

    A body whose mass centre lies off the end moves there with b(e) + offset * b'(e).
    """
    stiff, line, span, overhang = floats(*rod)
    mass, diametral, offset = floats(body.mass, body.diametral_inertia, body.offset)
    wave = math.pi / span
    reach = span + overhang
    beyond = wave * overhang
    # sin^2 over the whole rod: half its length less sin(2 pi e / L) / (4 pi / L)
    square = 0.5 * reach - np.sin(2.0 * beyond) / (4.0 * wave)
    end, slope = -np.sin(beyond), -wave * np.cos(beyond)
    moved = np.square(end + offset * slope)
    kinetic = line * square + mass * moved + diametral * slope**2
    frequency = rounded(wave**2 * np.sqrt(stiff * square / kinetic), 20.0)
    # the two parts of the motion of the mass may cancel
    lost = mass * (np.square(end) + np.square(offset * slope)) / kinetic
    return Bounded(frequency.value, frequency.error * (1.0 + lost))
