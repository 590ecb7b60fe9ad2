"""The last digits of an optimum on a kink: planes sampled around it, and a linear programme."""

from contextlib import suppress

import numpy as np

from vibecalc.core.study.search.derivatives import measured_noise
from vibecalc.core.study.search.local_search import Stranded, forward_slopes, with_steps
from vibecalc.core.study.search.newton import Refined, walls
from vibecalc.core.study.search.problem import KNOWN, Sampler, spread

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
#: fall that the planes may still promise, relative to radius and slope
SETTLED = 2e-2


#: values (1 + m,) and gradients (1 + m, k) at a point (k,), in the order point, values, gradients
_Plane = tuple[np.ndarray, np.ndarray, np.ndarray]


def settle(values: Sampler, start: np.ndarray) -> Refined | None:
    """Descend on a function whose pieces meet in kinks, such as the largest of hidden curves.

    Parameters
    ----------
    values : Sampler
        Of the largest part: the objective and margins.
    start : (k,) array
        Point of the unit cube close to a local optimum.

    Returns
    -------
    settled : Refined
        None in its place where the surroundings cannot be evaluated, or planes promise a fall.

    Notes
    -----
    Around the best point gradients are sampled at points of a low-discrepancy sequence, which
    keeps them off the kinks themselves. Their tangent planes show the pieces that meet there; a
    linear programme finds the lowest point of all planes within a radius. If it is not lower in
    truth, planes are added near it; once that does not help the radius shrinks. For the idea see
    J. V. Burke, A. S. Lewis, M. L. Overton, SIAM J. Optim. 15 (2005), 751-779.
    """
    offsets = iter(2 * spread(8 * MOST_ROUNDS + 2 * start.size, start.size) - 1)
    unit, merit = start, _merit(values, start)
    radius, vain = FIRST_RADIUS, 0
    planes: list[_Plane] = []
    fresh = [(unit, 0.5)] * (2 * start.size + 1)
    for _ in range(MOST_ROUNDS):
        sizes = [size * radius for _, size in fresh]
        beside = [one + size * next(offsets) for (one, _), size in zip(fresh, sizes, strict=True)]
        asked = [
            (values.box.inside(point), min(1e-7, 2e-3 * size))
            for point, size in zip(beside, sizes, strict=True)
        ]
        values.ahead([one for place in asked for one in with_steps(*place)])
        more = [_plane(values, *place) for place in asked]
        planes = [
            plane
            for plane in planes + [one for one in more if one is not None]
            if np.max(np.abs(plane[0] - unit)) <= 1.5 * radius
        ]
        lowest = _lowest(planes, unit, radius, values.box.around) if planes else None
        if lowest is None:
            return None
        there, height, margins, bounds = lowest
        promised = max(0.0, merit - height)
        step = float(np.max(np.abs(there - unit)))
        fall = merit - _merit(values, there)
        fresh = [(unit, 0.5), (there, 0.1), (there, 0.02)]
        if fall > 0:
            unit, merit = values.box.inside(there), merit - fall
        if fall > WORTH * promised:
            vain = 0
            if step > 0.9 * radius:
                radius = min(LARGEST_RADIUS, 2 * radius)
            continue
        vain += 1
        if vain < start.size + 3 and promised > 1e-13:
            continue
        if radius <= LAST_RADIUS:
            slopes = [float(np.linalg.norm(first[0])) for _, _, first in planes]
            residual = promised / (radius * max(1.0, *slopes))
            vector = values(unit)
            if vector is None or residual > SETTLED:
                return None
            noise = float(measured_noise(values, unit)[0])
            pulling = (margins > 1e-6) & (vector[1:] < 1e-6)
            sides = walls(values.box, unit) * (np.abs(bounds) > 1e-6)
            unit, bias = values.box.fold(unit), values.bias(values.box.fold(unit))
            held = np.where(pulling, margins, 0.0)
            gradients = np.array([first for _, _, first in planes])
            # a gradient taken across a kink lifts a plane a little: count the promise fourfold
            # and the pieces bend away from their planes by the square of the radius
            excess = 4 * promised + BEND * radius**2 + 1e-12 + 2 * noise
            away = radius + step + np.sqrt(2 * noise) + _reach(values, unit, bias, gradients)
            return Refined(
                unit=unit,
                error=np.where(sides == 0, away, 0.0),
                excess=excess + float(bias[0] + held @ bias[1:]),
                objective=float(vector[0]),
                margins=held,
                bounds=np.where(sides != 0, bounds, 0.0),
                sides=sides,
                residual=residual,
                method="sampled planes",
            )
        vain = 0
        radius = max(LAST_RADIUS, min(0.25 * radius, 4 * step))
    return None


def _merit(values: Sampler, unit: np.ndarray) -> float:
    return values.top(unit) + PRICE * values.violation(unit)


def _plane(values: Sampler, point: np.ndarray, step: float) -> _Plane | None:
    """The tangent plane at a point, from steps aside; None if it cannot be evaluated there."""
    height = values(point)
    if height is None:
        return None
    with suppress(Stranded):
        return point, height, forward_slopes(values, point, step)
    return None


def _lowest(
    planes: list[_Plane], unit: np.ndarray, radius: float, around: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray, np.ndarray] | None:
    """The lowest point of all cuts within the radius, its merit, and what holds it there."""
    from scipy.optimize import linprog

    size = unit.size
    points, values, first = (np.array(part) for part in zip(*planes, strict=True))
    height = values + np.einsum("krn,kn->kr", first, unit - points)
    is_goal = np.arange(height.shape[1]) == 0
    sign, top = np.where(is_goal, 1.0, -1.0), float(np.max(height[:, 0]))
    scale = max(float(np.max(np.abs(first[:, 0]))) * radius, 1e-300)
    # unknowns: step / radius (k), height above the top / scale, violation / scale
    slopes = sign[:, None] * first * radius / scale
    slack = np.broadcast_to(-1.0 * np.column_stack([is_goal, ~is_goal]), (*height.shape, 2))
    room = np.where(around, np.inf, np.stack([unit, 1.0 - unit]) / radius)
    least, most = np.maximum(-1.0, -room[0]), np.minimum(1.0, room[1])
    programme = linprog(
        np.append(np.zeros(size), [1.0, PRICE]),
        A_ub=np.concatenate([slopes, slack], axis=2).reshape(-1, size + 2),
        b_ub=(is_goal * top - sign * height).ravel() / scale,
        bounds=[*zip(least.tolist(), most.tolist(), strict=True), (None, None), (0.0, None)],
        method="highs-ds",
    )
    if programme.x is None:
        return None
    duals = -np.asarray(programme.ineqlin.marginals).reshape(height.shape)
    pulls = np.where(least > -1.0, programme.lower.marginals[:size], 0.0)
    pulls = pulls + np.where(most < 1.0, programme.upper.marginals[:size], 0.0)
    merit = top + scale * float(programme.x[size] + PRICE * programme.x[size + 1])
    margins = np.sum(duals[:, 1:], axis=0)
    return unit + radius * programme.x[:size], merit, margins, pulls * scale / radius


# ----------------------------------------------------------------------------
# How far an optimum may be off by errors of the values, whatever holds it.
# ----------------------------------------------------------------------------

#: first step away from an optimum, and growth of the steps
FIRST_AWAY, AWAY = 1e-5, 1.6


def _reach(
    values: Sampler, unit: np.ndarray, bias: np.ndarray, gradients: np.ndarray
) -> np.ndarray:
    """How far each coordinate (k,) of an optimum may be off by errors (1 + m,) of the values.

    The extents of all points that lie no higher than the optimum by twice the error of the
    objective, and break margins by no more than theirs: along the axes, and along the lines to the
    farthest points by the planes of these `gradients` (j, 1 + m, k).
    """
    from scipy.optimize import linprog

    size, base = unit.size, values(unit)
    if base is None or not np.any(bias > KNOWN):
        return np.zeros(size)

    def within(step: np.ndarray) -> bool:
        there = values(unit + step)
        if there is None or np.any(there[1:] < np.minimum(base[1:], 0.0) - 2.0 * bias[1:] - MARGIN):
            return False
        # of an objective without error the limits alone tell
        return bool(there[0] - base[0] < 2.0 * bias[0] + KNOWN)

    def extent(axis: np.ndarray) -> float:
        step = FIRST_AWAY
        while step < 1.0 and within(step * axis):
            step *= AWAY
        return step

    signs = np.where(np.arange(base.size) == 0, 1.0, -1.0)
    room = 2.0 * bias + np.append(KNOWN, np.maximum(base[1:], 0.0) + MARGIN)
    away, largest = np.zeros(size), np.max(np.abs(room))
    for axis in (*np.eye(size), *-np.eye(size)):
        rows = (signs[:, None] * gradients).reshape(-1, size)
        right = np.tile(room / largest, len(gradients))
        farthest = linprog(-axis, A_ub=rows, b_ub=right, bounds=(-1.0 / largest, 1.0 / largest))
        for line in (axis,) if farthest.x is None else (axis, farthest.x):
            line = line / max(float(np.linalg.norm(line)), 1e-300)
            away = np.maximum(away, extent(line) * np.abs(line))
    return away
