"""An order on an undamped natural frequency: refused at a point, masked in a range of speeds."""

import math
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF
from vibecalc.response.resonance import Resonances

_TURN = 2.0 * math.pi


class Masked(NamedTuple):
    """Intervals of crank speed in which nothing is computed, ascending; all (intervals,).

    Speeds in rad/s; `mode` counts from 1. Inside, fewer than four digits would remain.
    """

    low: np.ndarray
    centre: np.ndarray
    high: np.ndarray
    order: np.ndarray
    mode: np.ndarray

    @property
    def centre_error(self) -> np.ndarray:
        """Absolute error of each centre: the ends stand where the doubt of it has grown so far."""
        doubt: np.ndarray = 0.5 * SINGULAR * (self.high - self.low) + UNIT_ROUNDOFF * self.centre
        return doubt


def check_operating_point(
    resonances: Resonances, orders: np.ndarray, speed: float
) -> tuple[str, ...]:
    """Refuse a speed at which an order stands on an undamped natural frequency.

    Raises NumericalFailure naming order and mode if the mode is driven. Returns one warning for
    each mode that is met and not driven, whose contribution is left out as zero.
    """
    distance = np.asarray(orders)[:, None] * speed / resonances.frequency - 1.0
    met = np.abs(distance) < resonances.exposed()
    warnings = []
    for row, column in np.argwhere(met):
        mode = int(column) + 1
        frequency = float(resonances.frequency[column])
        place = (
            f"order {orders[row]:g} at {speed:.9g} rad/s ({speed * 60.0 / _TURN:.6g} rpm) is on "
            f"the undamped natural frequency of mode {mode}, {frequency:.9g} rad/s "
            f"({frequency / _TURN:.6g} Hz)"
        )
        if resonances.idle[row, column]:
            warnings.append(
                f"{place}, but does not drive it: the modal force is zero to rounding, and the "
                f"mode is left out of this order"
            )
            continue
        raise NumericalFailure(
            f"{place}: relative distance {distance[row, column]:.1e}, nearer than "
            f"{resonances.exposed()[column]:.1e}, damping ratio "
            f"{resonances.damping_ratio[column]:.1e}. The response has no bound there. Give the "
            f"mounts damping or a loss factor, or move the speed or the stiffness"
        )
    return tuple(warnings)


def left_out(resonances: Resonances) -> np.ndarray:
    """Pairs (orders, modes) of which the mode is undamped and the order does not drive it."""
    return resonances.idle & (resonances.exposed() > 0.0)


def masked_speeds(resonances: Resonances, orders: np.ndarray, start: float, stop: float) -> Masked:
    """Intervals of [start, stop] too near a driven undamped resonance, by order and mode."""
    centre = resonances.frequency / np.asarray(orders)[:, None]
    width = np.broadcast_to(resonances.exposed(), centre.shape)
    low, high = centre * (1.0 - width), centre * (1.0 + width)
    row, column = np.nonzero((width > 0.0) & ~resonances.idle & (high > start) & (low < stop))
    ascending = np.argsort(centre[row, column], kind="stable")
    row, column = row[ascending], column[ascending]
    pick = (row, column)
    return Masked(low[pick], centre[pick], high[pick], np.asarray(orders)[row], column + 1)


def idle_warnings(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float
) -> tuple[str, ...]:
    """Undamped modes that a run-up meets with orders that do not drive them, one text per mode."""
    met = resonances.frequency / np.asarray(orders)[:, None]
    crossed = left_out(resonances) & (met >= start) & (met <= stop)
    return tuple(
        f"undamped mode {column + 1} ({resonances.frequency[column]:.9g} rad/s) is crossed by "
        f"order {', '.join(f'{order:g}' for order in np.asarray(orders)[crossed[:, column]])} "
        f"without being driven (modal force zero to rounding): it is left out there"
        for column in np.flatnonzero(np.any(crossed, axis=0))
    )


def outside(masked: Masked, speed: np.ndarray) -> np.ndarray:
    """True for speeds (...,) that lie in none of the intervals; the ends are outside."""
    inside = (speed[..., None] > masked.low) & (speed[..., None] < masked.high)
    clear: np.ndarray = ~np.any(inside, axis=-1)
    return clear
