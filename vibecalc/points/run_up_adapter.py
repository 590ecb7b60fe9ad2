"""Adapter: readings at the points of the body over the run-up of [isolation]."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.body_run_up import RunUpSection, sections
from vibecalc.isolation.rows import Readout
from vibecalc.isolation.run_up import RunUp, joined, run_up
from vibecalc.isolation.run_up_peaks import RunUpPeak, over_all
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.points.model import QUANTITIES, Readings, band_of, readings_of
from vibecalc.points.readings import with_rates
from vibecalc.points.results import RUN_UP
from vibecalc.points.rms_over_speed import BandRows, rms_run_up
from vibecalc.points.severity import LOWER, UPPER, severity


def run_points_run_up(scene: Scene) -> None:
    """Emit peaks over the cycle and r.m.s. values over speed, their largest and its speed."""
    readings, band = readings_of(scene.case), band_of(scene.case)
    scene.cite(
        "peak over the cycle and r.m.s. in a band at each speed, maxima refined",
        "run-up at points",
        "docs/theory_mounts.md, quasi-steady run-up",
    )
    parts = [passed(p, readings, band_rows(p, readings, band)) for p in sections(scene)]
    peaks, levels = (joined(each) for each in zip(*parts, strict=True))
    if peaks.unresolved:
        scene.warn(
            f"the run-up at the points has {peaks.unresolved} speed intervals coarser than "
            "requested, as the number of speeds is limited; its maxima are not affected"
        )
    if scene.case.vibration_severity is not None:
        levels = _with_severity(levels)
    count = len(readings.names)
    for kind, found in (("peak", peaks), ("rms", levels)):
        axes, top = {"sensor": readings.names, "speed": found.speed}, found.peak
        value, speed = Bounded(top.value, top.error), Bounded(top.speed, top.speed_error)
        names = [*(f"{name}_{kind}" for name in QUANTITIES), "severity"]
        for number in range(found.curve.shape[1] // count):
            own, path = slice(number * count, (number + 1) * count), f"{RUN_UP}/{names[number]}"
            scene.emit(path, found.curve[:, own].T, axes=axes)
            scene.emit(f"{path}_largest", value[own], axes=axes)
            scene.emit(f"{path}_largest_speed", speed[own], axes=axes)


def band_rows(part: RunUpSection, readings: Readings, band: tuple[float, float]) -> BandRows:
    """Displacements, velocities and accelerations over crank speed, with the band."""
    row = (readings.row @ part.system.reach)[:, None, :]
    readout = Readout(row.astype(complex), np.zeros(row.shape), 8.0 * UNIT_ROUNDOFF)
    kept, left_out = part.rows_of(readout, False)
    rows, beyond = with_rates(kept, part.order), with_rates(left_out, part.beyond)
    return BandRows(rows, beyond, part.order, part.beyond, part.factor, band)


def passed(part: RunUpSection, readings: Readings, counted: BandRows) -> tuple[RunUp, RunUp]:
    """Peaks over the cycle and r.m.s. values of one part of the run-up."""
    size = np.abs(readings.row @ part.system.reach @ part.system.shapes.shape).T
    shows = np.tile(size > 1e-12 * size.max(), 3)
    peaks = run_up(part.counted(counted.rows, counted.left_out, shows))
    masked = peaks.masked._replace(order=peaks.masked.order * part.step)
    return peaks, rms_run_up(counted, peaks._replace(masked=masked), shows, part.start, part.stop)


def _with_severity(found: RunUp) -> RunUp:
    """With severity behind the rows of three quantities; its largest is that of their largest."""
    top, count = found.peak, found.curve.shape[1] // 3
    whole = severity(*(found.curve[:, k * count : (k + 1) * count] for k in range(3)))
    factor = np.repeat([LOWER, 1.0, 1.0 / UPPER], count)
    value = (top.value * factor).reshape(3, count)
    error = np.where(np.isfinite(top.value), top.error * factor, 0.0).reshape(3, count).max(axis=0)
    row = np.argmax(value, axis=0) * count + np.arange(count)
    highest = RunUpPeak(np.max(value, axis=0), error, top.speed[row], top.speed_error[row])
    off = over_all(highest, lambda row: (found.speed, whole[:, row]))
    highest = highest._replace(speed_error=off.speed_error)
    peak = RunUpPeak(*(np.concatenate(pair) for pair in zip(top, highest, strict=True)))
    return found._replace(curve=concatenate([found.curve, whole]), peak=peak)
