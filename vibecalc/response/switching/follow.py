"""A body on mounts through a course of speeds and operations: what it does on the way."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import WithError
from vibecalc.response.switching.course import Segment, follow_course
from vibecalc.response.switching.free_motion import modal_size, propagator
from vibecalc.response.switching.history import History, history
from vibecalc.response.switching.peaks import Peaks, true_peaks
from vibecalc.response.switching.readings import columns, read_bound, steady_peaks
from vibecalc.response.switching.settling import Settling, settling
from vibecalc.response.switching.steady import Steady, steady_motion, steady_state
from vibecalc.response.switching.system import Loads, ModalLoads, ModalSystem, Piece, modal_loads


class Transient(NamedTuple):
    """What a body does on a course; columns as in `readings`.

    `final` (columns,) are the peaks of the steady motion that it settles into, `later` (columns,)
    bounds whatever comes after the last piece: where it is not above `peaks` these hold for good.
    """

    history: History
    peaks: Peaks
    settling: Settling
    final: WithError
    later: np.ndarray


def follow(
    system: ModalSystem,
    loads: Loads,
    pieces: Sequence[Piece],
    *,
    angle: float = 0.0,
    before: int | None = None,
    buckets: int = 400,
    tolerance: float = 0.05,
) -> Transient:
    """Follow a body from a steady motion through pieces of linearly changing crank speed.

    Parameters
    ----------
    system, loads
        Modes with their damping; loads on the body for each operation.
    pieces
        The course, in time; each begins at the speed at which the one before it ends. Speed 0 is
        a stand, negative speeds turn the other way. The last speed and operation go on for ever.
    angle
        Crank angle at time 0, rad.
    before
        Operation whose steady motion, at the first speed, the body is in at time 0; that of the
        first piece if not given.
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
        The speed jumps between pieces.
    """
    modal = modal_loads(system, loads)
    first = pieces[0].operation if before is None else before
    total = sum(piece.duration for piece in pieces)
    segments = follow_course(
        system, modal, pieces, angle=angle, before=first, longest=0.5 * total / buckets
    )
    peaks = true_peaks(system, modal, segments)
    last = segments[-1]
    steady = steady_motion(system, modal, last.run.operation, last.run.end_speed)
    final = steady_peaks(system, steady, modal.orders, last.run.end_speed)
    settled = _settled(system, modal, segments, steady, final, peaks, tolerance)
    later = _later(system, modal, last, steady, final)
    return Transient(history(system, modal, segments, buckets), peaks, settled, final, later)


def _deviation(
    system: ModalSystem, loads: ModalLoads, segment: Segment, steady: Steady, time: float
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
    steady: Steady,
    final: WithError,
    peaks: Peaks,
    tolerance: float,
) -> Settling:
    last = segments[-1]
    # a last piece of constant speed is free deviation from its start, a ramp from its end
    time = 0.0 if last.run.acceleration == 0.0 else last.run.duration
    deviation = _deviation(system, loads, last, steady, time)
    energy = columns(len(system.shape)).energy
    rest = final.value[energy] == 0.0
    height, doubt = (peaks.value, peaks.error) if rest else (final.value, final.error)
    reference = float(np.sqrt(2.0 * height[energy]))
    doubt_size = float(doubt[energy]) / reference if reference else 0.0
    error = last.error + steady.error
    start = last.run.start + time
    return settling(system, deviation, error, start, reference, doubt_size, tolerance)


def _later(
    system: ModalSystem, loads: ModalLoads, last: Segment, steady: Steady, final: WithError
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
