"""Peaks over the cycle on a grid of crank angles, good for searching: to some 1e-4 of themselves.

`vibecalc.numerics.cycle_peak` gives the exact ones.
"""

import numpy as np

#: angles per period of the highest order
_DENSITY = 16


def angle_grid(orders: np.ndarray) -> np.ndarray:
    """Crank angles (angles,) in [0, 2 pi) that resolve the highest order."""
    count = _DENSITY * int(np.max(orders))
    return np.arange(count) * (2.0 * np.pi / count)


def squares(value: np.ndarray, orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Squared length (..., rows, angles) of rows with harmonics (..., rows, components, orders)."""
    turning = np.outer(np.asarray(orders, dtype=float), angle)
    basis = np.concatenate([np.cos(turning), -np.sin(turning)])
    flat = np.concatenate([value.real, value.imag], axis=-1)
    signal = (flat.reshape(-1, flat.shape[-1]) @ basis).reshape(*flat.shape[:-1], -1)
    if signal.shape[-2] == 1:
        only: np.ndarray = np.square(signal[..., 0, :])
        return only
    total: np.ndarray = np.sum(np.square(signal), axis=-2)
    return total


def coarse_peak(value: np.ndarray, orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Peaks (..., rows): each grid maximum lifted by the parabola through it, then the highest.

    Lifting all of them before comparing keeps the curve over speed from jumping where two
    branches change places.
    """
    height = squares(value, orders, angle)
    left = np.concatenate([height[..., -1:], height[..., :-1]], axis=-1)
    right = np.concatenate([height[..., 1:], height[..., :1]], axis=-1)
    bend = 2.0 * height - left - right
    local = (height >= left) & (height >= right) & (bend > 0.0)
    slope = np.where(local, right - left, 0.0)
    lifted = height + slope * slope / (8.0 * np.where(local, bend, 1.0))
    peak: np.ndarray = np.sqrt(np.max(lifted, axis=-1))
    return peak
