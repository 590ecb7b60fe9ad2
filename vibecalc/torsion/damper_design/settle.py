"""From a coarse map downhill on the worst section, then Newton's method for the last digits."""

from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.least_norm import nonnegative_least_squares
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.torsion.damper_design.peaks import (
    LEVEL,
    DamperPeaks,
    Survey,
    about,
    drift,
    follow,
    place_error,
    same_branch,
    survey,
)
from vibecalc.torsion.damper_design.problem import DamperProblem, Limits
from vibecalc.torsion.damper_design.readings import map_largest, reading_error

# ----------------------------------------------------------------------------
# A coarse map over ln k and ln c (and ln J), and where its valleys are.
# ----------------------------------------------------------------------------


class Chart(NamedTuple):
    """On axes `inertia` (j,), `stiffness` (k,), `damping` (c,): arrays (j, k, c).

    `worst` largest weighted half range on the grid of speeds and cycle samples, `heat` in W and
    `travel` in rad at their worst speeds: a picture, not the values of the design.
    """

    inertia: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    worst: FloatArray
    heat: FloatArray
    travel: FloatArray


def chart(problem: DamperProblem, limits: Limits, points: int = 41, speeds: int = 161) -> Chart:
    """Map of `points` values of each of J, k and c whose bounds differ."""
    return chart_of(survey(problem, limits, speeds), points)


def chart_of(prepared: Survey, points: int) -> Chart:
    """The same from a prepared survey."""
    axes = [
        np.geomspace(low, high, points) if high > low else np.array([low])
        for low, high in prepared.bounds
    ]
    inertia, stiffness, damping = axes
    k, c = (a.ravel() for a in np.meshgrid(stiffness, damping, indexing="ij"))
    shape = (inertia.size, stiffness.size, damping.size)
    worst, heat, travel = np.empty(shape), np.empty(shape), np.empty(shape)
    for index, value in enumerate(inertia):
        responses = prepared.table(float(value))
        values = map_largest(prepared.system, responses, k, c)
        worst[index], heat[index], travel[index] = (one.reshape(shape[1:]) for one in values.T)
    return Chart(inertia, stiffness, damping, worst, heat, travel)


def valleys(prepared: Survey, chart: Chart, most: int) -> FloatArray:
    """Variables (b, v) of all local minima of the map, lowest first, at most `most`.

    Outside the limits the excess counts in units of the largest value, so that the least violated
    place is a valley too.
    """
    limits = prepared.limits
    over = np.maximum(chart.heat / limits.heat, chart.travel / limits.travel) - 1.0
    level = chart.worst
    level = np.where(over > 0.0, np.max(level) * (1.0 + over), level)
    padded = np.pad(level, 1, constant_values=np.inf)
    shape = level.shape
    lowest = np.ones(shape, dtype=bool)
    for shift in product((0, 1, 2), repeat=3):
        part = tuple(slice(s, s + n) for s, n in zip(shift, shape, strict=True))
        lowest &= level <= padded[part]
    places = np.argwhere(lowest)
    places = places[np.argsort(level[lowest], kind="stable")][:most]
    axes = (chart.inertia, chart.stiffness, chart.damping)
    values = np.stack([axes[i][places[:, i]] for i in prepared.moving], axis=-1)
    return np.log(values)


# ----------------------------------------------------------------------------
# Downhill on the worst section by linear programs in a trust region.
#
# K. Madsen, An algorithm for minimax solution of overdetermined systems of non-linear equations,
# J. Inst. Maths Applics 16 (1975) 321: every peak is taken as linear in the variables, and the
# step is as long as that has proved true.
# ----------------------------------------------------------------------------

_DESCENT_STEPS = 40
_DESCENT_SHARE = 0.85
#: of the value, for peaks on the way
_TOLERANCE = 1e-7
_SMALL = 2e-3
#: weights of a violated limit over the worst section, the next where a limit stays broken
_PENALTIES = (5.0, 100.0, 1e4)
#: excess over a limit, over that limit, above which a place breaks it
BROKEN = 1e-4
_HALVINGS = 6
#: reach of the linear program that judges an end
_LEFT = 0.1


class DesignPoint(NamedTuple):
    """Variables (v,), their peaks, and merit: worst section and violated limits (with an infinite
    penalty the excess alone); `over` the worst excess over a limit, over that limit.
    """

    variables: FloatArray
    peaks: DamperPeaks
    merit: float
    over: float


def place(
    prepared: Survey, variables: FloatArray, penalty: float = _PENALTIES[0],
    share: float = _DESCENT_SHARE, tolerance: float = LEVEL,
) -> DesignPoint:  # fmt: skip
    """The peaks of one damper."""
    damper = prepared.damper(variables)
    tops = prepared.peaks(damper, share, tolerance)
    section, scale, worst = prepared.levels(tops)
    over = float(np.max((tops.value / scale)[~section], initial=1.0)) - 1.0
    merit = worst + penalty * worst * over if penalty < np.inf else over
    return DesignPoint(variables, tops, merit, over)


def descend(prepared: Survey, start: FloatArray) -> DesignPoint:
    """Search from logarithms (v,) until steps of a thousandth bring nothing."""
    bounds = prepared.logarithms
    end = np.clip(start, bounds[:, 0], bounds[:, 1])
    for penalty in _PENALTIES:
        found = _descend(prepared, end, penalty)
        if found.over <= BROKEN:
            break
        end = found.variables
    if found.over > BROKEN:
        # the excess alone, and the worst section again from a place that keeps the limits
        found = _descend(prepared, end, np.inf)
        if found.over <= BROKEN:
            found = _descend(prepared, found.variables, _PENALTIES[-1])
    return place(prepared, found.variables)


def lenient(prepared: Survey, most: int) -> list[DesignPoint]:
    """Corners of the bounds by their excess over a limit, at most `most`.

    Rings that are all but locked or free turn little into heat: the map over the middle of the
    bounds may show nothing of them.
    """
    found: list[DesignPoint] = []
    for corner in product(*prepared.logarithms):
        try:
            found.append(place(prepared, np.array(corner), tolerance=_TOLERANCE))
        except NumericalFailure:
            # a locked ring may leave a mode without damping
            continue
    return sorted(found, key=lambda one: (one.over, one.merit))[:most]


def _descend(prepared: Survey, start: FloatArray, penalty: float) -> DesignPoint:
    bounds = prepared.logarithms
    here = place(prepared, start, penalty, tolerance=_TOLERANCE)
    radius = 0.4
    for _ in range(_DESCENT_STEPS):
        step, foreseen = _linear_program(prepared, here, radius, penalty)
        if foreseen <= 1e-5 * abs(here.merit):
            break
        beyond = np.clip(here.variables + step, bounds[:, 0], bounds[:, 1])
        there = place(prepared, beyond, penalty, tolerance=_TOLERANCE)
        if here.merit - there.merit < 0.75 * foreseen:
            # along a curved edge the linear step leaves it: come back once before judging
            reach = 0.5 * float(np.max(np.abs(step)))
            back = there.variables + _linear_program(prepared, there, reach, penalty)[0]
            back = np.clip(back, bounds[:, 0], bounds[:, 1])
            there = min(
                there, place(prepared, back, penalty, tolerance=_TOLERANCE), key=lambda p: p.merit
            )
        gained = here.merit - there.merit
        if gained > 0.75 * foreseen:
            radius = min(2.0 * radius, 1.5)
        elif gained < 0.25 * foreseen:
            radius = 0.35 * min(radius, float(np.max(np.abs(step))))
        if gained > 0.0:
            here = there
        if radius < _SMALL:
            break
    return here


def _linear_program(
    prepared: Survey, here: DesignPoint, radius: float, penalty: float
) -> tuple[FloatArray, float]:
    """Best step (v,) within the radius if all were linear, and the merit it would gain."""
    from scipy.optimize import linprog

    tops, moving = here.peaks, prepared.moving
    section, scale, worst = prepared.levels(tops)
    slope = tops.slope[:, moving] / scale[:, None]
    level = tops.value / scale
    # unknowns: step, level of the sections, excess over limits
    rows = np.hstack([slope, -section[:, None].astype(float), -(~section[:, None]).astype(float)])
    right = np.where(section, 0.0, 1.0) - level
    only_excess = penalty == np.inf
    cost = np.append(np.zeros(moving.size), [0.0, 1.0] if only_excess else [1.0, penalty])
    bounds = prepared.logarithms - here.variables[:, None]
    box = [(max(low, -radius), min(high, radius)) for low, high in bounds]
    solution = linprog(cost, rows, right, bounds=[*box, (None, None), (0.0, None)], method="highs")
    if solution.x is None:
        return np.zeros(moving.size), 0.0
    step = np.asarray(solution.x[: moving.size])
    excess = max(0.0, float(np.max(level[~section], initial=1.0)) - 1.0)
    if only_excess:
        return step, excess - float(solution.fun)
    return step, worst * (1.0 + penalty * excess - float(solution.fun))


def nearest_within_limits(prepared: Survey, broken: DesignPoint, within: DesignPoint) -> FloatArray:
    """Variables (v,) between a place that breaks a limit and one that keeps it, which still do.

    Halving the straight way in logarithms: as near to the first as a few steps tell.
    """
    bad, good = broken.variables, within.variables
    for _ in range(_HALVINGS):
        middle = 0.5 * (bad + good)
        if place(prepared, middle, tolerance=_TOLERANCE).over <= 0.0:
            good = middle
        else:
            bad = middle
    return good


def foreseen(prepared: Survey, end: DesignPoint) -> tuple[FloatArray, float]:
    """Length (v,) of the step that a linear program would still take, and what it would gain.

    What is left of a broken limit counts as if it were the objective.
    """
    penalty = np.inf if end.over > BROKEN else _PENALTIES[0]
    step, gain = _linear_program(prepared, end, _LEFT, penalty)
    worst = prepared.levels(end.peaks)[2]
    return np.abs(step) + _SMALL, abs(gain) * (worst if penalty == np.inf else 1.0) + (
        end.over * worst
    )


# ----------------------------------------------------------------------------
# The last digits of a tuning: Newton's method on the peaks that hold it.
#
# Unknowns are the variables, the common level of the sections and the weights of the peaks; the
# conditions are equal levels, limits just met, and slopes that cancel with these weights. Peaks
# are followed to their own speeds at each step, so that no grid of speeds remains in the answer.
# ----------------------------------------------------------------------------

_MOST_STEPS = 20
#: change of a logarithm in one step
_LONGEST = 0.1
_DIFFERENCE = 1e-4
_PROBE = 1e-10
#: round-off of a slope by a logarithm over that of its value
_SLOPE = 3.0


class Stationary(NamedTuple):
    """A tuning at which weighted slopes cancel.

    `variables` (v,) are logarithms, `level` the common height of the sections at the peaks `peaks`,
    `weight` (p,) of these, of sections they add up to 1; `bound_weight` (v,) what bounds pull;
    `speed` (p,) in rad/s; `residual` of the slopes over the level, `curvature` least of the
    Lagrangian along directions that the peaks leave free, over the level (infinite where they leave
    none).
    """

    variables: Bounded
    level: Bounded
    peaks: DamperPeaks
    weight: Bounded
    bound_weight: Bounded
    speed: Bounded
    residual: float
    curvature: Bounded


def newton(
    prepared: Survey, variables: FloatArray, tops: DamperPeaks, fixed: BoolArray
) -> Stationary | None:
    """Iterate with these active peaks and fixed variables; None where it does not converge."""
    moving, free = prepared.moving, np.flatnonzero(~fixed)
    f, p = free.size, tops.row.size
    x, weight, last = variables.copy(), np.zeros(p), np.inf
    for _ in range(_MOST_STEPS):
        now = tracked(prepared, x, tops)
        if now is None:
            return None
        tops = now
        section, scale, _ = prepared.levels(tops)
        slope = tops.slope[:, moving] / scale[:, None]
        if not np.any(weight):
            rows = np.vstack([slope.T[free], section.astype(float)])
            weight = nonnegative_least_squares(rows, np.append(np.zeros(f), 1.0))
        hessian = _hessian(prepared, x, tops, weight / scale)
        if hessian is None:
            return None
        # for step (f,), level and new weights (p,)
        matrix = np.zeros((f + 1 + p, f + 1 + p))
        matrix[:f, :f] = hessian[np.ix_(free, free)]
        matrix[:f, f + 1 :], matrix[f + 1 :, :f] = slope[:, free].T, slope[:, free]
        matrix[f, f + 1 :], matrix[f + 1 :, f] = section, -section.astype(float)
        right = np.where(section, 0.0, 1.0) - tops.value / scale
        right = np.concatenate([np.zeros(f), [1.0], right])
        solution = np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-13)[0], dtype=float)
        step, weight = solution[:f], solution[f + 1 :]
        length = float(np.max(np.abs(step), initial=0.0))
        x = x.copy()
        x[free] += step * min(1.0, _LONGEST / max(length, 1e-300))
        if length < 1e-10 or (length < 1e-6 and length > 0.3 * last):
            return _finished(prepared, x, tops, weight, fixed, hessian, matrix, length)
        last = length
    return None


def tracked(prepared: Survey, variables: FloatArray, tops: DamperPeaks) -> DamperPeaks | None:
    """The same peaks of a damper close by; None where one has gone from its place."""
    system = prepared.system
    low, high = about(tops, system.problem.speed, prepared.step)
    now = follow(system, prepared.damper(variables), tops.row, low, high, near=tops.phase)
    reach = 3.0 * np.maximum(high - tops.speed, tops.speed - low)
    return None if np.any(np.abs(now.speed - tops.speed) > reach) else now


def _hessian(
    prepared: Survey, x: FloatArray, tops: DamperPeaks, share: FloatArray,
    difference: float = _DIFFERENCE,
) -> FloatArray | None:  # fmt: skip
    """Curvature (v, v) of the peaks with shares (p,), by central differences of slopes."""
    columns = []
    for move in difference * np.eye(x.size):
        pair = [tracked(prepared, x + side * move, tops) for side in (1.0, -1.0)]
        if pair[0] is None or pair[1] is None:
            return None
        columns.append(share @ (pair[0].slope - pair[1].slope)[:, prepared.moving])
    result = np.array(columns).reshape(x.size, x.size) / (2.0 * difference)
    symmetric: FloatArray = 0.5 * (result + result.T)
    return symmetric


def _finished(
    prepared: Survey, x: FloatArray, tops: DamperPeaks, weight: FloatArray, fixed: BoolArray,
    hessian: FloatArray, matrix: FloatArray, length: float,
) -> Stationary | None:  # fmt: skip
    """Level, errors and certificate at the end of the iteration."""
    end = tracked(prepared, x, tops)
    inwards = np.where(x < prepared.logarithms.mean(axis=1), _PROBE, -_PROBE) * ~fixed
    nearby = tracked(prepared, x + inwards, tops)
    if end is None or nearby is None:
        return None
    moving, free = prepared.moving, np.flatnonzero(~fixed)
    system, damper = prepared.system, prepared.damper(x)
    section, scale, worst = prepared.levels(end)
    slope = end.slope[:, moving] / scale[:, None]
    balance = weight @ slope
    # noise of levels: bounds on round-off; of slopes: what a step of 1e-10 changes beyond what
    # their curvature says
    jump = (nearby.value - end.value) / scale - slope @ inwards
    rounding = reading_error(system, damper, end.speed, end.row, end.phase)
    value_noise = rounding / scale + np.abs(jump)
    moved = weight @ (nearby.slope[:, moving] / scale[:, None])
    # differences across a bound are not known: of free variables alone
    probed = np.abs(moved - balance - hessian @ inwards)[free]
    spread = float(np.abs(weight) @ value_noise)
    slope_noise = float(np.max(probed, initial=0.0) + _SLOPE * spread)
    residual = np.abs(balance[free])
    noise = np.concatenate([slope_noise + residual, [0.0], value_noise])
    unknown = np.abs(np.linalg.pinv(matrix, rcond=1e-13)) @ noise
    unknown = unknown + length**2 + 1e-3 * length
    error = np.zeros(moving.size)
    error[free] = unknown[: free.size]
    weight_error = unknown[free.size + 1 :]
    bound_error = np.abs(slope.T) @ weight_error + np.abs(hessian) @ error + slope_noise
    share = float(weight[section] @ (end.value[section] / worst))
    unequal = float(np.max(np.abs(end.value[section] / worst - share), initial=0.0))
    slack = spread + float(np.sum(residual) * np.max(error, initial=0.0)) + unequal
    by_damper = drift(system, damper, end, prepared.step)[:, moving]
    speed_error = place_error(system, damper, end) + np.abs(by_damper) @ error
    curvature, curvature_error = _curvature(matrix, free.size), 0.0
    if np.isfinite(curvature):
        wider = _hessian(prepared, x, end, weight / scale, 2.0 * _DIFFERENCE)
        if wider is None:
            return None
        curvature_error = float(np.linalg.norm(wider - hessian, 2)) + slope_noise / _DIFFERENCE
    return Stationary(
        Bounded(x, error),
        Bounded(np.asarray(worst * share), np.asarray(worst * slack)),
        end,
        Bounded(weight, weight_error),
        Bounded(np.where(fixed, -balance, 0.0), np.where(fixed, bound_error, 0.0)),
        Bounded(end.speed, speed_error),
        float(np.max(residual, initial=0.0)),
        Bounded(np.asarray(curvature), np.asarray(curvature_error)),
    )


def _curvature(matrix: FloatArray, free: int) -> float:
    """Least eigenvalue of the curvature within directions that keep all active levels."""
    if free == 0:
        return np.inf
    rows = matrix[free + 1 :, : free + 1]
    _, size, right = np.linalg.svd(rows)
    rank = int(np.sum(size > 1e-10 * max(float(size[0]), 1e-300)))
    null = right[rank:, :free].T
    if null.shape[1] == 0:
        return np.inf
    length = np.linalg.norm(null, axis=0)
    null = np.linalg.qr(null[:, length > 1e-12])[0]
    if null.shape[1] == 0:
        return np.inf
    return float(np.min(np.linalg.eigvalsh(null.T @ matrix[:free, :free] @ null)))


# ----------------------------------------------------------------------------
# Which peaks and bounds hold a tuning: an active set around Newton's method.
# ----------------------------------------------------------------------------

_CLOSENESS = (3e-3, 3e-4, 3e-2)
_ROUNDS = 12
_WRONG = 1e-7
_SHARE = 0.9
#: peaks of a section whose speeds differ by less than this share are pairs of one cycle
_ONE_CYCLE = 1e-3


def settle(prepared: Survey, end: DesignPoint) -> Stationary | None:
    """Refine the end of a descent; None where no set of peaks and bounds holds it.

    Crests of one cycle that are all but equal may rise and fall together everywhere: no tuning
    makes them equal. A second search therefore holds the highest of each cycle only.
    """
    for alone in (False, True):
        for closeness in _CLOSENESS:
            tops, fixed = _first_guess(prepared, end, closeness, alone)
            held = _iterate(prepared, end, tops, fixed, alone)
            if held is not None and _is_minimum(end, held):
                return held
    return None


def _same_cycle(tops: DamperPeaks, one: DamperPeaks) -> BoolArray:
    """Which peaks (p,) are read in the same cycle as a single one."""
    near = np.abs(tops.speed / one.speed[0] - 1.0) < _ONE_CYCLE
    same: BoolArray = near & (tops.row == one.row[0])
    return same


def _highest(tops: DamperPeaks) -> DamperPeaks:
    """The highest peak of each cycle."""
    highest: list[int] = []
    for i in np.argsort(-tops.value, kind="stable"):
        if not np.any(
            _same_cycle(tops.some(np.array(highest, dtype=int)), tops.some(np.array([i])))
        ):
            highest.append(int(i))
    return tops.some(np.array(highest, dtype=int))


def _is_minimum(end: DesignPoint, held: Stationary) -> bool:
    """Whether the refined place is no saddle and no worse than where the descent ended."""
    lower = held.level.value <= end.merit * (1.0 + 1e-6) or end.over > 1e-6
    return bool(held.curvature.value > 0.0 and lower)


def _first_guess(
    prepared: Survey, end: DesignPoint, closeness: float, alone: bool
) -> tuple[DamperPeaks, BoolArray]:
    """Peaks near the top and bounds nearby that least squares gives a weight."""
    tops, x = _highest(end.peaks) if alone else end.peaks, end.variables
    section, scale, _ = prepared.levels(tops)
    near = tops.value / scale >= 1.0 - closeness
    tops, section, scale = tops.some(near), section[near], scale[near]
    bounds = prepared.logarithms
    low, high = x - bounds[:, 0] < closeness, bounds[:, 1] - x < closeness
    normals = np.hstack([np.diag(high.astype(float)), -np.diag(low.astype(float))])
    slope = (tops.slope[:, prepared.moving] / scale[:, None]).T
    top = np.hstack([slope, normals])
    last = np.append(section.astype(float), np.zeros(normals.shape[1]))
    right = np.append(np.zeros(prepared.moving.size), 1.0)
    weight = nonnegative_least_squares(np.vstack([top, last]), right)
    used = weight[: tops.row.size] > _WRONG
    pulls = weight[tops.row.size :].reshape(2, -1).sum(axis=0)
    return tops.some(used), pulls > _WRONG


def _iterate(
    prepared: Survey, end: DesignPoint, tops: DamperPeaks, fixed: BoolArray, alone: bool
) -> Stationary | None:
    bounds, x = prepared.logarithms, end.variables.copy()
    for _ in range(_ROUNDS):
        if not np.any(prepared.levels(tops)[0]):
            return None
        nearer = np.where(x < bounds.mean(axis=1), bounds[:, 0], bounds[:, 1])
        x = np.where(fixed, nearer, x)
        held = newton(prepared, x, tops, fixed)
        if held is None:
            return None
        x, weight, pull = held.variables.value, held.weight.value, held.bound_weight.value
        beyond = (x < bounds[:, 0]) | (x > bounds[:, 1])
        if np.any(beyond & ~fixed):
            fixed = fixed | beyond
            x = np.clip(x, bounds[:, 0], bounds[:, 1])
            continue
        tops = held.peaks
        if weight.size > 1 and float(np.min(weight)) < -_WRONG:
            tops = tops.some(np.arange(weight.size) != int(np.argmin(weight)))
            continue
        # a lower bound holds back a value that would gain by falling, an upper one by rising
        upper = x > bounds.mean(axis=1)
        wrong = fixed & (np.where(upper, pull, -pull) < -_WRONG)
        if np.any(wrong):
            fixed = fixed & ~wrong
            continue
        missing = _above(prepared, held)
        if missing is None:
            return held
        if alone:
            tops = tops.some(~_same_cycle(tops, missing))
        tops = tops.joined(missing)
    return None


def _above(prepared: Survey, held: Stationary) -> DamperPeaks | None:
    """The worst peak above the level or a limit that is not yet held, or None."""
    tops = prepared.peaks(prepared.damper(held.variables.value), _SHARE)
    level, known = held.level, held.peaks
    scale = np.where(prepared.levels(tops)[0], level.value, prepared.scale[tops.row])
    over = tops.value / scale - 1.0
    same = (known.row == tops.row[:, None]) & same_branch(
        prepared.system, known.phase, tops.phase[:, None]
    )
    same &= np.abs(known.speed / tops.speed[:, None] - 1.0) < 1e-5
    over[np.any(same, axis=1)] = 0.0
    worst = int(np.argmax(over))
    if over[worst] <= 1e-10 + 2.0 * float(level.error / level.value):
        return None
    return tops.some(np.array([worst]))


# ----------------------------------------------------------------------------
# How far descents ended from the optima of their own basins.
# ----------------------------------------------------------------------------

#: an end this close, in logarithms and in height, belongs to the optimum already held
_SAME, _AS_HIGH = 0.03, 1e-3
#: a foreseen step below which an end counts as the optimum of its basin
_SETTLED = 0.01
#: height over that of the optimum up to which another basin is worth its own proof
_RIVAL = 1.05


def basins(prepared: Survey, held: Stationary, ends: list[DesignPoint]) -> tuple[Bounded, Bounded]:
    """J, k, c (b, 3) and the objective (b,) of all ends, with what their optima are away.

    The way to the optimum that Newton's method finds from an end. Where none proves one, and in
    basins far above the best one, the step that a linear program would still take and its gain.
    """
    away, above = np.zeros((len(ends), 3)), np.zeros(len(ends))
    known, values = [held], np.array([prepared.damper(end.variables) for end in ends])
    for place, end in enumerate(ends):
        tuning = next((one for one in known if _belongs(one, end)), None)
        step, above[place] = foreseen(prepared, end)
        # Newton's method costs as much as a descent: not where nothing more is to be had
        rival = end.over <= BROKEN and end.merit < _RIVAL * held.level.value
        if tuning is None and rival and np.max(step, initial=0.0) > _SETTLED:
            tuning = settle(prepared, end)
            if tuning is not None:
                known.append(tuning)
        if tuning is not None:
            step = np.abs(tuning.variables.value - end.variables) + tuning.variables.error
            above[place] = abs(tuning.level.value - end.merit) + tuning.level.error
        away[place, prepared.moving] = values[place, prepared.moving] * step
    return Bounded(values, away), Bounded(np.array([end.merit for end in ends]), above)


def _belongs(held: Stationary, end: DesignPoint) -> bool:
    level = float(held.level.value)
    near = np.max(np.abs(held.variables.value - end.variables), initial=0.0) < _SAME
    return bool(near and abs(end.merit - level) < _AS_HIGH * level)
