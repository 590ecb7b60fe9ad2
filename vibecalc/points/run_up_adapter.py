"""Adapter: readings at the points of the body over the run-up of [isolation]."""

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.common import RunUpSection
from vibecalc.isolation.adapters.run_up import sections
from vibecalc.isolation.rows import Readout, with_left_out
from vibecalc.isolation.run_up import RunUp, joined, run_up
from vibecalc.isolation.run_up_peaks import RunUpPeak, highest_of
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.maxima import top_errors
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, FloatArray
from vibecalc.points.model import QUANTITIES, Readings, band_of, readings_of
from vibecalc.points.readings import with_rates
from vibecalc.points.results import RUN_UP, SeverityInRunUp
from vibecalc.points.rms_over_speed import BandRows, RmsRunUp, rms_run_up
from vibecalc.points.severity import LOWER, UPPER, severity


def run_points_run_up(scene: Scene) -> None:
    """Emit peaks over the cycle and r.m.s. values over speed, their largest and its speed."""
    readings, band = readings_of(scene.case), band_of(scene.case)
    scene.cite(
        "peak over the cycle and r.m.s. in a band at each speed, maxima refined",
        "run-up at points",
        "docs/theory.md, quasi-steady run-up",
    )
    found = [passed(part, readings, band) for part in sections(scene)]
    peaks = joined([peak for peak, _ in found])
    if peaks.unresolved:
        scene.warn(
            f"the run-up at the points has {peaks.unresolved} intervals of speed that are coarser "
            "than asked for, since the number of speeds is capped; its maxima are not affected"
        )
    _emit(scene, readings, "peak", peaks.speed, peaks.curve, peaks.peak)
    levels = [level for _, level in found]
    speed = np.concatenate([one.speed for one in levels])
    new = np.concatenate([[True], np.diff(speed) > 0.0])
    curve = concatenate([one.curve for one in levels], axis=0)[new]
    top = highest_of([one.peak for one in levels])
    _emit(scene, readings, "rms", speed[new], curve, top)
    if scene.case.vibration_severity is not None:
        _emit_severity(scene, readings, speed[new], curve, top)


def band_rows(part: RunUpSection, readings: Readings, band: tuple[float, float]) -> BandRows:
    """Displacements, velocities and accelerations over crank speed, with the band."""
    setup, of_body = part.setup, part.setup.of_body
    row = (readings.row @ of_body.motion)[:, None, :]
    rounding = 8.0 * UNIT_ROUNDOFF
    kept = of_body.rows(Readout(row.astype(complex), np.zeros(row.shape), rounding))
    order = setup.harmonics * setup.step
    rows, beyond = with_rates(kept.rows, order), with_rates(kept.left_out, kept.beyond)
    return BandRows(rows, beyond, order, kept.beyond, kept.factor, band)


def passed(
    part: RunUpSection, readings: Readings, band: tuple[float, float]
) -> tuple[RunUp, RmsRunUp]:
    """Peaks over the cycle and r.m.s. values of one part of the run-up."""
    setup, counted = part.setup, band_rows(part, readings, band)
    size = np.abs(readings.row @ setup.of_body.modes).T
    shows = np.tile(size > 1e-12 * size.max(), 3)
    peaks = run_up(
        with_left_out(
            counted.rows, counted.left_out, counted.factor, counted.beyond / setup.step
        ),
        setup.harmonics, setup.resonances, part.start, part.stop, shows,
    )  # fmt: skip
    masked = peaks.masked._replace(order=peaks.masked.order * setup.step)
    return peaks, rms_run_up(counted, peaks.speed, masked, shows, part.start, part.stop)


def _emit(
    scene: Scene, readings: Readings, kind: str, speed: FloatArray, curve: Bounded, top: RunUpPeak
) -> None:
    axes = {"sensor": readings.names, "speed": speed}
    count = len(readings.names)
    for number, name in enumerate(QUANTITIES):
        own = slice(number * count, (number + 1) * count)
        path = f"{RUN_UP}/{name}_{kind}"
        scene.emit(path, curve.value[:, own].T, curve.error[:, own], axes)
        known = np.isfinite(top.value[own])
        scene.emit(f"{path}_largest", top.value[own], np.where(known, top.error[own], 0.0), axes)
        scene.emit(f"{path}_largest_speed", top.speed[own], top.speed_error[own], axes)


def _emit_severity(
    scene: Scene, readings: Readings, speed: FloatArray, curve: Bounded, top: RunUpPeak
) -> None:
    """Severity over speed; its largest is the largest of what the three largest values make."""
    count = len(readings.names)
    own = [slice(number * count, (number + 1) * count) for number in range(3)]
    axes = {"sensor": readings.names, "speed": speed}
    whole = severity(*(curve[:, one] for one in own))
    factor = np.array([[LOWER], [1.0], [1.0 / UPPER]])
    value, error = (np.reshape(part, (3, count)) * factor for part in (top.value, top.error))
    error = np.max(np.where(np.isfinite(value), error, 0.0), axis=0)
    largest = Bounded(np.max(value, axis=0), error)
    row = np.argmax(value, axis=0) * count + np.arange(count)
    place = Bounded(top.speed[row], top.speed_error[row])
    off = [top_errors(place[k], largest[k], speed, whole[:, k])[0] for k in range(count)]
    found = SeverityInRunUp(
        severity=whole.T,
        severity_largest=largest,
        severity_largest_speed=Bounded(place.value, np.array(off)),
    )
    scene.emit_all(found, axes)
