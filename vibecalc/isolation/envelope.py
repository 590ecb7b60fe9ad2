"""Peaks over the cycle on a grid of crank angles, good for searching: to some 1e-4 of themselves.

`vibecalc.numerics.cycle_peak` gives the exact ones.
"""

import numpy as np

#: angles per period of the highest order
_DENSITY = 16


def angle_grid(orders: np.ndarray) -> np.ndarray:
    """Crank angles (angles,) that resolve the highest order, over one period of the length.

    That is a turn over the greatest common divisor of the orders, and half of it where all orders
    are odd multiples of that, since the signal then comes back with the other sign.
    """
    step = int(np.gcd.reduce(orders))
    periods = 2 * step if np.all(orders // step % 2) else step
    count = _DENSITY * int(np.max(orders))
    return np.arange(count // periods) * (2.0 * np.pi / count)


def squares(value: np.ndarray, orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Squared length (..., rows, angles) of rows with harmonics (..., rows, components, orders)."""
    turning = np.outer(np.asarray(orders, dtype=float), angle)
    basis = np.concatenate([np.cos(turning), -np.sin(turning)])
    flat = np.concatenate([value.real, value.imag], axis=-1)
    signal = (flat.reshape(-1, flat.shape[-1]) @ basis).reshape(*flat.shape[:-1], -1)
    np.square(signal, out=signal)
    total: np.ndarray = signal[..., 0, :] if signal.shape[-2] == 1 else signal.sum(axis=-2)
    return total


def coarse_peak(value: np.ndarray, orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Peaks (..., rows): each grid maximum lifted by the parabola through it, then the highest.

    Lifting all of them before comparing keeps the curve over speed from jumping where two
    branches change places.
    """
    around = np.concatenate([angle[-1:], angle, angle[:1]])
    height = squares(value, orders, around)
    shape, height = height.shape[:-1], height.reshape(-1, len(around))
    # a parabola lifts a maximum by a quarter of itself at most: what is lower cannot win
    high = height[:, 1:-1] >= 0.8 * height.max(axis=1, keepdims=True)
    row, column = np.divmod(np.flatnonzero(high), len(angle))
    before, top, after = height[row, column], height[row, column + 1], height[row, column + 2]
    slope, bend = after - before, 2.0 * top - before - after
    curved = (top >= before) & (top >= after) & (bend > 0.0)
    lift = np.where(curved, np.square(slope), 0.0) / np.where(curved, 8.0 * bend, 1.0)
    highest = np.maximum.reduceat(top + lift, np.flatnonzero(np.diff(row, prepend=-1)))
    peak: np.ndarray = np.sqrt(highest).reshape(shape)
    return peak
