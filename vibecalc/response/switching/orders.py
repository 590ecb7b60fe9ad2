"""Waves of all orders at many crank angles, for sums by one product of real matrices."""

import numpy as np


def order_waves(angle: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """cos and sin (angles, 2 orders) of n theta, side by side; orders are integers from 1.

    Powers of exp(i theta) by doubling, so that hundreds of orders cost one multiplication each;
    the relative error is about n eps, no more than that of the angle itself.
    """
    highest = int(np.max(orders, initial=0))
    power = np.empty((len(angle), highest + 1), dtype=complex)
    power[:, 0] = 1.0
    if highest:
        power[:, 1] = np.cos(angle) + 1j * np.sin(angle)
    known = 1
    while known < highest:
        more = min(known, highest - known)
        power[:, known + 1 : known + 1 + more] = power[:, 1 : 1 + more] * power[:, known, None]
        known += more
    return np.ascontiguousarray(power[:, orders]).view(float)


def real_rows(amplitude: np.ndarray) -> np.ndarray:
    """Rows (2 orders, columns) whose product with the waves is Re sum A_n exp(i n theta)."""
    rows = np.empty((2 * len(amplitude), amplitude.shape[1]))
    rows[0::2], rows[1::2] = amplitude.real, -amplitude.imag
    return rows
