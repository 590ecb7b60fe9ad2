"""The largest magnitude of every reading over a course, between the times of the grid too."""

from typing import NamedTuple

import numpy as np

from vibecalc.response.switching.course import Segment, motion_at
from vibecalc.response.switching.intervals import Candidates, candidates
from vibecalc.response.switching.readings import Jet, read, read_error
from vibecalc.response.switching.system import ModalLoads, ModalSystem

#: intervals looked at exactly for each reading, the most promising first
_MOST = 200
_STEPS = 10
#: a search ends when it moves by less than this share of its interval
_SETTLED = 1e-6


class Peaks(NamedTuple):
    """Largest magnitudes (columns,) with absolute errors, when (s), and at which crank speed.

    The time is the first at which the value is reached to within rounding; its error is that of
    the summit's place where it is round, or the distance to the next time where it is flat.
    """

    value: np.ndarray
    error: np.ndarray
    time: np.ndarray
    time_error: np.ndarray
    speed: np.ndarray


def true_peaks(system: ModalSystem, loads: ModalLoads, segments: list[Segment]) -> Peaks:
    """Peaks of all readings: intervals that may hold one are searched on the motion itself."""
    sampled, all_of_them = candidates(system, loads, segments)
    width = len(sampled)
    left_over, rank = np.zeros(width), np.argsort(-all_of_them.upper, kind="stable")
    chosen: list[int] = []
    for column in range(width):
        mine = rank[all_of_them.column[rank] == column]
        chosen += mine[:_MOST].tolist()
        left_over[column] = np.max(all_of_them.upper[mine[_MOST:]], initial=0.0)
    which = all_of_them.take(np.array(chosen, dtype=int))
    height, time, bend, slack = _climb(system, loads, segments, which)

    value, error, moment, round_, speed = np.zeros((5, width))
    starts = np.array([segment.run.start for segment in segments])
    for column in range(width):
        mine = np.flatnonzero(which.column == column)
        value[column] = np.max(height[mine])
        reached = mine[height[mine] >= value[column] * (1.0 - 1e-13)]
        when = starts[which.segment[reached]] + time[reached]
        first = reached[np.argmin(when)]
        segment = segments[which.segment[first]]
        doubt = read_error(system, np.full(width, value[column]), segment.error, segment.largest)
        missed = np.max((height + slack)[mine] - value[column])
        error[column] = doubt[column] + max(missed, left_over[column] - value[column], 0.0)
        moment[column] = np.min(when)
        round_[column] = max(-bend[first], 0.0)
        speed[column] = segment.run.speed_at(time[first])
    longest = max(float(np.max(np.diff(segment.grid))) for segment in segments)
    doubt = np.sqrt(4.0 * error / np.where(round_ > 0.0, round_, np.inf))
    return Peaks(value, error, moment, np.where(doubt > 0.0, doubt, longest), speed)


def _climb(
    system: ModalSystem, loads: ModalLoads, segments: list[Segment], which: Candidates
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Height, time, second derivative and missing height of the summit in each interval.

    Newton's method for the slope, kept between times where it rises and where it falls; an end
    of the interval is such a time once it has been looked at.
    """
    low, high, time = which.left.copy(), which.right.copy(), which.guess.copy()
    width = high - low
    low_seen, high_seen = np.zeros((2, len(time)), dtype=bool)
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
        low_seen[now], high_seen[now] = low_seen[now] | rises, high_seen[now] | ~rises
        round_ = bend < 0.0
        target = time[now] - np.divide(slope, bend, out=np.zeros_like(slope), where=round_)
        inside = round_ & (target >= low[now]) & (target <= high[now])
        middle = 0.5 * (low[now] + high[now])
        up = np.where(high_seen[now], middle, high[now])
        down = np.where(low_seen[now], middle, low[now])
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
