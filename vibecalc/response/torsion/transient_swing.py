"""The largest swing of a section within one cycle of the machine, and when it is.

Windows of time that are laid side by side cut a swing in two and say its time to a window only.
Here the cycle may begin anywhere: the half range is the largest of (crest - trough) / 2 over all
crests and troughs that lie no more than one cycle apart, and its place is midway between the two.
A slow swing may not have both within a cycle: the values at the two ends of one count too.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import angle_at, speed_at
from vibecalc.response.torsion.transient_peaks import Envelope
from vibecalc.response.torsion.transient_sliding import values_at
from vibecalc.response.torsion.transient_waterfall import (
    TimeCourse,
    angle_between,
    time_course,
)

#: share of the highest bound that windows of the first look reach; looks before all are taken
_FIRST, _LOOKS = 0.98, 3
#: share of the second difference, and of the spacing, by which a parabola's summit may be off
_VALUE, _PLACE = 0.02, 0.1


class Swings(NamedTuple):
    """Per section (e,): largest `half_range` in N m with `error`, `time` in s with `time_error`,
    crank `speed` in rad/s there."""

    half_range: FloatArray
    error: FloatArray
    time: FloatArray
    time_error: FloatArray
    speed: FloatArray


def largest_swings(
    run: TransientRun, found: Envelope, cycle: float, span: tuple[float, float] | None = None
) -> Swings:
    """The largest half range over a cycle of `cycle` rad of the crank that begins anywhere.

    Within the `span` of time in s, where that is given; the windows must cover it.

    `found` are windows side by side. What those reach together that a cycle meets bounds its swing:
    two of them, but more where the crank is slow and a window holds less than a cycle.
    """
    angle = angle_at(run.stretches, run.borders, found.time)
    count, sections = found.high.shape
    # where the last cycle that begins in each window has ended
    after = np.minimum(np.searchsorted(angle, angle[1:] + cycle * (1.0 + 1e-9)), count)
    bound = np.array([
        0.5 * (found.high[k:end].max(axis=0) - found.low[k:end].min(axis=0))
        for k, end in enumerate(after)
    ])  # fmt: skip
    best = np.zeros((4, sections))
    wanted = np.any(bound >= _FIRST * bound.max(axis=0), axis=1)
    seen = np.zeros_like(wanted)
    for look in range(_LOOKS + 1):
        for first, last in _spans(np.flatnonzero(wanted & ~seen)):
            begin, end = float(found.time[first]), float(found.time[after[last]])
            if span is not None:
                begin, end = max(begin, span[0]), min(end, span[1])
            course = time_course(run, begin, end)
            for section in range(sections):
                own = _swing(course, section, cycle)
                if own[0] > best[0, section]:
                    best[:, section] = own
        seen |= wanted
        wanted = np.any(bound > best[0], axis=1) if look < _LOOKS - 1 else np.ones_like(seen)
        if np.all(seen | ~np.any(bound > best[0], axis=1)):
            break
    half, error, time, doubt = best
    speed = speed_at(run.stretches, run.borders, time)
    return Swings(half, error + run.torque_error, time, doubt, speed)


def _spans(place: IntArray) -> list[tuple[int, int]]:
    """First and last of each run of whole numbers without a gap."""
    if place.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(place) > 1)
    firsts = place[np.append(0, cuts + 1)]
    return list(zip(firsts.tolist(), place[np.append(cuts, place.size - 1)].tolist(), strict=True))


def _swing(course: TimeCourse, section: int, cycle: float) -> tuple[float, float, float, float]:
    """Half range, its error, time and error of the time of one section."""
    up = _crests(course.time, course.value[:, section])
    down = _crests(course.time, -course.value[:, section])
    angles = [np.interp(side[0], course.time, course.angle) for side in (up, down)]
    near = np.abs(angles[0][:, None] - angles[1]) <= cycle * (1.0 + 1e-9)
    half = np.where(near, 0.5 * (up[1][:, None] + down[1]), -np.inf)
    doubt = 0.5 * (up[2][:, None] + down[2])
    middle = 0.5 * (up[0][:, None] + down[0])
    whole = _apart(course, section, cycle)
    middle, half, doubt = (
        np.append(pairs[near], ends)
        for pairs, ends in zip((middle, half, doubt), whole, strict=True)
    )
    best = int(np.argmax(half))
    # what reaches as high within the errors may be the highest
    rival = half + doubt >= half[best] - doubt[best]
    error = max(float(doubt[best]), float(np.max((half + doubt)[rival])) - float(half[best]))
    away = float(np.max(np.abs(middle[rival] - middle[best])))
    step = 0.5 * _PLACE * float(np.max(np.diff(course.time)))
    return float(half[best]), error, float(middle[best]), away + 2.0 * step


def _apart(
    course: TimeCourse, section: int, cycle: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times midway, half ranges and their errors of values a whole cycle apart, at their crests."""
    first = np.flatnonzero(course.angle + cycle <= course.angle[-1])
    if first.size < 3:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    begin, value = course.time[first], course.value[:, section]
    # the last cycle ends where the course does
    last = _time_of(course, course.angle[-1:] - cycle)
    if last[0] - begin[-1] > _PLACE * (begin[-1] - begin[-2]):
        begin = np.append(begin, last)
    end = _time_of(course, angle_between(course, begin) + cycle)
    (near, own), (far, slip) = (values_at(course.time, value, at) for at in (begin, end))
    gap, middle = 0.5 * (far - near), 0.5 * (begin + end)
    sides = [_crests(middle, sign * gap) for sign in (1.0, -1.0)]
    time, half, doubt = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    return time, half, doubt + np.interp(time, middle, slip + own)


def _time_of(course: TimeCourse, angle: FloatArray) -> FloatArray:
    """Times at which the crank has turned that far."""
    time = np.interp(angle, course.angle, course.time)
    for _ in range(2):
        speed = np.interp(time, course.time, course.speed)
        late = angle_between(course, time) - angle
        time = time - np.where(speed > 0.0, late / np.where(speed > 0.0, speed, 1.0), 0.0)
    return np.asarray(np.clip(time, course.time[0], course.time[-1]))


def _crests(time: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, heights and errors of the crests of a course, its two ends among them."""
    inner = np.flatnonzero((value[1:-1] >= value[:-2]) & (value[1:-1] > value[2:])) + 1
    before, after = time[inner] - time[inner - 1], time[inner + 1] - time[inner]
    rise = (value[inner] - value[inner - 1]) / before
    fall = (value[inner + 1] - value[inner]) / after
    bend = (fall - rise) / (before + after)
    slope = (rise * after + fall * before) / (before + after)
    shift = np.clip(-0.5 * slope / bend, -before, after)
    ends = np.array([0, value.size - 1])
    return (
        np.append(time[inner] + shift, time[ends]),
        np.append(value[inner] + 0.5 * slope * shift, value[ends]),
        np.append(_VALUE * np.abs(bend) * before * after, np.zeros(2)),
    )
