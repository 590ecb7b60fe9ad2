"""What is read off the motion: displacements, forces, energies, with their true peaks."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import Peak, cycle_peak, vector_cycle_peak
from vibecalc.numerics.maxima import SURE
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.motion import ModalMotion, Segment, motion_at, motion_on_grid
from vibecalc.response.switching.system import ModalLoads, ModalSystem, SteadyMotion

# ----------------------------------------------------------------------------
# What is read off the motion: displacements, forces through the mounts, energies.
#
# Columns, for a body of k coordinates (usually 6, x y z rx ry rz): `DISPLACEMENT` k displacements
# of the reference point (m, rad), then k forces and couples through the mounts on the ground
# (N, N m), then kinetic, potential and total energy (J).
# ----------------------------------------------------------------------------


class Jet(NamedTuple):
    """Readings (times, columns) with their first and second derivative by time."""

    value: np.ndarray
    rate: np.ndarray
    bend: np.ndarray


class Columns(NamedTuple):
    """Where the readings of a body with k coordinates stand."""

    displacement: slice
    mount_force: slice
    kinetic: int
    potential: int
    energy: int


def columns(coordinates: int = 6) -> Columns:
    """Columns of the readings of a body."""
    k = coordinates
    return Columns(slice(0, k), slice(k, 2 * k), 2 * k, 2 * k + 1, 2 * k + 2)


def momentum_rows(system: ModalSystem) -> np.ndarray:
    """M V = inverse of V^T (coordinates, modes): brings modal forces back to coordinates."""
    rows: np.ndarray = np.linalg.inv(system.shape).T
    return rows


def read(system: ModalSystem, motion: ModalMotion) -> Jet:
    """All readings of a motion.

    The mounts push the ground with K x + C x' = M V (w^2 q + 2 zeta w q'), the modal damping being
    the mounts'. Energies are half the sums of q'^2 and of w^2 q^2.
    """
    place, frequency = system.shape.T, system.frequency
    damping, back = 2.0 * system.damping_ratio * frequency, momentum_rows(system).T
    q, v, a, j = motion
    w2 = frequency**2
    kinetic = (0.5 * v**2, v * a, a**2 + v * j)
    potential = (0.5 * w2 * q**2, w2 * q * v, w2 * (v**2 + q * a))
    jets = []
    for n, (lower, upper) in enumerate(((q, v), (v, a), (a, j))):
        energies = [np.sum(kinetic[n], axis=-1), np.sum(potential[n], axis=-1)]
        parts = [lower @ place, (w2 * lower + damping * upper) @ back]
        jets.append(np.column_stack([*parts, *energies, energies[0] + energies[1]]))
    return Jet(*jets)


def linear_rows(system: ModalSystem) -> tuple[np.ndarray, np.ndarray]:
    """Factors (columns, modes) of q and of q' in displacements and mount forces."""
    back, frequency = momentum_rows(system), system.frequency
    on_velocity = np.zeros_like(back)
    return (
        np.concatenate([system.shape, back * frequency**2]),
        np.concatenate([on_velocity, back * 2.0 * system.damping_ratio * frequency]),
    )


def read_bound(system: ModalSystem, size: np.ndarray) -> np.ndarray:
    """Largest readings (..., columns) of motions whose modes have the sizes (..., modes).

    The size of a mode is sqrt(q'^2 + w^2 q^2). A mode that nothing holds must be at rest.
    """
    on_place, on_velocity = linear_rows(system)
    held = system.frequency > 0.0
    place = np.where(held, on_place / np.where(held, system.frequency, 1.0), 0.0)
    linear = size @ np.hypot(place, on_velocity).T
    energy = np.repeat(0.5 * np.sum(size**2, axis=-1, keepdims=True), 3, axis=-1)
    return np.concatenate([linear, energy], axis=-1)


def read_error(
    system: ModalSystem, value: np.ndarray, error: np.ndarray, largest: np.ndarray
) -> np.ndarray:
    """Absolute errors (..., columns) of readings, from those of the sizes of the modes (modes,).

    `largest` (modes,) are the sizes themselves; what rounding adds to the sums grows with them.
    """
    bound = read_bound(system, error + 8.0 * EPSILON * largest)
    spread = np.sqrt(2.0 * np.sum(error**2)) * np.sqrt(np.abs(value[..., -3:]))
    energy = bound[..., -3:] + spread + 8.0 * EPSILON * np.abs(value[..., -3:])
    linear = np.broadcast_to(bound[..., :-3], value[..., :-3].shape)
    return np.concatenate([linear, energy], axis=-1)


def steady_peaks(
    system: ModalSystem, steady: SteadyMotion, orders: np.ndarray, speed: float
) -> Bounded:
    """Largest magnitudes (columns,) of all readings over a cycle of the steady motion."""
    rates = 1j * (orders * speed)[:, None] * steady.amplitude
    size = np.sum(np.hypot(system.frequency * np.abs(steady.amplitude), np.abs(rates)), axis=0)
    value, _, rounding = reading_peaks(system, steady.amplitude, rates, orders)
    return Bounded(value, read_error(system, value, steady.error, size) + rounding)


def reading_peaks(
    system: ModalSystem, amplitude: np.ndarray, rate: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Peaks over a cycle from modal amplitudes of q and q' (..., orders, modes).

    Returns values, crank angles and the errors of rounding, each (..., columns).
    """
    on_place, on_velocity = linear_rows(system)
    linear = cycle_peak(np.swapaxes(amplitude @ on_place.T + rate @ on_velocity.T, -1, -2), orders)
    energies = [_energy_peak(system, amplitude, rate, orders, which) for which in range(3)]
    parts = zip(linear, *energies, strict=True)
    value, angle, error = (
        np.concatenate([first, *(one[..., None] for one in others)], axis=-1)
        for first, *others in parts
    )
    return value, angle, error


def reading_peak(
    system: ModalSystem,
    amplitude: np.ndarray,
    rate: np.ndarray,
    orders: np.ndarray,
    column: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Values and crank angles (...,) of one column of `reading_peaks`."""
    count = 2 * len(system.shape)
    if column >= count:
        peak = _energy_peak(system, amplitude, rate, orders, column - count)
    else:
        on_place, on_velocity = (rows[column] for rows in linear_rows(system))
        peak = cycle_peak(amplitude @ on_place + rate @ on_velocity, orders)
    return peak.value, peak.angle


def _energy_peak(
    system: ModalSystem, amplitude: np.ndarray, rate: np.ndarray, orders: np.ndarray, which: int
) -> Peak:
    """Peaks of kinetic, potential or total energy: half the squared length of a vector."""
    strained = system.frequency * amplitude
    parts = ([rate], [strained], [rate, strained])[which]
    vector = np.swapaxes(np.concatenate(parts, axis=-1), -1, -2)
    length = vector_cycle_peak(vector, orders)
    error = length.value * length.error + 0.5 * length.error**2
    return Peak(0.5 * length.value**2, length.angle, error)


# ----------------------------------------------------------------------------
# Intervals of the grid in which a reading may have its peak.
# ----------------------------------------------------------------------------

_BLOCK = 1 << 13


class Candidates(NamedTuple):
    """Intervals (any,): highest possible value, column, segment, both ends and a first guess.

    Times count from the segment's start.
    """

    upper: np.ndarray
    column: np.ndarray
    segment: np.ndarray
    left: np.ndarray
    right: np.ndarray
    guess: np.ndarray

    def take(self, which: np.ndarray) -> "Candidates":
        """Some of them, by mask or number."""
        return Candidates(*(part[which] for part in self))


def candidates(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment]
) -> tuple[np.ndarray, Candidates]:
    """Largest samples (columns,), and all intervals that may reach beyond them.

    On every interval the cubic through values and slopes at its ends is compared with the second
    derivatives there, which tells how far it may be off.
    """
    best = np.zeros(2 * len(system.shape) + 3)
    blocks = []
    for number, segment in enumerate(segments):
        grid = segment.grid
        for start in range(0, len(grid) - 1, _BLOCK):
            part = slice(start, start + _BLOCK + 1)
            times = grid[part]
            jet = read(system, motion_on_grid(system, loads, segment, part))
            best = np.maximum(best, np.max(np.abs(jet.value), axis=0))
            upper, guess = _cubic(jet, np.diff(times))
            at, column = np.nonzero(upper >= best)
            left, right = times[at], times[at + 1]
            inside = left + guess[at, column] * (right - left)
            owner = np.full(len(at), number)
            blocks.append(Candidates(upper[at, column], column, owner, left, right, inside))
    joined = Candidates(*(np.concatenate(part) for part in zip(*blocks, strict=True)))
    return best, joined.take(joined.upper >= best[joined.column])


def _cubic(jet: Jet, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Upper estimate of the magnitude on each interval (intervals, columns), and where it is."""
    h = length[:, None]
    low, high = jet.value[:-1], jet.value[1:]
    slope, end_slope = h * jet.rate[:-1], h * jet.rate[1:]
    square = 3.0 * (high - low) - 2.0 * slope - end_slope
    cube = 2.0 * (low - high) + slope + end_slope
    root = np.sqrt(np.maximum(square**2 - 3.0 * cube * slope, 0.0))
    pivot = -(square + np.copysign(root, square))
    top = np.maximum(np.abs(low), np.abs(high))
    guess = np.where(np.abs(high) > np.abs(low), 1.0, 0.0)
    for above, below in ((pivot, 3.0 * cube), (slope, pivot)):
        inside = np.abs(above) < np.abs(below)
        place = np.divide(above, below, out=np.zeros_like(above), where=inside)
        place = np.maximum(place, 0.0)
        there = np.abs(low + place * (slope + place * (square + place * cube)))
        guess = np.where(there > top, place, guess)
        top = np.maximum(top, there)
    off = np.maximum(
        np.abs(h**2 * jet.bend[:-1] - 2.0 * square),
        np.abs(h**2 * jet.bend[1:] - 2.0 * square - 6.0 * cube),
    )
    # for a quartic remainder the distance is a 32nd of what the second derivative is off
    return top + off / 16.0, guess


# ----------------------------------------------------------------------------
# The largest magnitude of every reading over a course, between the times of the grid too.
# ----------------------------------------------------------------------------

#: intervals examined exactly for each reading, the most promising first
_MOST_INTERVALS = 200
_STEPS = 10
#: a search ends when it moves by less than this share of its interval
_SETTLED = 1e-6


class ReadingPeaks(NamedTuple):
    """Largest magnitudes (columns,) with absolute errors, when (s), and at which crank speed.

    The time is the first at which the value is reached to within rounding; its error is that of
    the peak's place where it is round, or the distance to the next time where it is flat, and spans
    to other peaks that the error of the value does not exclude.
    """

    value: np.ndarray
    error: np.ndarray
    time: np.ndarray
    time_error: np.ndarray
    speed: np.ndarray


def true_peaks(system: ModalSystem, loads: ModalLoads, segments: list[Segment]) -> ReadingPeaks:
    """Peaks of all readings: intervals that may hold one are searched on the motion itself."""
    sampled, all_of_them = candidates(system, loads, segments)
    width = len(sampled)
    left_over, rank = np.zeros(width), np.argsort(-all_of_them.upper, kind="stable")
    chosen: list[int] = []
    for column in range(width):
        mine = rank[all_of_them.column[rank] == column]
        chosen += mine[:_MOST_INTERVALS].tolist()
        left_over[column] = np.max(all_of_them.upper[mine[_MOST_INTERVALS:]], initial=0.0)
    which = all_of_them.take(np.array(chosen, dtype=int))
    height, time, bend, slack = _climb(system, loads, segments, which)

    value, error, moment, round_, speed, apart = np.zeros((6, width))
    starts = np.array([segment.run.start for segment in segments])
    for column in range(width):
        mine = np.flatnonzero(which.column == column)
        value[column] = np.max(height[mine])
        reached = mine[height[mine] >= value[column] * (1.0 - 1e-13)]
        when = starts[which.segment[reached]] + time[reached]
        first = reached[np.argmin(when)]
        segment = segments[which.segment[first]]
        uncertainty = read_error(
            system, np.full(width, value[column]), segment.error, segment.largest
        )
        missed = np.max((height + slack)[mine] - value[column])
        error[column] = uncertainty[column] + max(missed, left_over[column] - value[column], 0.0)
        moment[column] = np.min(when)
        round_[column] = max(-bend[first], 0.0)
        if error[column] > SURE * value[column]:
            # both heights are off
            rivals = mine[height[mine] >= value[column] - 2.0 * error[column]]
            later = starts[which.segment[rivals]] + time[rivals] - moment[column]
            apart[column] = np.max(np.abs(later))
        speed[column] = segment.run.speed_at(time[first])
    longest = max(float(np.max(np.diff(segment.grid))) for segment in segments)
    uncertainty = np.sqrt(4.0 * error / np.where(round_ > 0.0, round_, np.inf))
    uncertainty = np.where(uncertainty > 0.0, uncertainty, longest)
    return ReadingPeaks(value, error, moment, np.maximum(uncertainty, apart), speed)


def _climb(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment], which: Candidates
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Height, time, second derivative and missing height of the peak in each interval.

    Newton's method for the slope, kept between times where it rises and where it falls; an end
    of the interval is such a time once it has been examined.
    """
    low, high, time = which.left.copy(), which.right.copy(), which.guess.copy()
    width = high - low
    low_known, high_known = np.zeros((2, len(time)), dtype=bool)
    best, best_time, best_bend = np.full(len(time), -1.0), time.copy(), np.zeros(len(time))
    slack = np.zeros(len(time))
    open_ = np.ones(len(time), dtype=bool)
    for _ in range(_STEPS):
        now = np.flatnonzero(open_)
        jet = _one_reading(system, loads, segments, which.take(now), time[now])
        sign = np.where(jet.value < 0.0, -1.0, 1.0)
        size, slope, bend = sign * jet.value, sign * jet.rate, sign * jet.bend
        better = now[size > best[now]]
        best_bend[better] = bend[size > best[now]]
        best_time[better] = time[better]
        best[now] = np.maximum(best[now], size)

        rises = slope > 0.0
        low[now], high[now] = (
            np.where(rises, time[now], low[now]),
            np.where(rises, high[now], time[now]),
        )
        low_known[now], high_known[now] = low_known[now] | rises, high_known[now] | ~rises
        round_ = bend < 0.0
        target = time[now] - np.divide(slope, bend, out=np.zeros_like(slope), where=round_)
        inside = round_ & (target >= low[now]) & (target <= high[now])
        middle = 0.5 * (low[now] + high[now])
        up = np.where(high_known[now], middle, high[now])
        down = np.where(low_known[now], middle, low[now])
        target = np.where(inside, target, np.where(rises, up, down))
        moved = np.abs(target - time[now])
        slack[now] = np.abs(slope) * moved + np.maximum(size - best[now], 0.0)
        time[now] = target
        open_[now] = moved > _SETTLED * width[now]
        if not np.any(open_):
            break
    return best, best_time, best_bend, slack


def _one_reading(
    system: ModalSystem,
    loads: ModalLoads,
    segments: list[Segment],
    which: Candidates,
    time: np.ndarray,
) -> Jet:
    """The reading of each candidate with its derivatives at one time in its interval."""
    result = np.zeros((3, len(time)))
    for number in np.unique(which.segment):
        mine = np.flatnonzero(which.segment == number)
        jet = read(system, motion_at(system, loads, segments[number], time[mine]))
        result[:, mine] = [part[np.arange(len(mine)), which.column[mine]] for part in jet]
    return Jet(*result)


# ----------------------------------------------------------------------------
# A course thinned out for pictures, so that every swing survives.
# ----------------------------------------------------------------------------

#: samples in a turn of the crank at its fastest, and in a period of the fastest mode
_PER_TURN, _PER_PERIOD = 64, 16
#: no more than this in a span: of a longer one only the outline is seen
_MOST_SAMPLES = 256


class History(NamedTuple):
    """Lowest and highest sample of each reading, `low` and `high` (buckets, columns).

    `time` and `speed` (buckets + 1,) at the edges of the buckets, in s and rad/s. The samples of
    a bucket are evenly spaced from edge to edge, both included, `samples` distances apart: where
    they stand follows from course and machine alone. True peaks are found elsewhere.
    """

    time: np.ndarray
    speed: np.ndarray
    low: np.ndarray
    high: np.ndarray
    samples: int


def history(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment], buckets: int
) -> History:
    """Extremes of samples in equal spans of time."""
    runs = [segment.run for segment in segments]
    total = runs[-1].start + runs[-1].duration
    edges = np.linspace(0.0, total, buckets + 1)
    samples = _samples(system, segments, total / buckets)
    every = np.linspace(0.0, total, buckets * samples + 1)
    ends = np.array([run.start + run.duration for run in runs])
    owner = np.minimum(np.searchsorted(ends, every, side="left"), len(runs) - 1)
    value = np.empty((len(every), 2 * len(system.shape) + 3))
    for number, segment in enumerate(segments):
        mine = np.flatnonzero(owner == number)
        for start in range(0, len(mine), _BLOCK):
            part = mine[start : start + _BLOCK]
            time = np.clip(every[part] - segment.run.start, 0.0, segment.run.duration)
            value[part] = read(system, motion_at(system, loads, segment, time)).value
    first = np.arange(buckets) * samples
    # the sample on an edge belongs to the buckets on both sides
    closing = value[first + samples]
    low = np.minimum(np.minimum.reduceat(value[:-1], first), closing)
    high = np.maximum(np.maximum.reduceat(value[:-1], first), closing)
    held = owner[::samples]
    speed = [runs[n].speed_at(t - runs[n].start) for n, t in zip(held, edges, strict=True)]
    return History(edges, np.array(speed), low, high, samples)


def _samples(system: ModalSystem, segments: list[Segment], span: float) -> int:
    """Distances between samples in a bucket of `span` s."""
    fastest = max(max(abs(s.run.speed), abs(s.run.end_speed)) for s in segments)
    highest = float(np.max(system.frequency, initial=0.0))
    rate = max(_PER_TURN * fastest, _PER_PERIOD * highest) / (2.0 * np.pi)
    return int(np.clip(np.ceil(rate * span), 1, _MOST_SAMPLES))
