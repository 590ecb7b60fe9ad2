"""The largest swing of a section within one cycle of the machine, and when it is.

Windows of time that are laid side by side cut a swing in two and say its time to a window only.
Here the cycle may begin anywhere: the half range is the largest of (crest - trough) / 2 over all
crests and troughs that lie no more than one cycle apart, and its place is midway between the two.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import speed_at
from vibecalc.response.torsion.transient_peaks import Envelope
from vibecalc.response.torsion.transient_waterfall import TimeCourse, time_course

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


def largest_swings(run: TransientRun, found: Envelope, cycle: float) -> Swings:
    """The largest half range over a cycle of `cycle` rad of the crank that begins anywhere.

    `found` are windows side by side, each a whole cycle at least: no cycle meets more than two of
    them, so that what two neighbours reach together bounds every swing within them.
    """
    high = np.maximum(found.high[:-1], found.high[1:])
    bound = 0.5 * (high - np.minimum(found.low[:-1], found.low[1:]))
    sections = bound.shape[1]
    best = np.zeros((4, sections))
    wanted = np.any(bound >= _FIRST * bound.max(axis=0), axis=1)
    seen = np.zeros_like(wanted)
    for look in range(_LOOKS + 1):
        for first, last in _spans(np.flatnonzero(wanted & ~seen)):
            course = time_course(run, float(found.time[first]), float(found.time[last + 2]))
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
    i, j = np.unravel_index(int(np.argmax(half)), half.shape)
    # what reaches as high within the errors may be the highest
    rival = near & (half + doubt >= half[i, j] - doubt[i, j])
    error = max(float(doubt[i, j]), float(np.max((half + doubt)[rival])) - float(half[i, j]))
    away = float(np.max(np.abs(middle[rival] - middle[i, j])))
    step = 0.5 * _PLACE * float(np.max(np.diff(course.time)))
    return float(half[i, j]), error, float(middle[i, j]), away + 2.0 * step


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
