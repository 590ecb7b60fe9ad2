"""How far a motion moves when its readings move a little: from readings to any result.

To first order. Everything is real here: the parts of a motion are its three real, then its three
imaginary parts, and a result is a gradient by them.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.measurement.level import DECIBEL
from vibecalc.measurement.level_fit import Fit
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray

#: share of the largest curvature below which the motion hangs on rounding alone
_FLAT = 1e-13


class Spread(NamedTuple):
    """`slopes` (6, n) of the parts of a motion by its readings; how far these may be off.

    `half_widths` (n,) bound a reading's error, `deviations` (n,) are its standard uncertainty.
    An infinite slope says that first order does not hold. `doubt` is the relative error of the
    slopes from rounding.
    """

    slopes: FloatArray
    half_widths: FloatArray
    deviations: FloatArray
    doubt: float = 0.0

    def deviation(self, gradient: FloatArray) -> FloatArray:
        """Standard uncertainty (...) of results with gradients (..., 6)."""
        return np.asarray(np.linalg.norm(self._moves(gradient) * self.deviations, axis=-1))

    def bound(self, gradient: FloatArray) -> FloatArray:
        """Largest change (...) of results with gradients (..., 6), all readings at their ends."""
        return np.asarray(np.abs(self._moves(gradient)) @ self.half_widths)

    def in_units(self, units: FloatArray) -> "Spread":
        """The same for a motion multiplied by `units` (3,)."""
        return self._replace(slopes=self.slopes * np.tile(units, 2)[:, None])

    def turned(self, factor: complex, flipped: bool) -> "Spread":
        """The same for a motion multiplied by a factor, and then conjugated if `flipped`."""
        if not np.isfinite(self.slopes).all():
            return self
        moves = (self.slopes[:3] + 1j * self.slopes[3:]) * factor
        side = -1.0 if flipped else 1.0
        return self._replace(slopes=np.concatenate([moves.real, side * moves.imag]))

    def _moves(self, gradient: FloatArray) -> FloatArray:
        if not np.isfinite(self.slopes).all():
            return np.where(np.any(gradient != 0.0, axis=-1)[..., None], np.inf, 0.0) * np.ones(
                self.slopes.shape[1]
            )
        return np.asarray(gradient @ self.slopes)


def level_spread(
    fit: Fit, reference: FloatArray, half_widths: FloatArray, deviations: FloatArray
) -> Spread:
    """Spread of a motion found from levels, its phase held at a reference row (3,)."""
    values, vectors = np.linalg.eigh(fit.hessian)
    turn = np.concatenate([-fit.motion.imag, fit.motion.real])
    turn = turn / np.linalg.norm(turn)
    # the common phase is free: it is the one direction without curvature
    free = int(np.argmax(np.abs(vectors.T @ turn)))
    kept = np.delete(np.arange(6), free)
    widths = (half_widths, deviations)
    if np.min(values[kept]) <= _FLAT * np.max(values):
        return Spread(np.full((6, len(half_widths)), np.inf), *widths)
    doubt = 16.0 * EPSILON * float(np.max(values) / np.min(values[kept]))
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
    slopes = inverse @ (fit.jacobian / half_widths[:, None]).T
    signal = complex(reference @ fit.motion)
    across = _phase_gradient(reference, signal)
    along = float(across @ turn)
    slopes = slopes - np.multiply.outer(turn, across @ slopes) / along
    return Spread(slopes, *widths, doubt)


def level_gradient(rows: FloatArray, motion: ComplexArray) -> FloatArray:
    """Gradients (..., 6) of levels in dB at rows (..., 3); zero where the signal is zero."""
    slope = DECIBEL * rows * _inverse(rows @ motion)[..., None]
    return np.concatenate([slope.real, -slope.imag], axis=-1)


def phase_gradient(rows: FloatArray, motion: ComplexArray) -> FloatArray:
    """Gradients (..., 6) of phases in rad at rows (..., 3); zero where the signal is zero."""
    return _phase_gradient(rows, rows @ motion)


def _phase_gradient(rows: FloatArray, signal: ComplexArray | complex) -> FloatArray:
    slope = rows * np.asarray(_inverse(signal))[..., None]
    return np.concatenate([slope.imag, slope.real], axis=-1)


def _inverse(signal: ComplexArray | complex) -> ComplexArray:
    value = np.asarray(signal, dtype=complex)
    there = np.abs(value) > 0.0
    return np.asarray(np.where(there, 1.0, 0.0) / np.where(there, value, 1.0))
