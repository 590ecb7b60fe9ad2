"""The last digits of a tuning: Newton's method on the peaks and bounds that hold it."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.least_norm import nonnegative_least_squares
from vibecalc.numerics.rounding import BoolArray, FloatArray
from vibecalc.torsion.damper_design.descend import BROKEN, DesignPoint, foreseen
from vibecalc.torsion.damper_design.peaks import (
    DamperPeaks,
    Survey,
    about,
    drift,
    follow,
    place_error,
    same_branch,
)
from vibecalc.torsion.damper_design.readings import reading_error

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

    `weight` (p,) of the peaks `peaks`, of sections they add up to 1; `bound_weight` (v,) what
    bounds pull; `variable_error` (v,) of the logarithms;
    `weight_error` (p,), `bound_error` (v,), `speed_error` (p,) in rad/s and `curvature_error`;
    `residual` of the slopes over the level, `curvature` least of the Lagrangian along directions
    that the peaks leave free, over the level (infinite where they leave none).
    """

    variables: FloatArray
    level: float
    peaks: DamperPeaks
    weight: FloatArray
    bound_weight: FloatArray
    variable_error: FloatArray
    level_error: float
    residual: float
    curvature: float
    weight_error: FloatArray
    bound_error: FloatArray
    speed_error: FloatArray
    curvature_error: float


def newton(
    prepared: Survey, variables: FloatArray, tops: DamperPeaks, fixed: BoolArray
) -> Stationary | None:
    """Iterate with these active peaks and fixed variables; None where it does not converge."""
    moving, free = prepared.moving, np.flatnonzero(~fixed)
    x = variables.copy()
    weight = np.zeros(tops.row.size)
    last = np.inf
    for _ in range(_MOST_STEPS):
        now = tracked(prepared, x, tops)
        if now is None:
            return None
        tops = now
        scale = _scale(prepared, tops)
        slope = tops.slope[:, moving] / scale[:, None]
        if not np.any(weight):
            weight = _weights(prepared, tops, slope, free)
        hessian = _hessian(prepared, x, tops, weight, scale)
        if hessian is None:
            return None
        matrix, right = _conditions(prepared, tops, slope, hessian, free)
        solution: FloatArray = np.array(np.linalg.lstsq(matrix, right, rcond=1e-13)[0], dtype=float)
        step = solution[: free.size]
        weight = solution[free.size + 1 :]
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
    low, high = about(tops, system.problem.speed, prepared.grid[1] - prepared.grid[0])
    now = follow(system, prepared.damper(variables), tops.row, low, high, near=tops.phase)
    reach = 3.0 * np.maximum(high - tops.speed, tops.speed - low)
    gone = np.abs(now.speed - tops.speed) > reach
    return None if np.any(gone) else now


def _scale(prepared: Survey, tops: DamperPeaks) -> FloatArray:
    """Worst section for sections, the limit for heat and travel (p,)."""
    section = tops.row < prepared.system.twist.shape[0]
    worst = np.max(tops.value[section])
    return np.where(section, worst, prepared.scale[tops.row])


def _weights(
    prepared: Survey, tops: DamperPeaks, slope: FloatArray, free: np.ndarray
) -> FloatArray:
    """First weights (p,), none negative, by least squares."""
    section = tops.row < prepared.system.twist.shape[0]
    rows = np.vstack([slope.T[free], section.astype(float)])
    return nonnegative_least_squares(rows, np.append(np.zeros(free.size), 1.0))


def _hessian(
    prepared: Survey, x: FloatArray, tops: DamperPeaks, weight: FloatArray, scale: FloatArray,
    difference: float = _DIFFERENCE,
) -> FloatArray | None:  # fmt: skip
    """Curvature (v, v) of the weighted peaks, by central differences of slopes."""
    count = prepared.moving.size
    result = np.zeros((count, count))
    share = weight / scale
    for column in range(count):
        pair = []
        for side in (1.0, -1.0):
            nearby = x.copy()
            nearby[column] += side * difference
            now = tracked(prepared, nearby, tops)
            if now is None:
                return None
            pair.append(share @ now.slope[:, prepared.moving])
        result[:, column] += (pair[0] - pair[1]) / (2.0 * difference)
    symmetric: FloatArray = 0.5 * (result + result.T)
    return symmetric


def _conditions(
    prepared: Survey,
    tops: DamperPeaks,
    slope: FloatArray,
    hessian: FloatArray,
    free: np.ndarray,
) -> tuple[FloatArray, FloatArray]:
    """Newton's matrix and right-hand side for step (f,), level and new weights (p,)."""
    section = tops.row < prepared.system.twist.shape[0]
    f, p = free.size, tops.row.size
    scale = _scale(prepared, tops)
    matrix = np.zeros((f + 1 + p, f + 1 + p))
    matrix[:f, :f] = hessian[np.ix_(free, free)]
    matrix[:f, f + 1 :] = slope[:, free].T
    matrix[f, f + 1 :] = section
    matrix[f + 1 :, :f] = slope[:, free]
    matrix[f + 1 :, f] = -section.astype(float)
    level = tops.value / scale
    right = np.concatenate([np.zeros(f), [1.0], np.where(section, 0.0, 1.0) - level])
    return matrix, right


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
    damper, scale = prepared.damper(x), _scale(prepared, end)
    section = end.row < prepared.system.twist.shape[0]
    worst = float(np.max(end.value[section]))
    slope = end.slope[:, moving] / scale[:, None]
    balance = weight @ slope
    bound = np.where(fixed, -balance, 0.0)
    # noise of levels: bounds on round-off; of slopes: what a step of 1e-10 changes beyond what
    # their curvature says
    value_noise = reading_error(prepared.system, damper, end.speed, end.row) / scale
    jump = (nearby.value - end.value) / scale - slope @ inwards
    value_noise = value_noise + np.abs(jump)
    moved = weight @ (nearby.slope[:, moving] / scale[:, None])
    # differences across a bound are not known: of free variables alone
    probed = np.abs(moved - balance - hessian @ inwards)[free]
    slope_noise = float(np.max(probed, initial=0.0) + _SLOPE * (np.abs(weight) @ value_noise))
    noise = np.concatenate([np.full(free.size, slope_noise), [0.0], value_noise])
    residual = np.abs(balance[free])
    noise[: free.size] += residual
    unknown = np.abs(np.linalg.pinv(matrix, rcond=1e-13)) @ noise
    unknown = unknown + length**2 + 1e-3 * length
    error = np.zeros(moving.size)
    error[free] = unknown[: free.size]
    weight_error = unknown[free.size + 1 :]
    bound_error = np.abs(slope.T) @ weight_error + np.abs(hessian) @ error + slope_noise
    level = worst * float(weight[section] @ (end.value[section] / worst))
    spread = float(np.abs(weight) @ value_noise)
    unequal = float(np.max(np.abs(end.value[section] / worst - level / worst), initial=0.0))
    curvature = _curvature(matrix, free.size)
    slack = spread + float(np.sum(residual) * np.max(error, initial=0.0)) + unequal
    step = prepared.grid[1] - prepared.grid[0]
    by_damper = drift(prepared.system, damper, end, step)[:, moving]
    speed_error = place_error(prepared.system, damper, end) + np.abs(by_damper) @ error
    curvature_error = 0.0
    if np.isfinite(curvature):
        wider = _hessian(prepared, x, end, weight, scale, 2.0 * _DIFFERENCE)
        if wider is None:
            return None
        curvature_error = float(np.linalg.norm(wider - hessian, 2)) + slope_noise / _DIFFERENCE
    return Stationary(
        x, level, end, weight, bound, error, worst * slack,
        float(np.max(residual, initial=0.0)), curvature,
        weight_error, np.where(fixed, bound_error, 0.0), speed_error, curvature_error,
    )  # fmt: skip


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
    lower = held.level <= end.merit * (1.0 + 1e-6) or end.over > 1e-6
    return held.curvature > 0.0 and lower


def _first_guess(
    prepared: Survey, end: DesignPoint, closeness: float, alone: bool
) -> tuple[DamperPeaks, BoolArray]:
    """Peaks near the top and bounds nearby that least squares gives a weight."""
    tops, x = _highest(end.peaks) if alone else end.peaks, end.variables
    section = tops.row < prepared.system.twist.shape[0]
    worst = float(np.max(tops.value[section]))
    scale = np.where(section, worst, prepared.scale[tops.row])
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
    bounds = prepared.logarithms
    sections = prepared.system.twist.shape[0]
    x = end.variables.copy()
    for _ in range(_ROUNDS):
        if not np.any(tops.row < sections):
            return None
        nearer = np.where(x < bounds.mean(axis=1), bounds[:, 0], bounds[:, 1])
        x = np.where(fixed, nearer, x)
        held = newton(prepared, x, tops, fixed)
        if held is None:
            return None
        beyond = (held.variables < bounds[:, 0]) | (held.variables > bounds[:, 1])
        if np.any(beyond & ~fixed):
            fixed = fixed | beyond
            x = np.clip(held.variables, bounds[:, 0], bounds[:, 1])
            continue
        x, tops = held.variables, held.peaks
        if held.weight.size > 1 and float(np.min(held.weight)) < -_WRONG:
            tops = tops.some(np.arange(tops.row.size) != int(np.argmin(held.weight)))
            continue
        # a lower bound holds back a value that would gain by falling, an upper one by rising
        upper = x > bounds.mean(axis=1)
        wrong = fixed & (np.where(upper, held.bound_weight, -held.bound_weight) < -_WRONG)
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
    tops = prepared.peaks(prepared.damper(held.variables), _SHARE)
    section = tops.row < prepared.system.twist.shape[0]
    scale = np.where(section, held.level, prepared.scale[tops.row])
    over = tops.value / scale - 1.0
    for i, (row, speed) in enumerate(zip(tops.row, tops.speed, strict=True)):
        known = (held.peaks.row == row) & (np.abs(held.peaks.speed / speed - 1.0) < 1e-5)
        known &= same_branch(prepared.system, held.peaks.phase, tops.phase[i])
        if np.any(known):
            over[i] = 0.0
    worst = int(np.argmax(over))
    if over[worst] <= 1e-10 + 2.0 * held.level_error / held.level:
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


def basin_errors(
    prepared: Survey, held: Stationary, ends: list[DesignPoint]
) -> tuple[FloatArray, FloatArray]:
    """Errors (b, 3) of J, k, c and (b,) of the objective of all ends.

    The way to the optimum that Newton's method finds from an end. Where none proves one, and in
    basins far above the best one, the step that a linear program would still take and its gain.
    """
    away, above = np.zeros((len(ends), 3)), np.zeros(len(ends))
    known = [held]
    for place, end in enumerate(ends):
        tuning = next((one for one in known if _belongs(one, end)), None)
        step, above[place] = foreseen(prepared, end)
        # Newton's method costs as much as a descent: not where nothing more is to be had
        rival = end.over <= BROKEN and end.merit < _RIVAL * held.level
        if tuning is None and rival and np.max(step, initial=0.0) > _SETTLED:
            tuning = settle(prepared, end)
            if tuning is not None:
                known.append(tuning)
        if tuning is not None:
            step = np.abs(tuning.variables - end.variables) + tuning.variable_error
            above[place] = abs(tuning.level - end.merit) + tuning.level_error
        values = np.array(prepared.damper(end.variables))[prepared.moving]
        away[place, prepared.moving] = values * step
    return away, above


def _belongs(held: Stationary, end: DesignPoint) -> bool:
    near = np.max(np.abs(held.variables - end.variables), initial=0.0) < _SAME
    return bool(near and abs(end.merit - held.level) < _AS_HIGH * held.level)
