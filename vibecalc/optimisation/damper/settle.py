"""Which summits and bounds hold a tuning: an active set around Newton's method."""

import numpy as np

from vibecalc.numerics.nonnegative import nonnegative_least_squares
from vibecalc.numerics.typing import BoolArray
from vibecalc.optimisation.damper.active import Held, newton
from vibecalc.optimisation.damper.descend import Place
from vibecalc.optimisation.damper.follow import Summits, same_branch
from vibecalc.optimisation.damper.survey import Survey

_CLOSENESS = (3e-3, 3e-4, 3e-2)
_ROUNDS = 12
_WRONG = 1e-7
_SHARE = 0.9
#: summits of a section whose speeds differ by less than this share are pairs of one cycle
_ONE_CYCLE = 1e-3


def settle(prepared: Survey, end: Place) -> Held | None:
    """Refine the end of a descent; None where no set of summits and bounds holds it.

    Crests of one cycle that are all but equal may rise and fall together everywhere: no tuning
    makes them equal. A second search therefore holds the highest of each cycle only.
    """
    for alone in (False, True):
        for closeness in _CLOSENESS:
            seen, fixed = _first_guess(prepared, end, closeness, alone)
            held = _iterate(prepared, end, seen, fixed, alone)
            if held is not None and _is_minimum(prepared, end, held):
                return held
    return None


def _same_cycle(seen: Summits, one: Summits) -> BoolArray:
    """Which summits (p,) are read in the same cycle as a single one."""
    near = np.abs(seen.speed / one.speed[0] - 1.0) < _ONE_CYCLE
    same: BoolArray = near & (seen.row == one.row[0])
    return same


def _highest(seen: Summits) -> Summits:
    """The highest summit of each cycle."""
    kept: list[int] = []
    for i in np.argsort(-seen.value, kind="stable"):
        if not np.any(_same_cycle(seen.some(np.array(kept, dtype=int)), seen.some(np.array([i])))):
            kept.append(int(i))
    return seen.some(np.array(kept, dtype=int))


def _is_minimum(prepared: Survey, end: Place, held: Held) -> bool:
    """Whether the refined place is no saddle and no worse than where the descent ended."""
    cost = prepared.limits.inertia_price * prepared.damper(held.variables).inertia
    lower = held.level + cost <= end.merit * (1.0 + 1e-6) or end.over > 1e-6
    return held.curvature > 0.0 and lower


def _first_guess(
    prepared: Survey, end: Place, closeness: float, alone: bool
) -> tuple[Summits, BoolArray]:
    """Summits near the top and bounds nearby that least squares gives a weight."""
    seen, x = _highest(end.seen) if alone else end.seen, end.variables
    section = seen.row < prepared.system.twist.shape[0]
    worst = float(np.max(seen.value[section]))
    scale = np.where(section, worst, prepared.scale[seen.row])
    near = seen.value / scale >= 1.0 - closeness
    seen, section, scale = seen.some(near), section[near], scale[near]
    bounds = prepared.logarithms
    low, high = x - bounds[:, 0] < closeness, bounds[:, 1] - x < closeness
    normals = np.hstack([np.diag(high.astype(float)), -np.diag(low.astype(float))])
    slope = (seen.slope[:, prepared.moving] / scale[:, None]).T
    top = np.hstack([slope, normals])
    last = np.append(section.astype(float), np.zeros(normals.shape[1]))
    cost = prepared.limits.inertia_price * prepared.damper(x).inertia / worst
    right = np.append(-cost * (prepared.moving == 0), 1.0)
    weight = nonnegative_least_squares(np.vstack([top, last]), right)
    used = weight[: seen.row.size] > _WRONG
    pulls = weight[seen.row.size :].reshape(2, -1).sum(axis=0)
    return seen.some(used), pulls > _WRONG


def _iterate(
    prepared: Survey, end: Place, seen: Summits, fixed: BoolArray, alone: bool
) -> Held | None:
    bounds = prepared.logarithms
    sections = prepared.system.twist.shape[0]
    x = end.variables.copy()
    for _ in range(_ROUNDS):
        if not np.any(seen.row < sections):
            return None
        nearer = np.where(x < bounds.mean(axis=1), bounds[:, 0], bounds[:, 1])
        x = np.where(fixed, nearer, x)
        held = newton(prepared, x, seen, fixed)
        if held is None:
            return None
        beyond = (held.variables < bounds[:, 0]) | (held.variables > bounds[:, 1])
        if np.any(beyond & ~fixed):
            fixed = fixed | beyond
            x = np.clip(held.variables, bounds[:, 0], bounds[:, 1])
            continue
        x, seen = held.variables, held.seen
        if held.weight.size > 1 and float(np.min(held.weight)) < -_WRONG:
            seen = seen.some(np.arange(seen.row.size) != int(np.argmin(held.weight)))
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
            seen = seen.some(~_same_cycle(seen, missing))
        seen = seen.joined(missing)
    return None


def _above(prepared: Survey, held: Held) -> Summits | None:
    """The worst summit above the level or a limit that is not yet held, or None."""
    seen = prepared.summits(prepared.damper(held.variables), _SHARE)
    section = seen.row < prepared.system.twist.shape[0]
    scale = np.where(section, held.level, prepared.scale[seen.row])
    over = seen.value / scale - 1.0
    for i, (row, speed) in enumerate(zip(seen.row, seen.speed, strict=True)):
        known = (held.seen.row == row) & (np.abs(held.seen.speed / speed - 1.0) < 1e-5)
        known &= same_branch(prepared.system, held.seen.phase, seen.phase[i])
        if np.any(known):
            over[i] = 0.0
    worst = int(np.argmax(over))
    if over[worst] <= 1e-10 + 2.0 * held.level_error / held.level:
        return None
    return seen.some(np.array([worst]))
