"""Runs a line with variable inertias and holds its error estimates against the exact motion."""

from collections.abc import Iterator

import numpy as np
from exact_variable_inertia import Motion, VariableTruth
from random_line_studies import Table
from study_inputs import StudyInputs
from study_report import StudyReport, Truth, report

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

ROOT = "response/torsion/variable_inertia/"
#: beginnings of paths below the root, and why there is no truth for them
NO_TRUTH = {
    "highest_order": "what was kept",
    "secondary/source": "an order that is named; where round-off is all there is, any",
    "wedge/": "formulas of the first order; their estimate says what the next one may change",
    "unstable/growth": "the fastest of what was examined",
}
#: truth with so many times the orders, and a few more
_MORE, _EXTRA = 1.7, 8
#: share of a speed within which a border is looked for
_ABOUT = (2e-3, 4e-4, 8e-5)


def judge_variable(table: Table) -> StudyReport:
    """Every quantity below `variable_inertia/` next to its truth, or why it has none.

    NumericalFailure if the run refuses.
    """
    case = validate(table)
    record = run_case(case)
    return report(case, record, ROOT, list(truths(case, record)), NO_TRUTH)


def truths(case: Case, record: Record) -> Iterator[Truth]:
    """Path, found and true values, and the noise of the true ones."""
    line = VariableTruth(StudyInputs(case))
    one = line.inputs
    highest = float(_own(record, "highest_order"))
    steps = int(_MORE * highest * line.turns) + _EXTRA
    spread = line.relative_variation()[one.built.freedom]
    yield "relative_variation", spread, 1e-15
    yield from _operating(line, record, steps)
    if f"{ROOT}speeds/change" in record:
        yield from _speeds(line, record, steps)
    if f"{ROOT}unstable/from" in record:
        yield from _borders(line, record, case)


def _own(record: Record, name: str) -> np.ndarray:
    return np.asarray(record[ROOT + name].values)


def _axis(record: Record, name: str, axis: str) -> np.ndarray:
    axes = {one.name: one.values for one in record[ROOT + name].axes}
    return np.asarray(axes[axis], dtype=float)


def _two(line: VariableTruth, speed: float, steps: int, exact: bool) -> tuple[Motion, np.ndarray]:
    """The motion, and what five steps more change of it (N + 1, n)."""
    found, other = (line.motion(speed, count, exact) for count in (steps, steps + 5))
    return found, 2.0 * np.abs(found.angle - other.angle[: steps + 1])


def _operating(line: VariableTruth, record: Record, steps: int) -> Iterator[Truth]:
    one = line.inputs
    speed, ratio = one.speed, one.section_ratio
    size = np.abs(ratio)
    full, slip = _two(line, speed, steps, True)
    torque = line.torque(full, speed)
    turning = speed * full.order[1:, None]
    stiff = np.abs(one.stiffness + 1j * turning * one.damping)
    uncertainty = (slip[1:] @ np.abs(one.element).T) * stiff
    kept = len(_axis(record, "torque", "order"))
    noise = float((uncertainty / size).max())
    true = (torque[:kept] / ratio).T
    yield "torque", true, noise
    plain = line.constant(speed, steps)
    constant = line.half_range(plain, speed)
    varying, blur = line.half_range(full, speed), uncertainty.sum(axis=0)
    tiny = 1e-14 * constant
    yield "constant_half_range", constant / size, float((tiny / size).max())
    yield "torque_half_range", varying / size, float((blur / size).max())
    change = varying / constant - 1.0
    slack = float(((blur + tiny * varying / constant) / constant).max()) + 2e-16
    yield "change", change, slack
    yield from _secondary(line, record, plain, steps)
    growth = line.growth(speed, full)
    again = line.growth(speed, Motion(full.order, full.angle + slip))
    slack = 4.0 * abs(again - growth) + 1e-13 * speed
    yield "growth", np.array(growth), slack


def _secondary(line: VariableTruth, record: Record, plain: Motion, steps: int) -> Iterator[Truth]:
    """What the other orders add, and the share of the first of them."""
    one, speed = line.inputs, line.inputs.speed
    section = int(np.argmax(np.abs(_own(record, "change"))))
    linear, slip = _two(line, speed, steps, False)
    row = one.element[section]
    added = (linear.angle - plain.angle)[1:] @ row * one.section_ratio[section]
    kept = len(_axis(record, "secondary/twist", "order"))
    noise = float((slip @ np.abs(row)).max() * abs(one.section_ratio[section]))
    noise += 1e-15 * float(np.abs(plain.angle[1:]).max())
    yield "secondary/twist", added[:kept], noise
    size = np.abs(_fed(line, linear, speed, kept, row))
    total = size.sum(axis=1)
    share = size.max(axis=1) / np.where(total > 0.0, total, 1.0)
    yield "secondary/share", share, 1e-13


def _fed(
    line: VariableTruth, motion: Motion, speed: float, kept: int, row: np.ndarray
) -> np.ndarray:
    """Twist of a section at orders p = 1 ... kept (steps) from every order q, (kept, N + 1)."""
    one, order = line.inputs, motion.order
    count = len(order)
    series = np.zeros((2 * count + 1, len(one.inertia)), dtype=complex)
    for h, value in enumerate(line.variation, start=1):
        if h * line.turns <= 2 * count:
            series[h * line.turns] = 0.5 * value
    out = np.zeros((kept, count), dtype=complex)
    q = np.arange(count)
    for p in range(1, kept + 1):
        apart = np.where((q <= p)[:, None], series[np.abs(p - q)], series[np.abs(p - q)].conj())
        force = apart * motion.angle + series[p + q] * motion.angle.conj()
        force *= (0.5 * speed**2 * (order[p] ** 2 + order**2))[:, None]
        w = speed * order[p]
        matrix = line.stiffness + 1j * w * line.damping - w**2 * np.diag(one.inertia)
        out[p - 1] = np.linalg.solve(matrix, force.T).T @ row
    return out


def _speeds(line: VariableTruth, record: Record, steps: int) -> Iterator[Truth]:
    """Linear motions over the range."""
    ratio = np.abs(line.inputs.section_ratio)[:, None]
    speeds = _axis(record, "speeds/change", "variable_speed")
    half, change, blur = [], [], []
    for speed in speeds:
        full, slip = _two(line, float(speed), steps, False)
        plain = line.half_range(line.constant(float(speed), steps), float(speed))
        half.append(line.half_range(full, float(speed)))
        change.append(half[-1] / plain - 1.0)
        turning = float(speed) * full.order[1:, None]
        stiff = np.abs(line.inputs.stiffness + 1j * turning * line.inputs.damping)
        blur.append(((slip[1:] @ np.abs(line.inputs.element).T) * stiff).sum(axis=0))
    true, changes, uncertainty = np.array(half).T, np.array(change).T, np.array(blur).T
    slack = float((uncertainty / true * (1.0 + np.abs(changes))).max()) + 1e-14
    found = _own(record, "speeds/torque_half_range")
    unbounded = ~np.isfinite(found)
    true = np.where(unbounded, np.inf, true)
    yield "speeds/torque_half_range", true / ratio, float((uncertainty / ratio).max())
    changes = np.where(unbounded, np.inf, changes)
    yield "speeds/change", changes, slack
    reported = np.where(unbounded, -1.0, np.abs(changes))
    best = reported.argmax(axis=1)
    largest = changes[np.arange(len(best)), best]
    yield "largest_change", largest, slack
    found = _own(record, "largest_change_speed")
    # of those that are equal within their error the one that was found
    slack += 2.0 * record[f"{ROOT}largest_change"].error_estimate
    same = np.array([
        float(own) if reported[k, np.argmin(np.abs(speeds - own))] >= reported[k].max() - slack
        else speeds[best[k]]
        for k, own in enumerate(found)
    ])  # fmt: skip
    yield "largest_change_speed", same, 0.0


def _parted(line: VariableTruth, speed: float) -> tuple[float, bool, float]:
    """Speeds on either side of a border, and whether it grows above; a range may be narrow."""
    for share in _ABOUT:
        low, high = speed * (1.0 - share), speed * (1.0 + share)
        rises = line.growth(high, None) > 0.0
        if (line.growth(low, None) > 0.0) != rises:
            return low, rises, high
    raise AssertionError("no border about the one found")


def _borders(line: VariableTruth, record: Record, case: Case) -> Iterator[Truth]:
    """Speeds at which the growth about even turning changes its sign, by bisection about those
    found. Drifts may turn into vibration there, so that it jumps."""
    asked = case.response.torsion.speeds
    for name in ("from", "to"):
        found, true = _own(record, f"unstable/{name}"), []
        for speed in found.tolist():
            near = speed
            if asked.start < speed < asked.stop:
                low, rises, high = _parted(line, speed)
                for _ in range(34):
                    near = 0.5 * (low + high)
                    if (line.growth(near, None) > 0.0) == rises:
                        high = near
                    else:
                        low = near
            true.append(near)
        slack = 1e-10 * float(np.max(found, initial=0.0))
        yield f"unstable/{name}", np.array(true), slack
