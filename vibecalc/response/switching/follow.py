"""A body followed through a course of speeds and operations until it has settled."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.switching.motion import Segment, follow_profile
from vibecalc.response.switching.readings import (
    History,
    ReadingPeaks,
    columns,
    history,
    read_bound,
    reading_peak,
    reading_peaks,
    steady_peaks,
    true_peaks,
)
from vibecalc.response.switching.system import (
    Loads,
    ModalLoads,
    ModalSystem,
    SpeedSegment,
    SteadyMotion,
    modal_loads,
    modal_size,
    propagator,
    steady_motion,
    steady_state,
)

# ----------------------------------------------------------------------------
# When a body has settled into its final motion.
# ----------------------------------------------------------------------------

_HALVINGS = 100


class SettlingTime(NamedTuple):
    """`time` in s from the course's start, with its error; `after` in s from the last change.

    `deviation` is the size of the deviation just after the last change, over the reference size.
    """

    time: float
    error: float
    after: float
    deviation: float


def settling(
    system: ModalSystem,
    deviation: np.ndarray,
    deviation_error: np.ndarray,
    last_change: float,
    reference: float,
    reference_error: float,
    tolerance: float,
) -> SettlingTime:
    """When free motion from the state `deviation` (modes, 2) has died down.

    The size of the deviation is sqrt(2 E), E being the kinetic and potential energy of the
    difference between the motion and the final one: a length in the space of states, so that it
    falls with the amplitude and mixes metres and radians as the machine does. Once the load no
    longer changes, E only falls, hence one time divides before from after. Settled means
    sqrt(2 E) <= tolerance * reference.

    Parameters
    ----------
    deviation, deviation_error
        State at `last_change` (s), and the error (modes,) of its sizes.
    reference, reference_error
        The size that counts as whole: sqrt(2 E) of the final steady motion at its highest.

    Returns
    -------
    Settling
        The time is `last_change` where the deviation is small enough from there on. Its error
        is that of both sizes carried over; where energy pauses at the threshold it is as long.

    Raises
    ------
    NumericalFailure
        The threshold lies below the error of the deviation.
    """
    start = float(np.sqrt(np.sum(modal_size(system, deviation) ** 2)))
    uncertainty = float(np.sqrt(np.sum(deviation_error**2))) + 4.0 * EPSILON * start
    uncertainty += tolerance * reference_error
    threshold = tolerance * reference
    if start <= threshold:
        return SettlingTime(last_change, 0.0, 0.0, start / reference if reference else 0.0)
    if threshold <= uncertainty:
        raise NumericalFailure(
            "no settling time: the final motion is so small that the deviation from it drowns in "
            "rounding, or in what the dropped orders may add, before it is a small part of it; ask "
            "for a larger settle tolerance or keep more orders ([excitation] orders)"
        )

    def size(time: float) -> float:
        moved = propagator(system, np.asarray(time))(deviation)
        return float(np.sqrt(np.sum(modal_size(system, moved) ** 2)))

    after = _first_below(size, threshold)
    low, high = (
        _first_below(size, level) for level in (threshold + uncertainty, threshold - uncertainty)
    )
    error = max(high - after, after - low) + 8.0 * EPSILON * (after + last_change)
    return SettlingTime(last_change + after, error, after, start / reference)


def _first_below(size: Callable[[float], float], level: float) -> float:
    """The time at which a falling size reaches a level, by doubling and halving."""
    if size(0.0) <= level:
        return 0.0
    low, high = 0.0, 1e-6
    while size(high) > level:
        low, high = high, 2.0 * high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if size(middle) > level else (low, middle)
    return high


# ----------------------------------------------------------------------------
# A body on mounts through a course of speeds and operations: what it does on the way.
# ----------------------------------------------------------------------------


class Transient(NamedTuple):
    """What a body does on a course; columns as in `readings`.

    `final` (columns,) are the peaks of the steady motion that it settles into, `later` (columns,)
    bounds whatever comes after the last piece: where it is not above `peaks` these hold for good.
    """

    history: History
    peaks: ReadingPeaks
    settling: SettlingTime
    final: Bounded
    later: np.ndarray


def follow(
    system: ModalSystem,
    loads: Loads,
    profile: Sequence[SpeedSegment],
    *,
    angle: float = 0.0,
    before: int | None = None,
    buckets: int = 400,
    tolerance: float = 0.05,
) -> Transient:
    """Follow a body from a steady motion through segments of linearly changing crank speed.

    Parameters
    ----------
    system, loads
        Modes with their damping; loads on the body for each operation.
    profile
        Segments in time; each begins at the speed at which the one before it ends. Speed 0 is
        a stand, negative speeds turn the other way. The last speed and operation go on for ever.
    angle
        Crank angle at time 0, rad.
    before
        Operation whose steady motion, at the first speed, the body is in at time 0; that of the
        first segment if not given.
    buckets
        Number of equal spans of time in the history.
    tolerance
        The body has settled when its deviation from the final steady motion, as sqrt(energy), is
        down to this share of the largest sqrt(energy) of that motion, or of the largest on the
        way if the body comes to rest. Counted from the last change of load at the earliest.

    Returns
    -------
    Transient
        Histories, true peaks, settling; errors are absolute and of the modes and loads as given.

    Raises
    ------
    NumericalFailure
        A driven mode is not held or has no damping, the course is too long to follow, or the
        settling drowns in rounding or in what the dropped orders may add.
    ValueError
        The speed jumps between segments.
    """
    modal = modal_loads(system, loads)
    first = profile[0].operation if before is None else before
    total = sum(segment.duration for segment in profile)
    segments = follow_profile(
        system, modal, profile, angle=angle, before=first, longest=0.5 * total / buckets
    )
    peaks = true_peaks(system, modal, segments)
    last = segments[-1]
    steady = steady_motion(system, modal, last.run.operation, last.run.end_speed)
    final = steady_peaks(system, steady, modal.orders, last.run.end_speed)
    settled = _settled(system, modal, segments, steady, final, peaks, tolerance)
    later = _later(system, modal, last, steady, final)
    return Transient(history(system, modal, segments, buckets), peaks, settled, final, later)


def _deviation(
    system: ModalSystem, loads: ModalLoads, segment: Segment, steady: SteadyMotion, time: float
) -> np.ndarray:
    """State (modes, 2) on the grid at a segment's start or end, less the final steady one."""
    speed = segment.run.end_speed
    at = steady_state(steady, loads.orders, speed, segment.run.angle_at(np.asarray(time)))
    difference: np.ndarray = segment.state[0 if time == 0.0 else -1] - at
    return difference


def _settled(
    system: ModalSystem,
    loads: ModalLoads,
    segments: list[Segment],
    steady: SteadyMotion,
    final: Bounded,
    peaks: ReadingPeaks,
    tolerance: float,
) -> SettlingTime:
    last = segments[-1]
    # a last piece of constant speed is free deviation from its start, a ramp from its end
    time = 0.0 if last.run.acceleration == 0.0 else last.run.duration
    deviation = _deviation(system, loads, last, steady, time)
    energy = columns(len(system.shape)).energy
    at_standstill = final.value[energy] == 0.0
    height, uncertainty = (
        (peaks.value, peaks.error) if at_standstill else (final.value, final.error)
    )
    reference = float(np.sqrt(2.0 * height[energy]))
    uncertainty_size = float(uncertainty[energy]) / reference if reference else 0.0
    error = last.error + steady.error
    start = last.run.start + time
    return settling(system, deviation, error, start, reference, uncertainty_size, tolerance)


def _later(
    system: ModalSystem, loads: ModalLoads, last: Segment, steady: SteadyMotion, final: Bounded
) -> np.ndarray:
    """Bound (columns,) on the readings after the course: steady peaks and what is left."""
    begin = 0.0 if last.run.acceleration == 0.0 else last.run.duration
    deviation = _deviation(system, loads, last, steady, begin)
    left = propagator(system, np.asarray(last.run.duration - begin))(deviation)
    bound = read_bound(system, modal_size(system, left) + last.error + steady.error)
    top = final.value + final.error
    later: np.ndarray = top + bound
    later[-3:] = (np.sqrt(top[-3:]) + np.sqrt(bound[-3:])) ** 2
    return later


# ----------------------------------------------------------------------------
# Peaks of a change that goes on for ever after the time in which it is followed.
# ----------------------------------------------------------------------------


def lasting_peaks(transient: Transient) -> ReadingPeaks:
    """The larger of the peaks on the way and of the steady motion that the body settles into.

    A peak below that of the steady motion would only say that the time was too short for it. Where
    the steady motion is the larger one by more than the errors, the body comes up to it later than
    it is followed: the time and the speed are those of the end, exactly by that definition.
    """
    peaks, final = transient.peaks, transient.final
    larger = final.value > peaks.value
    clear = final.value - final.error > peaks.value + peaks.error
    end = float(transient.history.time[-1])
    # the error bounds the larger of two, whichever it truly is
    return ReadingPeaks(
        np.where(larger, final.value, peaks.value),
        np.where(clear, final.error, np.maximum(peaks.error, final.error)),
        np.where(clear, end, peaks.time),
        np.where(clear, 4.0 * EPSILON * end, peaks.time_error),
        np.where(clear, transient.history.speed[-1], peaks.speed),
    )


# ----------------------------------------------------------------------------
# What the same course would do if it were run infinitely slowly.
# ----------------------------------------------------------------------------

_BASE, _NEAR = 100, 6
_PARTS, _ROUNDS = 9, 25
#: a search ends when neighbouring speeds differ by less than this share
_FINE = 1e-11
#: peaks on the first speeds that are searched, as a share of the highest
_NEARLY = 0.9


class SlowPeaks(NamedTuple):
    """Largest steady peak of each reading (columns,) over all speeds, its error and the speed."""

    value: np.ndarray
    error: np.ndarray
    speed: np.ndarray


def slow_peaks(system: ModalSystem, loads: Loads, profile: Sequence[SpeedSegment]) -> SlowPeaks:
    """Largest steady readings at any speed that the course passes or stays at.

    Speeds stand close around each resonance and evenly between; around the highest of each
    reading the step is then halved until it no longer matters. Divide the peaks of the transient
    by these to see what its haste is worth. Loads that grow with acceleration have no part here.

    Raises
    ------
    NumericalFailure
        The search does not settle, or `modal_loads` refuses the loads.
    """
    modal = modal_loads(system, loads)
    width = 2 * len(system.shape) + 3
    value, error, best = np.zeros((3, width))
    for operation in sorted({segment.operation for segment in profile}):
        mine = [segment for segment in profile if segment.operation == operation]
        speeds = np.unique(np.concatenate([_speeds(system, modal, segment) for segment in mine]))
        motion = _motions(system, modal, operation, speeds)
        heights = reading_peaks(system, *motion, modal.orders)[0]
        for column in range(width):
            for low, high in _promising(speeds, heights[:, column]):
                top, missing, at = _peak(system, modal, operation, low, high, column)
                if top > value[column]:
                    steady = steady_motion(system, modal, operation, at)
                    uncertainty = steady_peaks(system, steady, modal.orders, at).error[column]
                    value[column], error[column], best[column] = top, uncertainty + missing, at
    return SlowPeaks(value, error, best)


def _speeds(system: ModalSystem, loads: ModalLoads, segment: SpeedSegment) -> np.ndarray:
    low, high = sorted((segment.start_speed, segment.end_speed))
    spread = np.concatenate([[0.0], np.geomspace(0.1, 30.0, _NEAR)])
    spread = np.concatenate([-spread[:0:-1], spread])
    centre = (system.frequency / loads.orders[:, None])[..., None]
    near = np.ravel(centre * (1.0 + np.minimum(system.damping_ratio, 1.0)[:, None] * spread))
    near = np.concatenate([near, -near])
    inside = near[(near > low) & (near < high)]
    return np.concatenate([np.linspace(low, high, _BASE), inside])


def _promising(speeds: np.ndarray, heights: np.ndarray) -> list[tuple[float, float]]:
    """Neighbours of each peak on the speeds that nearly reaches the highest."""
    padded = np.concatenate([[-1.0], heights, [-1.0]])
    peak = (heights >= padded[:-2]) & (heights > padded[2:]) & (heights > 0.0)
    tops = np.flatnonzero(peak & (heights >= _NEARLY * np.max(heights)))
    last = len(speeds) - 1
    return [(speeds[max(top - 1, 0)], speeds[min(top + 1, last)]) for top in tops.tolist()]


def _motions(
    system: ModalSystem, loads: ModalLoads, operation: int, speeds: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Steady amplitudes (speeds, orders, modes) of q and q'."""
    amplitude = np.array(
        [steady_motion(system, loads, operation, speed).amplitude for speed in speeds.tolist()]
    )
    return amplitude, 1j * (loads.orders * speeds[:, None])[..., None] * amplitude


def _peak(
    system: ModalSystem,
    loads: ModalLoads,
    operation: int,
    low: float,
    high: float,
    column: int,
) -> tuple[float, float, float]:
    """Highest value of one column between two speeds, what may be missing, and its speed.

    Of three equally spaced points on a parabola the middle one, if highest, lacks at most a
    quarter of the larger drop to the others; twice that is granted.
    """
    top = drop = at = 0.0
    for _ in range(_ROUNDS):
        between = np.linspace(low, high, _PARTS)
        motion = _motions(system, loads, operation, between)
        heights = reading_peak(system, *motion, loads.orders, column)[0]
        number = int(np.argmax(heights))
        sides = (max(number - 1, 0), min(number + 1, _PARTS - 1))
        top, at = float(heights[number]), float(between[number])
        drop = top - float(np.min(heights[list(sides)]))
        low, high = (float(between[side]) for side in sides)
        if drop <= _FINE * top or low == high:
            return top, 0.5 * drop, at
    raise NumericalFailure(
        f"the largest steady motion near {at:.9g} rad/s was not found: it still changes by "
        f"{drop / top:.1g} of itself between neighbouring speeds"
    )
