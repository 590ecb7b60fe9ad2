"""Where an order may meet a natural frequency: refused at a point, masked in a range."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure, in_hertz, in_rpm
from vibecalc.numerics.leading import leave_alone
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Where an order may meet a natural frequency, and how close it may come.
# ----------------------------------------------------------------------------


class Resonances(NamedTuple):
    """Natural frequencies with what decides whether an order may stand on them.

    `frequency`, `damping_ratio` (modes,): rad/s and 1. `half_width` (modes,): relative distance
    from the frequency within which fewer than four digits of an undamped response remain.
    `idle` (orders, modes): the order does not drive the mode, its modal force is zero to rounding.
    Each may have leading axes of points. Behind the modes there may be resonances that strong
    damping puts elsewhere, or a shaft line has, and that no order may not stand on (NaN for none).
    """

    frequency: np.ndarray
    damping_ratio: np.ndarray
    half_width: np.ndarray
    idle: np.ndarray

    def exposed(self) -> np.ndarray:
        """Relative half width (modes,) of the forbidden zone; zero where damping closes it."""
        squared = np.square(self.half_width) - np.square(self.damping_ratio)
        width: np.ndarray = np.sqrt(np.maximum(squared, 0.0))
        return width

    def beside(self, frequency: np.ndarray, ratio: np.ndarray) -> "Resonances":
        """With others (..., any) that a search of speeds has to examine."""
        none = np.zeros(frequency.shape)
        others = (frequency, ratio, none, none[..., None, :] > 0.0)
        return Resonances(*map(_joined, self, others))


def _joined(first: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Arrays (..., n) and (..., m) side by side; either may lack leading axes of the other."""
    leading = np.broadcast_shapes(first.shape[:-1], other.shape[:-1])
    both = [np.broadcast_to(part, (*leading, part.shape[-1])) for part in (first, other)]
    return np.concatenate(both, axis=-1)


# ----------------------------------------------------------------------------
# An order on an undamped natural frequency: refused at a point, masked in a range of speeds.
# ----------------------------------------------------------------------------


class MaskedSpeeds(NamedTuple):
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
        """Absolute error of each centre: the ends are where its uncertainty has grown so far."""
        uncertainty: np.ndarray = (
            0.5 * SINGULAR * (self.high - self.low) + UNIT_ROUNDOFF * self.centre
        )
        return uncertainty


def check_operating_point(
    resonances: Resonances, orders: np.ndarray, speed: float, warn: Callable[[str], None]
) -> None:
    """Refuse a speed at which an order stands on an undamped natural frequency.

    Of many points (...), at speeds (...), those that are met have to be run alone. Else raises
    NumericalFailure naming order and mode if the mode is driven, and warns of each mode that is met
    and not driven, whose contribution is left out as zero.
    """
    rate = np.asarray(orders)[:, None] * np.asarray(speed)[..., None, None]
    distance = rate / resonances.frequency[..., None, :] - 1.0
    met = np.abs(distance) < resonances.exposed()[..., None, :]
    if met.ndim > 2:
        leave_alone(np.any(met, axis=(-2, -1)))
        return
    for row, column in np.argwhere(met):
        frequency = float(resonances.frequency[column])
        place = (
            f"order {orders[row]:g} at {in_rpm(speed)} is on "
            f"the undamped natural frequency of mode {column + 1}, {in_hertz(frequency)}"
        )
        if not resonances.idle[row, column]:
            raise NumericalFailure(
                f"{place}: relative distance {distance[row, column]:.1e}, nearer than "
                f"{resonances.exposed()[column]:.1e}, damping ratio "
                f"{resonances.damping_ratio[column]:.1e}. The response has no bound there. Give "
                f"the mounts damping or a loss factor, or move the speed or the stiffness"
            )
        warn(
            f"{place}, but does not drive it: the modal force is zero to rounding, and the mode is "
            f"left out of this order"
        )


def left_out(resonances: Resonances) -> np.ndarray:
    """Pairs (orders, modes) of which the mode is undamped and the order does not drive it."""
    return resonances.idle & (resonances.exposed() > 0.0)[..., None, :]


def masked_speeds(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float
) -> MaskedSpeeds:
    """Intervals of [start, stop] too near a driven undamped resonance, by order and mode."""
    centre = resonances.frequency / np.asarray(orders)[:, None]
    width = np.broadcast_to(resonances.exposed(), centre.shape)
    low, high = centre * (1.0 - width), centre * (1.0 + width)
    row, column = np.nonzero((width > 0.0) & ~resonances.idle & (high > start) & (low < stop))
    ascending = np.argsort(centre[row, column], kind="stable")
    row, column = row[ascending], column[ascending]
    pick = (row, column)
    return MaskedSpeeds(low[pick], centre[pick], high[pick], np.asarray(orders)[row], column + 1)


def idle_warnings(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float
) -> tuple[str, ...]:
    """Undamped modes that a run-up meets with orders that do not drive them, one text per mode."""
    met = resonances.frequency / np.asarray(orders)[:, None]
    crossed = left_out(resonances) & (met >= start) & (met <= stop)
    return tuple(
        f"undamped mode {column + 1} ({in_hertz(resonances.frequency[column])}) is crossed by "
        f"order {', '.join(f'{order:g}' for order in np.asarray(orders)[crossed[:, column]])} "
        f"without being driven (modal force zero to rounding): it is left out there"
        for column in np.flatnonzero(np.any(crossed, axis=0))
    )


def outside(masked: MaskedSpeeds, speed: np.ndarray) -> np.ndarray:
    """True for speeds (...,) that lie in none of the intervals; the ends are outside."""
    inside = (speed[..., None] > masked.low) & (speed[..., None] < masked.high)
    clear: np.ndarray = ~np.any(inside, axis=-1)
    return clear


# ----------------------------------------------------------------------------
# Crank speeds at which a curve of energies shows every resonance.
# ----------------------------------------------------------------------------

_EVEN = 400
#: distances from a resonance, relative to it, at which a curve of energies needs points
_NEAR = np.concatenate([[0.0], np.geomspace(1e-6, 0.3, 36)])


def energy_speeds(
    resonances: Resonances,
    orders: np.ndarray,
    masked: MaskedSpeeds,
    first: float,
    last: float,
    kinks: np.ndarray,
) -> np.ndarray:
    """Ascending speeds (speeds,) in [first, last] rad/s, outside the masked intervals.

    Even steps, and steps that shrink towards every speed at which an order meets a mode; `kinks`
    and the ends of masked intervals are among them, however narrow these are.
    """
    met = (resonances.frequency / np.asarray(orders)[:, None])[~resonances.idle]
    met = met[(met > first) & (met < last)]
    close = np.concatenate([met[:, None] * (1.0 + sign * _NEAR) for sign in (-1.0, 1.0)])
    speed = np.sort(np.concatenate([np.linspace(first, last, _EVEN), close.ravel()]))
    speed = speed[np.concatenate([[True], np.diff(speed) > 1e-9 * last])]
    speed = np.sort(np.concatenate([speed, masked.low, masked.high, kinks]))
    speed = speed[np.concatenate([[True], np.diff(speed) > 0.0])]
    return np.asarray(speed[(speed >= first) & (speed <= last) & outside(masked, speed)])
