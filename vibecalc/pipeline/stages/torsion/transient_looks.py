"""Adapter, continued: the course of the worst section about its peak, and its waterfalls."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.pipeline.entries.torsion_studies import TRANSIENT
from vibecalc.pipeline.scene import Scene
from vibecalc.pipeline.stages.torsion.setup import Setup
from vibecalc.response.torsion.transient_march import TransientRun
from vibecalc.response.torsion.transient_motion import angle_at, speed_at
from vibecalc.response.torsion.transient_step import Propagator
from vibecalc.response.torsion.transient_waterfall import (
    TimeCourse,
    frequency_waterfall,
    order_waterfall,
    time_course,
)

_WINDOWS, _FREQUENCIES = 60, 160
#: turns of a window of orders: halves are told apart
_TURNS = 8.0
#: turns on both sides of the peak, and points that are kept of them
_ABOUT, _POINTS = 6.0, 3000
_TABLE = 20001
#: radians of the fastest that is there between two points of a waterfall
_RADIANS = 1.0


def emit_looks(scene: Scene, setup: Setup, run: TransientRun, section: int) -> None:
    """Course and waterfalls of one section, counted from 0."""
    times = np.linspace(0.0, float(run.borders.time[-1]), _TABLE)
    angles = angle_at(run.stretches, run.borders, times)
    ratio = float(setup.shaft.section_ratio[section])
    _emit_course(scene, run, section, ratio, (times, angles))
    paths = [f"{TRANSIENT}waterfall/{name}" for name in ("speed", "order", "frequency")]
    if not scene.wants(*paths):
        return
    _emit_waterfalls(scene, setup, run, section, ratio, (times, angles))


def _emit_course(
    scene: Scene, run: TransientRun, section: int, ratio: float,
    table: tuple[FloatArray, FloatArray],
) -> None:  # fmt: skip
    times, angles = table
    when = float(scene.record[f"{TRANSIENT}peak_time"].values[section]) if (
        f"{TRANSIENT}peak_time" in scene.record.quantities
    ) else float(times[-1])  # fmt: skip
    middle, reach = float(np.interp(when, times, angles)), 2.0 * np.pi * _ABOUT
    start, end = (float(np.interp(middle + s * reach, angles, times)) for s in (-1.0, 1.0))
    found = time_course(run, start, max(end, start + 1e-9))
    every = max(1, -(-len(found.time) // _POINTS))
    value = found.value[::every, section] / ratio
    error = run.torque_error[section] / abs(ratio)
    axes = {"course_time": found.time[::every]}
    scene.emit(f"{TRANSIENT}course/torque", value, error, axes)


def _thinned(found: TimeCourse, longest: float) -> TimeCourse:
    """Every so many-th point, no two further apart than `longest` s (or as far as they are)."""
    every = max(1, int(longest / float(np.max(np.diff(found.time)))))
    return TimeCourse(*(part[::every] for part in found))


def _emit_waterfalls(
    scene: Scene, setup: Setup, run: TransientRun, section: int, ratio: float,
    table: tuple[FloatArray, FloatArray],
) -> None:  # fmt: skip
    times, angles = table
    order = setup.drive.order
    total, whole = float(times[-1]), float(angles[-1])
    turns = min(_TURNS, whole / (2.0 * np.pi) / 2.5)
    reach = 0.5 * 2.0 * np.pi * turns * 1.02
    fastest = float(run.borders.speed.max())
    natural = setup.modes.frequency
    top = min(float(order[-1]) * fastest, 1.15 * float(natural[-1]))
    frequency = np.linspace(0.0, top, _FREQUENCIES)
    width = min(4.0 * np.pi / (frequency[1] - frequency[0]), total / 6.0)
    first = max(float(np.interp(angles[0] + reach, angles, times)), 0.52 * width)
    last = min(float(np.interp(angles[-1] - reach, angles, times)), total - 0.52 * width)
    centre = np.linspace(first, last, _WINDOWS)
    limit = _RADIANS / max(float(order[-1]) * fastest, float(natural[-1]))
    of_order = np.empty((_WINDOWS, len(order)), dtype=complex)
    of_frequency = np.empty((_WINDOWS, _FREQUENCIES), dtype=complex)
    sums, known = np.zeros(2), dict[tuple[float, int], Propagator]()
    for row, when in enumerate(centre):
        place = float(np.interp(when, times, angles))
        ends = [float(np.interp(place + s * reach, angles, times)) for s in (-1.0, 1.0)]
        low, high = min(ends[0], when - 0.51 * width), max(ends[1], when + 0.51 * width)
        near = time_course(run, max(low, 0.0), min(high, total), known=known)
        found = _thinned(near, limit)
        at = np.array([when])
        by_order = order_waterfall(found, section, order, at, turns)
        by_frequency = frequency_waterfall(found, section, frequency, at, width)
        of_order[row], of_frequency[row] = by_order.amplitude[0], by_frequency.amplitude[0]
        sums = np.maximum(sums, [by_order.error.max(), by_frequency.error.max()])
    speed = speed_at(run.stretches, run.borders, centre)
    axes = {"waterfall_time": centre, "half_order": order, "waterfall_frequency": frequency}
    scene.emit(f"{TRANSIENT}waterfall/speed", speed, 8.0 * EPSILON * fastest, axes)
    # a mean of values, so that what the values are off adds no more than theirs
    error = (2.0 * run.torque_error[section] + sums) / abs(ratio)
    scene.emit(f"{TRANSIENT}waterfall/order", of_order / ratio, float(error[0]), axes)
    scene.emit(f"{TRANSIENT}waterfall/frequency", of_frequency / ratio, float(error[1]), axes)
