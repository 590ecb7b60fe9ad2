"""From a start towards a minimax: sequential quadratic programming on the levels of the peaks.

Near a point every peak is its level plus slope times step; the multipliers of the peaks that hold
each other up weigh their second derivatives (J. Nocedal and S. J. Wright, Numerical Optimization,
2nd ed. 2006, ch. 18). The step is kept inside a box that shrinks when the peaks disappoint.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.nonnegative import nonnegative_least_squares
from vibecalc.optimisation.absorber.several_problem import Problem, Rows, largest, rows_at

_PENALTY = 20.0
_STEPS = 100
#: curvature given to the unknown level, so that the step is a least distance
_SOFT = 1e-3


class Descent(NamedTuple):
    """Where a descent ended: ratios (q,), the peaks there, how many points were evaluated."""

    ratios: np.ndarray
    rows: Rows
    evaluations: int


def descend(problem: Problem, start: np.ndarray, scale: np.ndarray, least: float) -> Descent:
    """Descend until the box is smaller than `least` (relative); `scale` (q,) is a usual size.

    Raises NumericalFailure where the peaks at the start are infinite.
    """
    lower, upper = problem.lower / scale, problem.upper / scale
    point = np.clip(start / scale, lower, upper)
    rows = rows_at(problem, point * scale)
    reach, used = 0.3, 1
    for _ in range(_STEPS):
        size = reach * np.maximum(np.abs(point), 0.05)
        box = np.maximum(lower, point - size) - point, np.minimum(upper, point + size) - point
        level, over = largest(rows)
        step, promised = _quadratic_step(_scaled(rows, scale), box)
        if promised <= 1e-13:
            break
        trial = np.clip(point + step, lower, upper)
        used += 1
        try:
            there = rows_at(problem, trial * scale)
            new, beyond = largest(there)
            gain = (level + _PENALTY * over) - (new + _PENALTY * beyond)
        except NumericalFailure:
            gain = -1.0
        if gain > 0.1 * promised:
            point, rows = trial, there
            if gain > 0.7 * promised:
                reach = min(2.0 * reach, 1.0)
        else:
            reach *= 0.3
        if reach < least:
            break
    return Descent(point * scale, rows, used)


def _scaled(rows: Rows, scale: np.ndarray) -> Rows:
    return rows._replace(slope=rows.slope * scale, bend=rows.bend * scale[:, None] * scale[None, :])


def multipliers(rows: Rows, lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, float]:
    """Weights of the rows (objective rows add to one) that best cancel their slopes, and the rest.

    `lower`, `upper`: masks of ratios that stand on a bound, which may hold against the slope.
    """
    size = rows.slope.shape[1]
    unit = np.eye(size)
    walls = np.concatenate([-unit[lower], unit[upper]])
    heavy = 1e3 * max(float(np.max(np.abs(rows.slope), initial=0.0)), 1.0)
    table = np.concatenate([rows.slope, walls])
    sums = np.concatenate([heavy * (rows.kind == 0), np.zeros(len(walls))])
    found = nonnegative_least_squares(
        np.concatenate([table.T, sums[None]]), np.append(np.zeros(size), heavy)
    )
    return found[: len(rows.level)], float(np.linalg.norm(found @ table))


def _quadratic_step(rows: Rows, box: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, float]:
    """Step that lowers the model most, and by how much it does."""
    level, over = largest(rows)
    close = rows.level > np.where(rows.kind == 0, level, 0.0) - 0.3
    weight, _ = multipliers(rows.some(close), box[0] >= 0.0, box[1] <= 0.0)
    bend = np.tensordot(weight, rows.bend[close], 1)
    values, vectors = np.linalg.eigh(0.5 * (bend + bend.T))
    floor = 1e-3 * max(float(np.max(np.abs(values))), 1e-3)
    values = np.maximum(np.abs(values), floor)
    step = np.clip(_least_distance(rows, level, (values, vectors), box), *box)
    own = rows.kind == 0
    moved = rows.level + rows.slope @ step
    bent = 0.5 * float(values @ (step @ vectors) ** 2)
    model = float(np.max(moved[own])) + bent
    excess = max(float(np.max(moved[~own], initial=0.0)), 0.0)
    return step, level + _PENALTY * over - model - _PENALTY * excess


def _least_distance(
    rows: Rows, level: float, bend: tuple[np.ndarray, np.ndarray],
    box: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:  # fmt: skip
    """min t + penalty s + d' B d / 2 over steps d, rows below t (travels below s >= 0), d in a box.

    With a little curvature given to t and s it is the point of a polyhedron nearest to the origin
    (C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974, ch. 23).
    """
    values, vectors = bend
    size, count = len(values), len(rows.level)
    back = vectors / np.sqrt(values)  # step from the scaled unknowns
    own = (rows.kind == 0).astype(float)
    root = np.sqrt(_SOFT)
    table = np.zeros((count + 1 + 2 * size, size + 2))
    right = np.zeros(len(table))
    table[:count, :size] = -rows.slope @ back
    table[:count, size], table[:count, size + 1] = own / root, (1.0 - own) / root
    right[:count] = rows.level - own * level + np.where(own > 0.0, 1.0, _PENALTY) / _SOFT
    table[count, size + 1], right[count] = 1.0 / root, _PENALTY / _SOFT
    table[count + 1 : count + 1 + size, :size], right[count + 1 : count + 1 + size] = back, box[0]
    table[count + 1 + size :, :size], right[count + 1 + size :] = -back, -box[1]
    # rows of length one, and distances of order one
    length = np.linalg.norm(table, axis=1)
    far = _PENALTY / root
    table, right = table / length[:, None], right / length / far
    goal = np.zeros(size + 3)
    goal[-1] = 1.0
    matrix = np.concatenate([table.T, right[None]])
    found = nonnegative_least_squares(matrix, goal)
    rest = matrix @ found - goal
    step: np.ndarray = back @ (-rest[:size] / rest[-1] * far)
    return step
