"""Turning of the connecting rod against its cylinder, as harmonics.

The rod stands at the angle phi to the cylinder axis, sin phi = (R sin t - e) / L, with R, L, e and
the crank angle t of `slider_crank.py`. With u = R sin t / L, e for e / L, lam = R / L and the sign
s of e, its derivatives by the crank angle are

    phi' = lam cos t / cos phi,
    phi'' = (-u (1 - (lam + |e|)^2) - e (lam + s u)^2) / cos^3 phi:

neither loses digits where the rod almost lies across the cylinder. (The second form is ours.)
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import pole, series_terms
from vibecalc.kinematics.slider_crank import rod_projection
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray, two_sum

MOST_SAMPLES = 1 << 20
#: relative rounding of a sample that is a product or quotient of some ten factors
SAMPLE_ROUNDING = 8.0 * EPSILON


class RodAngle(NamedTuple):
    """Harmonics C_n of orders 0 .. n (..., n + 1), f = Re sum C_n exp(i n t), with errors.

    `acceleration` is phi'' (by the crank angle, times w^2 that by time), `product` is phi' phi'',
    `tangent` is tan phi. The errors hold for the lengths as stored.
    """

    acceleration: Bounded
    product: Bounded
    tangent: Bounded


def rod_angle_harmonics(
    crank_radius: ArrayLike,
    rod_length: ArrayLike,
    wrist_pin_offset: ArrayLike = 0.0,
    *,
    highest_order: int,
) -> RodAngle:
    """Harmonics of phi'', of phi' phi'' and of tan phi.

    Parameters
    ----------
    crank_radius, rod_length, wrist_pin_offset : arrays that broadcast, m
        R, L and e with R + |e| < L.
    highest_order : int
        Orders 0 to this one.

    Returns
    -------
    RodAngle
        Arrays (..., highest_order + 1). Transforms of samples that are exact to rounding, so many
        that none of an order is taken for another; the error of every order is some roundings of
        the largest ones. What the symmetry of the motion forbids is exactly zero: cos of odd and
        sin of even orders (the other way round for `product`), without an offset also the even
        orders (odd ones of `product`).

    Raises
    ------
    NumericalFailure
        The crank does not turn over (R + |e| >= L), or more than 2^20 samples would be needed:
        1 - R/L below about 1e-9, or orders above half a million.
    """
    values = (crank_radius, rod_length, wrist_pin_offset)
    radius, length, offset = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in values))
    clearance = _clearance(radius, length, offset)
    samples = _count(radius, length, offset, highest_order)
    motion, size = _samples(samples, radius, length, offset, clearance)
    harmonics = np.fft.rfft(motion, axis=-1)[..., : highest_order + 1] * (2.0 / samples)
    harmonics[..., 0] *= 0.5
    rounding = SAMPLE_ROUNDING * size.mean(axis=-1)
    rounding += EPSILON * np.log2(samples) * np.sqrt(np.mean(motion**2, axis=-1))
    error = np.repeat(2.0 * rounding[..., None], highest_order + 1, axis=-1)

    order = np.arange(highest_order + 1)
    has_offset = (offset != 0.0)[..., None]
    for row, parity in ((0, 0), (1, 1), (2, 0)):
        even = order % 2 == parity
        harmonics[row] = np.where(even, harmonics[row].real, 1j * harmonics[row].imag)
        there = has_offset | ~even
        for part in (harmonics, error):
            part[row] = np.where(there, part[row], 0.0)
    harmonics[:2, ..., 0] = error[:2, ..., 0] = 0.0  # the mean of a derivative
    return RodAngle(*map(Bounded, harmonics, error))


def largest_rod_acceleration(
    crank_radius: ArrayLike, rod_length: ArrayLike, wrist_pin_offset: ArrayLike = 0.0
) -> Bounded:
    """Largest |phi''| over a turn and its error, lam / sqrt(1 - (lam + |e|/L)^2), lam = R / L.

    phi'' falls steadily with sin t: with z = |sin phi| its slope is negative as long as
    (1 - z)(2 - z) > 0. So it is largest where the crank stands across the cylinder, on the side
    away from the offset. (Own derivation.) Times w^2 it is in rad/s^2.
    """
    values = (crank_radius, rod_length, wrist_pin_offset)
    radius, length, offset = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in values))
    value = np.asarray(radius / (length * np.sqrt(_clearance(radius, length, offset))))
    return Bounded(value, SAMPLE_ROUNDING * value)


def _clearance(radius: FloatArray, length: FloatArray, offset: FloatArray) -> FloatArray:
    """1 - (R + |e|)^2 / L^2, to full relative accuracy."""
    gap, gap_low = two_sum(length, -radius)
    reach = np.abs(offset)
    short = (gap - reach + gap_low) / length
    if not np.all((radius > 0.0) & (short > 0.0)):
        raise NumericalFailure(
            "kinematics: the crank cannot turn over: R must be above 0 and R + |e| below L"
        )
    return np.asarray(short * ((length + radius + reach) / length))


def _count(radius: FloatArray, length: FloatArray, offset: FloatArray, highest: int) -> int:
    """Samples per turn, a power of two: aliases of the orders kept are below rounding."""
    near = pole(radius / length, np.abs(offset / radius))
    # a quarter more than the sum of the amplitudes asks for, as those of phi' phi'' fall later
    needed = highest + 8 + 1.25 * series_terms(near.radius, "harmonics of the rod's angle")
    if needed > MOST_SAMPLES:
        raise NumericalFailure(
            f"kinematics: the harmonics of the rod's angle would take {needed:.3g} samples, more "
            f"than {MOST_SAMPLES}, because R/L (with the offset) is within rounding of 1 or the "
            "order is too high; lengthen the rod"
        )
    return max(16, 1 << int(np.ceil(np.log2(max(needed, 2 * highest + 2)))))


def _samples(
    count: int,
    radius: FloatArray,
    length: FloatArray,
    offset: FloatArray,
    clearance: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """phi'', phi' phi'' and tan phi (3, ..., count), and the sizes of what forms them."""
    sine, cosine = _circle(count)
    r, length_, e = radius[..., None], length[..., None], offset[..., None]
    rod = rod_projection(sine, cosine, r, length_, e)
    tangent = (r * sine - e) / rod
    lateral = (np.abs(r * sine) + np.abs(e)) / rod
    velocity = r * cosine / rod
    # 1 + s sin t, with s the sign of the offset
    towards = np.where(e >= 0.0, sine, -sine)
    nearby = np.where(towards < 0.0, cosine * cosine / (1.0 + np.abs(towards)), 1.0 + towards)
    turn = -(r * sine / length_) * clearance[..., None]
    bend = -(e / length_) * (r / length_ * nearby) ** 2
    cube = (rod / length_) ** 3
    acceleration, strain = (turn + bend) / cube, (np.abs(turn) + np.abs(bend)) / cube
    return (
        np.stack([acceleration, velocity * acceleration, tangent]),
        np.stack([strain, np.abs(velocity) * strain, lateral]),
    )


def _circle(count: int) -> tuple[FloatArray, FloatArray]:
    """Sine and cosine at `count` angles of a turn, each to full relative accuracy also near 0."""
    quarter = np.sin(2.0 * np.pi / count * np.arange(count // 4 + 1))
    half = np.concatenate([quarter, quarter[-2:0:-1]])
    sine = np.concatenate([half, -half])
    return sine, np.roll(sine, -(count // 4))
