"""Harmonics of the exact motion when the cylinder axis passes through the crank axis.

With lam = R/L and lam = 2 kappa / (1 + kappa^2), the projection of the rod over the crank radius is

    sqrt(1 - lam^2 sin^2 t) / lam = |1 + kappa^2 exp(2 i t)| / (2 kappa),

and multiplying out the two binomial series gives the coefficient of cos 2kt,

    binomial(1/2, k) kappa^(2k - 1) F(-1/2, k - 1/2; k + 1; kappa^4),

half of it at k = 0. (Closed form of the series in Biezeno and Grammel, Technische Dynamik, XII.)
No step cancels: F = 1 - (positive terms) and stays above sqrt(1 - kappa^4).
"""

from functools import lru_cache

import numpy as np

from vibecalc.kinematics.poles import pole, series_terms
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray

SMALLEST_NORMAL = float(np.finfo(np.float64).tiny)


def centred_harmonics(
    rod_ratio: FloatArray, highest_order: int, derivative: int
) -> tuple[FloatArray, FloatArray]:
    """Real coefficients n^derivative C_n, s/R = sum C_n cos(n angle), and their absolute errors.

    Parameters
    ----------
    rod_ratio : array (...,)
        R/L, taken as exact, between 0 and 1.
    highest_order : int
        Orders 0 to this one.
    derivative : int
        Power of n, taken in before anything underflows.

    Returns
    -------
    values, error : arrays (..., highest_order + 1)
        Odd orders above 1 are exactly zero; a value below the smallest normal double is zero.

    Raises
    ------
    NumericalFailure
        R/L is so close to 1 that more than a million terms would be needed (1 - R/L < 1e-10).
    """
    near = pole(rod_ratio, np.zeros_like(rod_ratio))
    half_order = np.arange(highest_order // 2 + 1)
    factor, factor_error = _gauss_series(near.radius, near.gap_root, half_order)

    power = np.where(half_order == 0, -1, 2 * half_order - 1)
    lower_power = power // 2
    kappa = near.radius[..., None]
    weight = _binomials(len(half_order)) * (2.0 * half_order) ** derivative
    weight[0] *= 0.5
    lower = weight * np.power(kappa, lower_power.astype(np.float64))
    upper = np.power(kappa, (power - lower_power).astype(np.float64)) * factor
    even = lower * (upper * (1.0 + power * near.correction[..., None]))
    even_error = np.abs(even) * (3.0 * EPSILON + factor_error) + SMALLEST_NORMAL
    even = np.where(np.abs(even) < SMALLEST_NORMAL, 0.0, even)

    values = np.zeros((*rod_ratio.shape, highest_order + 1))
    error = np.zeros_like(values)
    values[..., ::2] = even
    error[..., ::2] = even_error * (weight != 0.0)
    values[..., 1:2] = 1.0
    return values, error


def _gauss_series(
    kappa: FloatArray, gap_root: FloatArray, half_order: np.ndarray
) -> tuple[FloatArray, FloatArray]:
    """F(-1/2, k - 1/2; k + 1; kappa^4), shape (..., k), and its relative error.

    Summed from the smallest term (Horner), so that rounding does not grow with the number of
    terms. Near 1 the argument comes from its distance to 1, which carries more digits.
    """
    distance = 4.0 * gap_root / (1.0 + gap_root) ** 2
    argument = np.where(distance < 0.5, 1.0 - distance, (kappa * kappa) ** 2)[..., None]
    k = half_order.astype(np.float64)
    sum_ = np.ones(np.broadcast_shapes(argument.shape, k.shape))
    for term in range(series_terms(argument, "harmonics"), 0, -1):
        ratio = (term - 1.5) / term * (1.0 - 1.5 / (k + term))
        sum_ = 1.0 + argument * ratio * sum_
    sensitivity = np.minimum(0.5 * argument / distance[..., None], 0.5 * (k + 1.0))
    return sum_, EPSILON * (1.0 + (1.0 + sensitivity) / sum_)


@lru_cache(maxsize=8)
def _binomial_table(count: int) -> tuple[float, ...]:
    """Rounded values of binomial(1/2, k) from exact integers: -(-1)^k C(2k, k) / (4^k (2k - 1))."""
    central, table = 1, []
    for k in range(count):
        sign = 1 if k % 2 else -1
        table.append(sign * central / ((2 * k - 1) << (2 * k)) if k else 1.0)
        central = central * 2 * (2 * k + 1) // (k + 1)
    return tuple(table)


def _binomials(count: int) -> FloatArray:
    return np.array(_binomial_table(count))
