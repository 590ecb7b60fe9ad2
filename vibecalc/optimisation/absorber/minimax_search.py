"""Descent of the largest peak, with all peaks found afresh, to where Newton takes over."""

from typing import NamedTuple

import numpy as np

from vibecalc.optimisation.absorber.minimax_points import (
    Reduced,
    Tunings,
    reduced,
    slopes,
    times,
)
from vibecalc.response.absorber.peaks import maxima

#: first and largest change of ln k and ln z2 in one step
_FIRST, _LARGEST = 0.5, 1.5
#: a step this short leaves the rest to Newton's method
_SHORT = 0.02


class Found(NamedTuple):
    """Best place (2, n), ln u of its two highest peaks (2, n) and their excess (2, n).

    A place without a second peak has its excess as zero; without any peak above the floor, both.
    """

    place: np.ndarray
    y: np.ndarray
    excess: np.ndarray
    evaluations: np.ndarray


def two_highest(points: Tunings, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """ln u and excess (2, n) of the two highest maxima above the floor, by rising frequency."""
    count = place.shape[1]
    rows, u, value, _ = maxima(points.parts(place), points.weights)
    high = value > 0.0
    rows, u, value = rows[high], u[high], value[high]
    order = np.lexsort((-value, rows))
    rows, u, value = rows[order], u[order], value[order]
    rank = np.arange(len(rows)) - np.searchsorted(rows, rows)
    y, level = np.zeros((2, count)), np.zeros((2, count))
    kept = rank < 2
    y[rank[kept], rows[kept]] = np.log(u[kept])
    level[rank[kept], rows[kept]] = value[kept]
    swap = (level[1] > 0.0) & (y[1] < y[0])
    y[:, swap], level[:, swap] = y[::-1, swap], level[::-1, swap]
    return y, level


def descend(points: Tunings, place: np.ndarray, rounds: int = 60, short: float = _SHORT) -> Found:
    """Lower the largest peak from `place` (2, n) until the step is `short` or no peak is left."""
    best = place.copy()
    y, level = two_highest(points, best)
    used = np.ones(place.shape[1], dtype=int)
    reach = np.full(place.shape[1], _FIRST)
    live = np.flatnonzero(np.max(level, axis=0) > 0.0)
    for _ in range(rounds):
        if not len(live):
            break
        now = points.some(live)
        step = _step(now, best[:, live], y[:, live], level[:, live], reach[live])
        size = np.max(np.abs(step), axis=0)
        trial_y, trial_level = two_highest(now, best[:, live] + step)
        used[live] += 1
        top, old = np.max(trial_level, axis=0), np.max(level[:, live], axis=0)
        better = top < old
        moved = live[better]
        best[:, moved] += step[:, better]
        y[:, moved], level[:, moved] = trial_y[:, better], trial_level[:, better]
        full = size > 0.9 * reach[live]
        grown = np.where(full, np.minimum(2.0 * reach[live], _LARGEST), reach[live])
        reach[live] = np.where(better, grown, 0.3 * size)
        ended = (better & (size < short) & np.all(trial_level > 0.0, axis=0)) | (
            reach[live] < 1e-3 * short
        )
        live = live[~(ended | (better & (top <= 0.0)))]
    return Found(best, y, level, used)


def _step(
    points: Tunings, place: np.ndarray, y: np.ndarray, level: np.ndarray, reach: np.ndarray
) -> np.ndarray:
    """Step (2, n) of the model of one or two peaks, no longer than `reach` in either logarithm."""
    with np.errstate(all="ignore"):
        flat = reduced(slopes(points, place, y))
        main = np.argmax(level, axis=0)
        chosen = np.arange(place.shape[1])
        alone = _downhill(flat, main, chosen, reach)
        both = _balanced(flat, reach)
        usable = np.all(level > 0.0, axis=0) & np.all(np.isfinite(both), axis=0)
    step = np.where(usable, both, alone)
    return np.where(np.isfinite(step), step, 0.0)


def _downhill(flat: Reduced, main: np.ndarray, chosen: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Newton's step of the higher peak where it bends upwards, else along its slope."""
    slope, bend = flat.p[:, main, chosen], flat.pp[:, main, chosen]
    kk, kz, zz = bend
    whole = kk * zz - kz * kz
    newton = -np.stack([zz * slope[0] - kz * slope[1], kk * slope[1] - kz * slope[0]]) / whole
    convex = (whole > 0.0) & (kk > 0.0)
    step = np.where(convex, newton, -slope * reach / np.max(np.abs(slope), axis=0))
    return _within(step, reach)


def _balanced(flat: Reduced, reach: np.ndarray) -> np.ndarray:
    """Step to equal peaks and down along them; NaN where one peak would carry all the weight."""
    apart = flat.p[:, 0] - flat.p[:, 1]
    length = np.hypot(*apart)
    across = apart / length
    along = np.stack([-across[1], across[0]])
    close = -across * (flat.level[0] - flat.level[1]) / length
    weight = -np.sum(apart * flat.p[:, 1], axis=0) / length**2
    share = np.clip(weight, 0.0, 1.0)
    bend = share * flat.pp[:, 0] + (1.0 - share) * flat.pp[:, 1]
    pull = np.sum(along * (flat.p[:, 1] + times(bend, close)), axis=0)
    curve = np.abs(np.sum(along * times(bend, along), axis=0))
    step = _within(close, reach) - along * np.clip(pull / curve, -reach, reach)
    return np.where((weight > 0.0) & (weight < 1.0), _within(step, reach), np.nan)


def _within(step: np.ndarray, reach: np.ndarray) -> np.ndarray:
    shorter: np.ndarray = step * np.minimum(1.0, reach / np.max(np.abs(step), axis=0))
    return shorter
