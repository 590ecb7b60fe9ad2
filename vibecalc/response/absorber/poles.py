"""Natural frequencies, damped poles, the antiresonance and the locked and free limits."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.absorber.coefficients import coupling, denominator
from vibecalc.response.absorber.model import Absorber


class Landmarks(NamedTuple):
    """Frequency ratios x that belong to the undamped system, all (...).

    `lower`, `upper`: natural frequencies (`upper` infinite where the secondary is locked,
    `lower` zero where it has no spring); `antiresonance` sqrt(k / m), at which the undamped
    secondary holds the primary still under a force; `locked` 1 / sqrt(1 + m) and `free` 1, the
    only natural frequency with the secondary locked to the primary or parted from it.
    """

    lower: np.ndarray
    upper: np.ndarray
    antiresonance: np.ndarray
    locked: np.ndarray
    free: np.ndarray


def landmarks(mass_ratio: ArrayLike, stiffness_ratio: ArrayLike) -> Landmarks:
    """Undamped natural frequencies and limits (eq. 2.9 with all damping zero).

    m u^2 - (m + k + k m) u + k = 0 with u = x^2, solved without a difference of like numbers.
    """
    m, k = np.broadcast_arrays(
        np.asarray(mass_ratio, dtype=float), np.asarray(stiffness_ratio, dtype=float)
    )
    locked = 1.0 / np.sqrt(1.0 + m)
    stiff = np.isinf(k) | (m == 0.0)
    finite = np.where(stiff, 1.0, k)
    ratio = finite / np.where(stiff, 1.0, m)
    # u1 + u2 = 1 + ratio (1 + m), u1 u2 = ratio; the square below is a sum
    total = 1.0 + ratio * (1.0 + m)
    gap = np.hypot(1.0 - ratio * (1.0 + m), 2.0 * np.sqrt(ratio * m))
    upper = (total + gap) / 2.0
    lower = ratio / upper
    # without mass the secondary's own frequency is beyond all others
    return Landmarks(
        np.where(stiff, locked, np.sqrt(lower)),
        np.where(stiff, np.inf, np.sqrt(upper)),
        np.where(stiff, np.inf, np.sqrt(ratio)),
        locked,
        np.ones_like(locked),
    )


class Poles(NamedTuple):
    """Roots s = -decay + i x of D(s) in units of w1, (..., 4), and an error of each.

    Sorted by |s|; `found` is false in places that a limit (no spring, locked) leaves empty, where
    the value is zero.
    """

    value: np.ndarray
    error: np.ndarray
    found: np.ndarray


def poles(absorber: Absorber) -> Poles:
    """Damped poles of the coupled system, polished by Newton's method."""
    return roots_of(denominator(coupling(absorber)))


def roots_of(coefficients: np.ndarray) -> Poles:
    """Roots of polynomials (..., 5), coefficients by rising power, the first of them not zero."""
    shape = coefficients.shape[:-1]
    flat = coefficients.reshape(-1, 5)
    value = np.zeros((len(flat), 4), dtype=complex)
    found = np.zeros((len(flat), 4), dtype=bool)
    degree = 4 - np.argmax((flat != 0.0)[:, ::-1], axis=-1)
    for each in np.unique(degree):
        rows = np.flatnonzero(degree == each)
        count = int(each)
        matrix = np.zeros((len(rows), count, count))
        matrix[:, np.arange(1, count), np.arange(count - 1)] = 1.0
        matrix[:, :, -1] = -flat[rows, :count] / flat[rows, count, None]
        roots = np.linalg.eigvals(matrix).astype(complex)
        roots = np.take_along_axis(roots, np.argsort(np.abs(roots), axis=-1), axis=-1)
        value[rows, :count], found[rows, :count] = roots, True
    rising = np.arange(5)
    slopes = flat[:, 1:] * rising[1:]
    for _ in range(3):
        step = _ratio(_at(flat, value), _at(slopes, value))
        value = np.where(found & (np.abs(step) < 0.1 * np.abs(value)), value - step, value)
    size = _at(np.abs(flat), np.abs(value).astype(complex)).real
    doubt = 8.0 * UNIT_ROUNDOFF * size
    # a close pair moves by the root of the doubt
    simple = _ratio(doubt, np.abs(_at(slopes, value)))
    bend = np.abs(_at(slopes[:, 1:] * rising[1:4], value)) / 2.0
    error = np.minimum(4.0 * simple, 4.0 * np.sqrt(_ratio(doubt, bend)))
    error = np.where(found, error + 2.0 * UNIT_ROUNDOFF * np.abs(value), 0.0)
    return Poles(value.reshape(*shape, 4), error.reshape(*shape, 4), found.reshape(*shape, 4))


def _at(coefficients: np.ndarray, s: np.ndarray) -> np.ndarray:
    result = np.zeros_like(s)
    for place in range(coefficients.shape[-1] - 1, -1, -1):
        result = result * s + coefficients[:, place, None]
    return result


def _ratio(top: np.ndarray, bottom: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        result = top / bottom
    return np.where(np.isfinite(result), result, np.inf)
