"""A body followed through a course of speeds and operations until it has settled."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, maximum, where
from vibecalc.numerics.cycle_peak import Peak, vector_cycle_peak
from vibecalc.numerics.maxima import EQUAL, Maxima, by_values
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.energies import half_square
from vibecalc.response.switching.motion import Followed, follow_profile
from vibecalc.response.switching.readings import (
    ENERGY,
    History,
    course_peaks,
    history,
    read_error,
    steady_peaks,
)
from vibecalc.response.switching.system import (
    ModalLoads,
    ModalSystem,
    SpeedSegment,
    free_motion,
    modal_size,
    poles,
    steady_amplitude,
    steady_motion,
    steady_state,
)

# ----------------------------------------------------------------------------
# A body on mounts through a course of speeds and operations: what it does on the way.
# ----------------------------------------------------------------------------


class Transient(NamedTuple):
    """What a body does on a course that ends at a constant speed; columns as in `readings`.

    `peaks`, one for each column, go on for ever: a peak on the way below that of the steady motion
    that the body settles into would only say that the time was too short for it. Where the steady
    motion is the larger one by more than the errors, the body comes up to it later than it is
    followed, and the place is the end, exactly by that definition. `speed` (columns,) is the
    crank's at the peaks. `settled` is the time in s from the last change until the deviation from
    the steady motion, as sqrt(energy), is down to a share of its own. `later` (columns,) bounds
    whatever comes after the course.
    """

    history: History
    peaks: Maxima
    speed: np.ndarray
    settled: Bounded
    later: np.ndarray


def follow(
    system: ModalSystem,
    loads: ModalLoads,
    profile: Sequence[SpeedSegment],
    *,
    before: int,
    angle: float = 0.0,
    buckets: int = 400,
    tolerance: float = 0.05,
) -> Transient:
    """Follow a body from a steady motion through segments of linearly changing crank speed.

    Parameters
    ----------
    system, loads
        Modes with their damping; loads on them for each operation.
    profile
        Segments in time; each begins at the speed at which the one before it ends. Speed 0 is a
        stand, negative speeds turn the other way. The last one has a constant speed.
    before
        Operation whose steady motion, at the first speed, the body is in at time 0.
    angle
        Crank angle at time 0, rad.
    buckets
        Number of equal spans of time in the history.
    tolerance
        The body has settled when its deviation from the final steady motion, as sqrt(energy), is
        down to this share of the largest sqrt(energy) of that motion, or of the largest on the
        way if the body comes to rest. Counted from the start of the last segment.

    Raises
    ------
    NumericalFailure
        The course is too long to follow, or the settling drowns in rounding or in what the dropped
        orders may add.
    """
    total = sum(segment.duration for segment in profile)
    followed = follow_profile(
        system, loads, profile, angle=angle, before=before, longest=0.5 * total / buckets
    )
    peaks = course_peaks(followed)
    final = steady_peaks(system, loads, profile[-1].operation, profile[-1].end_speed)
    settled, left = _settled(followed, loads, peaks.height, final, tolerance)
    top = final.value + final.error
    later = top + read_error(system, top, left)
    clear = final.value - final.error > peaks.height.value + peaks.height.error
    end = Bounded(np.asarray(total), np.asarray(4.0 * EPSILON * total))
    place = where(clear, end, peaks.place)
    run = followed.panels.run[followed.panel_at(place.value)]
    return Transient(
        history(followed, buckets),
        peaks._replace(place=place, height=maximum(peaks.height, final)),
        followed.course.speed_at(run, place.value),
        settled,
        later,
    )


#: parts of an interval in which the size reaches a level
_PARTS = 64


def _settled(
    followed: Followed, loads: ModalLoads, peaks: Bounded, final: Bounded, tolerance: float
) -> tuple[Bounded, np.ndarray]:
    """When the free motion from the start of the last segment has died down, in s from there.

    Its size is sqrt(2 E), E being the kinetic and potential energy of the difference between the
    motion and the final one: a length in the space of states, so that it falls with the amplitude
    and mixes metres and radians as the machine does. Once the load no longer changes, E only falls,
    hence one time divides before from after. The error of the time is that of both sizes carried
    over; where energy pauses at the threshold it is as long. Also the sizes (modes,) that may be
    left at the end.
    """
    course, panels = followed.course, followed.panels
    system, speed = course.system, course.speed[-1]
    steady = steady_motion(system, loads, int(course.operation[-1]), speed)
    at = steady_state(steady.amplitude, course.orders, speed, course.angle[-1])
    first = int(np.searchsorted(panels.node, course.time[-2]))
    deviation = followed.state[first] - at
    off = followed.error + steady.error

    def size(time: np.ndarray | float) -> np.ndarray:
        moved = free_motion(system, np.asarray(time), deviation)
        return np.asarray(np.linalg.norm(modal_size(system, moved), axis=-1))

    whole = peaks if final.value[ENERGY] == 0.0 else final
    reference = float(np.sqrt(2.0 * whole.value[ENERGY]))
    threshold = tolerance * reference
    uncertainty = float(np.linalg.norm(off)) + 4.0 * EPSILON * float(size(0.0))
    uncertainty += tolerance * float(whole.error[ENERGY]) / reference if reference else 0.0
    left = modal_size(system, free_motion(system, course.time[-1] - course.time[-2], deviation))
    if size(0.0) <= threshold:
        return Bounded(np.zeros(()), np.zeros(())), left + off
    if threshold <= uncertainty:
        raise NumericalFailure(
            "no settling time: the final motion is so small that the deviation from it drowns in "
            "rounding, or in what the dropped orders may add, before it is a small part of it; ask "
            "for a larger settle tolerance or keep more orders ([excitation] orders)"
        )
    after, *others = (_first_below(size, threshold + k * uncertainty) for k in (0.0, 1.0, -1.0))
    error = np.max(np.abs(np.array(others) - after)) + 8.0 * EPSILON * (after + course.time[-2])
    return Bounded(np.asarray(after), error), left + off


def _first_below(size: Callable[[np.ndarray | float], np.ndarray], level: float) -> float:
    """The time at which a falling size reaches a level.

    One call takes many times, so that each part of an interval is a small one of the interval
    before; scipy's root finders take longer to import than a change to follow.
    """
    if size(0.0) <= level:
        return 0.0
    low, high = 0.0, 1e-6
    while size(high) > level:
        low, high = high, 2.0 * high
    while high - low > 4.0 * EPSILON * high:
        times = np.linspace(low, high, _PARTS + 1)
        # the size at the upper end is known to be below
        end = 1 + int(np.argmax(np.append(size(times[1:-1]) <= level, True)))
        low, high = float(times[end - 1]), float(times[end])
    return high


# ----------------------------------------------------------------------------
# The largest kinetic energy over all crank angles of a change within no time, and over all speeds
# at which the same course would pass if it were run infinitely slowly.
#
# Both are the highest point of a curve of which each value is a peak over a cycle. Where one moment
# of the cycle takes over from another the curve has a kink, but that is never a maximum.
# ----------------------------------------------------------------------------


#: error of a sum of all orders and modes, over the sum of their sizes
_SUMMED = 16.0 * EPSILON


def _highest(
    curve: Callable[[np.ndarray], Peak], at: np.ndarray, value: np.ndarray
) -> tuple[Bounded, float]:
    """The highest value of a curve, known at places `at` (n,) close enough, and its place."""
    end = int(np.argmax(value))
    inner = (value[1:-1] >= value[:-2]) & (value[1:-1] > value[2:])
    top = np.flatnonzero(inner & (value[1:-1] >= EQUAL**2 * value[end])) + 1
    found = by_values(
        lambda _, place: curve(place).value, np.zeros(len(top), dtype=np.int64),
        at[top - 1], at[top], at[top + 1],
    )  # fmt: skip
    if len(found.row) and found.height.value[0] >= value[end]:
        return found.height[0], float(found.place.value[0])
    return Bounded(value[end], np.zeros(())), float(at[end])


def slow_energy(system: ModalSystem, loads: ModalLoads, operation: int, top: float) -> Bounded:
    """Largest kinetic energy of the steady motion at any speed from rest to `top`, either sign.

    Speeds stand close around each resonance and evenly between. Divide the peaks of the transient
    by this to see what its haste is worth.
    """
    orders, amplitude = loads.orders[: loads.retained], loads.amplitude[operation]

    def curve(speed: np.ndarray) -> Peak:
        moved = steady_amplitude(system, orders, amplitude[: loads.retained], speed).value
        return vector_cycle_peak(
            np.swapaxes(1j * orders[:, None] * speed[..., None, None] * moved, -1, -2), orders
        )

    spread = np.concatenate([[0.0], np.geomspace(0.1, 30.0, 6)])
    spread = np.concatenate([-spread[:0:-1], spread])
    width = np.minimum(system.damping_ratio, 1.0)[:, None] * spread
    near = np.ravel((system.frequency / orders[:, None])[..., None] * (1.0 + width))
    near = np.unique(np.concatenate([np.linspace(0.0, abs(top), 100), near]))
    speeds = np.sort(np.copysign(near[(near >= 0.0) & (near <= abs(top))], top))
    length, speed = _highest(curve, speeds, curve(speeds).value)
    steady = steady_motion(system, loads, operation, speed)
    size = np.sum(np.abs((orders * speed)[:, None] * steady.amplitude), axis=0)
    return half_square(length, float(np.linalg.norm(steady.error + _SUMMED * size)))


#: phase that the motion turns between two times that are looked at, and how many of these at most
_COARSE, _TIMES, _MOST_BLOCKS = 0.4, 128, 40


def worst_instant(
    system: ModalSystem, loads: ModalLoads, before: int, after: int, speed: float
) -> tuple[Bounded, float]:
    """Largest kinetic energy after a change within no time, and its crank angle in [0, 2 pi).

    At a time t after the change the velocities are a sum of orders of the angle of change: the
    largest energy over all angles is a peak over a cycle. Later than a time at which the free
    motion left cannot add to the peak, nothing is sought. What is not decided by then stands in the
    error: with hardly any damping the free motion of several modes may still come together much
    later, and the error is a bound on that.
    """
    orders = loads.orders[: loads.retained]
    rates = 1j * (orders * speed)[:, None]
    old, new = (steady_motion(system, loads, which, speed) for which in (before, after))
    gone = old.amplitude - new.amplitude
    gone = np.stack([gone, rates * gone], axis=-1)

    def curve(time: np.ndarray) -> Peak:
        # the angle counts from the change: the final motion has turned since
        turned = rates * np.exp(rates * time[..., None, None]) * new.amplitude
        free = free_motion(system, time[..., None], gone)[..., 1]
        return vector_cycle_peak(np.swapaxes(turned + free, -1, -2), orders)

    def left(time: float) -> float:
        """Bound on what free motion still adds, which never grows."""
        moved = modal_size(system, free_motion(system, np.asarray(time), gone))
        return float(np.linalg.norm(np.sum(moved, axis=0)))

    forced, free = np.abs(rates * new.amplitude), modal_size(system, gone)
    size = np.sum(forced + free, axis=0)
    off = float(np.linalg.norm(2.0 * (old.error + new.error) + _SUMMED * size))
    final = float(vector_cycle_peak((rates * new.amplitude).T, orders).value)
    if not np.any(free):
        return half_square(Bounded(np.asarray(final), np.zeros(())), off), 0.0
    slow, gap = poles(system)
    turning = np.sum(forced * np.abs(rates) ** 2 + free * np.abs(slow - gap) ** 2)
    step, values = _COARSE * float(np.sqrt(np.sum(size) / turning)), np.zeros(0)
    for _ in range(_MOST_BLOCKS):
        block = step * np.arange(len(values), len(values) + _TIMES)
        values = np.append(values, curve(block).value)
        later = final + left(block[-1])
        if later <= np.max(values):
            break
    length, time = _highest(curve, step * np.arange(len(values)), values)
    angle = float(curve(np.array([time])).angle[0])
    if length.value <= final:
        length, angle = Bounded(np.asarray(final), length.error), 0.0
    beyond = np.maximum(later - length.value, 0.0)
    return half_square(length, off + beyond), angle


# ----------------------------------------------------------------------------
# Which resonances a speed profile runs through, when, and how fast.
# ----------------------------------------------------------------------------


class Passages(NamedTuple):
    """Orders that meet modes (from 1) at crank speeds in rad/s and times in s, all (n,).

    `energy` in J is the peak energy of the mode if the crank stayed there. `haste` is
    n |w'| / (zeta w_j)^2: well below 1 the motion follows as if it stayed, above 1 the resonance
    has no time to build up.
    """

    mode: np.ndarray
    order: np.ndarray
    speed: np.ndarray
    time: np.ndarray
    energy: np.ndarray
    haste: np.ndarray


def passages(system: ModalSystem, loads: ModalLoads, profile: Sequence[SpeedSegment]) -> Passages:
    """All passages of driven modes in order of time; a constant speed passes none.

    An order n passes a mode where n |w| is its undamped natural frequency; there
    Q = p_n W^2 / (2 i zeta w_j n W) at W = w_j / n, which is a peak energy of
    w_j^2 |p_n|^2 / (8 zeta^2 n^4). Modes damped critically or more have no resonance.
    """
    order, start, rows = loads.orders[: loads.retained, None], 0.0, []
    frequency, ratio = system.frequency, system.damping_ratio
    for duration, first, last, operation in profile:
        gain = (last - first) / duration
        if gain:
            speed = np.copysign(frequency / order, first + last)
            time = (speed - first) / gain
            force = np.abs(loads.amplitude.value[operation, : loads.retained])
            met = (time >= 0.0) & (time < duration) & (force > 0.0) & (ratio < 1.0)
            n, mode = np.nonzero(met)
            energy = 0.5 * np.square(0.5 * (frequency * force / order**2)[met] / ratio[mode])
            haste = order[n, 0] * abs(gain) / np.square((ratio * frequency)[mode])
            rows.append((mode + 1, order[n, 0], speed[met], start + time[met], energy, haste))
        start += duration
    found = [np.concatenate(part) for part in zip(*rows, strict=True)]
    rank = np.lexsort((found[0], found[3]))
    return Passages(*(part[rank] for part in found))
