"""Damping proportional to inertia and stiffness: the series of Rayleigh and of Caughey.

Baca (2007, eq. 4.27): 2 zeta = sum_d alpha_d W^(2 d - 1), d = 0, 1 for Rayleigh. Such a series fits
damping ratios that are given at some frequencies; between and beyond them it says what its powers
say, and from three terms on that may be negative. It cannot stand for a damper at one station.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.closed_form import floats
from vibecalc.numerics.rounding import EPSILON, SINGULAR, UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray


class Series(NamedTuple):
    """alpha_d in s^(2 d - 1), shape (k,), with absolute errors; `condition` is that of the fit.

    The condition number is of the system with frequencies over their largest; its product with the
    rounding is what the coefficients may lose. `coefficient` is that system's own: c_d with
    2 zeta = sum c_d (W / reference)^(2 d - 1).
    """

    alpha: FloatArray
    error: FloatArray
    condition: float
    reference: float
    coefficient: FloatArray
    coefficient_error: FloatArray


def caughey_series(frequency: ArrayLike, damping_ratio: ArrayLike) -> Series:
    """The series of k terms through damping ratios (k,) at frequencies (k,) in rad/s.

    Two terms are Rayleigh's. NumericalFailure for equal or vanishing frequencies, and where fewer
    than four digits of a coefficient remain: with eight modes of an engine the powers run to
    W^13, and the coefficients beyond the first few mean little.
    """
    natural, wanted = floats(frequency, damping_ratio)
    if np.any(natural <= 0.0) or np.unique(natural).size < natural.size:
        raise NumericalFailure("a damping series needs frequencies above zero, all different")
    reference = float(natural.max())
    scaled = natural / reference
    power = 2.0 * np.arange(natural.size) - 1.0
    system = scaled[:, None] ** power
    condition = float(np.linalg.cond(system))
    inverse = np.linalg.inv(system)
    coefficient = np.linalg.solve(system, 2.0 * wanted)
    # one step of refinement, then the residual and the roundings of the data through |inverse|
    coefficient = coefficient + inverse @ (2.0 * wanted - system @ coefficient)
    size = np.abs(system) @ np.abs(coefficient)
    doubt = np.abs(inverse) @ (
        np.abs(2.0 * wanted - system @ coefficient)
        + (natural.size + 6.0) * UNIT_ROUNDOFF * size
        + UNIT_ROUNDOFF * (np.abs(system) * np.abs(power)) @ np.abs(coefficient)
    )
    if condition * UNIT_ROUNDOFF > SINGULAR or np.any(
        doubt > SINGULAR * np.max(np.abs(coefficient))
    ):
        raise NumericalFailure(
            f"a damping series of {natural.size} terms is ill conditioned here "
            f"(condition {condition:.1g}): fewer than four digits of it remain"
        )
    with np.errstate(under="ignore"):
        alpha = coefficient * reference**-power
        error = doubt * reference**-power + 8.0 * EPSILON * np.abs(alpha)
    return Series(alpha, error, condition, reference, coefficient, doubt)


def series_damping(series: Series, frequency: ArrayLike) -> WithError:
    """Damping ratios that a series gives at frequencies (...) in rad/s, above zero."""
    (natural,) = floats(frequency)
    if np.any(natural <= 0.0):
        raise NumericalFailure("a rigid mode has no damping ratio")
    power = 2.0 * np.arange(series.alpha.size) - 1.0
    term = (natural[..., None] / series.reference) ** power
    value = 0.5 * term @ series.coefficient
    rounding = (np.abs(power) + power.size + 4.0) * EPSILON * np.abs(series.coefficient)
    error = 0.5 * term @ (series.coefficient_error + rounding)
    return WithError(np.asarray(value), np.asarray(error))
