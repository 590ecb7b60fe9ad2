"""Questions of vibration at points: the peak over the cycle, the largest r.m.s. of the run-up."""

import numpy as np

from vibecalc.core.accuracy.kinds import Counted, peak_over_cycle, peak_over_range
from vibecalc.core.accuracy.topic import Answer, Ask, Solver, Topic
from vibecalc.core.run.stage import Scene
from vibecalc.isolation.adapters.body_run_up import sections
from vibecalc.points.adapter import motion_of_body
from vibecalc.points.model import band_of, readings_of
from vibecalc.points.readings import signals
from vibecalc.points.results import ROOT, RUN_UP
from vibecalc.points.rms_over_speed import rms_at
from vibecalc.points.run_up_adapter import band_rows, passed


def points_topics(scene: Scene) -> list[Topic]:
    """The largest velocity of a reading over the cycle; none at rest."""
    given, path = motion_of_body(scene), f"{ROOT}/velocity_peak"
    readings, speed, kept = readings_of(scene.case), scene.case.machine.speed, given.retained
    peaks = scene.record[path].values
    worst = int(np.argmax(peaks))
    if not peaks[worst] > 0.0:
        return []
    velocity = signals(given.motion, readings.row, given.order * speed)[1]
    doubled = np.rint(2.0 * given.order[:kept]).astype(int)
    words = f"reading {readings.names[worst]!r} at {speed:.6g} rad/s, {kept} orders"
    ask, row = Ask("largest velocity at a point", words, path), velocity.value[[worst], :kept]
    return [peak_over_cycle(ask, row, doubled, "half the crank angle [rad]")]


def points_run_up_topics(scene: Scene) -> list[Topic]:
    """The largest r.m.s. velocity of a reading in the run-up; none where all have no bound."""
    readings, band = readings_of(scene.case), band_of(scene.case)
    count, every = len(readings.names), []
    for part in sections(scene):
        counted = band_rows(part, readings, band)
        top = passed(part, readings, counted)[1].peak
        every += [(float(top.value[row]), float(top.speed[row]), row, part, counted)
                  for row in range(count, 2 * count) if 0.0 < top.value[row] < np.inf]  # fmt: skip
    if not every:
        return []
    _, known, row, part, counted = max(every, key=lambda one: one[0])
    ends = float(part.start), float(part.stop)

    def alone(_: float) -> Answer:
        rows = Counted(counted.rows)
        peak = passed(part, readings, counted._replace(rows=rows))[1].peak
        return Answer(peak.value[[row]], float(rows.asked), float(peak.speed[row]))

    words = f"reading {readings.names[row - count]!r}, {ends[0]:.6g} to {ends[1]:.6g} rad/s"
    ask = Ask("largest r.m.s. of the run-up", words, f"{RUN_UP}/velocity_rms_largest", 90.0,
              "curves and peaks of all readings, and every resonance, so that no narrow one is "
              "missed")  # fmt: skip
    return [peak_over_range(
        ask, Solver("resonances and slopes", alone),
        lambda speed: rms_at(counted, speed, speed).value[:, row], ends, known,
        "crank speed [rad/s]", "speeds",
    )]  # fmt: skip
