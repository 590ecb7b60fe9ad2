"""What is read off the motion: displacements, forces, energies, with their true peaks."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.maxima import SURE, Jet, Maxima, by_slopes, first_highest
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.motion import BLOCK, Followed
from vibecalc.response.switching.system import ModalLoads, ModalSystem, modal_size, steady_motion

# ----------------------------------------------------------------------------
# What is read off the motion: displacements, forces through the mounts, energies.
#
# Columns, for a body of k coordinates (usually 6, x y z rx ry rz): k displacements of the reference
# point (m, rad), then k forces and couples through the mounts on the ground (N, N m), then kinetic,
# potential and total energy (J).
# ----------------------------------------------------------------------------

#: places of the energies, from the end
KINETIC, POTENTIAL, ENERGY = -3, -2, -1


def read(system: ModalSystem, motion: np.ndarray) -> np.ndarray:
    """All readings of a motion (4, n, modes), and their two derivatives by time (3, n, columns).

    Energies are half the sums of q'^2 and of w^2 q^2.
    """
    on_place, on_velocity = linear_rows(system)
    linear = motion[:3] @ on_place.T + motion[1:] @ on_velocity.T
    q, v, a, j = motion
    kinetic = np.sum([0.5 * v**2, v * a, a**2 + v * j], axis=-1)
    potential = np.array([0.5 * q**2, q * v, v**2 + q * a]) @ system.frequency**2
    return np.concatenate(
        [linear, np.stack([kinetic, potential, kinetic + potential], axis=-1)], axis=-1
    )


def linear_rows(system: ModalSystem) -> tuple[np.ndarray, np.ndarray]:
    """Factors (columns, modes) of q and of q' in displacements and mount forces.

    The mounts push the ground with K x + C x' = M V (w^2 q + 2 zeta w q'), the modal damping being
    the mounts'; M V is the inverse of V^T.
    """
    back, frequency = np.linalg.inv(system.shape).T, system.frequency
    return (
        np.concatenate([system.shape, back * frequency**2]),
        np.concatenate([np.zeros_like(back), back * 2.0 * system.damping_ratio * frequency]),
    )


def read_error(system: ModalSystem, value: np.ndarray, size: np.ndarray) -> np.ndarray:
    """How far readings (columns,) may be off where the modes are by a `size` (modes,).

    That of a mode is sqrt(q'^2 + w^2 q^2). A mode that nothing holds must be at rest.
    """
    on_place, on_velocity = linear_rows(system)
    held = system.frequency > 0.0
    place = np.where(held, on_place / np.where(held, system.frequency, 1.0), 0.0)
    whole = np.linalg.norm(size)
    energy = whole * np.sqrt(2.0 * np.abs(value[KINETIC:])) + 0.5 * whole**2
    return np.concatenate([np.hypot(place, on_velocity) @ size, energy])


def steady_peaks(system: ModalSystem, loads: ModalLoads, operation: int, speed: float) -> Bounded:
    """Largest magnitudes (columns,) of all readings over a cycle of the steady motion."""
    steady = steady_motion(system, loads, operation, speed)
    orders, place = loads.orders[: loads.retained], steady.amplitude
    rate = 1j * (orders * speed)[:, None] * place
    on_place, on_velocity = linear_rows(system)
    strained = system.frequency * place
    linear = vector_cycle_peak((on_place @ place.T + on_velocity @ rate.T)[:, None], orders)
    energies = [
        vector_cycle_peak(vector.T, orders)
        for vector in (rate, strained, np.concatenate([rate, strained], axis=1))
    ]
    value = np.append(linear.value, [0.5 * peak.value**2 for peak in energies])
    off = np.append(linear.error, [peak.value * peak.error for peak in energies])
    size = np.sum(np.hypot(np.abs(strained), np.abs(rate)), axis=0)
    return Bounded(value, read_error(system, value, steady.error + 8.0 * EPSILON * size) + off)


# ----------------------------------------------------------------------------
# The largest magnitude of every reading over a course.
#
# Within a panel a reading is above neither end by more than the slope there over the panel's
# length. Panels that may hold a peak are searched on the motion itself.
# ----------------------------------------------------------------------------


def course_peaks(followed: Followed) -> Maxima:
    """The first largest magnitude of each reading, one for each column, in s from the start."""
    system, (node, run) = followed.course.system, followed.panels
    best, found = np.zeros(2 * len(system.shape) + 3), []
    for start in range(0, len(run), BLOCK):
        panel = np.arange(len(run))[start : start + BLOCK]
        states = [(followed.state[panel + k], run[panel], node[panel + k]) for k in (0, 1)]
        ends = [read(system, followed.motion_of(*one)) for one in states]
        best = np.max([best, *(np.max(np.abs(end[0]), axis=0) for end in ends)], axis=0)
        reach = [(node[panel + 1] - node[panel])[:, None] * np.abs(end[1]) for end in ends]
        for sign in (1.0, -1.0):
            rows = zip(ends, reach, strict=True)
            upper = np.max([sign * end[0] + room for end, room in rows], axis=0)
            at, column = np.nonzero((upper >= best) & (best > 0.0))
            found.append(np.array([panel[at], column, np.full(len(at), sign), upper[at, column]]))
    which = np.concatenate(found, axis=1)
    which = which[:3, which[3] >= best[which[1].astype(int)]]
    panel, column, sign = which[0].astype(int), which[1].astype(int), which[2]

    def jet_at(row: np.ndarray, time: np.ndarray) -> Jet:
        every = read(system, followed.motion_at(panel[row], time))
        value, slope, bend = sign[row] * every[:, np.arange(len(row)), column[row]]
        return Jet(value, 8.0 * EPSILON * best[column[row]], slope, bend)

    inner = by_slopes(jet_at, np.stack([node[panel], node[panel + 1]], axis=1))
    # where the load jumps there may be a kink
    last = np.append(np.flatnonzero(np.diff(run)), len(run) - 1)
    ends = np.abs(
        read(system, followed.motion_at(np.append(0, last), node[np.append(0, last + 1)]))[0]
    )
    place = np.repeat(node[np.append(0, last + 1)], len(best))
    none = np.zeros(len(place))
    kinks = Maxima(
        np.tile(np.arange(len(best)), len(ends)), Bounded(place, none),
        Bounded(ends.ravel(), none), none,
    )  # fmt: skip
    inner = inner._replace(row=column[inner.row])
    return _first_of(followed, [inner, kinks], best)


def _first_of(followed: Followed, found: list[Maxima], best: np.ndarray) -> Maxima:
    """The first highest of each column; heights and places with what the motion is off by."""
    top = first_highest(found)
    largest = np.max(modal_size(followed.course.system, followed.state), axis=0)
    size = followed.error + 8.0 * EPSILON * largest
    height = top.height.value
    error = read_error(followed.course.system, height, size)
    error += top.height.error + np.maximum(best - height, 0.0)
    off = top.place.error + np.sqrt(4.0 * error / np.where(top.bend < 0.0, -top.bend, np.inf))
    for one in found:  # both heights are off
        rivals = one.height.value >= (height - 2.0 * error)[one.row]
        rivals &= (error > SURE * height)[one.row]
        row = one.row[rivals]
        np.maximum.at(off, row, np.abs(one.place.value[rivals] - top.place.value[row]))
    return top._replace(place=Bounded(top.place.value, off), height=Bounded(height, error))


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


def history(followed: Followed, buckets: int) -> History:
    """Extremes of samples in equal spans of time."""
    course, total = followed.course, followed.course.time[-1]
    fastest = max(np.max(np.abs(course.speed)), abs(_speeds(followed, total)))
    rate = max(_PER_TURN * fastest, _PER_PERIOD * np.max(course.system.frequency, initial=0.0))
    samples = int(np.clip(np.ceil(rate * total / buckets / (2.0 * np.pi)), 1, _MOST_SAMPLES))
    time = np.linspace(0.0, total, buckets * samples + 1)
    value = np.concatenate(
        [
            read(course.system, followed.motion_at(followed.panel_at(part), part))[0]
            for part in np.array_split(time, -(-len(time) // BLOCK))
        ]
    )
    # the sample on an edge belongs to the buckets on both sides
    spans = np.arange(buckets)[:, None] * samples + np.arange(samples + 1)
    edges = time[::samples]
    return History(
        edges, _speeds(followed, edges), np.min(value[spans], axis=1),
        np.max(value[spans], axis=1), samples,
    )  # fmt: skip


def _speeds(followed: Followed, time: np.ndarray) -> np.ndarray:
    return followed.course.speed_at(followed.panels.run[followed.panel_at(time)], time)
