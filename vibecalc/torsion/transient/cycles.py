"""A run cycle by cycle: envelope, largest half range, and the steady response at each speed."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import FloatArray, IntArray
from vibecalc.torsion.transient.march import TransientRun
from vibecalc.torsion.transient.motion import angle_at, speed_at
from vibecalc.torsion.transient.peaks import (
    Envelope,
    SectionHistory,
    angle_between,
    peak,
    section_history,
)

# ----------------------------------------------------------------------------
# Envelope over a whole cycle of the machine that slides along a run.
#
# Windows of time laid side by side hold now more, now fewer firings, and a steady vibration looks
# unsteady in them. A window of a whole cycle holds every crest of a steady motion wherever it lies,
# so that only what changes from cycle to cycle moves the envelope.
# ----------------------------------------------------------------------------

#: the samples are this many times finer than the first sampling
_FINER = 4
#: cycles that are sampled at once, and samples that are kept beyond the windows of a block
_BLOCK, _MARGIN = 8.0, 3
#: halvings of the time in search of an angle
_HALVINGS = 60
#: a crest this share of a sample outside counts: its place is not known better
_PLACE = 0.1
#: least number of cycles of a run in which one may slide
FEWEST = 1.05


class SlidingExtremes(NamedTuple):
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


def sliding(run: TransientRun, cycle: float, count: int = 200) -> SlidingExtremes | None:
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
        history = _history(run, begin, end)
        jump = uneven(history.time, run)
        for section in range(e):
            for sign, out in ((1.0, high), (-1.0, low)):
                value = sign * history.value[:, section]
                extreme, uncertainty = _highest(history.time, value, jump, starts[rows], ends[rows])
                out[rows, section] = sign * extreme
                first = sign > 0.0
                error[rows, section] = (
                    uncertainty if first else np.maximum(error[rows, section], uncertainty)
                )
    # the speed of a window may turn at a border of two stretches
    inner = [
        np.concatenate([[a, b], run.borders.time[(run.borders.time > a) & (run.borders.time < b)]])
        for a, b in zip(starts, ends, strict=True)
    ]
    speeds = [speed_at(run.stretches, run.borders, one) for one in inner]
    return SlidingExtremes(
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


def _history(run: TransientRun, begin: float, end: float) -> SectionHistory:
    """Samples from a little before `begin` to a little after `end`."""
    step = max(block.step for block in run.blocks)
    return section_history(run, begin - _MARGIN * step, end + _MARGIN * step, finer=_FINER)


def uneven(time: FloatArray, run: TransientRun) -> np.ndarray:
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
    place, height, ahead, uncertainty = crests(value, uneven)
    gap = np.maximum(time[place + 1] - time[place], time[place] - time[place - 1])
    when = time[place] + ahead * gap
    best, error = values_at(time, value, np.concatenate([starts, ends]))
    size = starts.size
    # a crest between the last two samples of all shows in neither
    error[:size] += np.where(starts < time[1], _hidden(value[:3]), 0.0)
    error[size:] += np.where(ends > time[-2], _hidden(value[:-4:-1]), 0.0)
    top, slack = np.empty(size), np.empty(size)
    first = np.searchsorted(when + _PLACE * gap, starts)
    last = np.searchsorted(when - _PLACE * gap, ends, side="right")
    for row in range(size):
        inside = slice(int(first[row]), int(last[row]))
        values = np.concatenate([best[[row, size + row]], height[inside]])
        uncertainties = np.concatenate([error[[row, size + row]], uncertainty[inside]])
        winner = int(np.argmax(values))
        top[row] = values[winner]
        # what reaches as high within its error may be the highest
        slack[row] = max(
            float(uncertainties[winner]), float(np.max(values + uncertainties)) - top[row]
        )
    return top, slack


def crests(
    value: FloatArray, uneven: np.ndarray
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """Places of the crests of samples (k,), heights, how many samples further on, and errors.

    Over a kink or a change of spacing no polynomial holds: the sample, and all that it may be off.
    """
    place = np.flatnonzero((value[1:-1] >= value[:-2]) & (value[1:-1] > value[2:])) + 1
    near = np.clip(place, 2, value.size - 3)
    five = value[near[:, None] + np.arange(-2, 3)]
    height, share, uncertainty = (part[:, 0] for part in peak(five[:, :, None]))
    bend = 2.0 * value[place] - value[place - 1] - value[place + 1]
    kinks, ahead = uneven[place], near - place + 4.0 * share - 2.0
    return (
        place, np.where(kinks, value[place], height), np.where(kinks, 0.0, ahead),
        np.where(kinks, bend, uncertainty),
    )  # fmt: skip


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


# ----------------------------------------------------------------------------
# The largest swing of a section within one cycle of the machine, and when it is.
#
# Windows of time that are laid side by side cut a swing in two and say its time to a window only.
# Here the cycle may begin anywhere: the half range is the largest of (crest - trough) / 2 over all
# crests and troughs that lie no more than one cycle apart, and its place is midway between the two.
# A slow swing may not have both within a cycle: the values at the two ends of one count too.
# ----------------------------------------------------------------------------

#: share of the highest bound that windows of the first round reach; rounds before all are taken
_FIRST, _ROUNDS = 0.98, 3
#: share of the second difference, and of the spacing, by which a parabola's peak may be off
_VALUE, _SWING_PLACE = 0.02, 0.1


class Swings(NamedTuple):
    """Per section (e,): largest `half_range` in N m with `error`, crank `speed` in rad/s there.

    `time_error` in s is what the time of it may be off by.
    """

    half_range: FloatArray
    error: FloatArray
    time_error: FloatArray
    speed: FloatArray


def largest_swings(
    run: TransientRun, extremes: Envelope, cycle: float, span: tuple[float, float] | None = None
) -> Swings:
    """The largest half range over a cycle of `cycle` rad of the crank that begins anywhere.

    Within the `span` of time in s, where that is given; the windows must cover it.

    `extremes` are windows side by side. What those reach together that a cycle meets bounds its
    swing: two of them, but more where the crank is slow and a window holds less than a cycle.
    """
    angle = angle_at(run.stretches, run.borders, extremes.time)
    count, sections = extremes.high.shape
    # where the last cycle that begins in each window has ended
    after = np.minimum(np.searchsorted(angle, angle[1:] + cycle * (1.0 + 1e-9)), count)
    bound = np.array([
        0.5 * (extremes.high[k:end].max(axis=0) - extremes.low[k:end].min(axis=0))
        for k, end in enumerate(after)
    ])  # fmt: skip
    best = np.zeros((4, sections))
    wanted = np.any(bound >= _FIRST * bound.max(axis=0), axis=1)
    examined = np.zeros_like(wanted)
    for round_ in range(_ROUNDS + 1):
        for first, last in _spans(np.flatnonzero(wanted & ~examined)):
            begin, end = float(extremes.time[first]), float(extremes.time[after[last]])
            if span is not None:
                begin, end = max(begin, span[0]), min(end, span[1])
            history = section_history(run, begin, end)
            for section in range(sections):
                swing = _swing(history, section, cycle)
                if swing[0] > best[0, section]:
                    best[:, section] = swing
        examined |= wanted
        wanted = np.any(bound > best[0], axis=1) if round_ < _ROUNDS - 1 else np.ones_like(examined)
        if np.all(examined | ~np.any(bound > best[0], axis=1)):
            break
    half, error, time, uncertainty = best
    speed = speed_at(run.stretches, run.borders, time)
    return Swings(half, error + run.torque_error, uncertainty, speed)


def _spans(place: IntArray) -> list[tuple[int, int]]:
    """First and last of each run of whole numbers without a gap."""
    if place.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(place) > 1)
    firsts = place[np.append(0, cuts + 1)]
    return list(zip(firsts.tolist(), place[np.append(cuts, place.size - 1)].tolist(), strict=True))


def _swing(
    history: SectionHistory, section: int, cycle: float
) -> tuple[float, float, float, float]:
    """Half range, its error, time and error of the time of one section."""
    up = _crests(history.time, history.value[:, section])
    down = _crests(history.time, -history.value[:, section])
    angles = [np.interp(side[0], history.time, history.angle) for side in (up, down)]
    near = np.abs(angles[0][:, None] - angles[1]) <= cycle * (1.0 + 1e-9)
    half = np.where(near, 0.5 * (up[1][:, None] + down[1]), -np.inf)
    uncertainty = 0.5 * (up[2][:, None] + down[2])
    middle = 0.5 * (up[0][:, None] + down[0])
    whole = _apart(history, section, cycle)
    middle, half, uncertainty = (
        np.append(pairs[near], ends)
        for pairs, ends in zip((middle, half, uncertainty), whole, strict=True)
    )
    best = int(np.argmax(half))
    # what reaches as high within the errors may be the highest
    rival = half + uncertainty >= half[best] - uncertainty[best]
    error = max(
        float(uncertainty[best]), float(np.max((half + uncertainty)[rival])) - float(half[best])
    )
    away = float(np.max(np.abs(middle[rival] - middle[best])))
    step = 0.5 * _SWING_PLACE * float(np.max(np.diff(history.time)))
    return float(half[best]), error, float(middle[best]), away + 2.0 * step


def _apart(
    history: SectionHistory, section: int, cycle: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times midway, half ranges and their errors of values a whole cycle apart, at their crests."""
    first = np.flatnonzero(history.angle + cycle <= history.angle[-1])
    if first.size < 3:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    begin, value = history.time[first], history.value[:, section]
    # the last cycle ends where the time history does
    last = _time_of_swing(history, history.angle[-1:] - cycle)
    if last[0] - begin[-1] > _SWING_PLACE * (begin[-1] - begin[-2]):
        begin = np.append(begin, last)
    end = _time_of_swing(history, angle_between(history, begin) + cycle)
    (near, value_error), (far, slip) = (values_at(history.time, value, at) for at in (begin, end))
    gap, middle = 0.5 * (far - near), 0.5 * (begin + end)
    sides = [_crests(middle, sign * gap) for sign in (1.0, -1.0)]
    time, half, uncertainty = (np.concatenate(parts) for parts in zip(*sides, strict=True))
    return time, half, uncertainty + np.interp(time, middle, slip + value_error)


def _time_of_swing(history: SectionHistory, angle: FloatArray) -> FloatArray:
    """Times at which the crank has turned that far."""
    time = np.interp(angle, history.angle, history.time)
    for _ in range(2):
        speed = np.interp(time, history.time, history.speed)
        late = angle_between(history, time) - angle
        time = time - np.where(speed > 0.0, late / np.where(speed > 0.0, speed, 1.0), 0.0)
    return np.asarray(np.clip(time, history.time[0], history.time[-1]))


def _crests(time: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, heights and errors of the crests of a time history, its two ends among them."""
    inner = np.flatnonzero((value[1:-1] >= value[:-2]) & (value[1:-1] > value[2:])) + 1
    before, after = time[inner] - time[inner - 1], time[inner + 1] - time[inner]
    before_slope = (value[inner] - value[inner - 1]) / before
    fall = (value[inner + 1] - value[inner]) / after
    bend = (fall - before_slope) / (before + after)
    slope = (before_slope * after + fall * before) / (before + after)
    shift = np.clip(-0.5 * slope / bend, -before, after)
    ends = np.array([0, value.size - 1])
    return (
        np.append(time[inner] + shift, time[ends]),
        np.append(value[inner] + 0.5 * slope * shift, value[ends]),
        np.append(_VALUE * np.abs(bend) * before * after, np.zeros(2)),
    )


# ----------------------------------------------------------------------------
# A run through criticals next to the steady response at each speed.
# ----------------------------------------------------------------------------


class SectionPeaks(NamedTuple):
    """Largest magnitude `peak` (e,) of each section, with error, and where: s, rad/s."""

    peak: FloatArray
    error: FloatArray
    time: FloatArray
    speed: FloatArray


def section_peaks(run: TransientRun, extremes: Envelope) -> SectionPeaks:
    """Largest magnitudes over the whole run, from its envelope."""
    size = np.stack([extremes.high, -extremes.low])
    side, row = np.unravel_index(size.reshape(-1, size.shape[2]).argmax(axis=0), size.shape[:2])
    section = np.arange(size.shape[2])
    peak = size[side, row, section]
    time = np.where(side == 0, extremes.time_high[row, section], extremes.time_low[row, section])
    # another window within its own uncertainty of the best may hold a higher value, never by more
    upper = (np.maximum(extremes.high, -extremes.low) + extremes.error).max(axis=0)
    error = np.maximum(extremes.error[row, section], upper - peak)
    return SectionPeaks(peak, error, time, speed_at(run.stretches, run.borders, time))


def time_uncertainty(run: TransientRun, peaks: SectionPeaks) -> FloatArray:
    """How far off in s the times of the peaks (e,) may be, a step at most.

    Within so much of a smooth peak the torque is as high as its error says; of peaks that are
    equally high within their errors any one may be the peak.
    """
    step = max(block.step for block in run.blocks)
    uncertainty = np.full(peaks.time.size, step)
    for section, time in enumerate(peaks.time):
        near = section_history(run, time - 1.5 * step, time + 1.5 * step, finer=_FINER)
        value = np.abs(near.value[:, section])
        middle = int(np.clip(np.argmin(np.abs(near.time - time)), 1, value.size - 2))
        before, after = np.diff(near.time[middle - 1 : middle + 2])
        ascent, fall = np.diff(value[middle - 1 : middle + 2]) / (before, after)
        bend = 2.0 * (ascent - fall) / (before + after)
        if abs(near.time[middle] - time) <= max(before, after) and bend > 0.0:
            uncertainty[section] = min(step, 2.0 * np.sqrt(2.0 * peaks.error[section] / bend))
    return uncertainty


def largest_steady(
    speed: FloatArray, steady: FloatArray, between: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Largest steady half ranges (e,) of those (k, e) `between` two speeds, and their speeds.

    Raises NumericalFailure for a section without any.
    """
    inside = np.flatnonzero((speed >= between[0]) & (speed <= between[1]))
    top = inside[steady[inside].argmax(axis=0)]
    largest = steady[top, np.arange(steady.shape[1])]
    if np.any(largest <= 0.0):
        raise NumericalFailure("a section has no steady response to compare with")
    return largest, speed[top]
