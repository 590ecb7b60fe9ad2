"""Critical speeds: where an order of excitation meets a natural frequency."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray


class CriticalSpeeds(NamedTuple):
    """By rising speed (c,) in rad/s; `mode` is the place of its frequency, `error` absolute."""

    speed: FloatArray
    order: FloatArray
    mode: IntArray
    error: FloatArray


def critical_speeds(
    natural_frequency: ArrayLike,
    order: ArrayLike,
    lowest: float,
    highest: float,
    frequency_error: ArrayLike = 0.0,
) -> CriticalSpeeds:
    """Every speed from `lowest` to `highest` with order times speed a natural frequency (m,).

    Rigid modes (frequency 0) and order 0 have none. `frequency_error` (m,) is absolute.
    """
    natural, orders = np.asarray(natural_frequency, dtype=float), np.asarray(order, dtype=float)
    mode, place = np.meshgrid(np.arange(len(natural)), np.arange(len(orders)), indexing="ij")
    met = (natural[mode] > 0.0) & (orders[place] > 0.0)
    mode, place = mode[met], place[met]
    speed = natural[mode] / orders[place]
    doubt = np.broadcast_to(frequency_error, natural.shape)[mode] / orders[place]
    inside = (speed >= lowest) & (speed <= highest)
    mode, place, speed, doubt = mode[inside], place[inside], speed[inside], doubt[inside]
    first = np.lexsort((orders[place], speed))
    error = doubt + EPSILON * speed
    return CriticalSpeeds(speed[first], orders[place][first], mode[first], error[first])
