"""Where a run-up is sampled: first grid of speeds, refinement, speeds known, crank angles."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.isolation.rows import Jet
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.rounding import FloatArray
from vibecalc.response.resonances import MaskedSpeeds, Resonances, outside

# ----------------------------------------------------------------------------
# At which speeds of a run-up to sample first: a coarse grid, and clusters at order resonances.
# ----------------------------------------------------------------------------

#: first offset of a cluster in half bandwidths, growth of the offsets, largest relative offset
_FIRST, _GROWTH, _FARTHEST = 0.6, 2.4, 0.75

#: the same where only the highest place is sought, and the steps between speeds there
_SPARSE_FIRST, _SPARSE_GROWTH, _SPARSE_FARTHEST, _SPARSE_STEP = 0.5, 2.0, 0.5, 1.4


def base_speeds(
    resonances: Resonances, orders: np.ndarray, start: float, stop: float, count: int
) -> np.ndarray:
    """Uniform speeds, as many again in geometric steps from below the lowest order resonance."""
    uniform = np.linspace(start, stop, count)
    lowest = np.min(resonances.frequency) / np.max(orders) / 3.0
    floor = max(start, lowest, stop * 1e-6)
    if floor >= stop:
        return uniform
    return np.concatenate([uniform, np.geomspace(floor, stop, count // 2)[1:-1]])


def resonant_speeds(resonances: Resonances, orders: np.ndarray) -> np.ndarray:
    """Crank speed (orders, modes) at which an order meets a natural frequency, rad/s."""
    speed: np.ndarray = resonances.frequency / np.asarray(orders, dtype=float)[:, None]
    return speed


def sparse_speeds(
    frequency: np.ndarray, orders: np.ndarray, start: np.ndarray, stop: np.ndarray
) -> np.ndarray:
    """Of each machine both ends and geometric steps from below the lowest order resonance.

    `frequency` is (machines, n), `start` and `stop` (machines,); the result (machines, speeds),
    NaN for none. Between resonances, which have speeds of their own, a curve bends on the scale of
    the speed.
    """
    lowest = np.nanmin(frequency, axis=1) / np.max(orders) / 1.5
    floor = np.maximum(np.maximum(start, lowest), stop * 1e-6)
    # all below the lowest resonance
    low = floor >= stop
    ratio = np.where(low, 2.0, stop / np.where(low, 1.0, floor))
    count = np.maximum(np.ceil(np.log(ratio) / np.log(_SPARSE_STEP)), 3.0)
    step = np.arange(np.max(count))
    speed = np.where(low, np.nan, floor)[:, None] * ratio[:, None] ** (step / count[:, None])
    speed = np.where(step < count[:, None], speed, np.nan)
    middle = np.where(low, 0.5 * (start + stop), np.nan)
    return np.concatenate([np.stack([start, middle, stop], axis=1), speed], axis=1)


def clusters(resonances: Resonances, orders: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Speeds in geometric steps away from chosen (orders, modes) resonances, on either side.

    The first step is less than the half bandwidth, so that no resonance is too narrow to be
    seen; next to a masked interval it starts at the interval's edge.
    """
    ratio, exposed = resonances.damping_ratio, resonances.exposed()
    order, mode = np.nonzero(chosen)
    centre = resonant_speeds(resonances, orders)[order, mode]
    return _spread(centre, ratio[mode], exposed[mode], _FIRST, _GROWTH, _FARTHEST)[0]


def sparse_clusters(
    centre: np.ndarray, damping_ratio: np.ndarray, exposed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The same about speeds (n,) with few speeds: enough that a climb from the best of them finds
    the peak. Also tells which of the (n,) each is about."""
    return _spread(centre, damping_ratio, exposed, _SPARSE_FIRST, _SPARSE_GROWTH, _SPARSE_FARTHEST)


def _spread(
    centre: np.ndarray,
    damping_ratio: np.ndarray,
    exposed: np.ndarray,
    first: float,
    growth: float,
    farthest: float,
) -> tuple[np.ndarray, np.ndarray]:
    width = np.maximum(np.maximum(first * damping_ratio, exposed), 1e-13)
    steps = np.maximum(np.ceil(np.log(farthest / width) / np.log(growth)), 0.0).astype(int) + 1
    which = np.repeat(np.arange(len(centre)), steps)
    step = np.arange(len(which)) - np.repeat(np.cumsum(steps) - steps, steps)
    offset = width[which] * growth**step
    near = centre[which]
    speeds = np.concatenate([near * (1.0 - offset), near * (1.0 + offset)])
    return speeds, np.concatenate([which, which])


def admitted(speed: np.ndarray, masked: MaskedSpeeds, start: float, stop: float) -> np.ndarray:
    """Ascending speeds within the range, without doubles, none inside a masked interval."""
    edges = np.concatenate([masked.low, masked.high])
    ascending: np.ndarray = np.sort(np.concatenate([speed, edges]))
    # np.unique does the same, but imports the masked arrays of numpy
    ascending = ascending[np.concatenate([[True], np.diff(ascending) > 0.0])]
    ascending = ascending[(ascending >= start) & (ascending <= stop)]
    if len(masked.low):
        ascending = ascending[outside(masked, ascending)]
    return ascending


def beside_poles(
    centre: np.ndarray,
    exposed: np.ndarray,
    masked: MaskedSpeeds,
    start: float | np.ndarray,
    stop: float | np.ndarray,
) -> np.ndarray:
    """Where to look at resonances `centre` (..., modes): outside the range, at its end.

    Next to a pole the response is taken at the edge of its interval; poles moved by damping that
    is not there stand on others.
    """
    at = np.clip(centre * (1.0 - exposed), start, stop)
    for low, high in zip(masked.low.tolist(), masked.high.tolist(), strict=True):
        at[(at > low) & (at < high)] = low if low >= np.max(start) else high
    return at


# ----------------------------------------------------------------------------
# Speeds of a run-up that were examined, so that none is computed twice.
# ----------------------------------------------------------------------------

#: arrays (speeds, ...) at speeds (speeds,)
SpeedFunction = Callable[[FloatArray], tuple[FloatArray, ...]]


class CachedFunction:
    """A function of the speed that remembers what it gave at each of them.

    `add` gives it what is known from elsewhere.
    """

    def __init__(self, function: SpeedFunction) -> None:
        self._function = function
        self._speed = np.zeros(0)
        self._values: tuple[FloatArray, ...] = ()

    @property
    def speed(self) -> FloatArray:
        """The speeds examined, ascending."""
        return self._speed

    def add(self, speed: FloatArray, *values: FloatArray) -> None:
        """Values (speeds, ...) at speeds (speeds,); of doubles the first counts."""
        if len(self._speed):
            speed = np.concatenate([self._speed, speed])
            values = tuple(map(np.concatenate, zip(self._values, values, strict=True)))
        order = np.argsort(speed, kind="stable")
        ascending = speed[order]
        order = order[np.concatenate([[True], np.diff(ascending) > 0.0])]
        self._speed, self._values = speed[order], tuple(one[order] for one in values)

    def __call__(self, speed: FloatArray) -> tuple[FloatArray, ...]:
        """Values at ascending speeds without doubles, from memory where they are there."""
        place = np.searchsorted(self._speed, speed)
        if len(self._speed):
            known = self._speed[np.minimum(place, len(self._speed) - 1)] == speed
        else:
            known = np.zeros(len(speed), dtype=bool)
        if not np.all(known):
            self.add(speed[~known], *self._function(speed[~known]))
            place = np.searchsorted(self._speed, speed)
        return tuple(one[place] for one in self._values)


# ----------------------------------------------------------------------------
# Bisection of a run-up curve until straight lines between its points are good enough.
# ----------------------------------------------------------------------------

#: no interval is cut below this relative width
_NARROWEST = 1e-14

#: next to a pole without bound the curve is resolved relative to itself
_NEAR_POLE = 0.02


class Curve(NamedTuple):
    """Ascending speeds (speeds,), values (speeds, rows), intervals left unresolved by the cap."""

    speed: np.ndarray
    value: np.ndarray
    unresolved: int


def resolve(
    curve_at: Callable[[np.ndarray], np.ndarray],
    speed: np.ndarray,
    masked: MaskedSpeeds,
    infinite: np.ndarray,
    tolerance: float,
    most_points: int,
) -> Curve:
    """Add midpoints until each is within `tolerance` of the chord, of each row's maximum.

    Parameters
    ----------
    curve_at : rows at speeds, (speeds,) to (speeds, rows).
    speed : ascending first speeds, none inside a masked interval.
    infinite : (rows,) rows that have no bound within the range; the maximum that counts for
        them is that of the speeds well away from the masked intervals.
    """
    value = curve_at(speed)
    left, right = np.arange(len(speed) - 1), np.arange(1, len(speed))
    open_left, open_right = speed[left], speed[right]
    low_value, high_value = value[left], value[right]
    all_speed, all_value = [speed], [value]
    total = len(speed)
    scale = _scale(speed, value, masked, infinite)
    while True:
        wide = open_right - open_left > _NARROWEST * open_right
        if len(masked.centre):
            across = (open_left[:, None] < masked.centre) & (open_right[:, None] > masked.centre)
            wide &= ~np.any(across, axis=1)
        open_left, open_right = open_left[wide], open_right[wide]
        low_value, high_value = low_value[wide], high_value[wide]
        room = most_points - total
        if not len(open_left) or len(open_left) > room:
            break
        middle = 0.5 * (open_left + open_right)
        middle_value = curve_at(middle)
        all_speed.append(middle)
        all_value.append(middle_value)
        total += len(middle)
        scale = np.maximum(scale, np.where(infinite, 0.0, np.max(middle_value, axis=0)))
        chord = 0.5 * (low_value + high_value)
        allowed = tolerance * scale + np.where(infinite, _NEAR_POLE * middle_value, 0.0)
        poor = np.any(np.abs(middle_value - chord) > allowed, axis=1)
        open_left = np.concatenate([open_left[poor], middle[poor]])
        open_right = np.concatenate([middle[poor], open_right[poor]])
        low_value, high_value = (
            np.concatenate([low_value[poor], middle_value[poor]]),
            np.concatenate([middle_value[poor], high_value[poor]]),
        )
    merged = np.concatenate(all_speed)
    ascending = np.argsort(merged, kind="stable")
    return Curve(merged[ascending], np.concatenate(all_value)[ascending], len(open_left))


def _scale(
    speed: np.ndarray, value: np.ndarray, masked: MaskedSpeeds, infinite: np.ndarray
) -> np.ndarray:
    """Largest value of each row that the tolerance is relative to."""
    top: np.ndarray = np.max(value, axis=0)
    if not np.any(infinite):
        return top
    away = np.all(np.abs(speed[:, None] - masked.centre) > 0.01 * masked.centre, axis=1)
    if not np.any(away):
        return top
    return np.where(infinite, np.max(value[away], axis=0), top)


# ----------------------------------------------------------------------------
# Peaks over the cycle: exact ones with their errors, and others on a grid of crank angles, good for
# searching, to some 1e-4 of themselves.
# ----------------------------------------------------------------------------


def uncertainty_of(jet: Jet) -> np.ndarray:
    """What the errors of the harmonics may add to the length of each row (speeds, rows)."""
    return np.asarray(np.sqrt(np.sum(np.square(np.sum(jet.error, axis=-1)), axis=-1)))


def exact_peaks(harmonics: np.ndarray, uncertainty: np.ndarray, orders: np.ndarray) -> Bounded:
    """Peaks (...) of harmonics (..., components, orders) of some uncertainty (...)."""
    peak = vector_cycle_peak(harmonics, orders)
    return Bounded(peak.value, peak.error + uncertainty)


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
