"""Kernel: displacement, velocity and acceleration at points of a body, and their r.m.s. in a band.

A body moves by X exp(i n angle) in each order n, six complex amplitudes about its reference point.
A reading is a row of six numbers: the displacement along a direction at a point is its product with
X. At the frequency w = n times the crank speed, velocity is i w and acceleration -w^2 times that.
Over the cycle the orders are orthogonal, so that the square of an r.m.s. value is half the sum of
the squared amplitudes of the orders that it counts (Parseval).
"""

from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, BoolArray, FloatArray

#: an order this close to an end of the band, relatively, is on it
_ON = 1e-12


class Signals(NamedTuple):
    """Complex amplitudes (..., readings, orders), 0 to peak, in m, m/s and m/s^2."""

    displacement: Bounded
    velocity: Bounded
    acceleration: Bounded


def signals(motion: Bounded, row: FloatArray, frequency: FloatArray) -> Signals:
    """Readings `row` (r, 6) of a motion (..., orders, 6) at frequencies (..., orders), rad/s."""
    value = motion.value @ row.T
    size = np.abs(row.T)
    error = motion.error @ size + 8.0 * UNIT_ROUNDOFF * (np.abs(motion.value) @ size)
    found = Bounded(np.swapaxes(value, -1, -2), np.swapaxes(error, -1, -2))
    rate = np.asarray(frequency)[..., None, :]
    velocity = found * (1j * rate)
    return Signals(found, velocity, velocity * (1j * rate))


def in_band(frequency: FloatArray, band: tuple[float, float]) -> BoolArray:
    """Which frequencies count: those within the band, its ends included."""
    low, high = band
    return np.asarray((frequency >= low * (1.0 - _ON)) & (frequency <= high * (1.0 + _ON)))


def rms(harmonics: Bounded, counts: BoolArray, retained: int, tail: FloatArray | float) -> Bounded:
    """R.m.s. values (...) of the first `retained` orders (..., m) that count (..., m).

    What the others, up to m, would add is in the error, `tail` times, where they count. `tail` has
    the first axes of the values.
    """
    kept = np.where(counts[..., :retained], harmonics.value[..., :retained], 0.0)
    error = np.where(counts[..., :retained], harmonics.error[..., :retained], 0.0)
    found = Bounded(kept, error).norm()
    dropped = np.where(counts[..., retained:], np.abs(harmonics.value[..., retained:]), 0.0)
    size = dropped.sum(axis=-1)
    factor = np.reshape(tail, (*np.shape(tail), *(1,) * (size.ndim - np.ndim(tail))))
    # at right angles to what is kept: it adds a square
    added = np.hypot(found.value, factor * size) - found.value
    half = np.sqrt(0.5)
    value = half * found.value
    return Bounded(value, half * (found.error + added) + 2.0 * UNIT_ROUNDOFF * value)


# ----------------------------------------------------------------------------
# The same over crank speed, with derivatives.
# ----------------------------------------------------------------------------


def with_rates(rows: HarmonicsAt, order: FloatArray) -> HarmonicsAt:
    """Rows of displacements over crank speed, then their velocities, then their accelerations.

    Each derivative in time multiplies an order by i times its frequency, `order` (orders,) times
    the crank speed.
    """

    def harmonics_at(speed: np.ndarray, slopes: bool = False, errors: bool = False) -> Jet:
        jets = [rows(speed, slopes, errors)]
        rate = (speed[:, None] * order)[:, None, None, :]
        for _ in range(2):
            jets.append(_rate(jets[-1], rate, order))
        return Jet(*(_together(parts) for parts in zip(*jets, strict=True)))

    return harmonics_at


def _together(parts: tuple[np.ndarray, ...]) -> np.ndarray:
    return EMPTY if parts[0] is EMPTY else np.concatenate(parts, axis=1)


def _rate(jet: Jet, rate: FloatArray, order: FloatArray) -> Jet:
    """Derivative in time of harmonics (speeds, rows, components, orders)."""
    value, error = Bounded(jet.value, jet.error) * (1j * rate)
    if jet.slope is EMPTY:
        return Jet(value, error)
    moved = Bounded(jet.slope, jet.slope_error) * rate + Bounded(jet.value, jet.error) * order
    curvature = 1j * (rate * jet.curvature + 2.0 * order * jet.slope)
    return Jet(value, error, 1j * moved.value, moved.error, curvature)
