"""A peak of the response in logarithms, with all derivatives that a tuning needs."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.absorber.coefficients import Coupling
from vibecalc.response.absorber.excess import ALL, excess
from vibecalc.response.absorber.measure import Measure, measure
from vibecalc.response.absorber.model import Transfer


class Tunings(NamedTuple):
    """Points (n,) to be tuned: ratios that stay, and the weights of the response made small."""

    primary_damping: np.ndarray
    mass_ratio: np.ndarray
    weights: Measure

    def some(self, rows: np.ndarray) -> "Tunings":
        """The chosen points."""
        return Tunings(
            self.primary_damping[rows], self.mass_ratio[rows],
            Measure(*(a[rows] for a in self.weights)),
        )  # fmt: skip

    def parts(self, place: np.ndarray) -> Coupling:
        """The system at place (2, n): logarithms of k and of 2 z2."""
        z1, m = self.primary_damping, self.mass_ratio
        g0, g1 = np.exp(place)
        return Coupling(z1, m, m, g0, g1, np.zeros(m.shape, dtype=int))


def tunings(primary_damping: np.ndarray, mass_ratio: np.ndarray, transfer: Transfer) -> Tunings:
    """Points for arrays (n,)."""
    zero = np.zeros(mass_ratio.shape)
    parts = Coupling(primary_damping, mass_ratio, mass_ratio, zero, zero, zero.astype(int))
    return Tunings(primary_damping, mass_ratio, measure(parts, transfer))


class Slopes(NamedTuple):
    """w = ln(A / Q) at y = ln u with derivatives by y and by p = (ln k, ln z2).

    `level`, `y`, `yy` (...); `p`, `yp` (2, ...); `pp` (3, ...): by kk, kz, zz.
    """

    level: np.ndarray
    y: np.ndarray
    yy: np.ndarray
    p: np.ndarray
    yp: np.ndarray
    pp: np.ndarray


def slopes(points: Tunings, place: np.ndarray, y: np.ndarray) -> Slopes:
    """Derivatives at `place` (2, n) and `y` (..., n). NaN where A is not positive."""
    parts = points.parts(place)
    u = np.exp(y)
    found = excess(parts, points.weights, u, ALL)
    g0, g1 = parts.g0, parts.g1
    scale = np.stack(
        np.broadcast_arrays(1.0, u, u * u, g0, g1, u * g0, u * g1, g0 * g0, g0 * g1, g1 * g1)
    )
    # in logarithms a second derivative by one variable gains the first
    a, q = (side * scale / side[0] for side in (found.above, found.below))
    first = a[[1, 3, 4]] - q[[1, 3, 4]]
    second = [a[i] - a[j] * a[k] - q[i] + q[j] * q[k] for i, j, k in _PAIRS]
    with np.errstate(invalid="ignore"):
        level = np.log(found.above[0] / found.below[0])
    return Slopes(
        level, first[0], second[0] + first[0], first[1:], np.stack(second[1:3]),
        np.stack([second[3] + first[1], second[4], second[5] + first[2]]),
    )  # fmt: skip


_PAIRS = ((2, 1, 1), (5, 1, 3), (6, 1, 4), (7, 3, 3), (8, 3, 4), (9, 4, 4))


class Reduced(NamedTuple):
    """The level of a peak as a function of p alone, its frequency following: value, slope, bend."""

    level: np.ndarray
    p: np.ndarray
    pp: np.ndarray


def reduced(found: Slopes) -> Reduced:
    """Eliminate y: the peak of the parabola through the point (to second order)."""
    step = found.y / found.yy
    level = found.level - 0.5 * found.y * step
    slope = found.p - found.yp * step
    (a, b), yy = found.yp, found.yy
    return Reduced(level, slope, found.pp - np.stack([a * a, a * b, b * b]) / yy)


def times(bend: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Symmetric 2 x 2 matrices (3, n) times vectors (2, n)."""
    kk, kz, zz = bend
    return np.stack([kk * vector[0] + kz * vector[1], kz * vector[0] + zz * vector[1]])
