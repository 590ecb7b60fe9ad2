"""Numerator and denominator in s = i x, with the limits of spring and damper divided out."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.absorber.model import Absorber, Transfer


class Coupling(NamedTuple):
    """N1 = own s^2 + g and g = g0 + g1 s, both over s^shift and scaled by one positive number.

    `shift` is 0, or 1 without a spring, or 2 for a free secondary (then g is left out). `own` is
    the secondary's inertia in that scale, zero where it is locked to the primary.
    All arrays have the common shape of the four ratios.
    """

    primary_damping: np.ndarray
    mass: np.ndarray
    own: np.ndarray
    g0: np.ndarray
    g1: np.ndarray
    shift: np.ndarray

    @property
    def motion(self) -> np.ndarray:
        """Coefficients of N1 (..., 3), lowest power first, after the shift."""
        zero = np.zeros_like(self.own)
        whole = np.stack([self.g0, self.g1, self.own], axis=-1)
        late = np.stack([self.g1, self.own, zero], axis=-1)
        free = np.stack([self.own, zero, zero], axis=-1)
        shift = self.shift[..., None]
        return np.where(shift == 0, whole, np.where(shift == 1, late, free))

    @property
    def link(self) -> np.ndarray:
        """Coefficients of g (..., 2) after the shift."""
        zero = np.zeros_like(self.own)
        whole = np.stack([self.g0, self.g1], axis=-1)
        late = np.stack([self.g1, zero], axis=-1)
        return np.where(self.shift[..., None] == 0, whole, late)


def coupling(absorber: Absorber) -> Coupling:
    """Bring every absorber, its limits included, to finite numbers of order one.

    A mass ratio of zero leaves the primary system alone. The scale cancels in every quotient.
    """
    z1, m, k, z2 = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in absorber))
    locked = np.isinf(k) | np.isinf(z2) | (m == 0.0)
    g0 = np.where(locked, 1.0, k)
    g1 = np.where(locked, 0.0, 2.0 * np.where(locked, 0.0, z2))
    own = np.where(locked, 0.0, m)
    scale = np.maximum(np.maximum(g0, g1), own)
    shift = np.where(g0 > 0.0, 0, np.where(g1 > 0.0, 1, 2))
    return Coupling(z1.copy(), m.copy(), own / scale, g0 / scale, g1 / scale, shift)


def denominator(parts: Coupling) -> np.ndarray:
    """Coefficients of D = (1 + 2 z1 s + s^2) N1 + m s^2 g (..., 5): sums of positive terms."""
    n0, n1, n2 = np.moveaxis(parts.motion, -1, 0)
    g0, g1 = np.moveaxis(parts.link, -1, 0)
    c, m = 2.0 * parts.primary_damping, parts.mass
    return np.stack([n0, n1 + c * n0, n2 + c * n1 + n0 + m * g0, c * n2 + n1 + m * g1, n2], axis=-1)


def numerator(parts: Coupling, transfer: Transfer) -> np.ndarray:
    """Coefficients of M (..., 3) of one response, after the shift and without the other factors."""
    zero = np.zeros_like(parts.own)
    wide = np.concatenate([parts.link, zero[..., None]], axis=-1)
    if transfer.motion == "primary":
        return parts.motion
    if transfer.motion == "secondary":
        return wide
    if transfer.motion == "ground":
        both: np.ndarray = parts.motion + parts.mass[..., None] * wide
        return both
    # -own s^2 over s^shift
    inertia: np.ndarray = -parts.own[..., None] * (np.arange(3) == (2 - parts.shift)[..., None])
    return inertia


class Ends(NamedTuple):
    """H ~ at_zero as x -> 0, and H ~ leading s^degree as x -> infinity."""

    at_zero: np.ndarray
    leading: np.ndarray
    degree: np.ndarray

    @property
    def magnitude_at_infinity(self) -> np.ndarray:
        """Limit of |H|: zero, a number or infinity."""
        size = np.abs(self.leading)
        return np.where(self.degree == 0, size, np.where((self.degree > 0) & (size > 0), np.inf, 0))


def ends(parts: Coupling, transfer: Transfer) -> Ends:
    """What H becomes at very low and very high frequency."""
    below = denominator(parts)
    above = numerator(parts, transfer)
    damped = (parts.primary_damping > 0.0) * transfer.ground
    top, top_degree = _highest(above)
    bottom, bottom_degree = _highest(below)
    factor = np.where(damped > 0, (2.0 * parts.primary_damping) ** damped, 1.0)
    at_zero = transfer.sign * above[..., 0] / below[..., 0] * (transfer.power == 0)
    return Ends(
        at_zero,
        transfer.sign * factor * top / bottom,
        transfer.power + damped + top_degree - bottom_degree,
    )


def _highest(coefficients: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Last coefficient that is not zero, and its power; (0, 0) of a polynomial that is zero."""
    there = coefficients != 0.0
    last = coefficients.shape[-1] - 1 - np.argmax(there[..., ::-1], axis=-1)
    last = np.where(np.any(there, axis=-1), last, 0)
    return np.take_along_axis(coefficients, last[..., None], axis=-1)[..., 0], last
