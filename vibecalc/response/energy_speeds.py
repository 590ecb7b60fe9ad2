"""Crank speeds at which a curve of energies shows every resonance."""

import numpy as np

from vibecalc.response.resonance import Resonances
from vibecalc.response.singular import Masked, outside

_EVEN = 400
#: distances from a resonance, relative to it, at which a curve of energies needs points
_NEAR = np.concatenate([[0.0], np.geomspace(1e-6, 0.3, 36)])


def energy_speeds(
    resonances: Resonances, orders: np.ndarray, masked: Masked, first: float, last: float
) -> np.ndarray:
    """Ascending speeds (speeds,) in [first, last] rad/s, outside the masked intervals.

    Even steps, and steps that shrink towards every speed at which an order meets a mode; the ends
    of masked intervals are among them.
    """
    met = (resonances.frequency / np.asarray(orders)[:, None])[~resonances.idle]
    met = met[(met > first) & (met < last)]
    close = np.concatenate([met[:, None] * (1.0 + sign * _NEAR) for sign in (-1.0, 1.0)])
    points = [np.linspace(first, last, _EVEN), close.ravel(), masked.low, masked.high]
    speed = np.sort(np.concatenate(points))
    speed = speed[(speed >= max(first, 0.0)) & (speed <= last)]
    distinct = np.concatenate([[True], np.diff(speed) > 1e-9 * last])
    speed = speed[distinct]
    kept: np.ndarray = speed[outside(masked, speed)]
    return kept
