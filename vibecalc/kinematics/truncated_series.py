"""The classic texts' motion: the root's binomial series in (R/L)^2 sin^2, cut after some terms.

    s/R = cos t + 1/lam - sum_{j=1}^{terms} b_j lam^(2j - 1) sin^(2j) t,    lam = R/L,
    b_j = C(2j, j) / (4^j (2j - 1)),
    4^j sin^(2j) t = C(2j, j) + 2 sum_k (-1)^k C(2j, j - k) cos 2kt

One term gives the acceleration -R (cos t + lam cos 2t) (Gibson 2008, eq. 5); 40 terms are Ong
(2000), eq. 2.15. All contributions to one harmonic have one sign, so that nothing cancels, and a
cut series has smaller harmonics than the exact motion. There is no wrist pin offset here.
"""

from functools import lru_cache
from math import comb

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.kinematics.harmonics import pole, series_terms
from vibecalc.kinematics.slider_crank import Motion
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

SMALLEST_NORMAL = float(np.finfo(np.float64).tiny)
#: of every harmonic, absolute error over its magnitude
RELATIVE_ERROR = 8.0 * EPSILON
#: terms of the rest beyond which its closed form takes over
LONGEST_TAIL = 4096


def truncated_harmonics(
    rod_ratio: ArrayLike, terms: int, highest_order: int, derivative: int = 0
) -> ComplexArray:
    """Coefficients C_n of s/R of the cut series, or (i n)^derivative C_n.

    Same convention as `harmonics.motion_harmonics`. Orders above 2 `terms` are zero.

    Parameters
    ----------
    rod_ratio : array (...,)
        R/L between 0 and 1, taken as exact.
    terms : int
        Terms of the series, at least 1.
    highest_order, derivative : int
        Orders 0 to this one; 0 position, 1 velocity, 2 acceleration.

    Returns
    -------
    complex array (..., highest_order + 1)
        Relative error at most 8 units in the last place (`RELATIVE_ERROR`); values below the
        smallest normal double are zero.
    """
    ratio = np.asarray(rod_ratio, dtype=np.float64)[..., None, None]
    count = min(terms, highest_order // 2) + 1
    j = np.arange(1, terms + 1)
    power = 2 * j - 1
    lower_power = power // 2
    weight = (2.0 * np.arange(count)) ** derivative
    # (..., k, j); the power is split so that a tiny ratio does not underflow too early
    lower = np.array(_coefficient_table(terms, count)) * weight[:, None] * ratio**lower_power
    even = np.sum((lower * ratio ** (power - lower_power))[..., ::-1], axis=-1)
    even = np.where(np.abs(even) < SMALLEST_NORMAL, 0.0, even)
    even[..., 0] += weight[0] / ratio[..., 0, 0]
    values = np.zeros((*even.shape[:-1], highest_order + 1), dtype=np.complex128)
    values[..., 0 : 2 * count : 2] = even
    values[..., 1:2] = 1.0
    turn: complex = (1.0, 1.0j, -1.0, -1.0j)[derivative % 4]
    return values * turn


def truncated_dropped_acceleration(
    rod_ratio: ArrayLike, terms: int, highest_order: int | None = None
) -> FloatArray:
    """Sum over n of n^2 times what the cut series lacks of the exact |C_n|, in units of R w^2.

    Without `highest_order` all harmonics of the cut series are kept; with it, those above are
    lacking too. It bounds the error of the acceleration and is attained at 90 degrees, where the
    terms left out have the closed form C(2j - 2, j - 1) / 4^(j - 1) lam^(2j - 1), j > `terms`.

    The relative accuracy is 1e-12.

    Raises
    ------
    NumericalFailure
        R/L is not between 0 and 1.
    """
    ratio = np.asarray(rod_ratio, dtype=np.float64)
    remainder = _remainder_at_right_angle(ratio, terms)
    if highest_order is not None and highest_order < 2 * terms:
        full = truncated_harmonics(ratio, terms, 2 * terms, derivative=2)
        remainder = remainder + np.sum(np.abs(full[..., highest_order + 1 :])[..., ::-1], axis=-1)
    return remainder


def truncated_motion(
    crank_angle: ArrayLike, crank_radius: ArrayLike, rod_length: ArrayLike, terms: int
) -> Motion:
    """Position, velocity and acceleration of the cut series; as `slider_crank.piston_motion`."""
    angle, radius, length = (
        np.asarray(value, dtype=np.float64) for value in (crank_angle, crank_radius, rod_length)
    )
    sine, cosine = np.sin(angle), np.cos(angle)
    square = (radius / length * sine) ** 2
    # series in u = lam^2 sin^2 t: sum b_j u^j over u, and its derivatives by u, by Horner
    value, slope, bend = (np.zeros_like(square) for _ in range(3))
    for factor in reversed(_series_factors(terms)):
        bend = bend * square + 2.0 * slope
        slope = slope * square + value
        value = value * square + factor
    slope, bend = value + square * slope, 2.0 * slope + square * bend
    value = value * square
    lead = radius * radius / length
    turn = 2.0 * lead * sine * cosine
    outward = radius * cosine + length
    primary, secondary = radius * cosine, 2.0 * lead * (cosine - sine) * (cosine + sine) * slope
    remainder = bend * turn * turn / length
    unit = 8.0 * EPSILON
    return Motion(
        position=outward - length * value,
        velocity=-radius * sine - turn * slope,
        acceleration=-primary - secondary - remainder,
        position_error=unit * (np.abs(primary) + length),
        velocity_error=unit * (np.abs(radius * sine) + np.abs(turn) * slope),
        acceleration_error=unit * (np.abs(primary) + 2.0 * lead * slope + np.abs(remainder)),
    )


def _series_factors(terms: int) -> list[float]:
    """b_1 ... b_terms, rounded once from exact integers."""
    return [comb(2 * j, j) / ((2 * j - 1) << (2 * j)) for j in range(1, terms + 1)]


@lru_cache(maxsize=8)
def _coefficient_table(terms: int, count: int) -> tuple[tuple[float, ...], ...]:
    """Contribution of term j to the coefficient of cos 2kt over lam^(2j - 1), shape (k, j)."""
    rows = [[0.0] * terms for _ in range(count)]
    central = 1
    for j in range(1, terms + 1):
        central = central * 2 * (2 * j - 1) // j
        denominator = (2 * j - 1) << (4 * j)
        rows[0][j - 1] = -central * central / denominator
        choose = central
        for k in range(1, min(j + 1, count)):
            choose = choose * (j - k + 1) // (j + k)
            sign = 1 if k % 2 else -1
            rows[k][j - 1] = sign * 2 * central * choose / denominator
    return tuple(tuple(row) for row in rows)


def _remainder_at_right_angle(ratio: FloatArray, terms: int) -> FloatArray:
    """Sum over j > terms of C(2j - 2, j - 1) / 4^(j - 1) lam^(2j - 1)."""
    near = pole(ratio, np.zeros_like(ratio))
    square = ratio * ratio
    count = series_terms(square, "rest of the truncated series", limit=10**18)
    if count > LONGEST_TAIL:
        index = np.arange(terms, 0, -1)
        ratios = np.array(_central_ratios(terms + 1))[index - 1]
        powers = ratio[..., None] ** (2 * index - 1)
        return np.asarray(ratio / near.gap_root - np.sum(ratios * powers, axis=-1))
    remainder = np.ones_like(ratio)
    for j in range(terms + count, terms, -1):
        remainder = 1.0 + square * ((2 * j - 1) / (2 * j)) * remainder
    half = terms // 2 + 1
    first = _central_ratios(terms + 1)[terms] * ratio**half
    return np.asarray(first * (ratio ** (2 * terms + 1 - half) * remainder))


def _central_ratios(count: int) -> list[float]:
    """C(2j, j) / 4^j for j = 0 ... count - 1, rounded once from exact integers."""
    return [comb(2 * j, j) / (1 << (2 * j)) for j in range(count)]
