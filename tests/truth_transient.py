"""Runs a change in time of a shaft line and holds every error estimate against the exact motion."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from exact_transient import STEPS, ExactMotion
from exact_transient_looks import (
    Extremes,
    SteadyCurve,
    extremes,
    hann,
    steady_largest,
    swings,
    windows,
)
from random_line_studies import Table
from study_inputs import StudyInputs
from study_report import StudyReport, Truth, report

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

ROOT = "response/torsion/transient/"
#: cycles have truths of their own, in `test_property_torsion_counting.py`
NO_TRUTH = {"counted/": "cycles"}
#: rows of a waterfall that are examined
ROWS = 6


def judge_transient(table: Table) -> StudyReport:
    """Every quantity below `transient/` next to its truth. NumericalFailure if the run refuses."""
    case = validate(table)
    record = run_case(case)
    return report(case, record, ROOT, list(truths(case, record)), {})


def truths(case: Case, record: Record) -> Iterator[Truth]:
    """Path, found and true values, and the noise of the true ones."""
    inputs = StudyInputs(case)
    motion = ExactMotion(inputs)
    noise = _noise(motion)
    yield from _peaks(motion, record, noise)
    yield from _course(motion, record, noise)
    yield from _waterfalls(motion, record, noise)
    if inputs.torsion.transient.kind in STEPS:
        yield from _steps(motion, record, noise)
    else:
        yield from _supply(motion, record, noise)
        yield from _passage(motion, record, noise)
    yield from _windows(motion, record, noise)


def _noise(motion: ExactMotion) -> np.ndarray:
    """What other panels change of the referred torques (e,)."""
    other = ExactMotion(motion.inputs, 1.37)
    time = motion.time[::3]
    gap = (motion.at(time) - other.at(time)) @ motion.view.T
    found: np.ndarray = 2.0 * np.abs(gap).max(axis=0)
    return found


def motion_extremes(motion: ExactMotion, section: int) -> Extremes:
    """Those of a section's torque, found once."""
    if section not in motion.kept:
        motion.kept[section] = extremes(motion, section)
    return motion.kept[section]


def _own(record: Record, name: str) -> np.ndarray:
    return np.asarray(record[ROOT + name].values)


def _axis(record: Record, name: str, axis: str) -> np.ndarray:
    axes = {one.name: one.values for one in record[ROOT + name].axes}
    return np.asarray(axes[axis], dtype=float)


def nearest(found: float, time: np.ndarray, height: np.ndarray, uncertainty: float) -> float:
    """The place nearest to the one found of those that reach the largest height, nearly."""
    places = time[height >= height.max() - uncertainty]
    return float(places[np.argmin(np.abs(places - found))])


def _peaks(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    ratio = np.abs(motion.inputs.section_ratio)
    peak, when, speed = [], [], []
    for e in range(len(ratio)):
        found = motion_extremes(motion, e)
        size = np.abs(found.value)
        peak.append(float(size.max()))
        uncertainty = 2.0 * record[f"{ROOT}peak"].error_estimate * ratio[e] + noise[e]
        when.append(nearest(float(_own(record, "peak_time")[e]), found.time, size, uncertainty))
        speed.append(float(motion.course(np.array(when[-1:]))[1][0]))
    values = np.array(peak) / ratio
    yield "peak", values, float(np.max(noise / ratio))
    if f"{ROOT}peak_stress" in record:
        diameter = motion.inputs.built.section_diameter  # of solid shafts
        places = np.flatnonzero(diameter)
        modulus = np.pi * diameter[places] ** 3 / 16.0
        slack = float(np.max((noise / ratio)[places] / modulus))
        yield "peak_stress", values[places] / modulus, slack
    # a time is that of a flat top
    yield "peak_time", np.array(when), 1e-8 * motion.end
    slip = 1e-8 * float(motion.border_speed.max())
    yield "peak_speed", np.array(speed), slip
    best = int(np.argmax(values)) + 1
    yield "worst_section", np.array(best), 0.0


def _worst(record: Record) -> int:
    return int(_own(record, "worst_section")) - 1


def _course(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    section = _worst(record)
    ratio = motion.inputs.section_ratio[section]
    time = _axis(record, "history/torque", "history_time")
    true = motion.at(time) @ motion.view[section] / ratio
    yield "history/torque", true, noise[section] / abs(ratio)


def _waterfalls(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    section = _worst(record)
    ratio = motion.inputs.section_ratio[section]
    time = _axis(record, "waterfall/order", "waterfall_time")
    frequency = _axis(record, "waterfall/frequency", "waterfall_frequency")
    yield "waterfall/speed", motion.course(time)[1], 0.0
    turned = float(motion.border_angle[-1])
    wide = 2.0 * np.pi * min(8.0, turned / (2.0 * np.pi) / 2.5)
    long = min(4.0 * np.pi / (frequency[1] - frequency[0]), motion.end / 6.0)
    rows = np.unique(np.linspace(0, len(time) - 1, ROWS).astype(int))
    for name, rate, width in (("order", motion.inputs.order, wide), ("frequency", frequency, long)):
        true = [
            hann(motion, section, rate, float(t), width, name == "order") / ratio
            for t in time[rows]
        ]
        found = _own(record, f"waterfall/{name}")[rows]
        yield f"waterfall/{name}", np.array(true), 2.0 * noise[section] / abs(ratio), found


def _steps(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    ratio = np.abs(motion.inputs.section_ratio)
    ends = []
    for name, part in zip(("before", "after"), motion.plan.parts, strict=True):
        ends.append(steady_largest(motion, part, motion.plan.speed) / ratio)
        slack = 1e-14 * float(ends[-1].max())
        yield f"steady_{name}", ends[-1], slack
    peak = (
        np.array([np.abs(motion_extremes(motion, e).value).max() for e in range(len(ratio))])
        / ratio
    )
    larger = np.maximum(*ends)
    slack = float(np.max((noise / ratio + 1e-14 * peak) / larger))
    yield "dynamic_factor", peak / larger, slack


def _supply(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    one, parts = motion.inputs, motion.plan.parts
    place = int(np.argmax([abs(p.acceleration) for p in parts]))
    part = parts[place]
    top, inertia = part.acceleration, one.inertia
    tiny = 1e-15
    yield "acceleration", np.array(top), tiny * abs(top)
    whole = top * inertia.sum()
    yield "acceleration_torque", np.array(whole), 2.0 * tiny * abs(whole)
    load = one.built.load_freedom
    gas, given_load = motion.given(part, float(motion.border_speed[place]))
    mean = part.scale[0] * gas[:, 0].real + given_load
    given = mean - inertia * top
    supplied = (motion.balance @ given - given)[load] / one.ratio[one.built.load_station]
    size = 8.0 * tiny * float(np.abs(mean).sum() + abs(whole))
    yield "acceleration_supplied", supplied, size
    at = np.array(one.built.load_station + 1)
    yield "acceleration_supplied_at", at, 0.0
    pull = motion.balance @ (-inertia * top)
    state = np.linalg.lstsq(motion.matrix, -motion.drive @ pull, rcond=1e-12)[0]
    carried = motion.view @ state
    ratio = one.section_ratio
    slack = 1e-14 * float(np.abs(carried).max())
    yield "acceleration_part", carried / ratio, slack
    left = [
        np.abs(extremes(motion, e, float(carried[e] / top)).value).max() for e in range(len(ratio))
    ]
    without = np.array(left) / np.abs(ratio)
    own = float(np.max(noise / np.abs(ratio))) + slack
    yield "peak_without_acceleration", without, own


def _lowest(motion: ExactMotion) -> float:
    """Lowest speed with a steady vibration to compare with: of a start, amid its first window."""
    if motion.plan.speed > 0.0:
        return float(motion.border_speed.min())
    slowest = 0.5 * float(motion.border_angle[-1]) / motion.end
    count = int(np.clip(motion.end * slowest / motion.inputs.cycle, 4, 400))
    return float(motion.course(np.array([0.5 * motion.end / count]))[1][0])


def _passage(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    one = motion.inputs
    ratio, (start, end) = np.abs(one.section_ratio), motion.plan.moving
    speeds = np.sort(motion.course(np.array([start, end]))[1])
    speeds = np.maximum(speeds, _lowest(motion))
    curve = SteadyCurve(one, float(speeds[0]), float(speeds[1]))
    half, fast = [], []
    for e in range(len(ratio)):
        found = swings(motion, motion_extremes(motion, e), e, one.cycle, (start, end))
        half.append(float(found.half.max()))
        speed = motion.course(found.middle)[1]
        uncertainty = 2.0 * record[f"{ROOT}peak_half_range"].error_estimate * ratio[e] + noise[e]
        own = float(_own(record, "peak_half_range_speed")[e])
        fast.append(nearest(own, speed, found.half, uncertainty))
    own = float(np.max(noise / ratio))
    peak, slip = np.array(half), 1e-8 * float(speeds[1])
    yield "peak_half_range", peak / ratio, own
    yield "peak_half_range_speed", np.array(fast), slip
    steady, uncertainty = curve.value.max(axis=0), record[f"{ROOT}steady_half_range"].error_estimate
    place = np.array([
        nearest(float(_own(record, "steady_half_range_speed")[e]), curve.speed, curve.value[:, e],
                2.0 * uncertainty * ratio[e])
        for e in range(len(ratio))
    ])  # fmt: skip
    close = 1e-9
    yield "steady_half_range", steady / ratio, close * float((steady / ratio).max())
    yield "steady_half_range_speed", place, 1e-5 * float(speeds[1])
    over = peak / steady - 1.0
    slack = float(np.max(noise / steady + close * peak / steady))
    yield "overshoot", over, slack
    sense = np.sign(one.torsion.transient.stop - motion.plan.speed)
    lag = sense * (np.array(fast) - place)
    yield "lag", lag, 1e-5 * float(speeds[1])


def _windows(motion: ExactMotion, record: Record, noise: np.ndarray) -> Iterator[Truth]:
    if f"{ROOT}torque_low" not in record:
        return
    one = motion.inputs
    ratio = one.section_ratio
    time = _axis(record, "torque_low", "transient_time")
    yield "speed", motion.course(time)[1], 0.0
    passed = np.diff(np.asarray(motion.course(time)[2], dtype=float)).max()
    assert passed < one.cycle, "windows of several cycles are not in these cases"
    found = [
        windows(motion, motion_extremes(motion, e), e, time, one.cycle) for e in range(len(ratio))
    ]
    ends = np.sort([[f[0] / r, f[1] / r] for f, r in zip(found, ratio, strict=True)], axis=1)
    own = float(np.max(noise / np.abs(ratio)))
    yield "torque_low", ends[:, 0], own
    yield "torque_high", ends[:, 1], own
    if f"{ROOT}half_range" not in record:
        return
    half = 0.5 * (ends[:, 1] - ends[:, 0])
    yield "half_range", half, own
    starts, stops = found[0][2:]
    speeds: Any = [
        motion.course(np.concatenate([
            [a, b], motion.border[(motion.border > a) & (motion.border < b)],
        ]))[1]
        for a, b in zip(starts, stops, strict=True)
    ]  # fmt: skip
    low = np.maximum([s.min() for s in speeds], _lowest(motion))
    high = np.maximum([s.max() for s in speeds], low)
    curve = SteadyCurve(one, float(low.min()), float(high.max()))
    true = curve.largest(low, high).T / np.abs(ratio)[:, None]
    slack = 1e-9 * float(true.max())
    yield "quasi_steady", true, slack
