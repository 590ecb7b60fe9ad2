"""What the sections see along a run: samples, crests and troughs, counted cycles."""

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.torsion.transient.march import CHUNK, Propagator, TransientRun
from vibecalc.torsion.transient.motion import Course

# ----------------------------------------------------------------------------
# Torques inside the steps, as exact as those at their ends.
# ----------------------------------------------------------------------------

#: points in a step: bounds of the first sampling
FEWEST_POINTS, MOST_POINTS = 6, 36

#: radians of the fastest mode between two points of the first sampling
SAMPLE_STEP = 1.0 / 3.0


class Samples(NamedTuple):
    """Section torques (k, e) in N m, referred, at times (k,) in s."""

    time: FloatArray
    value: FloatArray


def points_in(run: TransientRun, block: int) -> int:
    """How many points of a step of that block the first sampling takes."""
    data = run.blocks[block]
    part = run.course.parts[data.stretch]
    rate = 0.0 if part.in_time is None else part.in_time.fastest
    wanted = max(run.drive.systems[data.stretch].fastest, rate) * data.step / SAMPLE_STEP
    return int(np.clip(np.ceil(wanted), FEWEST_POINTS, MOST_POINTS))


def inside(run: TransientRun, number: int, tool: Propagator, steps: IntArray) -> FloatArray:
    """What a tool reads at the ends of the parts of some steps of a block, (steps, parts, e)."""
    inner = np.einsum("ks,jts->kjt", run.states[number][steps], tool.transition, optimize=True)
    read: FloatArray = inner + run.drive.gain(run.blocks[number], tool, steps)
    return read


def _pieces(
    run: TransientRun, finer: int, begin: float, end: float
) -> Iterator[tuple[float, float, FloatArray]]:
    """Runs of steps, with their ends, that meet a time: begin and spacing in s, torques (k, e)."""
    for number, block in enumerate(run.blocks):
        since = float(run.course.time[block.stretch]) + block.offset
        ends = np.clip([(begin - since) / block.step, (end - since) / block.step], 0, block.steps)
        last = int(np.ceil(ends[1]))
        parts = points_in(run, number) * finer
        system = run.drive.systems[block.stretch]
        width = system.torque.shape[0] * parts + 20 * run.drive.laws[0].power.size
        batch = max(1, CHUNK // width)
        for first in range(int(np.floor(ends[0])), last, batch):
            steps = np.arange(first, min(first + batch, last))
            values = inside(run, number, system.tool(block.step, parts), steps)
            whole = np.concatenate([
                run.states[number][[first]] @ system.torque.T,
                values.reshape(-1, values.shape[2]),
            ])  # fmt: skip
            yield since + first * block.step, block.step / parts, whole


def samples(run: TransientRun, begin: float, end: float, finer: int = 1) -> Samples:
    """Section torques at all times of the first sampling, or at `finer` times as many."""
    times, values = list[FloatArray](), list[FloatArray]()
    for start, step, value in _pieces(run, finer, begin, end):
        if times:
            times[-1], values[-1] = times[-1][:-1], values[-1][:-1]
        times.append(start + step * np.arange(len(value), dtype=float))
        values.append(value)
    if not times:
        raise NumericalFailure(f"no part of the run lies between {begin:.6g} and {end:.6g} s")
    time = np.concatenate(times)
    within = (time >= begin) & (time <= end)
    return Samples(time[within], np.concatenate(values)[within])


# ----------------------------------------------------------------------------
# Traces: the crests and troughs of every section, its ends and values at chosen times among them.
#
# Between two points in turn a torque rises or falls all the way, so that its largest value, the
# extremes of any window that begins and ends at chosen times, the largest swing within a cycle and
# the cycles of a rainflow are those of the points.
# ----------------------------------------------------------------------------

#: the samples of a trace are so many times finer than the first sampling, and about peaks
FINER, FINEST = 4, 8
#: coefficients (5, 5) of the polynomial through five equally spaced points about the middle one
_FIT: FloatArray = np.linalg.inv(np.vander(np.arange(-2.0, 3.0), increasing=True))
#: share of a sample by which a chosen time may lie outside
_EDGE = 1e-6
#: parts of the fourth difference that may be wrong of a crest, and of a value between samples
_OF_CREST, _BETWEEN = 1.0 / 64.0, 1.0 / 16.0


class Trace(NamedTuple):
    """Of one section `time` (r,) in s, `value` in N m, referred, with `error`, `bend` in N m/s^2.

    The bend is the second derivative in size; points are in the order of time.
    """

    time: FloatArray
    value: FloatArray
    error: FloatArray
    bend: FloatArray


def traces(
    run: TransientRun, at: FloatArray | None = None, finer: int = FINER,
    between: tuple[float, float] = (-np.inf, np.inf),
) -> list[Trace]:  # fmt: skip
    """Those of all sections, with the values `at` times (t,) in s, from steps between two times."""
    asked = np.unique(np.zeros(0) if at is None else at)
    found = list[FloatArray]()
    for begin, step, value in _pieces(run, finer, *between):
        section, place, height, error, bend = turns(value)
        points = np.stack([section, begin + step * place, height, error, bend / step**2])
        # the end of the piece before is known already
        found.append(points[:, place > 0.0] if found else points)
        place, last = (asked - begin) / step, len(value) - 1
        here = (place >= -_EDGE) & (place <= last + _EDGE)
        if np.any(here):
            found.append(_values_between(value, np.clip(place[here], 0, last), asked[here]))
    section, time, value, error, bend = np.concatenate(found, axis=1)
    order = np.lexsort((time, section))
    cuts = np.searchsorted(section[order], np.arange(1, len(run.torque_error)))
    return [
        Trace(time[rows], value[rows], error[rows] + base, bend[rows])
        for rows, base in zip(np.split(order, cuts), run.torque_error, strict=True)
    ]


def turns(value: FloatArray) -> tuple[np.ndarray, ...]:
    """Crests, troughs and both ends of samples (k, e): sections, places, heights, errors, bends.

    The peak of the polynomial of fourth degree through five points about the largest sample, found
    by Newton steps from that of the parabola through three. The error is a quarter of what the two
    differ by, with a share of the fourth difference in case that they meet by chance.
    """
    rises = np.diff(value, axis=0) > 0.0
    turn, crest = np.ones(value.shape, dtype=bool), np.concatenate([~rises[:1], rises])
    turn[1:-1] = rises[1:] != rises[:-1]
    place, section = np.nonzero(turn)
    sign = np.where(crest[place, section], 1.0, -1.0)
    centre = np.clip(place, 2, len(value) - 3)
    points = sign * value[centre + np.arange(-2, 3)[:, None], section]
    row, own = np.arange(len(place)), place - centre
    sample, near = points[own + 2, row], np.clip(own, -1, 1)
    left, middle, right = (points[near + side, row] for side in (1, 2, 3))
    hollow = 2.0 * middle - left - right
    round_ = hollow > 0.0
    move = np.clip(0.5 * (right - left) / np.where(round_, hollow, 1.0), -1.0, 1.0) * round_
    parabola = middle + 0.5 * move * (right - left) - 0.5 * move**2 * hollow
    power, u = _FIT @ points, near + move
    slope, curve = polyder(power), polyder(power, 2)
    for _ in range(3):
        bend = polyval(u, curve, tensor=False)
        step = polyval(u, slope, tensor=False) / np.where(bend < 0.0, bend, np.inf)
        u = np.clip(u - step, -2.0, 2.0)
    top = polyval(u, power, tensor=False)
    height = np.maximum(top, sample)
    u = np.where(top > sample, u, own)
    error = np.abs(height - np.maximum(parabola, sample)) / 4.0 + _OF_CREST * 24.0 * abs(power[4])
    return section, centre + u, sign * height, error, np.abs(polyval(u, curve, tensor=False))


def _values_between(value: FloatArray, place: FloatArray, time: FloatArray) -> FloatArray:
    """Rows (5, points) of a trace at places (t,) among samples (k, e)."""
    centre = np.clip(np.rint(place).astype(np.int64), 2, len(value) - 3)
    points = value[centre + np.arange(-2, 3)[:, None]]
    power = np.tensordot(_FIT, points, 1)
    height = polyval((place - centre)[:, None], power, tensor=False)
    section, when = np.broadcast_arrays(np.arange(value.shape[1]), time[:, None])
    rows = section, when, height, _BETWEEN * 24.0 * np.abs(power[4]), np.zeros_like(height)
    return np.stack([one.ravel() for one in rows])


# ----------------------------------------------------------------------------
# What traces hold: the largest magnitude, extremes of windows, the largest swing within a cycle.
# ----------------------------------------------------------------------------

#: highest points of a section that are examined with finer samples
_CANDIDATES = 3
#: points of a cycle at which values a cycle apart are compared
_OF_CYCLE = 512
#: share by which points a cycle apart may be farther from each other
_CLOSE = 1e-9


class Peaks(NamedTuple):
    """Largest magnitude `peak` (e,) of each section in N m, and when in s, each with its error.

    Within `time_error` the torque is as high as its error says, a step of the march at most.
    """

    peak: FloatArray
    error: FloatArray
    time: FloatArray
    time_error: FloatArray


#: share of a peak within which three samples on end are no crest but a torque that is held
_HELD = 1e-9


def section_peaks(run: TransientRun, seen: list[Trace]) -> Peaks:
    """Over the whole run; of peaks equally high within their errors any one may be the peak.

    Where a slipping clutch or damper holds a torque, it is where that begins.
    """
    found = []
    for section, trace in enumerate(seen):
        size = np.abs(trace.value)
        order = np.argsort(-size, kind="stable")
        near = [
            traces(run, None, FINEST, (when - run.longest, when + run.longest))[section]
            for when in trace.time[order[:_CANDIDATES]]
        ]
        value, error, time, bend = (
            np.concatenate(parts) for parts in (
                [np.abs(one.value) for one in near], [one.error for one in near],
                [one.time for one in near], [one.bend for one in near],
            )
        )  # fmt: skip
        best = int(np.argmax(value))
        rest = order[_CANDIDATES:]
        upper = np.append(value + error, size[rest] + trace.error[rest]).max() - value[best]
        away = 2.0 * np.sqrt(2.0 * upper / bend[best]) if bend[best] > 0.0 else np.inf
        place, level = time[best], np.flatnonzero(size >= (1.0 - _HELD) * value[best])
        if len(level) > 2 and level[2] == level[0] + 2:
            place = trace.time[level[0]]
        found.append((value[best], upper, place, min(away, run.longest)))
    return Peaks(*np.array(found).T)


class Windows(NamedTuple):
    """Windows of time (v,) in s: their middles by the angle, beginnings and ends."""

    middle: FloatArray
    begin: FloatArray
    end: FloatArray


#: least number of cycles of a run in which one may slide
FEWEST = 1.05


def sliding(course: Course, cycle: float, count: int = 200) -> Windows | None:
    """Windows of a cycle of `cycle` rad about each of `count` times.

    A window of a whole cycle holds every crest of a steady motion wherever it lies, so that only
    what changes from cycle to cycle moves an envelope over them.
    The times are equally spaced, the first and last half a cycle from the ends of the run. Where
    more than a cycle lies between two, the window holds as many whole cycles as lie between them,
    so that nothing is left out. None if the run has hardly a cycle or less.
    """
    first, last = course.angle[[0, -1]].astype(float)
    if last - first < FEWEST * cycle:
        return None
    reach = 0.5 * cycle
    for _ in range(2):
        start, stop = course.time_of(np.array([first + reach, last - reach])).tolist()
        middle = np.linspace(start, stop, count)
        angle = course.at(middle)[1]
        cycles = np.ceil(np.max(np.diff(angle), initial=0.0) / cycle - _CLOSE)
        reach = max(reach, 0.5 * cycle * cycles)
    return Windows(middle, course.time_of(angle - reach), course.time_of(angle + reach))


def extremes(trace: Trace, begin: FloatArray, end: FloatArray) -> tuple[FloatArray, ...]:
    """Lowest and highest values (v,) between times (v,) of the trace, and their error."""
    first, last = np.searchsorted(trace.time, begin), np.searchsorted(trace.time, end, "right")
    high, upper = (_largest(one, first, last) for one in (trace.value, trace.value + trace.error))
    low, under = (_largest(one, first, last) for one in (-trace.value, trace.error - trace.value))
    return -low, high, np.maximum(upper - high, under - low)


def _largest(value: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Largest of value[first[i]:last[i]] (v,), none of them empty."""
    ends = np.stack([first, last], axis=1).ravel()
    largest: FloatArray = np.maximum.reduceat(np.append(value, -np.inf), ends)[::2]
    return largest


class Swing(NamedTuple):
    """Half range in N m and the time in s midway between crest and trough, each with an error."""

    half_range: Any
    error: Any
    time: Any
    time_error: Any


def largest_swings(
    run: TransientRun, seen: list[Trace], cycle: float, span: tuple[float, float]
) -> Swing:
    """Per section (e,) the largest half range over a cycle of `cycle` rad that begins anywhere.

    Within a `span` of time in s, whose ends are times of the traces. That of a crest and a trough
    no more than a cycle apart, or, of a torque that swings slowly, of the two ends of a cycle.
    """
    ends = run.course.at(np.array(span))[1]
    count = max(0, int(np.ceil((ends[1] - ends[0]) / cycle - 1.0 - _CLOSE)))
    begins = np.linspace(ends[0], max(ends[1] - cycle, ends[0]), count + 1)

    @cache
    def apart(window: int) -> tuple[FloatArray, list[tuple[FloatArray, FloatArray]]]:
        """Times midway and half differences of values a cycle apart, by section, with errors."""
        angle = np.linspace(begins[window], begins[window + 1], _OF_CYCLE + 1)
        times = run.course.time_of(np.stack([angle, angle + cycle]))
        near = traces(run, times, between=(times[0, 0], times[1, -1]))
        places = [np.searchsorted(one.time, times) for one in near]
        return times.mean(axis=0), [
            (0.5 * np.diff(one.value[at], axis=0)[0], 0.5 * one.error[at].sum(axis=0))
            for one, at in zip(near, places, strict=True)
        ]

    found = []
    for section, trace in enumerate(seen):
        inside = (trace.time >= span[0]) & (trace.time <= span[1])
        points = Trace(*(one[inside] for one in trace))
        angle, value = run.course.at(points.time)[1], points.value
        swing = _within_a_cycle(points, angle, cycle * (1.0 + _CLOSE))
        # the torque between two points in turn lies between their values
        first = np.searchsorted(angle, begins[:-1]) - 1
        last = np.searchsorted(angle, begins[1:] + cycle) + 1
        first, last = np.maximum(first, 0), np.minimum(last, len(angle))
        most = 0.5 * (_largest(value, first, last) + _largest(-value, first, last))
        for window in np.argsort(-most, kind="stable"):
            if most[window] <= swing.half_range:
                break
            middle, sections = apart(int(window))
            gap, doubt = sections[section]
            _, place, height, uncertainty, _ = turns(gap[:, None])
            top = int(np.argmax(np.abs(height)))
            if abs(height[top]) > swing.half_range:
                at, step = place[top], middle[1] - middle[0]
                when = float(np.interp(at, np.arange(len(middle)), middle))
                slack = float(uncertainty[top] + np.max(doubt))
                swing = Swing(float(abs(height[top])), slack, when, float(step))
        found.append(swing)
    return Swing(*np.array(found).T)


def _within_a_cycle(points: Trace, angle: FloatArray, reach: float) -> Swing:
    """That of points which the crank, at angles (r,), passes within `reach` rad."""
    time, value, error, bend = points
    first = np.searchsorted(angle, angle - reach)
    last = np.searchsorted(angle, angle + reach, "right")
    half = 0.5 * (value + _largest(-value, first, last))
    upper = 0.5 * (value + error + _largest(error - value, first, last))
    top = int(np.argmax(half))
    slack = float(np.max(upper) - half[top])
    # what reaches as high within the errors may be the highest
    rival = np.append(top, np.flatnonzero(upper >= half[top] - slack))
    spans = zip(first[rival], last[rival], strict=True)
    partner = np.array([a + np.argmin(value[a:b]) for a, b in spans])
    middle, pair = 0.5 * (time[rival] + time[partner]), np.array([top, partner[0]])
    flat = np.sqrt(2.0 * error[pair] / np.where(bend[pair] > 0.0, bend[pair], np.inf))
    off = float(np.max(np.abs(middle - middle[0])) + flat.sum())
    return Swing(float(half[top]), slack, float(middle[0]), off)


# ----------------------------------------------------------------------------
# Orders and frequencies of a section's torque in a window that slides along a run.
# ----------------------------------------------------------------------------


def window_amplitudes(
    axis: FloatArray, value: FloatArray, rate: FloatArray, middle: float, width: float
) -> tuple[ComplexArray, FloatArray]:
    """Complex amplitudes (m,), 0-to-peak, of values (k,) in a Hann window, and their errors.

    On an axis (k,): the crank angle in rad, with orders as `rate` (m,), or the time in s, with
    frequencies in rad/s. An amplitude A stands for Re(A exp(i rate axis)). A rate further than
    4 pi / width from another one adds little to it. The error is what samples twice as far apart
    change: the sums stand for integrals; that of the samples themselves is not in it.
    Raises NumericalFailure for a window that is not full.
    """
    near = np.flatnonzero(np.abs(axis - middle) < 0.5 * width)
    if near.size < 16:
        raise NumericalFailure("a window of the waterfall holds fewer than 16 points")
    # one more on each side, where the window is zero, for the spacing at its ends
    some = slice(max(int(near[0]) - 2, 0), int(near[-1]) + 3)
    every, second = (
        _window(axis[some][::step], value[some][::step], rate, middle, width) for step in (1, 2)
    )
    return every, np.abs(every - second)


def _window(
    axis: FloatArray, value: FloatArray, rate: FloatArray, middle: float, width: float
) -> ComplexArray:
    """Amplitudes (m,) of samples in one window."""
    inside = np.abs(axis - middle) < 0.5 * width
    x = axis[inside]
    weight = np.gradient(axis)[inside] * (1.0 + np.cos(2.0 * np.pi * (x - middle) / width))
    if abs(weight.sum() - width) > 0.05 * width:
        raise NumericalFailure("a window of the waterfall reaches beyond the course")
    signal = weight * value[inside] / weight.sum()
    turned = np.exp(-1j * rate[:, None] * x)
    amplitude: ComplexArray = np.where(rate == 0.0, 1.0, 2.0) * (turned @ signal)
    return amplitude


# ----------------------------------------------------------------------------
# Cycles of reversals by the rainflow method of ASTM E1049-85, 5.4.4, and their table.
# ----------------------------------------------------------------------------


class Cycles(NamedTuple):
    """c cycles: `range` and `mean` (c,) in N m, `number` (c,) 1 or 1/2, `error` (c,) of the range.

    A range is crest less trough, twice the amplitude.
    """

    range: FloatArray
    mean: FloatArray
    number: FloatArray
    error: FloatArray


def rainflow_cycles(value: FloatArray, error: FloatArray, ignore: float = 0.0) -> Cycles:
    """Cycles of a trace (r,); those below the share `ignore` of the largest range are left out."""
    from rainflow import extract_cycles

    rows = np.array(list(extract_cycles(value)), dtype=float).reshape(-1, 5)
    ends = rows[:, 3:].astype(np.int64)
    off = error[ends].sum(axis=1)
    kept = rows[:, 0] >= ignore * np.max(rows[:, 0], initial=0.0)
    kept &= rows[:, 0] > 0.0
    return Cycles(rows[kept, 0], rows[kept, 1], rows[kept, 2], off[kept])


class RangeTable(NamedTuple):
    """b equal bins up to the largest range: upper `range` (b,) and `mean` (b,) in N m, `number`.

    The mean is that of the cycles of a bin, weighted by their numbers, 0 where there are none;
    `number` (b,) has the `error` (b,) of the cycles that are as near to a border as they are
    uncertain; `mean_error` is in N m.
    """

    range: FloatArray
    mean: FloatArray
    number: FloatArray
    error: FloatArray
    mean_error: float


def range_table(cycles: Cycles, bins: int) -> RangeTable:
    """Numbers and means of cycles by their ranges."""
    top = float(np.max(cycles.range, initial=0.0))
    if top == 0.0:
        none = np.zeros(bins)
        return RangeTable(none, none, none, none, 0.0)
    edges = np.append(top * np.arange(1, bins) / bins, top)
    place = np.searchsorted(edges[:-1], cycles.range, side="left")
    number = np.bincount(place, cycles.number, bins).astype(float)
    total = np.bincount(place, cycles.number * cycles.mean, bins)
    mean = total / np.where(number > 0.0, number, 1.0)
    # the largest defines the borders, and moves them all by its own error
    slack = cycles.error + float(cycles.error[np.argmax(cycles.range)])
    near = np.abs(cycles.range[:, None] - edges[:-1]) <= slack[:, None]
    unsure = near.T @ cycles.number
    error = np.append(unsure, 0.0) + np.append(0.0, unsure)
    moved = np.abs(cycles.mean).max() if np.any(unsure) else 0.0
    return RangeTable(edges, mean, number, error, float(moved + np.max(cycles.error)))


# ----------------------------------------------------------------------------
# Fatigue: the share of a life that cycles use up.
# ----------------------------------------------------------------------------


class Strength(NamedTuple):
    """An S-N line: N = cycles (amplitude / a)^slope for amplitudes a from `amplitude` on.

    Below it the exponent is `slope_below`, infinite for no damage at all.
    """

    amplitude: float
    cycles: float
    slope: float
    slope_below: float


def slope_below(slope: float, rule: str) -> float:
    """Exponent below the knee: "elementary", "haibach" (Haibach 1970: 2 k - 1) or "original"."""
    return {"elementary": slope, "haibach": 2.0 * slope - 1.0, "original": np.inf}[rule]


def miner_sum(cycles: Cycles, strength: Strength) -> tuple[float, float]:
    """Sum of n / N over cycles with its error, both absolute (Palmgren 1924, Miner 1945).

    Amplitudes are half of the ranges, in the unit of the line; means do not count.
    """
    amplitude = 0.5 * cycles.range
    share = amplitude / strength.amplitude
    above = share >= 1.0
    exponent = np.where(above, strength.slope, strength.slope_below)
    lasting = np.isfinite(exponent)
    power = np.where(lasting, share ** np.where(lasting, exponent, 1.0), 0.0)
    damage = cycles.number * power / strength.cycles
    doubt = 0.5 * cycles.error / np.where(amplitude > 0.0, amplitude, 1.0)
    steepest = np.where(lasting, exponent, 0.0)
    error = damage * (np.expm1(steepest * np.log1p(doubt)))
    # a cycle at the knee, on either side of it
    close = np.abs(share - 1.0) <= doubt
    error = error + np.where(close & ~lasting, cycles.number / strength.cycles, 0.0)
    return float(damage.sum()), float(error.sum() + 1e-13 * damage.sum())


def equivalent_number(cycles: Cycles, strength: Strength) -> tuple[float, float]:
    """Cycles of the largest range that use up as much as all together, with its error.

    Zero where the largest does no damage.
    """
    if not np.any(cycles.range > 0.0):
        return 0.0, 0.0
    top = [int(np.argmax(cycles.range))]
    largest = Cycles(*(part[top] for part in cycles))._replace(number=np.ones(1))
    (damage, error), (of_one, off) = (miner_sum(one, strength) for one in (cycles, largest))
    if of_one == 0.0:
        return 0.0, 0.0
    number = damage / of_one
    return number, (error + number * off) / of_one
