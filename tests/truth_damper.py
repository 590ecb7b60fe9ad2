"""The optimum of a damper in many digits, and what a run says of it next to that."""

from collections.abc import Iterator
from typing import Any

import mpmath
import numpy as np
from exact_damper import ExactLine, Peak
from line_damper_samples import direct
from mpmath import mpf
from random_machines import Table
from study_report import StudyReport
from truth_report import judge_rows

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Quantity, Record
from vibecalc.core.run.run import run_case
from vibecalc.torsion.adapters.damper_design import DesignTask, build_problem
from vibecalc.torsion.adapters.setup import build_setup
from vibecalc.torsion.damper_design.design import Design, Performance, design, performance
from vibecalc.torsion.damper_design.problem import Damper

DIGITS = 60
ROOT = "damper_design/"
Row = tuple[str, Any, Any]


def judge_damper(table: Table) -> StudyReport:
    """What a run stores of a design next to its truth, every third machine with its map."""
    case = validate(table)
    record, options = run_case(case), case.damper_design
    assert options is not None
    asked = build_problem(build_setup(case), options)
    found = design(asked.problem, asked.limits)
    with mpmath.workdps(DIGITS):
        rows = list(_truths(asked, found, record, options.objective))
        # by dense solves, of every third machine
        if int(table["title"].split()[-1]) % 3 == 0:
            rows += list(_chart(asked, found, record, options.objective))
        return StudyReport(list(judge_rows(rows, record)), [], [])


def _truths(asked: DesignTask, found: Design, record: Record, objective: str) -> Iterator[Row]:
    exact = ExactLine(asked.problem)
    x, level, weight, speed, pull, curvature = _optimum(exact, asked, found)
    square, ratio = mpf(asked.ratio) ** 2, abs(mpf(asked.ratio))
    own = [mpmath.exp(one) / square if one is not None else mpf(0) for one in x]

    def row(name: str, truth: Any, values: Any = None) -> Row:
        return f"{ROOT}{name}", record[ROOT + name].values if values is None else values, truth

    for name, value in zip(("inertia", "stiffness", "damping"), own, strict=True):
        yield row(name, [value])
    yield row("natural_frequency", [mpmath.sqrt(own[1] / own[0])])
    yield row("damping_ratio", [own[2] / (2 * mpmath.sqrt(own[0] * own[1]))])
    yield row(f"worst_{objective}", [level])
    order = np.argsort(found.peaks.speed, kind="stable")
    yield row("active/speed", [speed[i] for i in order])
    yield row("active/level", [1] * len(order))
    yield row("active/weight", [weight[i] for i in order])
    yield row("bound_sensitivity", pull)
    yield row("certificate", [0])
    if np.isfinite(found.curvature.value):
        yield row("curvature", [curvature])
    near = np.abs(np.log(found.basin.value[:, 1:] / found.damper.value[1:])) < 0.05
    if np.all(near):
        count = len(found.basin.value)
        yield row("basin/stiffness", [own[1]] * count)
        yield row("basin/damping", [own[2]] * count)
        yield row("basin/worst", [1] * count)
    worst_at = float(record[f"{ROOT}worst_speed"].values)
    yield row("worst_speed", [min(speed, key=lambda one: abs(one - worst_at))])
    tuned = performance(asked.problem, found.values)
    yield from _asked_of(exact, tuned, x, ratio, row, "")
    if asked.table is not None:
        other = performance(asked.problem, asked.table)
        its = [_log(one) for one in asked.table]
        worst, at = exact.climbed(_peak(other, 0, asked), its)
        yield row(f"table/worst_{objective}", [worst])
        yield row("table/worst_speed", [at])
        yield row("table/gain", [worst / level])
        yield from _asked_of(exact, other, its, ratio, row, "table/")
    yield from _mistuned(exact, asked, found, record, x, level)
    curve = record[f"{ROOT}curve/{objective}"]
    speeds = np.asarray(record_axis(curve, "speed"), dtype=float)
    bare = [x[0], None, None]
    dampers = [bare, x] if asked.table is None else [bare, [_log(one) for one in asked.table], x]
    seen, truths = [], []
    for damper, values in zip(dampers, np.asarray(curve.values), strict=True):
        if np.all(np.isfinite(values)):
            place = int(np.argmax(values))
            seen.append(float(values[place]))
            truths.append(_largest(exact, asked, damper, mpf(float(speeds[place]))))
    yield row(f"curve/{objective}", truths, seen)


def record_axis(quantity: Quantity, name: str) -> Any:
    """Values of one axis of a quantity."""
    return next(axis.values for axis in quantity.axes if axis.name == name)


def _log(value: float) -> Any:
    return mpmath.log(mpf(float(value))) if value > 0.0 else None


def _peak(seen: Performance, which: int, asked: DesignTask) -> Peak:
    place = seen.place
    speed = float(place.speed[which])
    a, b = (mpf(float(one)) for one in place.phase[which])
    held = speed in asked.problem.speed
    return Peak(int(place.row[which]), mpf(speed), (a, b), held)


def _asked_of(
    exact: ExactLine, seen: Performance, x: list[Any], ratio: Any, row: Any, stem: str
) -> Iterator[Row]:
    """Heat and travel with their speeds."""
    low, high = exact.problem.speed
    for which, name, factor in ((1, "heat", mpf(1)), (2, "travel", ratio)):
        speed = float(seen.place.speed[which])
        a, b = (mpf(float(one)) for one in seen.place.phase[which])
        one = Peak(int(seen.place.row[which]), mpf(speed), (a, b), speed in (low, high))
        value, at = exact.climbed(one, x)
        yield row(f"{stem}{name}", [factor * value])
        yield row(f"{stem}{name}_speed", [at])


def _optimum(exact: ExactLine, asked: DesignTask, found: Design) -> tuple[Any, ...]:
    """Newton's method on the conditions: logarithms, level, weights, speeds, pulls, curvature."""
    bounds = asked.limits.bounds
    values = found.damper.value
    moving = [i for i in range(3) if bounds[i, 1] > bounds[i, 0]]
    free = [i for i in moving if values[i] not in bounds[i]]
    x = [_log(one) for one in values]
    phases = np.mod(found.peaks.phase, 2.0 * np.pi)
    peaks = [
        Peak(int(r), mpf(float(s)), (mpf(a[0]), mpf(a[1])),
               float(s) in asked.problem.speed)
        for r, s, a in zip(found.peaks.row, found.peaks.speed, phases, strict=True)
    ]  # fmt: skip
    level, weight = mpf(float(found.worst.value)), [mpf(float(one)) for one in found.weight.value]
    section = [one.row < exact.sections for one in peaks]
    limit = {0: mpf(asked.limits.heat), 1: mpf(asked.limits.travel), 2: mpf(asked.limits.travel)}
    f, p = len(free), len(peaks)
    for _ in range(6):
        parts = [exact.derivatives(one, x, free) for one in peaks]
        size = f + 1 + 2 * p
        matrix, right = mpmath.matrix(size, size), mpmath.matrix(size, 1)
        for i, (value, slope, bend) in enumerate(parts):
            scale = level if section[i] else limit[peaks[i].row - exact.sections]
            for a in range(f):
                right[a] -= weight[i] * slope[a] / scale
                for b in range(f):
                    matrix[a, b] += weight[i] * bend[a][b] / scale
                matrix[a, f + 1 + i] = slope[a] / scale
                matrix[a, f + 1 + p + i] = 0 if peaks[i].held else weight[i] * bend[a][f] / scale
                matrix[f + 1 + i, a] = slope[a] / scale
                matrix[f + 1 + p + i, a] = 0 if peaks[i].held else bend[f][a] / scale
            matrix[f, f + 1 + i] = int(section[i])
            right[f] += (mpf(1) / p) - (weight[i] if section[i] else 0)
            matrix[f + 1 + i, f] = -int(section[i])
            right[f + 1 + i] = (level if section[i] else scale) / scale - value / scale
            matrix[f + 1 + p + i, f + 1 + p + i] = 1 if peaks[i].held else bend[f][f] / scale
            right[f + 1 + p + i] = 0 if peaks[i].held else -slope[f] / scale
        step = mpmath.lu_solve(matrix, right)
        for a, place in enumerate(free):
            x[place] += step[a]
        level *= 1 + step[f]
        weight = [one + step[f + 1 + i] for i, one in enumerate(weight)]
        peaks = [
            one._replace(speed=one.speed * (1 + step[f + 1 + p + i])) for i, one in enumerate(peaks)
        ]
        if max(abs(one) for one in step) < mpf("1e-20"):
            break
    else:
        raise AssertionError("the truth does not converge")
    pull = [mpf(0)] * 3
    whole = [exact.derivatives(one, x, moving) for one in peaks]
    scales = [level if s else limit[one.row - exact.sections]
              for s, one in zip(section, peaks, strict=True)]  # fmt: skip
    for a, place in enumerate(moving):
        if place not in free:
            pull[place] = -sum(
                w * part[1][a] / s for w, part, s in zip(weight, whole, scales, strict=True)
            )
    least = _curvature(matrix, peaks, f)
    return x, level, weight, [one.speed for one in peaks], pull, least


def _curvature(matrix: Any, peaks: list[Peak], f: int) -> Any:
    """Least curvature along what the peaks leave free, the speeds following."""
    p = len(peaks)
    rows_of = f + 1 + 2 * p
    reduced = np.zeros((f, f))
    for a in range(f):
        for b in range(f):
            follow = sum(
                matrix[a, at] * matrix[at, b] / matrix[at, at] for at in range(f + 1 + p, rows_of)
            )
            reduced[a, b] = float(matrix[a, b] - follow)
    rows = np.array([[float(matrix[f + 1 + i, b]) for b in range(f + 1)] for i in range(p)])
    size, right = np.linalg.svd(rows)[1:]
    null = right[int(np.sum(size > 1e-10 * size[0])) :, :f].T
    if null.shape[1] == 0:
        return mpmath.inf
    null = np.linalg.qr(null)[0]
    return mpf(float(np.min(np.linalg.eigvalsh(null.T @ reduced @ null))))


def _mistuned(
    exact: ExactLine, asked: DesignTask, found: Design, record: Record, x: list[Any], level: Any
) -> Iterator[Row]:
    """Two corners of the sensitivity."""
    quantity = record[f"{ROOT}sensitivity"]
    values = np.asarray(quantity.values)
    seen, truth = [], []
    for i, j in ((0, 0), (-1, -1)):
        factor = [1.0, float(record_axis(quantity, "stiffness_factor")[i]),
                  float(record_axis(quantity, "damping_factor")[j])]  # fmt: skip
        other = performance(
            asked.problem,
            Damper(*(a * b for a, b in zip(factor, found.values, strict=True))),
        )
        its = [a + mpmath.log(mpf(b)) for a, b in zip(x, factor, strict=True)]
        worst, _ = exact.climbed(_peak(other, 0, asked), its)
        seen.append(values[i, j])
        truth.append(worst / level)
    yield f"{ROOT}sensitivity", seen, truth


def _largest(exact: ExactLine, asked: DesignTask, x: list[Any], speed: Any) -> Any:
    """Largest half range of all sections at one speed."""
    best = mpf(0)
    damper = [mpmath.exp(one) if one is not None else mpf(0) for one in x]
    theta = 2.0 * np.pi * np.arange(720) / 720.0
    for row in np.flatnonzero(asked.problem.weight > 0.0).tolist():
        course = np.array([complex(one) for one in exact.course(row, damper, speed)])
        wave = (course @ np.exp(1j * np.outer(exact.harmonic, theta))).real
        phase = (mpf(theta[int(np.argmax(wave))]), mpf(theta[int(np.argmin(wave))]))
        best = max(best, exact.value(Peak(row, speed, phase, True), x, speed))
    return best


def _chart(asked: DesignTask, found: Design, record: Record, objective: str) -> Iterator[Row]:
    """Every fifth place of the map by dense solves, closely around the damped poles."""
    if f"{ROOT}chart/heat" not in record:
        return
    square = asked.ratio**2
    heat = record[f"{ROOT}chart/heat"]
    k, c = (np.asarray(record_axis(heat, f"chart_{n}"))[::5] for n in ("stiffness", "damping"))
    # sections are read as torques; a twist is not what this table forms
    paths = [("heat", -2, 1.0), ("travel", -1, abs(asked.ratio))]
    if asked.problem.quantity == "torque":
        paths.append((objective, 0, 1.0))
    found_at: dict[str, list[float]] = {name: [] for name, _, _ in paths}
    for one in k * square:
        for other in c * square:
            damper = Damper(found.values.inertia, float(one), float(other))
            fine = np.linspace(*asked.problem.speed, 1501)
            seen = direct(asked.problem, damper, fine, 96)
            columns = {"heat": seen[:, -2], "travel": seen[:, -1]}
            columns[objective] = seen[:, :-2].max(axis=1)
            for name, _, factor in paths:
                found_at[name].append(factor * float(columns[name].max()))
    for name, _, _ in paths:
        values = np.asarray(record[f"{ROOT}chart/{name}"].values)[::5, ::5]
        yield f"{ROOT}chart/{name}", values, [mpf(one) for one in found_at[name]]
