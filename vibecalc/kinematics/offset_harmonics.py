"""Harmonics of the exact motion with a wrist pin offset.

The rod's projection is the root of two factors, one from each dead side. With the poles q1 <= q2
of `poles.py` and the real power series h(y) = sqrt((1 + q1 y)(1 - q2 y)) = sum q2^j G_j y^j,

    sqrt(1 - lam^2 (sin t - e/R)^2) / lam = |h(i exp(i t))|^2 / (2 sqrt(q1 q2)),

so that its coefficient of exp(i n t) is i^n q2^n / sqrt(q1 q2) times the autocorrelation
S_n = sum_j q2^(2j) G_(j+n) G_j (half of it at n = 0). From (1 + (q1 - q2) y - q1 q2 y^2) h' =
((q1 - q2)/2 - q1 q2 y) h follows, with rho = q1/q2 and sigma = 1 - rho,

    (j + 1) G_(j+1) = sigma (j - 1/2) G_j + rho (j - 2) G_(j-1),      G_0 = 1, G_1 = -sigma/2:

all G_j from j = 1 on are negative, nothing cancels in the recurrence, and S_n loses at most the
factor by which |G_n| exceeds |S_n|. (The derivation is ours.)
"""

import numpy as np

from vibecalc.kinematics.poles import pole, series_terms
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.twofold import two_sum
from vibecalc.numerics.typing import ComplexArray, FloatArray

SMALLEST_NORMAL = float(np.finfo(np.float64).tiny)


def offset_harmonics(
    rod_ratio: FloatArray, offset_ratio: FloatArray, highest_order: int, derivative: int
) -> tuple[ComplexArray, FloatArray]:
    """Complex coefficients n^derivative C_n, s/R = Re sum C_n exp(i n angle), and absolute errors.

    Parameters
    ----------
    rod_ratio, offset_ratio : arrays (...,) of one shape
        R/L and e/R, taken as exact; a negative offset gives the conjugate coefficients.
    highest_order, derivative : int
        Orders 0 to `highest_order`; power of n, taken in before anything underflows.

    Returns
    -------
    values, error : arrays (..., highest_order + 1)
        Relative accuracy of a few units in the last place, growing with n to about 30 at
        order 200.

    Raises
    ------
    NumericalFailure
        (R + |e|)/L is so close to 1 that more than a million terms would be needed.
    """
    offset = np.abs(offset_ratio)
    near, far = pole(rod_ratio, offset), pole(rod_ratio, -offset)
    shift = rod_ratio * offset
    far_sum = 1.0 + shift + far.gap_root
    ratio = (1.0 - shift + near.gap_root) / far_sum
    difference = 2.0 * shift * (1.0 + 2.0 / (near.gap_root + far.gap_root)) / far_sum

    square = near.radius * near.radius
    count = series_terms(square, "harmonics with an offset")
    series = _root_series(difference, highest_order + count + 1)
    order = np.arange(highest_order + 1)
    tail = _autocorrelation_tail(series, square, highest_order, count)
    first = np.moveaxis(series[: highest_order + 1], 0, -1)
    correlation = first + tail

    q, power = near.radius[..., None], order - 1
    lower_power = power // 2
    weight = order.astype(np.float64) ** derivative
    weight[0] *= 0.5
    lower = weight * np.power(q, lower_power.astype(np.float64))
    upper = np.power(q, (power - lower_power).astype(np.float64)) / np.sqrt(ratio)[..., None]
    scale = upper * (1.0 + power * near.correction[..., None])
    part = lower * (scale * correlation)
    part_error = lower * (scale * (np.abs(first) + np.abs(tail)))
    part_error = part_error * EPSILON * (4.0 + 0.25 * order) + SMALLEST_NORMAL * (weight != 0.0)
    part = np.where(np.abs(part) < SMALLEST_NORMAL, 0.0, part)

    turn = np.array([1.0, 1.0j, -1.0, -1.0j])[order % 4]
    turn = np.where(offset_ratio[..., None] < 0.0, turn.conj(), turn)
    values: ComplexArray = part * turn
    values[..., 1:2] += 1.0
    return values, part_error


def _root_series(difference: FloatArray, length: int) -> FloatArray:
    """G_j of the module's docstring, shape (length, ...).

    sigma and rho have to add up to 1 beyond a double, or G drifts by their mismatch at each step.
    """
    ratio, ratio_low = two_sum(np.ones_like(difference), -difference)
    series = np.empty((max(length, 3), *difference.shape))
    series[0] = 1.0
    series[1] = -0.5 * difference
    for j in range(1, length - 1):
        before = (j - 2) * series[j - 1]
        series[j + 1] = difference * ((j - 0.5) * series[j]) + ratio * before
        series[j + 1] += ratio_low * before
        series[j + 1] /= j + 1
    return series[:length]


def _autocorrelation_tail(
    series: FloatArray, square: FloatArray, highest_order: int, count: int
) -> FloatArray:
    """S_n without its first term: sum over j >= 1 of q^(2j) G_(j+n) G_j, shape (..., n)."""
    # contiguous along j, so that numpy sums in pairs
    along = np.ascontiguousarray(np.moveaxis(series, 0, -1))
    weighted = np.power(square[..., None], np.arange(1.0, count + 1.0)) * along[..., 1 : count + 1]
    tail = np.empty((*square.shape, highest_order + 1))
    for n in range(highest_order + 1):
        tail[..., n] = np.sum(weighted * along[..., n + 1 : n + count + 1], axis=-1)
    return tail
