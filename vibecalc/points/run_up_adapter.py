"""Adapter: readings at the points of the body over the run-up of [isolation]."""

from collections.abc import Sequence

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.common import RunUpSection
from vibecalc.isolation.adapters.run_up import sections
from vibecalc.isolation.rows import Readout, with_left_out
from vibecalc.isolation.run_up import RunUp, joined, run_up
from vibecalc.isolation.run_up_peaks import RunUpPeak, over_all
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray
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
        "docs/theory.md, quasi-steady run-up",
    )
    parts = [passed(p, readings, band_rows(p, readings, band)) for p in sections(scene)]
    peaks, levels = (joined(each) for each in zip(*parts, strict=True))
    if peaks.unresolved:
        scene.warn(
            f"the run-up at the points has {peaks.unresolved} intervals of speed that are coarser "
            "than asked for, since the number of speeds is capped; its maxima are not affected"
        )
    count = len(readings.names)
    for number, name in enumerate(QUANTITIES):
        own = slice(number * count, (number + 1) * count)
        for kind, found in (("peak", peaks), ("rms", levels)):
            _emit(scene, f"{name}_{kind}", readings.names, found.speed, found.curve[:, own],
                  RunUpPeak._make(part[own] for part in found.peak))  # fmt: skip
    if scene.case.vibration_severity is not None:
        _emit(scene, "severity", readings.names, levels.speed, *_severity(levels, count))


def band_rows(part: RunUpSection, readings: Readings, band: tuple[float, float]) -> BandRows:
    """Displacements, velocities and accelerations over crank speed, with the band."""
    setup = part.setup
    row = (readings.row @ setup.system.reach)[:, None, :]
    rounding = 8.0 * UNIT_ROUNDOFF
    kept = setup.rows_of(Readout(row.astype(complex), np.zeros(row.shape), rounding))
    order = setup.harmonics * setup.step
    rows, beyond = with_rates(kept.rows, order), with_rates(kept.left_out, kept.beyond)
    return BandRows(rows, beyond, order, kept.beyond, kept.factor, band)


def passed(part: RunUpSection, readings: Readings, counted: BandRows) -> tuple[RunUp, RunUp]:
    """Peaks over the cycle and r.m.s. values of one part of the run-up."""
    setup = part.setup
    size = np.abs(readings.row @ setup.system.reach @ setup.system.shapes.shape).T
    shows = np.tile(size > 1e-12 * size.max(), 3)
    peaks = run_up(
        with_left_out(
            counted.rows, counted.left_out, counted.factor, counted.beyond / setup.step
        ),
        setup.harmonics, setup.resonances, part.start, part.stop, shows,
    )  # fmt: skip
    masked = peaks.masked._replace(order=peaks.masked.order * setup.step)
    return peaks, rms_run_up(counted, peaks._replace(masked=masked), shows, part.start, part.stop)


def _emit(
    scene: Scene, name: str, sensors: Sequence[str], speed: FloatArray, curve: Bounded,
    top: RunUpPeak,
) -> None:  # fmt: skip
    found = {
        "": curve.T,
        "_largest": Bounded(top.value, top.error),
        "_largest_speed": Bounded(top.speed, top.speed_error),
    }
    results = {f"{RUN_UP}/{name}{end}": one for end, one in found.items()}
    scene.emit_all(results, {"sensor": sensors, "speed": speed})


def _severity(found: RunUp, count: int) -> tuple[Bounded, RunUpPeak]:
    """Severity over speed; its largest is the largest of what the three largest values make."""
    whole = severity(*(found.curve[:, k * count : (k + 1) * count] for k in range(3)))
    factor, top = np.repeat([LOWER, 1.0, 1.0 / UPPER], count), found.peak
    value = (top.value * factor).reshape(3, count)
    error = np.where(np.isfinite(top.value), top.error * factor, 0.0).reshape(3, count).max(axis=0)
    row = np.argmax(value, axis=0) * count + np.arange(count)
    highest = RunUpPeak(np.max(value, axis=0), error, top.speed[row], top.speed_error[row])
    off = over_all(highest, lambda rows: ((k, found.speed, whole[:, k]) for k in rows.tolist()))
    return whole, highest._replace(speed_error=off.speed_error)
