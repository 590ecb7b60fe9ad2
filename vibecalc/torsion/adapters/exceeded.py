"""Ranges of speeds in which a limit of the case is exceeded, and those that are barred."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF, FloatArray, IntArray, distinct
from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.adapters.bounds import ROUNDINGS, Bound
from vibecalc.torsion.adapters.curves import solved
from vibecalc.torsion.adapters.loads import limits_gears, load_uncertainty, loads_of
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.critical_speeds import (
    RIVAL,
    Maxima,
    Value,
    barred_ranges,
    maxima,
    slopes,
)
from vibecalc.torsion.results import ROOT
from vibecalc.torsion.stress_limits import NO_BARRED_RANGE, barred_range

# ----------------------------------------------------------------------------
# Adapter: ranges of speeds in which a limit is exceeded, and the barred ranges that follow.
#
# A class rule bars more than the range in which the stress exceeds its limit: all of its formula's
# range about the speed of largest use.
# ----------------------------------------------------------------------------

#: minima above a limit, lowest first, that are searched between the speeds
DIPS = 64


class ExceededRanges(NamedTuple):
    """Ranges (b,) above one limit in rad/s: ends, speed of the largest use inside, with errors.

    `rule` (b, 2) is what the formula of a class rule bars about that speed, 0 without a rule.
    """

    start: FloatArray
    end: FloatArray
    error: FloatArray
    peak: FloatArray
    peak_error: FloatArray
    rule: FloatArray
    permitted: IntArray


def exceeded_of(
    setup: Setup,
    bound: Bound,
    use: FloatArray,
    top: Maxima,
    make: Callable[[IntArray], Value],
    speed: FloatArray,
    undamped: FloatArray,
) -> ExceededRanges:
    """Ranges above a limit with the uses (s, r) of its loads and the largest of each, `top`."""
    excess = _excess(setup, bound)
    near = [
        speed,
        top.speed,
        undamped,
        _close(use, make, speed, undamped),
        _dips(excess, use, speed),
    ]
    ranges = barred_ranges(excess, distinct(np.concatenate(near)))
    ends = list(zip(ranges.start.tolist(), ranges.end.tolist(), strict=True))
    peaks = [_peak(use, top, make, speed, undamped, *one) for one in ends]
    peak, peak_error = (np.array([one[k] for one in peaks]) for k in (0, 1))
    rule, permitted = np.zeros((len(ends), 2)), np.ones(len(ends), dtype=np.int64)
    rated = bound.basis.rated_speed
    if rated and len(ends):
        below = ranges.end <= NO_BARRED_RANGE * rated
        if bound.formula:
            barred = barred_range(peak, rated)
            rule = np.stack([barred.lower, barred.upper], axis=1)
            below = below & barred.permitted
        permitted = below.astype(np.int64)
    # nobody runs in a range that is barred
    permitted = np.where((ranges.start <= setup.speed) & (setup.speed <= ranges.end), 0, permitted)
    asked = float(speed[0]), float(speed[-1])
    error = np.array([_uncertainty(setup, bound, excess, one, asked) for one in ends])
    return ExceededRanges(ranges.start, ranges.end, error, peak, peak_error, rule, permitted)


def emit_barred(scene: Scene, ranges: list[ExceededRanges], speed: float) -> None:
    """Ranges above each limit, in the order of the limits, and what is barred for all of them.

    No range may be that holds the operating `speed` in rad/s.
    """
    place = f"{ROOT}/exceeded"
    start, end, error, peak, peak_error, rule, permitted = (
        np.concatenate(part) for part in zip(*ranges, strict=True)
    )
    number = np.repeat(np.arange(1, len(ranges) + 1), [len(one.start) for one in ranges])
    axes = {"exceeded": np.arange(1, len(start) + 1)}
    scene.emit(f"{place}/from", start, error, axes)
    scene.emit(f"{place}/to", end, error, axes)
    scene.emit(f"{place}/limit", number, 0.0, axes)
    peak_error = peak_error + 4.0 * EPSILON * peak
    scene.emit(f"{place}/peak_speed", peak, peak_error, axes)
    # the ends move by at most 9/8 of what the peak does
    off = np.where(rule[:, 0] > 0.0, 1.2 * peak_error + 8.0 * EPSILON * peak, 0.0)
    scene.emit(f"{place}/formula_from", rule[:, 0], off, axes)
    scene.emit(f"{place}/formula_to", rule[:, 1], off, axes)
    scene.emit(f"{place}/permitted", permitted, 0.0, axes)
    ruled = rule[:, 0] > 0.0
    lower = np.where(ruled, np.minimum(start, rule[:, 0]), start)
    upper = np.where(ruled, np.maximum(end, rule[:, 1]), end)
    joined = united(lower, upper)
    axes = {"barred": np.arange(1, len(joined) + 1)}
    uncertainty = np.maximum(error, off)
    off_of = np.array([np.max(uncertainty[group]) for group in joined])
    for name, value in (
        ("from", [np.min(lower[group]) for group in joined]),
        ("to", [np.max(upper[group]) for group in joined]),
    ):
        scene.emit(f"{ROOT}/barred/{name}", np.array(value), off_of, axes)
    allowed = np.array([np.min(permitted[group]) for group in joined], dtype=np.int64)
    held = [np.min(lower[group]) <= speed <= np.max(upper[group]) for group in joined]
    allowed = np.where(np.array(held, dtype=bool), 0, allowed)
    scene.emit(f"{ROOT}/barred/permitted", allowed, 0.0, axes)
    if any(held):
        scene.warn(
            "a limit for lasting operation is exceeded in a range that holds the operating speed: "
            "it cannot be barred, and the line is not acceptable there"
        )


def united(lower: FloatArray, upper: FloatArray) -> list[IntArray]:
    """Places of the ranges (b,) that overlap or touch, group by group, by rising speed."""
    groups: list[list[int]] = []
    reach = -np.inf
    for place in np.argsort(lower, kind="stable").tolist():
        if lower[place] > reach:
            groups.append([])
        groups[-1].append(place)
        reach = max(reach, float(upper[place]))
    return [np.array(group, dtype=np.int64) for group in groups]


def _close(
    use: FloatArray, make: Callable[[IntArray], Value], speed: FloatArray, undamped: FloatArray
) -> FloatArray:
    """Speeds (k,) of maxima that are below a limit at the speeds (s,) and may exceed it between."""
    inside = use[1:-1]
    high = (inside > use[:-2]) & (inside >= use[2:]) & (inside >= RIVAL) & (inside < 1.0)
    high &= np.isfinite(use[:-2] + use[2:])
    place, section = np.nonzero(high)
    place = place + 1
    if not len(place):
        return np.zeros(0)
    return maxima(make, use, speed, section, place, undamped).speed


def _dips(
    excess: Callable[[FloatArray], FloatArray], use: FloatArray, speed: FloatArray
) -> FloatArray:
    """Speeds (k,) of minima above a limit that may be below it between the speeds (s,)."""
    worst = np.max(use, axis=1)
    inside = worst[1:-1]
    low = (inside <= worst[:-2]) & (inside <= worst[2:]) & (inside > 1.0)
    place = np.flatnonzero(low) + 1
    place = np.sort(place[np.argsort(worst[place], kind="stable")][:DIPS])
    if not len(place):
        return np.zeros(0)
    start, at, end = speed[place - 1], speed[place], speed[place + 1]
    row, share = np.arange(len(place)), np.linspace(0.0, 1.0, 9)
    for _ in range(3):
        where = np.concatenate(
            [start[:, None] + (at - start)[:, None] * share,
             at[:, None] + (end - at)[:, None] * share[1:]], axis=1,
        )  # fmt: skip
        values = excess(where.ravel()).reshape(where.shape)
        best = np.clip(np.argmin(values, axis=1), 1, where.shape[1] - 2)
        start, at, end = where[row, best - 1], where[row, best], where[row, best + 1]
    return at


def _peak(
    use: FloatArray,
    top: Maxima,
    make: Callable[[IntArray], Value],
    speed: FloatArray,
    undamped: FloatArray,
    start: float,
    end: float,
) -> tuple[float, float]:
    """Speed of the largest use between two speeds, and its error."""
    without_end = undamped[(undamped >= start) & (undamped <= end)]
    if len(without_end):
        return float(without_end[0]), 1e-10 * float(without_end[0])
    peaks: list[tuple[float, float, float]] = []
    inside = np.flatnonzero((speed >= start) & (speed <= end))
    if len(inside):
        place, section = np.unravel_index(int(np.argmax(use[inside])), use[inside].shape)
        at = np.array([inside[place]])
        near = maxima(make, use, speed, np.array([section]), at, undamped)
        peaks.append((float(near.value[0]), float(near.speed[0]), float(near.speed_error[0])))
    for k in np.flatnonzero((top.speed >= start) & (top.speed <= end)).tolist():
        peaks.append((float(top.value[k]), float(top.speed[k]), float(top.speed_error[k])))
    if not peaks:  # narrower than the steps of the sweep
        return 0.5 * (start + end), 0.5 * (end - start)
    _, at_speed, error = max(peaks)
    return at_speed, error


def _excess(setup: Setup, bound: Bound) -> Callable[[FloatArray], FloatArray]:
    """Largest stress or torque less what is allowed, over the loads of a limit, at speeds (s,)."""
    gears = limits_gears(setup)

    def excess(speed: FloatArray) -> FloatArray:
        state = solved(setup.model, setup.drive, speed)
        loads = state.torque
        if gears:
            loads = loads_of(setup.shaft, setup.drive, setup.model, state)
        torque = np.moveaxis(loads[..., bound.load], 1, -1)
        stress = synthesis(setup.drive.cycles, torque).half_range * bound.factor
        limit = bound.continuous(speed)
        says = np.isfinite(limit)
        over = np.where(says, stress - np.where(says, limit, 0.0), -1.0)
        endless = np.any(state.masked, axis=1) & np.any(says, axis=1)
        return np.where(endless, np.inf, np.max(over, axis=1))

    return excess


def _uncertainty(
    setup: Setup,
    bound: Bound,
    excess: Callable[[FloatArray], FloatArray],
    ends: tuple[float, float],
    within: tuple[float, float],
) -> float:
    """What errors of the load and of the limit move an end of a range by: over the slope there.

    `within` are the ends of the speeds that were asked for.
    """
    at, load = np.array(ends), bound.load
    torque = load_uncertainty(setup, np.repeat(at, len(load)), np.tile(load, 2))
    error = np.max(torque.reshape(2, -1) * bound.factor, axis=1)
    if bound.roundings > ROUNDINGS:
        limit = bound.continuous(at)
        limit = np.max(np.where(np.isfinite(limit), limit, 0.0), axis=1)
        error = error + bound.roundings * UNIT_ROUNDOFF * limit
    with np.errstate(invalid="ignore", divide="ignore"):
        moved = error / slopes(excess, at, *within)
    moved = np.where(np.isfinite(moved), moved, 0.0)
    return float(np.max(2.0 * moved + 8.0 * EPSILON * at))
