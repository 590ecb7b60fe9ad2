"""Where run-ups are sampled: few speeds of many machines, or as many as a curve takes."""

from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.isolation.rows import Jet
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.response.resonances import MaskedSpeeds, Resonances, outside

# ----------------------------------------------------------------------------
# Machines that run up. Speeds of all of them stand in one list, each with the number of its
# machine, so that every step of a search is taken for all of them. What is found of one does not
# depend on the others.
# ----------------------------------------------------------------------------


class JetsAt(Protocol):
    """Rows (n,) at speeds (n,): jets (n, components, orders) with slopes, and with errors."""

    def __call__(self, speed: np.ndarray, row: np.ndarray, errors: bool = False) -> Jet: ...


class Machines(NamedTuple):
    """Machines of as many `rows` each, those of one after the other (machines * rows,).

    They pass the speeds from `start` to `stop`, rad/s. `harmonics_at` gives (n, rows, components,
    orders) of machines (n,) at speeds (n,). `resonances` (machines, modes) are to be looked at, NaN
    for none. Only one machine by itself has intervals `masked`; rows have no bound in those that
    each `meets` (masked, machines * rows). `look` is a quick way to jets, good to some 1e-9.
    """

    jets_at: JetsAt
    harmonics_at: Callable[[np.ndarray, np.ndarray], np.ndarray]
    orders: np.ndarray
    start: float
    stop: float
    resonances: Resonances
    rows: int
    masked: MaskedSpeeds
    meets: np.ndarray
    look: JetsAt | None = None

    @property
    def infinite(self) -> np.ndarray:
        """Which rows (machines * rows,) have no bound."""
        return np.asarray(np.any(self.meets, axis=0))

    def outside(self, speed: np.ndarray) -> np.ndarray:
        """Which speeds are in the range and in no masked interval; NaN are not."""
        within = (speed >= self.start) & (speed <= self.stop)
        return within & outside(self.masked, speed) if len(self.masked.low) else within


#: speeds times orders that are worked on at once: some 60 MB for a rigid body on four mounts
MOST_AT_ONCE = 30_000


def in_blocks(
    function: Callable[[np.ndarray], Iterable[np.ndarray]], speed: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, ...]:
    """The arrays `function` gives for speeds (speeds,), each joined along its first axis."""
    count = -(-len(speed) * len(orders) // MOST_AT_ONCE)
    if count < 2:
        return tuple(function(speed))
    parts = [function(part) for part in np.array_split(speed, min(count, len(speed)))]
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))


def exact_peaks(jet: Jet, orders: np.ndarray) -> Bounded:
    """Peaks over the cycle of jets (..., components, orders) with their errors."""
    peak = vector_cycle_peak(jet.value, orders)
    return Bounded(peak.value, peak.error + _size(np.sum(jet.error, axis=-1)))


# ----------------------------------------------------------------------------
# Few speeds: both ends and geometric steps, each speed at which an order meets a mode, and those
# close about where the highest point may be.
# ----------------------------------------------------------------------------

#: ratio of speeds between the resonances
_STEP = 1.4
#: first offset about a resonance in half bandwidths, growth of the offsets, largest relative one
_SPREAD = (0.5, 2.0, 0.5)
#: next to a resonance a row is no higher than there and so many times what the resonance gives
_ADDED = 3.0
#: share of a row's maximum that is its rounding
_ROUNDING = 1e-13
#: share of the highest value from which a sample may be next to the highest point
SPARSE = 0.8
#: relative distance of two speeds from which on they are not one
_APART = 1e-14


class Samples(NamedTuple):
    """Speeds (n,) of one machine after the other, rising, and rows (n, rows) there.

    `value` are peaks over a grid of crank angles, good to some 1e-4. `curve` (n, rows) has them
    exactly, with their errors.
    """

    machine: np.ndarray
    speed: np.ndarray
    value: np.ndarray
    curve: Bounded | None = None


def sparse_samples(machines: Machines) -> Samples:
    """Speeds between the resonances, at the resonances themselves, and closely only about those
    that can hold the maximum of a row: where all that is there and three times what the resonance
    adds come up to the highest value seen.
    """
    met = machines.resonances
    centre, at = met_at(machines)
    speed = np.concatenate([at.reshape(len(at), -1), _between(machines)], axis=1)
    used = machines.outside(speed)
    machine, _ = np.nonzero(used)
    speed = speed[used]
    harmonics, value = _seen(machines, machine, speed)
    # place of each resonance in the list
    place = (np.cumsum(used) - 1).reshape(used.shape)[:, : at[0].size].reshape(at.shape)
    of_order = _size(np.moveaxis(harmonics, -1, 1)[place, np.arange(at.shape[1])[:, None]])
    top = np.full((len(at), machines.rows), 1e-300)
    np.maximum.at(top, machine, value)
    top = top[:, None, None]
    may = (value[place] + _ADDED * of_order >= top) & (of_order > _ROUNDING * top)
    may &= ~machines.infinite.reshape(len(at), 1, 1, -1) & ~np.isnan(at)[..., None]
    of, order, mode = np.nonzero(np.any(may, axis=-1))
    which, offset = offsets(met.damping_ratio[of, mode], met.exposed()[of, mode], *_SPREAD)
    more, owner = centre[of, order, mode][which] * (1.0 + offset), of[which]
    used = machines.outside(more)
    more, owner = more[used], owner[used]
    machine, speed, value = (
        np.concatenate(pair)
        for pair in ((machine, owner), (speed, more), (value, _seen(machines, owner, more)[1]))
    )
    rising = np.lexsort((speed, machine))
    machine, speed, value = machine[rising], speed[rising], value[rising]
    apart = np.diff(speed) > _APART * speed[1:]
    new = np.concatenate([[True], (np.diff(machine) > 0) | apart])
    return Samples(machine[new], speed[new], value[new])


def met_at(machines: Machines) -> tuple[np.ndarray, np.ndarray]:
    """Speeds (machines, orders, modes) at which orders meet modes, and where these are looked at.

    Outside the range that is at its end, next to a pole at the edge of its interval; poles moved by
    damping that is not there stand on others.
    """
    met, masked = machines.resonances, machines.masked
    centre = met.frequency[:, None, :] / np.asarray(machines.orders, dtype=float)[:, None]
    at = np.clip(centre * (1.0 - met.exposed()[:, None, :]), machines.start, machines.stop)
    for low, high in zip(masked.low.tolist(), masked.high.tolist(), strict=True):
        at[(at > low) & (at < high)] = low if low >= machines.start else high
    return centre, at


def _between(machines: Machines) -> np.ndarray:
    """Speeds (machines, n) at the ends, and in geometric steps from below the lowest resonance.

    Between resonances, which have speeds of their own, a curve bends on the scale of the speed. NaN
    for none.
    """
    start, stop, count = machines.start, machines.stop, len(machines.resonances.frequency)
    lowest = np.nanmin(machines.resonances.frequency, axis=1) / np.max(machines.orders) / 1.5
    floor = np.minimum(np.maximum(np.maximum(start, lowest), stop * 1e-6), stop)
    steps = np.maximum(np.ceil(np.log(stop / floor) / np.log(_STEP)), 3.0)[:, None]
    step = np.arange(np.max(steps))
    geometric = floor[:, None] * (stop / floor)[:, None] ** (step / steps)
    given = [start, 0.5 * (start + stop), stop, *machines.masked.low, *machines.masked.high]
    ends = np.broadcast_to(np.array(given), (count, len(given)))
    return np.concatenate([ends, np.where(step < steps, geometric, np.nan)], axis=1)


def offsets(
    damping_ratio: np.ndarray, exposed: np.ndarray, first: float, growth: float, farthest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Relative offsets from resonances (n,), on both sides, and which resonance each is about.

    The first one is less than the half bandwidth, or the edge of a masked interval.
    """
    width = np.maximum(np.maximum(first * damping_ratio, exposed), 1e-13)
    steps = np.maximum(np.ceil(np.log(farthest / width) / np.log(growth)), 0.0).astype(int) + 1
    which = np.repeat(np.arange(len(width)), steps)
    step = np.arange(len(which)) - np.repeat(np.cumsum(steps) - steps, steps)
    offset = width[which] * growth**step
    return np.concatenate([which, which]), np.concatenate([-offset, offset])


def _seen(
    machines: Machines, machine: np.ndarray, speed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Harmonics at speeds (n,) of machines (n,), and peaks (n, rows) of them over a grid."""
    harmonics, orders = machines.harmonics_at(machine, speed), machines.orders

    def peaks(part: np.ndarray) -> tuple[np.ndarray, ...]:
        return (rough_peaks(harmonics[part], orders),)

    return harmonics, in_blocks(peaks, np.arange(len(speed)), orders)[0]


def _size(vector: np.ndarray) -> np.ndarray:
    """Length of complex vectors (..., components)."""
    return np.asarray(np.sqrt(np.sum(np.square(np.abs(vector)), axis=-1)))


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
    """Squared length (n, angles) of rows with harmonics (n, components, orders)."""
    turning = np.outer(np.asarray(orders, dtype=float), angle)
    basis = np.concatenate([np.cos(turning), -np.sin(turning)])
    flat = np.concatenate([value.real, value.imag], axis=-1)
    signal = (flat.reshape(-1, flat.shape[-1]) @ basis).reshape(*flat.shape[:-1], len(angle))
    return np.asarray(np.square(signal, out=signal).sum(axis=-2))


def coarse_peak(value: np.ndarray, orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Peaks (n,) of rows (n, components, orders): each grid maximum lifted by the parabola through
    it, then the highest."""
    height = squares(value, orders, np.concatenate([angle[-1:], angle, angle[:1]]))
    # a parabola lifts a maximum by a quarter of itself at most: what is lower cannot win
    high = height[:, 1:-1] >= 0.8 * height.max(axis=1, keepdims=True)
    row, column = np.nonzero(high)
    before, top, after = height[row, column], height[row, column + 1], height[row, column + 2]
    slope, bend = after - before, 2.0 * top - before - after
    curved = (top >= before) & (top >= after) & (bend > 0.0)
    lift = np.where(curved, np.square(slope), 0.0) / np.where(curved, 8.0 * bend, 1.0)
    highest = np.zeros(len(value))
    np.maximum.at(highest, row, top + lift)
    return np.sqrt(highest)


# ----------------------------------------------------------------------------
# As many speeds as a curve takes: even and geometric steps, clusters about resonances that can be
# seen in it, and midpoints until straight lines between its points are good enough.
# ----------------------------------------------------------------------------

#: as `_SPREAD`, for a curve
_CLUSTER = (0.6, 2.4, 0.75)
#: a resonance whose own order stays below this share of a row's maximum gets no cluster there
#: unless it stands where the row is high anyway
_NEGLIGIBLE = 1e-4


def curve_speeds(machine: Machines) -> np.ndarray:
    """First speeds (n,) of the curve of one machine, rising, none inside a masked interval."""
    met, start, stop, masked = machine.resonances, machine.start, machine.stop, machine.masked
    speed = np.linspace(start, stop, 25)
    floor = max(start, np.min(met.frequency) / np.max(machine.orders) / 3.0, stop * 1e-6)
    if floor < stop:
        speed = np.concatenate([speed, np.geomspace(floor, stop, 12)[1:-1]])
    centre, at = (part[0] for part in met_at(machine))
    chosen = (centre > 0.2 * start) & (centre < 4.0 * stop)
    if np.sum(chosen) > 8:
        seen = machine.harmonics_at(np.zeros(0, int), np.concatenate([at.ravel(), speed]))
        peak = rough_peaks(seen, machine.orders)
        of_order = seen[: at.size].reshape(*at.shape, *seen.shape[1:])
        of_order = _size(of_order[np.arange(len(at)), ..., np.arange(len(at))])
        here, top = peak[: at.size].reshape(of_order.shape), np.max(peak, axis=0)
        visible = (of_order > _ROUNDING * top) & (here > 0.5 * top)
        chosen &= np.any(visible | (of_order > _NEGLIGIBLE * top), axis=-1)
    mode = np.nonzero(chosen)[1]
    which, offset = offsets(met.damping_ratio[0, mode], met.exposed()[0, mode], *_CLUSTER)
    about = centre[chosen]
    more = about, about[which] * (1.0 + offset), masked.low, masked.high
    speed = np.sort(np.concatenate([speed, *more]))
    # np.unique does the same, but imports the masked arrays of numpy
    speed = speed[np.concatenate([[True], np.diff(speed) > 0.0])]
    return np.asarray(speed[machine.outside(speed)])


def rough_peaks(harmonics: np.ndarray, orders: np.ndarray) -> np.ndarray:
    """Peaks (n, rows) over a grid of angles of harmonics (n, rows, components, orders)."""
    flat = harmonics.reshape(-1, *harmonics.shape[2:])
    return coarse_peak(flat, orders, angle_grid(orders)).reshape(harmonics.shape[:2])


#: no interval is cut below this relative width
_NARROWEST = 1e-14
#: speeds of a curve, at most
_MOST_POINTS = 20_000
#: next to a pole without bound the curve is resolved relative to itself
_NEAR_POLE = 0.02


def resolve(
    curve_at: Callable[[np.ndarray], tuple[np.ndarray, ...]], machine: Machines, tolerance: float
) -> tuple[np.ndarray, Bounded, int]:
    """Speeds, rising, and the curve there, with midpoints added until each is within `tolerance` of
    the chord, of each row's maximum; how many intervals the cap on their number left unresolved.

    `curve_at` gives rows at speeds, (speeds,) to (speeds, rows): roughly, exactly, their errors.
    Of rows that have no bound the maximum that counts is that of the speeds well away from the
    masked intervals.
    """
    speed, masked, infinite = curve_speeds(machine), machine.masked, machine.infinite
    value, *exact = curve_at(speed)
    speeds, values = [speed], [Bounded(*exact)]
    away = np.all(np.abs(speed[:, None] - masked.centre) > 0.01 * masked.centre, axis=1)
    scale = np.max(value, axis=0)
    scale = np.where(infinite & np.any(away), np.max(value[away], axis=0, initial=0.0), scale)
    # ends of the open intervals, and values there
    low, high, at_low, at_high = speed[:-1], speed[1:], value[:-1], value[1:]
    while True:
        wide = high - low > _NARROWEST * high
        across = (low[:, None] < masked.centre) & (high[:, None] > masked.centre)
        wide &= ~np.any(across, axis=1)
        low, high, at_low, at_high = (part[wide] for part in (low, high, at_low, at_high))
        if not len(low) or len(low) > _MOST_POINTS - sum(map(len, speeds)):
            break
        middle = 0.5 * (low + high)
        found, *exact = curve_at(middle)
        speeds.append(middle)
        values.append(Bounded(*exact))
        scale = np.maximum(scale, np.where(infinite, 0.0, np.max(found, axis=0)))
        allowed = tolerance * scale + np.where(infinite, _NEAR_POLE * found, 0.0)
        poor = np.any(np.abs(found - 0.5 * (at_low + at_high)) > allowed, axis=1)
        between, at = middle[poor], found[poor]
        low, high = np.concatenate([low[poor], between]), np.concatenate([between, high[poor]])
        at_low, at_high = np.concatenate([at_low[poor], at]), np.concatenate([at, at_high[poor]])
    every = np.concatenate(speeds)
    rising = np.argsort(every, kind="stable")
    return every[rising], concatenate(values, axis=0)[rising], len(low)
