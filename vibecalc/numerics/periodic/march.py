"""Periodic solutions of one scalar equation by marching turn after turn, or the proof of none.

Two solutions of a scalar equation never cross. Marching from above every periodic solution
therefore comes down to the largest of them, and a march that falls to the floor shows that none
stays above it, within the error of the integration.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.periodic.panels import Rhs, solve_or_nan
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray

_MOST_NEWTON = 12
_MOST_DIVISIONS = 6
_NEWTON_TOLERANCE = 1e-12
#: or where the next step would be below this
_AHEAD = 1e-13
#: part of the size by which a turn ends beside its start through rounding alone
_ROUNDING = 4e-15
#: part of the size within which the slopes along a turn are those along its limit
_NEAR = 1e-2


class March(NamedTuple):
    """Outcome of every member; all (B,), `path` (B, P + 1) the values of the last turn at edges.

    `converged`: the value at the first edge repeats; `change` is how far the end of `path` still is
    from the limit, by the rate at which neighbours of the last turn fall upon it and by its
    rounding; its start is off by what the turn moved. `stalled`: the floor was met, in turn `turns`
    in the panel that begins at `stalled_at` (NaN otherwise). Neither: the turns were spent.
    """

    path: FloatArray
    change: FloatArray
    turns: IntArray
    converged: BoolArray
    stalled: BoolArray
    stalled_at: FloatArray


def march_turns(
    rhs: Rhs,
    edges: FloatArray,
    start: ArrayLike,
    *,
    floor: float = -np.inf,
    points: int = 3,
    tolerance: float = 1e-6,
    most_turns: int = 200,
) -> March:
    """March y' = f(x, y), n = 1, from `start` (B,) along edges (P + 1,) or (B, P + 1).

    `floor` is the value at which a member counts as stalled; `tolerance` is relative to the largest
    value of a turn. Each panel is one implicit Gauss step; where Newton's method fails in it, it is
    divided, and a member whose value cannot be carried through a 64th of a panel, or meets the
    floor, has stalled. The right-hand side gets piece None.
    """
    value = np.atleast_1d(np.asarray(start, dtype=np.float64)).copy()
    rows = np.atleast_2d(np.asarray(edges, dtype=np.float64))
    members = max(len(value), len(rows))
    rows = np.broadcast_to(rows, (members, rows.shape[1]))
    value = np.broadcast_to(value, (members,)).copy()
    path = np.repeat(value[:, None], rows.shape[1], axis=1)
    turns = np.zeros(members, dtype=np.int64)
    converged, stalled = np.zeros(members, dtype=bool), np.zeros(members, dtype=bool)
    stalled_at, change = np.full(members, np.nan), np.full(members, np.inf)
    older, growth = np.full(members, np.inf), np.zeros(members)
    with np.errstate(all="ignore"):
        for _ in range(most_turns):
            active = ~converged & ~stalled
            if not active.any():
                break
            turns += active
            growth = np.zeros(members)
            for panel in range(rows.shape[1] - 1):
                low, high = rows[:, panel], rows[:, panel + 1]
                value, lost, grown = _panel(rhs, low, high, value, active, floor, points)
                growth += grown
                stalled |= lost
                stalled_at[lost] = low[lost]
                active = active & ~lost
                path[active, panel + 1] = value[active]
                if not active.any():
                    break
            moved = np.abs(path[:, -1] - path[:, 0])
            # the first turns from far away may fall faster than all later ones: the slope along
            # the last one knows better what a neighbour does
            rate = np.clip(np.maximum(moved / older, np.exp(growth)), 0.0, 1.0 - 1e-12)
            size = np.abs(path).max(axis=1)
            noise = _ROUNDING * size
            left = np.where(np.isfinite(older), (moved * rate + noise) / (1.0 - rate), np.inf)
            change[active] = left[active]
            near = (left <= tolerance * size) & (moved <= np.minimum(older, _NEAR * size))
            converged |= active & (near | (moved <= noise))
            older = np.where(active, moved, older)
            going = active & ~converged
            path[going, 0] = value[going]
    return March(path, change, turns, converged, stalled, stalled_at)


def _panel(
    rhs: Rhs, low: FloatArray, high: FloatArray, value: FloatArray,
    active: BoolArray, floor: float, points: int,
) -> tuple[FloatArray, BoolArray, FloatArray]:  # fmt: skip
    """Values at `high`, which members have stalled on the way, and the slope summed along it."""
    found, good, grown = _step(rhs, low, high, value, points)
    good &= found > floor
    if (good | ~active).all():
        return np.where(active, found, value), np.zeros(len(value), dtype=bool), grown
    # those that fail try ever smaller parts, each from where it stands
    done = good | ~active
    now, at = np.where(good & active, found, value), np.where(done, high, low)
    width = (high - low) * 0.5
    smallest = (high - low) * 0.5**_MOST_DIVISIONS
    lost, growth = np.zeros(len(value), dtype=bool), np.where(good, grown, 0.0)
    while not (done | lost).all():
        target = np.where(done | lost, at, np.minimum(at + width, high))
        found, good, grown = _step(rhs, at, target, now, points)
        good &= (found > floor) & ~done & ~lost
        growth += np.where(good, grown, 0.0)
        now, at = np.where(good, found, now), np.where(good, target, at)
        lost |= ~good & ~done & (width <= smallest)
        width = np.where(good | done, width, 0.5 * width)
        done |= at >= high
    return np.where(active & ~lost, now, value), lost & active, growth


def _step(
    rhs: Rhs, low: FloatArray, high: FloatArray, value: FloatArray, points: int
) -> tuple[FloatArray, BoolArray, FloatArray]:
    """One implicit Gauss step of every member, where Newton's method found it, summed slope."""
    rule = gauss_rule(points)
    width = (high - low)[:, None]
    x = (low[:, None] + width * rule.nodes)[:, None]
    stages = np.repeat(value[:, None], points, axis=1)
    good, before = np.zeros(len(value), dtype=bool), np.full(len(value), np.inf)
    f = stages
    for _ in range(_MOST_NEWTON):
        f, jacobian = rhs(x, stages[:, None, :, None], None)
        f, slope = f[:, 0, :, 0], jacobian[:, 0, :, 0, 0]
        gap = stages - value[:, None] - (width * f) @ rule.integration.T
        matrix = np.eye(points) - (width * slope)[:, None, :] * rule.integration
        step = solve_or_nan(matrix, -gap[..., None])[..., 0]
        stages = stages + step
        size = np.abs(step).max(axis=1) / np.abs(stages).max(axis=1)
        # the next step, if steps square as the last two did, and no better than plainly squared:
        # the first from a constant may be small by accident
        ahead = size * size * np.maximum(size / (before * before), 1.0)
        good = (size <= _NEWTON_TOLERANCE) | (ahead <= _AHEAD)
        good |= np.abs(step).max(axis=1) == 0.0
        if (good | ~np.isfinite(size)).all():
            break
        before = size
    f, jacobian = rhs(x, stages[:, None, :, None], None)
    found = value + (width * f[:, 0, :, 0]) @ rule.weights
    grown = (width * jacobian[:, 0, :, 0, 0]) @ rule.weights
    return found, good & np.isfinite(found), grown
