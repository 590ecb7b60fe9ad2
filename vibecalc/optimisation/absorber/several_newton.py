"""The last digits of a minimax: Newton's method on the conditions that hold the peaks."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.several_descent import multipliers
from vibecalc.optimisation.absorber.several_problem import Problem, Rows, largest, rows_at

_STEPS = 15
_TIE = (1e-7, 1e-4, 1e-2, 1e-1)


class Held(NamedTuple):
    """A point that meets the conditions.

    `active` marks the rows that hold it, `weight` (r,) their multipliers (those of the objective
    add to one), `on_lower`, `on_upper` (q,) the bounds that do, `residual` what is left of the
    weighted slopes, `curvature` the least second derivative along directions that leave all active
    peaks alone (infinite if there are none), `step` the last step, all in units of `scale`.
    """

    ratios: np.ndarray
    rows: Rows
    active: np.ndarray
    weight: np.ndarray
    on_lower: np.ndarray
    on_upper: np.ndarray
    residual: float
    curvature: float
    step: float
    evaluations: int


def hold(problem: Problem, start: np.ndarray, scale: np.ndarray) -> Held | None:
    """Newton from near a minimax; None where no set of peaks and bounds holds a point nearby."""
    used = 0
    for tie in _TIE:
        found, more = _with(problem, start, scale, tie)
        used += more
        if found is not None:
            return found._replace(evaluations=used)
    return None


def _with(
    problem: Problem, start: np.ndarray, scale: np.ndarray, tie: float
) -> tuple[Held | None, int]:
    ratios, used = start, 0
    first = np.inf
    length = 0.0
    for _ in range(_STEPS):
        try:
            rows = rows_at(problem, ratios)
            rows = rows.some(~rows.shoulder)
        except NumericalFailure:
            return None, used
        used += 1
        wall = min(tie, 1e-3) * scale
        on_lower, on_upper = ratios <= problem.lower + wall, ratios >= problem.upper - wall
        top, over = largest(rows)
        first = min(first, top + over)
        gap = np.where(rows.kind == 0, top - rows.level, -rows.level)
        near = gap <= np.where(rows.moves, max(tie, min(4.0 * length, 0.1)), 1e-9)
        local = rows._replace(slope=rows.slope * scale)
        weight, _ = multipliers(local.some(near), on_lower, on_upper)
        weight_all = np.zeros(len(rows.level))
        weight_all[near] = weight
        active = weight_all > 1e-9
        free = ~(on_lower & _holds(weight_all @ local.slope, 1.0)) & ~(
            on_upper & _holds(weight_all @ local.slope, -1.0)
        )
        free &= problem.upper > problem.lower
        solved = _solve(rows, scale, active, weight_all, free)
        if solved is None:
            return None, used
        step, curvature = solved
        length = float(np.max(np.abs(step), initial=0.0))
        if length > 0.5:
            step *= 0.5 / length
        moved = np.clip(ratios + scale * step, problem.lower, problem.upper)
        moved = np.where(free, moved, np.where(on_lower, problem.lower, problem.upper))
        moved = np.where(free | on_lower | on_upper, moved, ratios)
        if length < 1e-9:
            break
        ratios = moved
    else:
        return None, used
    rest = weight_all @ local.slope
    residual = float(np.linalg.norm(rest[free]))
    far = 1e-9 + 1e2 * float(np.max(rows.error))
    spread = float(np.ptp(rows.level[active & (rows.kind == 0)]))
    own_weight = float(np.sum(weight_all[active & (rows.kind == 0)]))
    fine = residual < 1e-6 and spread < far and abs(own_weight - 1.0) < 1e-6
    fine &= bool(np.max(rows.level[rows.kind > 0], initial=0.0) < far)
    fine &= curvature > -1e-7 and top <= first + 1e-7
    if not fine:
        return None, used
    return (
        Held(ratios, rows, active, weight_all, on_lower & ~free, on_upper & ~free, residual,
             curvature, length, used),
        used,
    )  # fmt: skip


def _holds(pull: np.ndarray, sign: float) -> np.ndarray:
    """Where the weighted slope presses against the bound."""
    pressed: np.ndarray = sign * pull > 1e-9
    return pressed


def _solve(
    rows: Rows, scale: np.ndarray, active: np.ndarray, weight: np.ndarray, free: np.ndarray
) -> tuple[np.ndarray, float] | None:
    """Newton's step (q,) in units of scale, and the least curvature left free."""
    held = rows.some(active)
    bend = np.tensordot(weight[active], held.bend, 1) * scale[:, None] * scale[None, :]
    bend = bend[np.ix_(free, free)]
    slope = (held.slope * scale)[:, free]
    own = (held.kind == 0).astype(float)
    count, width = len(held.level), int(np.sum(free))
    if not count or not np.any(own):
        return None
    level = float(np.max(held.level[held.kind == 0]))
    table = np.zeros((width + count + 1, width + count + 1))
    table[:width, :width] = bend
    table[:width, width:-1] = slope.T
    table[width:-1, :width] = slope
    table[width:-1, -1] = -own
    table[-1, width:-1] = own
    right = np.zeros(width + count + 1)
    right[width:-1] = own * level - held.level
    right[-1] = 1.0
    found = np.linalg.lstsq(table, right, rcond=1e-13)[0]
    step = np.zeros(len(free))
    step[free] = found[:width]
    # directions in which all active levels stay together
    differences = slope - np.outer(own, own @ slope / np.sum(own))
    _, singular, turned = np.linalg.svd(differences, full_matrices=True)
    rank = int(np.sum(singular > 1e-9 * max(float(np.max(singular, initial=0.0)), 1e-300)))
    loose = turned[rank:]
    curvature = np.inf
    if len(loose):
        curvature = float(np.min(np.linalg.eigvalsh(loose @ bend @ loose.T)))
    return step, curvature
