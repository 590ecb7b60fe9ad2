"""The last digits of an optimum on a kink: planes sampled around it, or an exact zero."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.conditions import measured_noise
from vibecalc.core.study.search.problem import Values, spread
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# The last digits of an optimum on a kink: planes sampled around it, and a linear programme.
# ----------------------------------------------------------------------------

FIRST_RADIUS = 3e-3
LARGEST_RADIUS = 5e-2
LAST_RADIUS = 3e-6
MOST_ROUNDS = 150
#: price of a violated margin, in units of the scaled objective
PRICE = 1e3
#: curvature granted to the pieces, in scaled units
BEND = 10.0
#: share of the promised fall that makes a step worth while
WORTH = 0.1


class DescentEnd(NamedTuple):
    """The end of the descent on the unit cube; `excess` and `error` as in `active_set`.

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
    """Values (p + m,) and gradients (p + m, n) at a point (n,)."""

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
        lowest = _lowest(planes, sampler.entries, unit, radius) if planes else None
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
            slopes = [np.linalg.norm(plane.first[: sampler.entries], axis=1) for plane in planes]
            residual = promised / (radius * max(1.0, float(np.max(slopes))))
            noise = float(np.max(measured_noise(sampler, unit)[: sampler.entries]))
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
    violated = np.max(-vector[sampler.entries :], initial=0.0)
    return float(np.max(vector[: sampler.entries]) + PRICE * violated)


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


def _lowest(planes: list[_Plane], entries: int, unit: np.ndarray, radius: float) -> _Lowest | None:
    """The lowest point of all cuts within the radius, and the merit promised there."""
    from scipy.optimize import linprog

    size = unit.size
    points, values, first = (np.array(part) for part in zip(*planes, strict=True))
    count, rows = values.shape
    height = values + np.einsum("krn,kn->kr", first, unit - points)
    tilt = first * radius
    scale = max(float(np.max(np.abs(tilt[:, :entries]))), 1e-300)
    top = float(np.max(height[:, :entries]))
    # unknowns: step / radius (n), height above the top / scale, violation / scale
    objective = np.hstack(
        [tilt[:, :entries].reshape(-1, size) / scale, np.tile([-1.0, 0.0], (count * entries, 1))]
    )
    margin = np.hstack(
        [
            -tilt[:, entries:].reshape(-1, size) / scale,
            np.tile([0.0, -1.0], (count * (rows - entries), 1)),
        ]
    )
    right = np.concatenate([top - height[:, :entries].ravel(), height[:, entries:].ravel()])
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
    duals = -np.asarray(programme.ineqlin.marginals)[count * entries :]
    margins = np.sum(duals.reshape(count, rows - entries), axis=0)
    walls = np.where(least > -1.0, programme.lower.marginals[:size], 0.0)
    walls = walls + np.where(most < 1.0, programme.upper.marginals[:size], 0.0)
    merit = top + scale * float(programme.x[size] + PRICE * programme.x[size + 1])
    lowest = np.clip(unit + radius * programme.x[:size], 0, 1)
    return _Lowest(lowest, merit, margins, walls * scale / radius)


# ----------------------------------------------------------------------------
# Objectives that fall to an exact zero with a kink, as a difference without its sign does.
# ----------------------------------------------------------------------------

MOST_STEPS = 200
#: steps in which the height may fail to halve
PATIENCE = 12
#: difference step over the distance that is left to the zero
_NEAR = 1e-2
#: below this height the last gradient is better than a new one
_TOO_NEAR = 1e-8
#: radius on the unit cube at which the surroundings of a zero are sampled
_AROUND = 1e-5
#: singular value, relative to the largest, of a direction in which a zero is held
_HELD = 3e-3


class Zero(NamedTuple):
    """A zero of the objective on the unit cube that keeps all margins.

    `objective` is what is left of it, `slope` its least rise per unit of distance, and
    `free_directions` the dimension of the set of zeros around it.
    """

    unit: np.ndarray
    objective: float
    slope: float
    free_directions: int


def reach_zero(sampler: Values, start: np.ndarray, floor: float, enough: float) -> Zero | None:
    """Walk from the end of a search to a zero; None where the objective has none nearby.

    Parameters
    ----------
    sampler : Values
        Its entries are never negative.
    start : (n,) array
        Point of the unit cube.
    floor : float
        Value, in scaled units, below which there is no point in going on.
    enough : float
        Largest value that counts as a zero where no step makes it smaller.

    Notes
    -----
    The largest entry plus all violations grows in proportion to the distance from the zeros that
    keep the margins. A step against its gradient as long as the zero is far on a straight slope
    (B. T. Polyak, USSR Comput. Math. Math. Phys. 9 (1969), 14-29) doubles the digits where one
    smooth difference vanishes, and adds some where several do. It does not mind that a whole
    surface of zeros is as good, nor how that surface bends. The gradients around the zero span
    the directions that hold it; the others are free.
    """
    unit, value = start, _height(sampler, start)
    best, lowest, vain = unit, value, 0
    slope: np.ndarray | None = None
    for _ in range(MOST_STEPS):
        if value <= floor:
            break
        if slope is None or value > _TOO_NEAR:
            slope = _gradient(sampler, unit, value)
        if slope is None:
            break
        unit = np.clip(unit - value / float(slope @ slope) * slope, 0.0, 1.0)
        value = _height(sampler, unit)
        vain = 0 if value < 0.5 * lowest else vain + 1
        if value < lowest:
            best, lowest = unit, value
        if vain > PATIENCE or not np.isfinite(value):
            break
    return _described(sampler, best) if lowest <= enough else None


def _height(sampler: Values, unit: np.ndarray) -> float:
    vector = sampler(unit)
    if vector is None:
        return np.inf
    broken = np.sum(np.maximum(0.0, -vector[sampler.entries :]))
    return float(np.max(vector[: sampler.entries]) + broken)


def _gradient(sampler: Values, unit: np.ndarray, value: float) -> np.ndarray | None:
    """Forward differences short next to the way to the zero; None on level ground.

    On a wall of the cube a component that points out of it is dropped.
    """
    slope = np.zeros(unit.size)
    step = 1e-7
    for _ in range(8):  # the step is only known to be short once the slope is
        for axis in range(unit.size):
            nearby = unit.copy()
            nearby[axis] += step if unit[axis] < 0.5 else -step
            slope[axis] = (_height(sampler, nearby) - value) / (nearby[axis] - unit[axis])
        if not np.all(np.isfinite(slope)):
            return None
        length = float(np.linalg.norm(slope))
        if length == 0.0:
            return None
        wanted = max(_NEAR * value / length, 1e-13)
        if step <= 3.0 * wanted:
            break
        step = wanted
    out = ((unit <= 0) & (slope > 0)) | ((unit >= 1) & (slope < 0))
    slope = np.where(out, 0.0, slope)
    return slope if np.any(slope) else None


def _described(sampler: Values, unit: np.ndarray) -> Zero | None:
    """Rank of the gradients around the zero, and how steeply the objective leaves it."""
    size = unit.size
    vector = sampler(unit)
    assert vector is not None
    objective = float(np.max(vector[: sampler.entries]))
    inwards = np.clip(unit, _AROUND, 1.0 - _AROUND)
    gradients = []
    for offset in 2.0 * spread(4 * size, size) - 1.0:
        point = np.clip(inwards + _AROUND * offset, 0.0, 1.0)
        slope = _plain_gradient(sampler, point)
        if slope is not None:
            gradients.append(slope)
    if not gradients:
        return None
    # on a wall only what lies within it is free
    inside = (unit > 0) & (unit < 1)
    _, singular, right = np.linalg.svd(np.array(gradients)[:, inside], full_matrices=False)
    rank = int(np.sum(singular > _HELD * max(float(np.max(singular, initial=0.0)), 1e-300)))
    held = np.zeros((rank, size))
    held[:, inside] = right[:rank]
    rises = []
    for direction in [*held, *(-held), *(np.sum(held, axis=0, keepdims=True) if rank > 1 else ())]:
        near, far = (
            _height(sampler, np.clip(unit + radius * direction, 0.0, 1.0)) - objective
            for radius in (_AROUND, 2.0 * _AROUND)
        )
        if far > 3.0 * near:
            return None  # it grows with the square of the distance: no kink
        rises.append(near / (_AROUND * float(np.linalg.norm(direction))))
    least = min(rises, default=0.0)
    if rank and least <= 1e2 * EPSILON / _AROUND:
        return None
    return Zero(unit, objective, least if rank else np.inf, int(np.sum(inside)) - rank)


def _plain_gradient(sampler: Values, unit: np.ndarray) -> np.ndarray | None:
    """Gradient of the largest entry alone, None where it is zero or cannot be formed."""
    centre = sampler(unit)
    if centre is None:
        return None
    slope = np.zeros(unit.size)
    top = float(np.max(centre[: sampler.entries]))
    for axis in range(unit.size):
        nearby = unit.copy()
        nearby[axis] += 1e-8 if unit[axis] < 0.5 else -1e-8
        value = sampler(nearby)
        if value is None:
            return None
        slope[axis] = (float(np.max(value[: sampler.entries])) - top) / (nearby[axis] - unit[axis])
    return slope if np.any(slope) else None
