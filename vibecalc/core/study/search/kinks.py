"""The last digits of an optimum on a kink: planes sampled around it, and a linear programme."""

from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.conditions import measured_noise
from vibecalc.core.study.search.problem import KNOWN, BudgetSpent, Values, spread

FIRST_RADIUS = 3e-3
LARGEST_RADIUS = 5e-2
LAST_RADIUS = 3e-6
MOST_ROUNDS = 150
#: price of a violated margin, in units of the scaled objective
PRICE = 1e3
#: curvature granted to the pieces, in scaled units
BEND = 10.0
#: violation of a margin that is none
MARGIN = 1e-9
#: share of the promised fall that makes a step worth while
WORTH = 0.1


class DescentEnd(NamedTuple):
    """The end of the descent on the unit cube; `excess` and `error` as of `newton.polish`.

    `residual` is the fall that the planes still promise, over the radius and the steepest slope;
    `margins` (m,) and `bounds` (n,) are the multipliers of the last linear programme.
    """

    unit: np.ndarray
    error: np.ndarray
    excess: float
    residual: float
    margins: np.ndarray
    bounds: np.ndarray


class _Lowest(NamedTuple):
    unit: np.ndarray
    merit: float
    margins: np.ndarray
    bounds: np.ndarray


class _Plane(NamedTuple):
    """Values (1 + m,) and gradients (1 + m, n) at a point (n,)."""

    point: np.ndarray
    values: np.ndarray
    first: np.ndarray


def settle(sampler: Values, start: np.ndarray) -> DescentEnd | None:
    """Descend on a function whose pieces meet in kinks, such as the largest of hidden curves.

    Parameters
    ----------
    sampler : Values
    start : (n,) array
        Point of the unit cube close to a local optimum.

    Returns
    -------
    settled : DescentEnd or None
        None where the surroundings cannot be evaluated.

    Notes
    -----
    Around the best point gradients are sampled at points of a low-discrepancy sequence, which
    keeps them off the kinks themselves. Their tangent planes show the pieces that meet there; a
    linear programme finds the lowest point of all planes within a radius. If it is not lower in
    truth, planes are added near it; once that does not help the radius shrinks. For the idea see
    J. V. Burke, A. S. Lewis, M. L. Overton, SIAM J. Optim. 15 (2005), 751-779.
    """
    offsets = iter(2 * spread(8 * MOST_ROUNDS + 2 * start.size, start.size) - 1)
    unit, merit = start, _merit(sampler, start)
    radius = FIRST_RADIUS
    patience = start.size + 3
    vain = 0
    planes: list[_Plane] = []
    news = [(unit, 0.5)] * (2 * start.size + 1)
    for _ in range(MOST_ROUNDS):
        new_planes = [_plane(sampler, point, size * radius, next(offsets)) for point, size in news]
        planes = [
            plane
            for plane in planes + [one for one in new_planes if one is not None]
            if np.max(np.abs(plane.point - unit)) <= 1.5 * radius
        ]
        lowest = _lowest(planes, unit, radius) if planes else None
        if lowest is None:
            return None
        promised = max(0.0, merit - lowest.merit)
        step = float(np.max(np.abs(lowest.unit - unit)))
        fall = merit - _merit(sampler, lowest.unit)
        news = [(unit, 0.5), (lowest.unit, 0.1), (lowest.unit, 0.02)]
        if fall > 0:
            unit, merit = lowest.unit, merit - fall
        if fall > WORTH * promised:
            vain = 0
            if step > 0.9 * radius:
                radius = min(LARGEST_RADIUS, 2 * radius)
            continue
        vain += 1
        if vain < patience and promised > 1e-13:
            continue
        if radius <= LAST_RADIUS:
            slopes = [float(np.linalg.norm(plane.first[0])) for plane in planes]
            residual = promised / (radius * max(1.0, *slopes))
            noise = float(measured_noise(sampler, unit)[0])
            error = np.full(unit.size, radius + step + np.sqrt(2 * noise))
            # a gradient taken across a kink lifts a plane a little: count the promise fourfold
            # and the pieces bend away from their planes by the square of the radius
            excess = 4 * promised + BEND * radius**2 + 1e-12 + 2 * noise
            return DescentEnd(unit, error, excess, residual, lowest.margins, lowest.bounds)
        vain = 0
        radius = max(LAST_RADIUS, min(0.25 * radius, 4 * step))
    return None


def _merit(sampler: Values, unit: np.ndarray) -> float:
    vector = sampler(unit)
    if vector is None:
        return np.inf
    return float(vector[0] + PRICE * np.max(-vector[1:], initial=0.0))


def _plane(sampler: Values, unit: np.ndarray, size: float, offset: np.ndarray) -> _Plane | None:
    """The tangent plane at a point alongside `unit`, or None if it cannot be evaluated there."""
    point = np.clip(unit + size * offset, 0, 1)
    step = min(1e-7, 2e-3 * size)
    centre = sampler(point)
    if centre is None:
        return None
    columns = []
    for axis in range(unit.size):
        nearby = point.copy()
        nearby[axis] += step if point[axis] < 0.5 else -step
        value = sampler(nearby)
        if value is None:
            return None
        columns.append((value - centre) / (nearby[axis] - point[axis]))
    return _Plane(point, centre, np.stack(columns, axis=1))


def _lowest(planes: list[_Plane], unit: np.ndarray, radius: float) -> _Lowest | None:
    """The lowest point of all cuts within the radius, and the merit promised there."""
    from scipy.optimize import linprog

    size = unit.size
    points, values, first = (np.array(part) for part in zip(*planes, strict=True))
    count, rows = values.shape
    height = values + np.einsum("krn,kn->kr", first, unit - points)
    tilt = first * radius
    scale = max(float(np.max(np.abs(tilt[:, 0]))), 1e-300)
    top = float(np.max(height[:, 0]))
    # unknowns: step / radius (n), height above the top / scale, violation / scale
    objective = np.hstack([tilt[:, 0] / scale, np.tile([-1.0, 0.0], (count, 1))])
    limits = count * (rows - 1)
    margin = np.hstack(
        [-tilt[:, 1:].reshape(limits, size) / scale, np.tile([0.0, -1.0], (limits, 1))]
    )
    right = np.concatenate([top - height[:, 0], height[:, 1:].ravel()])
    least, most = np.maximum(-1.0, -unit / radius), np.minimum(1.0, (1 - unit) / radius)
    bounds = [*zip(least.tolist(), most.tolist(), strict=True), (None, None), (0.0, None)]
    programme = linprog(
        np.append(np.zeros(size), [1.0, PRICE]),
        A_ub=np.vstack([objective, margin]),
        b_ub=right / scale,
        bounds=bounds,
        method="highs-ds",
    )
    if programme.x is None:
        return None
    duals = -np.asarray(programme.ineqlin.marginals)[count:]
    margins = np.sum(duals.reshape(count, rows - 1), axis=0)
    walls = np.where(least > -1.0, programme.lower.marginals[:size], 0.0)
    walls = walls + np.where(most < 1.0, programme.upper.marginals[:size], 0.0)
    merit = top + scale * float(programme.x[size] + PRICE * programme.x[size + 1])
    lowest = np.clip(unit + radius * programme.x[:size], 0, 1)
    return _Lowest(lowest, merit, margins, walls * scale / radius)


# ----------------------------------------------------------------------------
# How far an optimum may be off by errors of the values, whatever holds it.
# ----------------------------------------------------------------------------

#: first step away from an optimum, growth of the steps, halvings of the last one
FIRST_AWAY, AWAY, HALVINGS = 1e-5, 4.0, 2
#: share of a rise at half the way of it, a quarter for a parabola and half for a kink
BOWL = 0.35


def reach(sampler: Values, unit: np.ndarray, bias: np.ndarray, leaning: np.ndarray) -> np.ndarray:
    """How far each coordinate (n,) of an optimum may be off by errors (1 + m,) of the values.

    The extents of all points that lie no higher than the optimum by twice the error of the
    objective, and break margins by no more than theirs, along each axis and along those of an
    ellipsoid with the mixed changes of two coordinates. Where the objective rises as a bowl along
    all axes, what slopes `leaning` (1 + m, n) of its error make of it, where that is less.
    """
    size, base = unit.size, sampler(unit)
    if base is None or not np.any(bias > KNOWN):
        return np.zeros(size)

    def rise(step: np.ndarray) -> float:
        """Over what is allowed: 1 at its end."""
        try:
            there = sampler(np.clip(unit + step, 0.0, 1.0))
        except BudgetSpent:
            there = None
        if there is None or np.any(there[1:] < np.minimum(base[1:], 0.0) - 2.0 * bias[1:] - MARGIN):
            return np.inf
        # of an objective without error the limits alone tell
        return max(float(there[0] - base[0]), 0.0) / (2.0 * float(bias[0]) + KNOWN)

    def extent(axis: np.ndarray) -> float:
        step = FIRST_AWAY
        while step < 1.0 and rise(step * axis) < 1.0:
            step *= AWAY
        factor = AWAY
        for _ in range(HALVINGS):
            factor = float(np.sqrt(factor))
            step = step if rise(step / factor * axis) < 1.0 else step / factor
        return step

    axes = np.eye(size)
    away = np.array([max(extent(axis), extent(-axis)) for axis in axes])
    together = np.eye(size)
    for i, j in combinations(range(size), 2):
        mixed = 0.0
        for one, other in product((-0.5, 0.5), repeat=2):
            high = rise(one * away[i] * axes[i] + other * away[j] * axes[j])
            mixed += 2.0 * np.sign(one * other) * min(high, 1.0)
        together[i, j] = together[j, i] = 0.25 * mixed
    # the main directions of that ellipsoid, each as far as it goes
    turned = away[:, None] * np.linalg.eigh(together)[1]
    turned /= np.linalg.norm(turned, axis=0)
    spread = turned * [max(extent(one), extent(-one)) for one in turned.T]
    extents = np.maximum(away, np.linalg.norm(spread, axis=1))
    halves = [max(rise(0.5 * away[i] * axes[i]), rise(-0.5 * away[i] * axes[i]))
              for i in range(size)]  # fmt: skip
    if max(halves) > BOWL:
        return np.asarray(extents)
    softness = spread @ spread.T / (4.0 * bias[0] + KNOWN)
    return np.asarray(np.minimum(extents, np.abs(softness) @ leaning[0]))
