"""Envelope over a whole cycle of the machine that slides along a run.

Windows of time laid side by side hold now more, now fewer firings, and a steady vibration looks
unsteady in them. A window of a whole cycle holds every crest of a steady motion wherever it lies,
so that only what changes from cycle to cycle moves the envelope.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import angle_at, speed_at
from vibecalc.response.torsion.transient_peaks import summit
from vibecalc.response.torsion.transient_waterfall import TimeCourse, time_course

#: the samples are this many times finer than the first look
_FINER = 4
#: cycles that are sampled at once, and samples that are kept beyond the windows of a block
_BLOCK, _MARGIN = 8.0, 3
#: halvings of the time in search of an angle
_HALVINGS = 60
#: a crest this share of a sample outside counts: its place is not known better
_PLACE = 0.1
#: least number of cycles of a run in which one may slide
FEWEST = 1.05


class Sliding(NamedTuple):
    """v windows, e sections: `low`, `high` (v, e) in N m with `error` (v, e).

    `time` (v,) in s and `speed` (v,) in rad/s of the crank are those in the middle of each window
    (of its angle), `speed_low`, `speed_high` (v,) the least and the greatest of the window.
    """

    time: FloatArray
    speed: FloatArray
    low: FloatArray
    high: FloatArray
    error: FloatArray
    speed_low: FloatArray
    speed_high: FloatArray


def sliding(run: TransientRun, cycle: float, count: int = 200) -> Sliding | None:
    """Lowest and highest section torques over a cycle of `cycle` rad about each of `count` times.

    The times are equally spaced, the first and last half a cycle from the ends of the run. Where
    more than a cycle lies between two, the window holds as many whole cycles as lie between them,
    so that nothing is left out. None if the run has hardly a cycle or less.
    """
    if float(run.borders.angle[-1] - run.borders.angle[0]) < FEWEST * cycle:
        return None
    time = _centres(run, 0.5 * cycle, count)
    passed = np.diff(angle_at(run.stretches, run.borders, time))
    cycles = max(1.0, float(np.ceil(passed.max(initial=0.0) / cycle - 1e-9)))
    reach = 0.5 * cycle * cycles
    time = _centres(run, reach, count)
    middle = angle_at(run.stretches, run.borders, time)
    starts, ends = (_time_of(run, middle + side * reach) for side in (-1.0, 1.0))
    e = run.system.torque.shape[0]
    low, high, error = (np.empty((count, e)) for _ in range(3))
    for rows in _blocks(middle, max(_BLOCK * cycle, 4.0 * reach)):
        begin, end = float(starts[rows[0]]), float(ends[rows[-1]])
        course = _course(run, begin, end)
        jump = _uneven(course.time, run)
        for section in range(e):
            for sign, out in ((1.0, high), (-1.0, low)):
                value = sign * course.value[:, section]
                own, doubt = _highest(course.time, value, jump, starts[rows], ends[rows])
                out[rows, section] = sign * own
                first = sign > 0.0
                error[rows, section] = doubt if first else np.maximum(error[rows, section], doubt)
    # the speed of a window may turn at a border of two stretches
    inner = [
        np.concatenate([[a, b], run.borders.time[(run.borders.time > a) & (run.borders.time < b)]])
        for a, b in zip(starts, ends, strict=True)
    ]
    speeds = [speed_at(run.stretches, run.borders, one) for one in inner]
    return Sliding(
        time, speed_at(run.stretches, run.borders, time), low, high, error + run.torque_error,
        np.array([one.min() for one in speeds]), np.array([one.max() for one in speeds]),
    )  # fmt: skip


def _centres(run: TransientRun, reach: float, count: int) -> FloatArray:
    """Times (count,) whose windows of `reach` rad to both sides lie within the run."""
    first, last = float(run.borders.angle[0]) + reach, float(run.borders.angle[-1]) - reach
    ends = _time_of(run, np.array([first, last]))
    return np.linspace(ends[0], ends[1], count)


def _time_of(run: TransientRun, angle: FloatArray) -> FloatArray:
    """Times in s at which the crank has turned that far, within the run."""
    low, high = np.zeros_like(angle), np.full_like(angle, run.borders.time[-1])
    for _ in range(_HALVINGS):
        half = 0.5 * (low + high)
        later = angle_at(run.stretches, run.borders, half) < angle
        low, high = np.where(later, half, low), np.where(later, high, half)
    return 0.5 * (low + high)


def _blocks(angle: FloatArray, span: float) -> list[IntArray]:
    """Rows in groups that lie within `span` rad."""
    number = np.floor((angle - angle[0]) / span).astype(np.int64)
    return [np.flatnonzero(number == one) for one in np.unique(number)]


def _course(run: TransientRun, begin: float, end: float) -> TimeCourse:
    """Samples from a little before `begin` to a little after `end`."""
    step = max(piece.step for piece in run.pieces)
    return time_course(run, begin - _MARGIN * step, end + _MARGIN * step, finer=_FINER)


def _uneven(time: FloatArray, run: TransientRun) -> np.ndarray:
    """Whether the five samples about each are unequally spaced, or a stretch ends among them."""
    gap = np.diff(time)
    odd = np.zeros(time.size, dtype=bool)
    odd[1:-1] = np.abs(np.diff(gap)) > 1e-6 * gap[:-1]
    place = np.searchsorted(time, run.borders.time[1:-1])
    odd[np.clip(place, 0, time.size - 1)] = True
    near = np.convolve(odd, np.ones(5), mode="same") > 0.5
    near[:2] = near[-2:] = True
    return np.asarray(near)


def _highest(
    time: FloatArray, value: FloatArray, uneven: np.ndarray, starts: FloatArray, ends: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest value (v,) between each start and end, from samples (k,), with its error (v,)."""
    place = np.flatnonzero((value[1:-1] >= value[:-2]) & (value[1:-1] > value[2:])) + 1
    near = np.clip(place, 2, time.size - 3)
    five = value[near[:, None] + np.arange(-2, 3)]
    height, share, doubt = (part[:, 0] for part in summit(five[:, :, None]))
    gap = np.maximum(time[place + 1] - time[place], time[place] - time[place - 1])
    when = time[near] + (4.0 * share - 2.0) * gap
    # over a kink or a change of spacing no polynomial holds: the sample, and all it may be off
    bend = 2.0 * value[place] - value[place - 1] - value[place + 1]
    height = np.where(uneven[place], value[place], height)
    when = np.where(uneven[place], time[place], when)
    doubt = np.where(uneven[place], bend, doubt)
    best, error = values_at(time, value, np.concatenate([starts, ends]))
    size = starts.size
    # a crest between the last two samples of all shows in neither
    error[:size] += np.where(starts < time[1], _hidden(value[:3]), 0.0)
    error[size:] += np.where(ends > time[-2], _hidden(value[:-4:-1]), 0.0)
    top, slack = np.empty(size), np.empty(size)
    first = np.searchsorted(when + _PLACE * gap, starts)
    last = np.searchsorted(when - _PLACE * gap, ends, side="right")
    for row in range(size):
        own = slice(int(first[row]), int(last[row]))
        values = np.concatenate([best[[row, size + row]], height[own]])
        doubts = np.concatenate([error[[row, size + row]], doubt[own]])
        winner = int(np.argmax(values))
        top[row] = values[winner]
        # what reaches as high within its error may be the highest
        slack[row] = max(float(doubts[winner]), float(np.max(values + doubts)) - top[row])
    return top, slack


def _hidden(value: FloatArray) -> float:
    """What a crest between the first two of three samples (3,) may rise above them."""
    bend = abs(float(value[0] - 2.0 * value[1] + value[2]))
    return bend if abs(float(value[0] - value[1])) <= bend else 0.0


def values_at(
    time: FloatArray, value: FloatArray, wanted: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values between samples through four of them, and what they differ from those of three."""
    first = np.clip(np.searchsorted(time, wanted) - 2, 0, time.size - 4)
    found = []
    for points in (first[:, None] + np.arange(4), first[:, None] + np.arange(1, 4)):
        at, total = time[points], np.zeros(wanted.size)
        for i in range(at.shape[1]):
            others = [j for j in range(at.shape[1]) if j != i]
            parts = [(wanted - at[:, j]) / (at[:, i] - at[:, j]) for j in others]
            total += np.prod(parts, axis=0) * value[points[:, i]]
        found.append(total)
    return found[0], np.abs(found[0] - found[1])
