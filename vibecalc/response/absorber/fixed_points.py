"""Frequencies at which the response does not depend on the secondary's damping."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF


class FixedPoints(NamedTuple):
    """Frequency ratios P and Q of the fixed points and |H| (force, displacement) there, all (...).

    `error_p` and `error_q` are of the magnitudes. Without a spring P is at zero frequency.
    """

    frequency_p: np.ndarray
    frequency_q: np.ndarray
    magnitude_p: np.ndarray
    magnitude_q: np.ndarray
    error_p: np.ndarray
    error_q: np.ndarray


def fixed_points(
    mass_ratio: ArrayLike, stiffness_ratio: ArrayLike, primary_damping: ArrayLike = 0.0
) -> FixedPoints:
    """The two points through which the curves of every z2 pass, for an undamped primary.

    Where they pass, the free curve 1 / (1 - u) of an undamped absorber and the locked curve
    1 / (1 - (1 + m) u) have the same magnitude: (2 + m) m u^2 - 2 (m + k + k m) u + 2 k = 0,
    |H| = 1 / |1 - (1 + m) u|. The frequencies are those of every response of the primary.
    With a damped primary no frequency is independent of z2: raises NumericalFailure.
    Source: Den Hartog, Mechanical Vibrations; Baca Vasquez (2007) takes the two peaks for them.
    """
    if np.any(np.asarray(primary_damping) != 0.0):
        raise NumericalFailure("a damped primary system has no fixed points: every curve differs")
    m, k = np.broadcast_arrays(
        np.asarray(mass_ratio, dtype=float), np.asarray(stiffness_ratio, dtype=float)
    )
    if not np.all((m > 0.0) & (k >= 0.0) & np.isfinite(k)):
        raise NumericalFailure("fixed points need a mass ratio above 0 and a finite stiffness")
    ratio = k / m
    total = 2.0 * (1.0 + ratio * (1.0 + m)) / (2.0 + m)
    # total^2/4 - 2 ratio/(2 + m), over (2 + m)^2: a sum of squares
    gap = np.sqrt(
        np.square(1.0 - ratio * (1.0 + m)) + 2.0 * m * ratio
    ) * 2.0 / (2.0 + m)  # fmt: skip
    upper = (total + gap) / 2.0
    lower = 2.0 * ratio / ((2.0 + m) * upper)
    height, error = [], []
    for u in (lower, upper):
        away = np.abs(1.0 - (1.0 + m) * u)
        height.append(1.0 / away)
        error.append(8.0 * UNIT_ROUNDOFF * (1.0 + (1.0 + m) * u) / np.square(away))
    return FixedPoints(np.sqrt(lower), np.sqrt(upper), *height, *error)
