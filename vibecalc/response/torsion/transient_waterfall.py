"""Orders and frequencies of a section's torque in a window that slides along a run."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import speed_at, turned_after
from vibecalc.response.torsion.transient_peaks import look, points_in
from vibecalc.response.torsion.transient_step import Propagator, propagator


class TimeCourse(NamedTuple):
    """Values (k, e) at times (k,) in s, with the crank's angle in rad and speed in rad/s (k,)."""

    time: FloatArray
    angle: FloatArray
    speed: FloatArray
    value: FloatArray


class Waterfall(NamedTuple):
    """`amplitude` (v, m) complex 0-to-peak at `time`, `speed` (v,) for `rate` (m,).

    A rate is an order, or a frequency in rad/s. `error` (v, m) is what samples twice as far apart
    change: the sums stand for integrals. The error of the samples themselves is not in it.
    """

    time: FloatArray
    speed: FloatArray
    rate: FloatArray
    amplitude: ComplexArray
    error: FloatArray


def time_course(
    run: TransientRun, start: float, end: float, of: str = "torque", finer: int = 1,
    known: dict[tuple[float, int], Propagator] | None = None,
) -> TimeCourse:  # fmt: skip
    """Section torques in N m (of="twist": twists in rad) at all times of the first look.

    `finer` times as many where that is more than one. `known` keeps the propagators for the next
    call with the same run and `of`.
    """
    view = run.system.torque if of == "torque" else run.system.twist
    times, values, angles = [], [], []
    for number, piece in enumerate(run.pieces):
        since = float(run.borders.time[piece.stretch]) + piece.offset
        first = int(np.clip(np.floor((start - since) / piece.step), 0, piece.steps))
        last = int(np.clip(np.ceil((end - since) / piece.step), 0, piece.steps))
        if last <= first:
            continue
        parts = points_in(run, number) * finer
        if known is None:
            known = {}
        if (piece.step, parts) not in known:
            known[piece.step, parts] = propagator(run.system, piece.step, parts, view)
        tool = known[piece.step, parts]
        inner = look(run, number, tool, np.arange(first, last), view)[:, :-1]
        passed = piece.step * (np.arange(first * parts, last * parts) / parts)
        own = piece.offset + passed
        begin = float(run.borders.angle[piece.stretch]), float(run.borders.speed[piece.stretch])
        times.append(since + passed)
        angles.append(begin[0] + turned_after(run.stretches[piece.stretch], begin[1], own))
        values.append(inner.reshape(-1, inner.shape[2]))
    if not times:
        raise NumericalFailure(f"no part of the run lies between {start:.6g} and {end:.6g} s")
    if end >= run.borders.time[-1]:
        times.append(run.borders.time[-1:])
        angles.append(run.borders.angle[-1:].astype(float))
        values.append((run.states[-1][-1] @ view.T)[None])
    time = np.concatenate(times)
    kept = (time >= start) & (time <= end)
    speed = speed_at(run.stretches, run.borders, time)
    return TimeCourse(
        time[kept], np.concatenate(angles)[kept], speed[kept], np.concatenate(values)[kept]
    )


def order_waterfall(
    found: TimeCourse, section: int, order: FloatArray, centre: FloatArray, turns: float
) -> Waterfall:
    """Complex amplitudes of orders (m,) in Hann windows of `turns` turns about times `centre` (v,).

    An amplitude A stands for Re(A exp(i q theta)). An order further than 2 / turns from q adds
    little to it.
    """
    place = angle_between(found, np.asarray(centre, dtype=float))
    return slide(found, section, order, centre, found.angle, place, 2.0 * np.pi * turns)


def angle_between(found: TimeCourse, time: FloatArray) -> FloatArray:
    """Crank angles (v,) between the samples, from angles and speeds: exact where jerk is even."""
    first = np.clip(np.searchsorted(found.time, time, side="right") - 1, 0, found.time.size - 2)
    width = found.time[first + 1] - found.time[first]
    u = (time - found.time[first]) / width
    low, high = (width * found.speed[first + side] for side in (0, 1))
    turned = found.angle[first + 1] - found.angle[first]
    way = u * (low + u * (3.0 * turned - 2.0 * low - high + u * (low + high - 2.0 * turned)))
    angle: FloatArray = found.angle[first] + way
    return angle


def frequency_waterfall(
    found: TimeCourse, section: int, frequency: FloatArray, centre: FloatArray, width: float
) -> Waterfall:
    """The same for frequencies (m,) in rad/s in windows of `width` s; phases at time zero."""
    at = np.asarray(centre, dtype=float)
    return slide(found, section, frequency, at, found.time, at, width)


def slide(
    found: TimeCourse, section: int, rate: FloatArray, centre: FloatArray,
    axis: FloatArray, place: FloatArray, width: float,
) -> Waterfall:  # fmt: skip
    """Windows of `width` about `place` (v,) on an axis (k,), either angle or time."""
    rate, centre = np.asarray(rate, dtype=float), np.asarray(centre, dtype=float)
    out = np.zeros((2, centre.size, rate.size), dtype=complex)
    value = found.value[:, section]
    for row, middle in enumerate(place):
        inside = np.flatnonzero(np.abs(axis - middle) < 0.5 * width)
        if inside.size < 16:
            raise NumericalFailure("a window of the waterfall holds fewer than 16 points")
        # one more on each side, where the window is zero, for the spacing at its ends
        some = slice(max(int(inside[0]) - 2, 0), int(inside[-1]) + 3)
        for which, every in enumerate((1, 2)):
            out[which, row] = _window(
                axis[some][::every], value[some][::every], rate, middle, width
            )
    speed = np.interp(centre, found.time, found.speed)
    return Waterfall(centre, speed, rate, out[0], np.abs(out[0] - out[1]))


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
