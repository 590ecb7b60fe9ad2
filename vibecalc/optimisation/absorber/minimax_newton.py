"""Newton's method on the conditions that hold the two peaks at the optimum."""

from typing import NamedTuple

import numpy as np

from vibecalc.optimisation.absorber.minimax_points import Tunings, reduced, slopes, times

#: largest change of a logarithm in one step
_REACH = 0.7


class Balance(NamedTuple):
    """Where two peaks hold each other: place (2, n), ln u of the peaks (2, n), weight of the first.

    `curvature` (n,) of the common level along the line on which the peaks stay equal; `gap` of
    the two levels; `step` the size of the last step; `evaluations` of a peak, (n,).
    """

    place: np.ndarray
    y: np.ndarray
    weight: np.ndarray
    curvature: np.ndarray
    gap: np.ndarray
    step: np.ndarray
    evaluations: np.ndarray


def two_peaks(
    points: Tunings, place: np.ndarray, y: np.ndarray, most: int = 14,
    enough: float | np.ndarray = 1e-9,
) -> Balance:  # fmt: skip
    """Solve for equal peaks whose slopes oppose each other.

    Unknowns are ln k, ln z2, the two ln u and the weight w of the first peak; equations: both
    peaks stationary, their levels equal, w grad_1 + (1 - w) grad_2 = 0. The frequencies are
    eliminated, then the step along the difference of the gradients, so that only the curvature
    along equal peaks is divided by; where it is not positive the step goes downhill instead.
    `enough` (n,): step after which a point is done; convergence is quadratic.
    Points that leave the region where there are two peaks come back as NaN.
    """
    place, y = place.copy(), y.copy()
    count = place.shape[1]
    weight = np.full(count, 0.5)
    last = (np.full(count, np.nan), np.full(count, np.nan), np.full(count, np.inf))
    curvature, gap, size = last
    used = np.zeros(count, dtype=int)
    live = np.arange(count)
    goal = np.broadcast_to(enough, (count,))
    with np.errstate(all="ignore"):
        for _ in range(most):
            now = points.some(live) if len(live) < count else points
            found = slopes(now, place[:, live], y[:, live])
            used[live] += 2
            flat = reduced(found)
            w = weight[live]
            bend = w * flat.pp[:, 0] + (1.0 - w) * flat.pp[:, 1]
            apart = flat.p[:, 0] - flat.p[:, 1]
            length = np.hypot(*apart)
            across = apart / length
            along = np.stack([-across[1], across[0]])
            difference = flat.level[0] - flat.level[1]
            close = -across * difference / length
            pull = np.sum(along * (flat.p[:, 1] + times(bend, close)), axis=0)
            curve = np.sum(along * times(bend, along), axis=0)
            step = close - along * pull / np.abs(curve)
            shrink = np.minimum(1.0, _REACH / np.max(np.abs(step), axis=0))
            step = step * shrink
            turned = times(bend, step) + flat.p[:, 1]
            new = -np.sum(apart * turned, axis=0) / length**2
            # a frequency moves with the tuning and to the top of its own parabola
            shift = -(found.y + np.sum(found.yp * step[:, None], axis=0)) / found.yy
            shift = np.clip(shift, -_REACH, _REACH)
            wrong = ~np.all(found.yy < 0.0, axis=0)
            step[:, wrong] = np.nan
            place[:, live] += step
            y[:, live] += shift
            weight[live] = np.clip(new, 0.02, 0.98)
            curvature[live], gap[live] = curve, difference
            size[live] = np.maximum(np.max(np.abs(step), axis=0), np.max(np.abs(shift), axis=0))
            live = live[np.isfinite(size[live]) & (size[live] > goal[live])]
            if not len(live):
                break
    return Balance(place, y, weight, curvature, gap, size, used)
