"""Orders and frequencies of a section's torque in a window that slides along a run."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import ComplexArray, FloatArray
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import speed_at, turned_after
from vibecalc.response.torsion.transient_peaks import look, points_in
from vibecalc.response.torsion.transient_step import propagator


class TimeCourse(NamedTuple):
    """Values (k, e) at times (k,) in s, with the crank's angle in rad and speed in rad/s (k,)."""

    time: FloatArray
    angle: FloatArray
    speed: FloatArray
    value: FloatArray


class Waterfall(NamedTuple):
    """`amplitude` (v, m) complex 0-to-peak at `time`, `speed` (v,) for `rate` (m,).

    A rate is an order, or a frequency in rad/s.
    """

    time: FloatArray
    speed: FloatArray
    rate: FloatArray
    amplitude: ComplexArray


def time_course(
    run: TransientRun, start: float, end: float, of: str = "torque", finer: int = 1
) -> TimeCourse:
    """Section torques in N m (of="twist": twists in rad) at all times of the first look.

    `finer` times as many where that is more than one.
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
        tool = propagator(run.system, piece.step, parts, view)
        inner = look(run, number, tool, np.arange(first, last), view)[:, :-1]
        passed = piece.step * (np.arange(first * parts, last * parts) / parts)
        own = piece.offset + passed
        begin = float(run.borders.angle[piece.stretch]), float(run.borders.speed[piece.stretch])
        times.append(since + passed)
        angles.append(begin[0] + turned_after(run.stretches[piece.stretch], begin[1], own))
        values.append(inner.reshape(-1, inner.shape[2]))
    if not times:
        raise NumericalFailure(f"no part of the run lies between {start:.6g} and {end:.6g} s")
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
    place = np.interp(centre, found.time, found.angle)
    return slide(found, section, order, centre, found.angle, place, 2.0 * np.pi * turns)


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
    out = np.zeros((centre.size, rate.size), dtype=complex)
    spacing = np.gradient(axis)
    for row, middle in enumerate(place):
        inside = np.abs(axis - middle) < 0.5 * width
        if inside.sum() < 8:
            raise NumericalFailure("a window of the waterfall holds fewer than 8 points")
        x = axis[inside]
        weight = spacing[inside] * (1.0 + np.cos(2.0 * np.pi * (x - middle) / width))
        if abs(weight.sum() - width) > 0.05 * width:
            raise NumericalFailure("a window of the waterfall reaches beyond the course")
        signal = weight * found.value[inside, section] / weight.sum()
        turned = np.exp(-1j * rate[:, None] * x)
        out[row] = np.where(rate == 0.0, 1.0, 2.0) * (turned @ signal)
    speed = np.interp(centre, found.time, found.speed)
    return Waterfall(centre, speed, rate, out)
