"""Kernel: displacement, velocity and acceleration at points of a body, and their r.m.s. in a band.

A body moves by X exp(i n angle) in each order n, six complex amplitudes about its reference point.
A reading is a row of six numbers: the displacement along a direction at a point is its product with
X. At the frequency w = n times the crank speed, velocity is i w and acceleration -w^2 times that.
Over the cycle the orders are orthogonal, so that the square of an r.m.s. value is half the sum of
the squared amplitudes of the orders that it counts (Parseval).
"""

import numpy as np

from vibecalc.isolation.rows import EMPTY, HarmonicsAt, Jet
from vibecalc.numerics.bounded import Bounded, reshaped, where
from vibecalc.numerics.rounding import BoolArray, FloatArray

#: an order this close to an end of the band, relatively, is on it
_ON = 1e-12


def signals(motion: Bounded, row: FloatArray, frequency: FloatArray) -> list[Bounded]:
    """Displacement, velocity and acceleration (..., readings, orders), m, m/s and m/s^2, 0 to peak.

    Of readings `row` (r, 6) of a motion (..., orders, 6) at frequencies (..., orders), rad/s.
    """
    found = reshaped(motion @ row.T, lambda part: np.swapaxes(part, -1, -2))
    rate = 1j * np.asarray(frequency)[..., None, :]
    return [found, found * rate, found * rate * rate]


def in_band(frequency: FloatArray, band: tuple[float, float]) -> BoolArray:
    """Which frequencies count: those within the band, its ends included."""
    low, high = band
    return np.asarray((frequency >= low * (1.0 - _ON)) & (frequency <= high * (1.0 + _ON)))


def rms(kept: Bounded, counts: BoolArray, dropped: FloatArray) -> Bounded:
    """R.m.s. values (...) of those harmonics (..., m) that count (..., m).

    What all others that count may add is in the error: `dropped` (...) is the sum of their sizes.
    """
    found = where(counts, kept, 0.0).norm()
    # at right angles to what is kept: it adds a square
    added = np.hypot(found.value, dropped) - found.value
    return Bounded(found.value, found.error + added) * float(np.sqrt(0.5))


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
        return Jet(
            *(part if part is EMPTY else np.concatenate((part, *more), axis=1)
              for part, *more in zip(*jets, strict=True))
        )  # fmt: skip

    return harmonics_at


def _rate(jet: Jet, rate: FloatArray, order: FloatArray) -> Jet:
    """Derivative in time of harmonics (speeds, rows, components, orders)."""
    value, error = Bounded(jet.value, jet.error) * (1j * rate)
    if jet.slope is EMPTY:
        return Jet(value, error)
    moved = Bounded(jet.slope, jet.slope_error) * rate + Bounded(jet.value, jet.error) * order
    curvature = 1j * (rate * jet.curvature + 2.0 * order * jet.slope)
    return Jet(value, error, 1j * moved.value, moved.error, curvature)
