"""Questions of vibration at points: the peak over the cycle, the largest r.m.s. of the run-up."""

import numpy as np

from vibecalc.core.accuracy.kinds import Ask, ours, peak_over_cycle, peak_over_range
from vibecalc.core.accuracy.topic import Answer, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.body_run_up import sections
from vibecalc.isolation.rows import Jet
from vibecalc.numerics.rounding import FloatArray
from vibecalc.points.adapter import motion_of_body
from vibecalc.points.model import band_of, readings_of
from vibecalc.points.readings import signals
from vibecalc.points.results import RUN_UP, AtPoints
from vibecalc.points.rms_over_speed import rms_at
from vibecalc.points.run_up_adapter import band_rows, passed


def points_topics(scene: Scene) -> list[Topic]:
    """The largest velocity of a reading over the cycle; none at rest."""
    given = motion_of_body(scene)
    readings, speed, kept = readings_of(scene.case), scene.case.machine.speed, given.retained
    peaks = scene.record[f"{AtPoints.ROOT}/velocity_peak"].values
    worst = int(np.argmax(peaks))
    if not peaks[worst] > 0.0:
        return []
    found = signals(given.motion, readings.row, given.order * speed).velocity.value[[worst], :kept]
    doubled = np.rint(2.0 * given.order[:kept]).astype(int)
    name = f"reading {readings.names[worst]!r} at {speed:.6g} rad/s, {kept} orders"
    ask = Ask(
        "points", "largest velocity at a point", name, f"{AtPoints.ROOT}/velocity_peak", "m/s"
    )
    topic = peak_over_cycle(ask, found, doubled)
    return [topic._replace(position=topic.position and "half the crank angle [rad]")]


def points_run_up_topics(scene: Scene) -> list[Topic]:
    """The largest r.m.s. velocity of a reading in the run-up; none where all have no bound."""
    readings, band = readings_of(scene.case), band_of(scene.case)
    count, every = len(readings.names), []
    for part in sections(scene):
        counted = band_rows(part, readings, band)
        top = passed(part, readings, counted)[1].peak
        every += [
            (float(top.value[row]), float(top.speed[row]), row, part, counted)
            for row in range(count, 2 * count)
            if np.isfinite(top.value[row])
        ]
    if not any(value > 0.0 for value, *_ in every):
        return []
    _, known, row, part, counted = max(every, key=lambda one: one[0])
    ends = float(part.start), float(part.stop)

    def curve(speed: FloatArray) -> FloatArray:
        return np.asarray(rms_at(counted, np.ravel(speed)).value[:, row].reshape(np.shape(speed)))

    def alone(_: float) -> Answer:
        asked = [0]

        def rows(speed: FloatArray, slopes: bool = False, errors: bool = False) -> Jet:
            asked[0] += len(speed)
            return counted.rows(speed, slopes=slopes, errors=errors)

        peak = passed(part, readings, counted._replace(rows=rows))[1].peak
        return Answer(peak.value[[row]], float(asked[0]), float(peak.speed[row]))

    words = f"reading {readings.names[row - count]!r}, {ends[0]:.6g} to {ends[1]:.6g} rad/s"
    ask = Ask(
        "points in the run-up", "largest r.m.s. of the run-up", words,
        f"{RUN_UP}/velocity_rms_largest", "m/s", 64.0,
        "curves and peaks of all readings, and every resonance, so that no narrow one is missed",
    )  # fmt: skip
    solver = ours("resonances and slopes", "speeds about resonances, Newton's method", alone)
    return [
        peak_over_range(ask, [solver], curve, *ends, "crank speed [rad/s]", known, work="speeds")
    ]
