"""Ranges of speeds in which a limit of the case is exceeded, and those that are barred."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.run.stage import Scene
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray, distinct
from vibecalc.torsion.adapters.bounds import SAME, Bound
from vibecalc.torsion.adapters.motion import Motion
from vibecalc.torsion.adapters.search import Search
from vibecalc.torsion.adapters.setup import Setup
from vibecalc.torsion.critical_speeds import RIVAL, barred_ranges, maxima, slopes
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


def exceeded_of(setup: Setup, search: Search, number: int, bound: Bound) -> ExceededRanges:
    """Ranges above a limit, from the samples of its use and the largest of each load."""
    columns = search.columns[f"use {number}"]
    use, speed = search.samples[search.clear][:, columns], search.pairs.imag[search.clear]
    top, undamped = search.top(f"use {number}").of(0), search.undamped_at

    def value(row: IntArray, where: FloatArray) -> FloatArray:
        return search.value(row + columns.start, where)

    def excess(at: FloatArray) -> FloatArray:
        found = use_of.of(Motion(setup, at)).value
        return np.asarray(np.max(found, axis=1, initial=0.0) - 1.0)

    use_of = search.readings[0][f"use {number}"]
    # maxima that may exceed the limit between the speeds, or are the largest of a range
    inside = use[1:-1]
    high = (inside > use[:-2]) & (inside >= use[2:]) & (inside >= RIVAL)
    place, section = np.nonzero(high & np.isfinite(use[:-2] + use[2:]))
    near = maxima(value, use, speed, section, place + 1, undamped)
    every = [speed, top.speed.value, undamped, near.speed, _dips(excess, use, speed)]
    ranges = barred_ranges(excess, distinct(np.concatenate(every)))
    start, end = (_at_corner(one, bound.corners) for one in (ranges.start, ranges.end))
    known = np.concatenate([
        [near.value, near.speed, near.speed_error],
        [top.value.value, *top.speed],
        np.stack([use.max(axis=1, initial=0.0), speed, np.zeros(len(speed))]),
        [np.full(len(undamped), np.inf), undamped, 1e-10 * undamped],
    ], axis=1)  # fmt: skip
    peak, peak_error = 0.5 * (start + end), 0.5 * (end - start)  # narrower than the steps
    for row, ends in enumerate(zip(start, end, strict=True)):
        held = known[:, (known[1] >= ends[0]) & (known[1] <= ends[1])]
        if held.size:
            _, peak[row], peak_error[row] = held[:, np.argmax(held[0])]
    rule, permitted = np.zeros((len(start), 2)), np.ones(len(start), dtype=np.int64)
    rated = bound.basis.rated_speed
    if rated and len(start):
        below = end <= NO_BARRED_RANGE * rated
        if bound.formula:
            barred = barred_range(peak, rated)
            rule = np.stack([barred.lower, barred.upper], axis=1)
            below = below & barred.permitted
        permitted = below.astype(np.int64)
    # nobody runs in a range that is barred
    permitted = np.where((start <= setup.speed) & (setup.speed <= end), 0, permitted)
    # what errors of the use move an end by: over the slope there
    at = np.concatenate([start, end])
    off = np.max([use_of.of(Motion(setup, part, bounded=True)).errors.max(axis=1, initial=0.0)
                  for part in (start, end)], axis=0) if len(start) else start  # fmt: skip
    with np.errstate(invalid="ignore", divide="ignore"):
        moved = np.tile(off, 2) / slopes(excess, at, float(speed[0]), float(speed[-1]))
    moved = 2.0 * np.where(np.isfinite(moved), moved, 0.0) + 8.0 * EPSILON * at
    error = np.max(moved.reshape(2, -1), axis=0)
    return ExceededRanges(start, end, error, peak, peak_error, rule, permitted)


def _at_corner(at: FloatArray, corners: FloatArray) -> FloatArray:
    """Speeds (b,) as those of corners (k,) where they are these but for the last digits."""
    for corner in corners.tolist():
        at = np.where(np.isclose(at, corner, rtol=2.0 * SAME, atol=0.0), corner, at)
    return at


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
            "a limit for continuous operation is exceeded in a range that holds the operating "
            "speed: it cannot be barred, and the line is not acceptable there"
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
