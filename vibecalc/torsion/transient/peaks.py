"""What a section sees along a run: envelope, true maxima, time history, waterfall."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import ComplexArray, FloatArray, IntArray
from vibecalc.torsion.transient.march import Propagator, TransientRun, inside, propagator
from vibecalc.torsion.transient.motion import speed_at, turned_after

# ----------------------------------------------------------------------------
# Envelope and true maxima of section torques or twists along a run.
#
# Every step is sampled at several points; in each window of time the steps with the highest
# (and lowest) peaks among them are sampled again with finer ones, and a polynomial through
# five of these gives the extreme value. States inside a step are as exact as those at its ends.
# ----------------------------------------------------------------------------

#: points in a step: bounds of the first sampling, and of the second per point of the first
FEWEST_POINTS, MOST_POINTS, SECOND_SAMPLING = 6, 36, 8

#: steps of a window that are sampled a second time
CANDIDATES = 3

#: radians of the fastest mode between two points of the first sampling
SAMPLE_STEP = 1.0 / 3.0

#: propagators held at once
MOST_TOOLS = 400

#: states held at once
CHUNK = 2_000_000


class Envelope(NamedTuple):
    """v windows of time, e sections: `low`, `high` (v, e) in N m (or rad) with `error` (v, e).

    `time` (v + 1,) are the borders in s, `time_low`, `time_high` (v, e) where the extremes lie,
    `speed` (v,) in rad/s the crank's in the middle of each window.
    """

    time: FloatArray
    speed: FloatArray
    low: FloatArray
    high: FloatArray
    error: FloatArray
    time_low: FloatArray
    time_high: FloatArray


def points_in(run: TransientRun, block: int) -> int:
    """How many points of a step of that block the first sampling takes."""
    data = run.blocks[block]
    part = run.stretches[data.stretch]
    rate = 0.0 if part.in_time is None else part.in_time.fastest
    wanted = max(run.system_of(data).fastest, rate) * data.step / SAMPLE_STEP
    return int(np.clip(np.ceil(wanted), FEWEST_POINTS, MOST_POINTS))


def step_values(
    run: TransientRun, block: int, tool: Propagator, steps: IntArray, view: FloatArray
) -> FloatArray:
    """Values (steps, parts + 1, e) at the start and the parts of steps of a block.

    `tool` is the propagator of that block's step to its parts, with the same `view` (e, s).
    """
    data, size, parts = run.blocks[block], view.shape[1], tool.transition.shape[0]
    part, law = run.stretches[data.stretch], run.laws[data.stretch]
    values = np.empty((steps.size, parts + 1, view.shape[0]))
    batch = max(1, CHUNK // (parts * size + 10 * 2 * law.power.size))
    for first in range(0, steps.size, batch):
        some = steps[first : first + batch]
        begin = run.states[block][some]
        values[first : first + batch, 0] = begin @ view.T
        values[first : first + batch, 1:] = inside(data, law, part, run.borders, tool, begin, some)
    return values


def envelope(run: TransientRun, windows: int = 200, of: str = "torque") -> Envelope:
    """Envelope of section torques (or of="twist") over equal windows of time.

    A step belongs to the window in which it begins; a window in which none begins takes over the
    value of the one before.
    """
    base = run.torque_error if of == "torque" else run.twist_error
    borders = np.linspace(0.0, run.borders.time[-1], windows + 1)
    e = base.size
    known: dict[tuple[int, float, int], tuple[Propagator, Propagator]] = {}
    best = {sign: np.full((windows, e), -np.inf) for sign in (1, -1)}
    when = {sign: np.zeros((windows, e)) for sign in (1, -1)}
    uncertainty = np.zeros((windows, e))
    for number, block in enumerate(run.blocks):
        parts = points_in(run, number)
        steps = np.arange(block.steps)
        system = run.system_of(block)
        view = system.torque if of == "torque" else system.twist
        key = (id(system), block.step, parts)
        if key not in known:
            if len(known) >= MOST_TOOLS:
                known.clear()
            known[key] = (
                propagator(system, block.step, parts, view),
                propagator(system, block.step, parts * SECOND_SAMPLING, view),
            )
        rough_tool, fine_tool = known[key]
        first = step_values(run, number, rough_tool, steps, view)
        since = run.borders.time[block.stretch] + block.offset
        start = since + block.step * steps
        window = np.clip(np.searchsorted(borders, start, side="right") - 1, 0, windows - 1)
        cuts = np.concatenate([[0], np.flatnonzero(np.diff(window)) + 1])
        ends = np.concatenate([cuts[1:], [block.steps]])
        rows = window[cuts]
        for sign in (1, -1):
            rough = peak(sign * first)[0]
            chosen, rival = candidates(rough, cuts, ends)
            unique, place = np.unique(chosen, return_inverse=True)
            place, section = place.reshape(chosen.shape), np.arange(e)
            value, share, error = peak(sign * step_values(run, number, fine_tool, unique, view))
            fine = value[place, section]
            # a step left out may rise above its first samples as much as one that was sampled twice
            refinement = np.abs(fine - np.take_along_axis(rough[:, None], chosen, axis=0)).max(
                axis=1
            )
            winner = fine.argmax(axis=1)[:, None]
            new = np.take_along_axis(fine, winner, axis=1)[:, 0]
            step = np.take_along_axis(chosen, winner, axis=1)[:, 0]
            at = np.take_along_axis(place, winner, axis=1)[:, 0]
            better = new > best[sign][rows]
            moment = start[step] + block.step * share[at, section]
            when[sign][rows] = np.where(better, moment, when[sign][rows])
            best[sign][rows] = np.maximum(best[sign][rows], new)
            place_error = error[at, section] + np.maximum(rival + refinement - new, 0.0)
            uncertainty[rows] = np.maximum(uncertainty[rows], place_error)
    for sign in (1, -1):
        fill_empty(best[sign], when[sign])
    middle = 0.5 * (borders[:-1] + borders[1:])
    speed = speed_at(run.stretches, run.borders, middle)
    return Envelope(borders, speed, -best[-1], best[1], uncertainty + base, when[-1], when[1])


def peak(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Largest value (r, e) of samples (r, points, e), its place as a share, and its error.

    The peak of the polynomial of fourth degree through five points about the largest sample,
    found by Newton steps from that of the parabola through three. The error is a quarter of what
    the two differ by, with a share of the fourth difference in case that they meet by chance.
    """
    last = values.shape[1] - 1
    index = values.argmax(axis=1)

    def at(place: IntArray) -> FloatArray:
        return np.take_along_axis(values, place[:, None], axis=1)[:, 0]

    sample, near = at(index), np.clip(index, 1, last - 1)
    left, middle, right = at(near - 1), at(near), at(near + 1)
    bend = 2.0 * middle - left - right
    safe = np.where(bend > 0.0, bend, 1.0)
    move = np.where(bend > 0.0, np.clip(0.5 * (right - left) / safe, -1.0, 1.0), 0.0)
    parabola = middle + 0.5 * move * (right - left) - 0.5 * move**2 * bend

    centre = np.clip(index, 2, last - 2)
    odd, odd_far = at(centre + 1) - at(centre - 1), at(centre + 2) - at(centre - 2)
    even, even_far = at(centre + 1) + at(centre - 1), at(centre + 2) + at(centre - 2)
    at_centre = at(centre)
    fourth = even_far - 4.0 * even + 6.0 * at_centre
    c1, c2 = (8.0 * odd - odd_far) / 12.0, (16.0 * even - even_far - 30.0 * at_centre) / 24.0
    c3, c4 = (odd_far - 2.0 * odd) / 12.0, fourth / 24.0
    u = near + move - centre
    for _ in range(3):
        slope = c1 + u * (2.0 * c2 + u * (3.0 * c3 + u * 4.0 * c4))
        curve = 2.0 * c2 + u * (6.0 * c3 + u * 12.0 * c4)
        down = curve < 0.0
        u = np.clip(u - np.where(down, slope / np.where(down, curve, 1.0), 0.0), -2.0, 2.0)
    value = at_centre + u * (c1 + u * (c2 + u * (c3 + u * c4)))
    share = np.where(value > sample, centre + u, index) / last
    value = np.maximum(value, sample)
    error = np.abs(value - np.maximum(parabola, sample)) / 4.0 + np.abs(fourth) / 64.0
    return value, share, error


def candidates(rough: FloatArray, cuts: IntArray, ends: IntArray) -> tuple[IntArray, FloatArray]:
    """The most promising steps of each window (windows, c, e) and the best of the others.

    `rough` (count, e) are the peaks of the first sampling; `cuts` and `ends` bound the windows. A
    window of few steps has some of them twice, and no other (minus infinity).
    """
    chosen = np.empty((cuts.size, CANDIDATES, rough.shape[1]), dtype=np.int64)
    rival = np.full((cuts.size, rough.shape[1]), -np.inf)
    for row, (a, b) in enumerate(zip(cuts, ends, strict=True)):
        if b - a <= CANDIDATES:
            chosen[row] = np.minimum(a + np.arange(CANDIDATES), b - 1)[:, None]
            continue
        ranked = np.argpartition(-rough[a:b], (CANDIDATES - 1, CANDIDATES), axis=0)
        chosen[row] = a + ranked[:CANDIDATES]
        rival[row] = np.take_along_axis(rough[a:b], ranked[CANDIDATES][None], axis=0)[0]
    return chosen, rival


def fill_empty(best: FloatArray, when: FloatArray) -> None:
    """Windows in which no step begins take the values of the one before, in place."""
    for row in range(1, best.shape[0]):
        if np.isneginf(best[row]).any():
            best[row], when[row] = best[row - 1], when[row - 1]


# ----------------------------------------------------------------------------
# Orders and frequencies of a section's torque in a window that slides along a run.
# ----------------------------------------------------------------------------


#: propagators to the parts of a step, by system, step and number of parts
KnownTools = dict[tuple[int, float, int], Propagator]


class SectionHistory(NamedTuple):
    """Values (k, e) at times (k,) in s, with the crank's angle in rad and speed in rad/s (k,)."""

    time: FloatArray
    angle: FloatArray
    speed: FloatArray
    value: FloatArray


def section_history(
    run: TransientRun, start: float, end: float, of: str = "torque", finer: int = 1,
    known: "KnownTools | None" = None,
) -> SectionHistory:  # fmt: skip
    """Section torques in N m (of="twist": twists in rad) at all times of the first sampling.

    `finer` times as many where that is more than one. `known` keeps the propagators for the next
    call with the same run and `of`.
    """
    times, values, angles = [], [], []
    for number, block in enumerate(run.blocks):
        since = float(run.borders.time[block.stretch]) + block.offset
        first = int(np.clip(np.floor((start - since) / block.step), 0, block.steps))
        last = int(np.clip(np.ceil((end - since) / block.step), 0, block.steps))
        if last <= first:
            continue
        parts = points_in(run, number) * finer
        system = run.system_of(block)
        view = system.torque if of == "torque" else system.twist
        if known is None:
            known = {}
        key = (id(system), block.step, parts)
        if key not in known:
            if len(known) >= MOST_TOOLS:
                known.clear()
            known[key] = propagator(system, block.step, parts, view)
        tool = known[key]
        inner = step_values(run, number, tool, np.arange(first, last), view)[:, :-1]
        passed = block.step * (np.arange(first * parts, last * parts) / parts)
        since_start = block.offset + passed
        begin = float(run.borders.angle[block.stretch]), float(run.borders.speed[block.stretch])
        times.append(since + passed)
        angles.append(begin[0] + turned_after(run.stretches[block.stretch], begin[1], since_start))
        values.append(inner.reshape(-1, inner.shape[2]))
    if not times:
        raise NumericalFailure(f"no part of the run lies between {start:.6g} and {end:.6g} s")
    if end >= run.borders.time[-1]:
        ending = run.system_of(run.blocks[-1])
        view = ending.torque if of == "torque" else ending.twist
        times.append(run.borders.time[-1:])
        angles.append(run.borders.angle[-1:].astype(float))
        values.append((run.states[-1][-1] @ view.T)[None])
    time = np.concatenate(times)
    within = (time >= start) & (time <= end)
    speed = speed_at(run.stretches, run.borders, time)
    return SectionHistory(
        time[within], np.concatenate(angles)[within], speed[within], np.concatenate(values)[within]
    )


def angle_between(history: SectionHistory, time: FloatArray) -> FloatArray:
    """Crank angles (v,) between the samples, from angles and speeds: exact where jerk is even."""
    first = np.clip(np.searchsorted(history.time, time, side="right") - 1, 0, history.time.size - 2)
    width = history.time[first + 1] - history.time[first]
    u = (time - history.time[first]) / width
    low, high = (width * history.speed[first + side] for side in (0, 1))
    turned = history.angle[first + 1] - history.angle[first]
    turned_on = u * (low + u * (3.0 * turned - 2.0 * low - high + u * (low + high - 2.0 * turned)))
    angle: FloatArray = history.angle[first] + turned_on
    return angle


def order_window(
    history: SectionHistory, section: int, order: FloatArray, centre: float, turns: float
) -> tuple[ComplexArray, FloatArray]:
    """Complex amplitudes of orders (m,), 0-to-peak, in a Hann window of `turns` turns, and errors.

    About the time `centre`. An amplitude A stands for Re(A exp(i q theta)). An order further than
    2 / turns from q adds little to it. The error is what samples twice as far apart change: the
    sums stand for integrals; that of the samples themselves is not in it.
    """
    place = float(angle_between(history, np.array([centre]))[0])
    return _both(history.angle, history.value[:, section], order, place, 2.0 * np.pi * turns)


def frequency_window(
    history: SectionHistory, section: int, frequency: FloatArray, centre: float, width: float
) -> tuple[ComplexArray, FloatArray]:
    """The same for frequencies (m,) in rad/s in a window of `width` s; phases at time zero."""
    return _both(history.time, history.value[:, section], frequency, centre, width)


def _both(
    axis: FloatArray, value: FloatArray, rate: FloatArray, middle: float, width: float
) -> tuple[ComplexArray, FloatArray]:
    """Amplitudes (m,) in a window on an axis (k,), either angle or time, and their errors."""
    inside = np.flatnonzero(np.abs(axis - middle) < 0.5 * width)
    if inside.size < 16:
        raise NumericalFailure("a window of the waterfall holds fewer than 16 points")
    # one more on each side, where the window is zero, for the spacing at its ends
    some = slice(max(int(inside[0]) - 2, 0), int(inside[-1]) + 3)
    every, second = (
        _window(axis[some][::step], value[some][::step], rate, middle, width) for step in (1, 2)
    )
    return every, np.abs(every - second)


def _window(
    axis: FloatArray, value: FloatArray, rate: FloatArray, middle: float, width: float
) -> ComplexArray:
    """Amplitudes (m,) of samples in one Hann window. Raises NumericalFailure if it is not full."""
    inside = np.abs(axis - middle) < 0.5 * width
    x = axis[inside]
    weight = np.gradient(axis)[inside] * (1.0 + np.cos(2.0 * np.pi * (x - middle) / width))
    if abs(weight.sum() - width) > 0.05 * width:
        raise NumericalFailure("a window of the waterfall reaches beyond the course")
    signal = weight * value[inside] / weight.sum()
    turned = np.exp(-1j * rate[:, None] * x)
    amplitude: ComplexArray = np.where(rate == 0.0, 1.0, 2.0) * (turned @ signal)
    return amplitude
