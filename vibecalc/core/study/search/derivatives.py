"""Derivatives from values, with the error they carry, and which conditions hold a point."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.problem import Sampler
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.least_norm import nonnegative_least_squares
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Derivatives from values, with the error they carry.
# ----------------------------------------------------------------------------

#: spacings on the unit cube that are tried in turn, until truncation is below the noise
SPACINGS = (2e-3, 2e-4, 2e-5, 2e-6)
#: jump of a derivative, in scaled units, that counts as one
KINK = 1e-5


class Slope(NamedTuple):
    """First and second derivatives along directions, (v, j) each, with their errors.

    `kinked` marks values whose derivative jumps here.
    """

    first: np.ndarray
    second: np.ndarray
    error: np.ndarray
    second_error: np.ndarray
    kinked: np.ndarray


def slopes_along(
    values: Sampler, unit: np.ndarray, directions: np.ndarray, noise: np.ndarray
) -> Slope:
    """Differentiate along unit directions through five equispaced points inside the unit cube.

    Parameters
    ----------
    unit, directions : (k,) and (j, k) arrays
        Point of the unit cube and directions.
    noise : (v,) array
        Absolute noise of the values.

    Raises
    ------
    NumericalFailure
        If points around have no value.

    Notes
    -----
    Near a wall the five points shift inwards. Truncation is judged from the difference to the
    formula through the three nearest of them; where it exceeds the noise the spacing shrinks.
    """
    best: list[Slope | None] = [None] * len(directions)
    left = list(range(len(directions)))
    for spacing in SPACINGS:
        asked = [_points(values, unit, directions[one], spacing) for one in left]
        values.ahead([point for _, points in asked for point in points])
        again = []
        for one, (nodes, points) in zip(left, asked, strict=True):
            rows = [row for row in map(values, points) if row is not None]
            if len(rows) < len(points):
                again.append(one)
                continue
            found, truncation = _at_spacing(np.array(rows), nodes, noise, spacing)
            best[one] = known = _better(found, best[one])
            settled = truncation <= np.maximum(found.error - truncation, 1e-9)
            if not np.all(settled & ~known.kinked):
                again.append(one)
        left = again
    slopes = [one for one in best if one is not None]
    if len(slopes) < len(best):
        raise NumericalFailure(
            f"no derivative at {unit.tolist()} of the unit cube: points around it have no value"
        )
    return Slope(*(np.stack(one, axis=1) for one in zip(*slopes, strict=True)))


def gradient(values: Sampler, unit: np.ndarray, noise: np.ndarray) -> Slope:
    """Derivatives by all coordinates."""
    return slopes_along(values, unit, np.eye(unit.size), noise)


def _better(found: Slope, known: Slope | None) -> Slope:
    """Of each value what has the smaller error, of derivatives without a kink if there are any."""
    if known is None:
        return found
    better = (known.kinked & ~found.kinked) | (
        (known.kinked == found.kinked) & (found.error < known.error)
    )
    return Slope(*(np.where(better, n, o) for n, o in zip(found, known, strict=True)))


def measured_noise(values: Sampler, unit: np.ndarray) -> np.ndarray:
    """Absolute noise of the values, (v,), from high differences of nine close points.

    Round-off of the values is the floor. J. J. More and S. M. Wild, Estimating computational
    noise, SIAM J. Sci. Comput. 33 (2011), 1292-1314.
    """
    direction = np.where(unit < 0.5, 1.0, -1.0) / np.sqrt(unit.size)
    points = [unit + 1e-7 * step * direction for step in range(9)]
    values.ahead(points)
    known = np.array([row for row in map(values, points) if row is not None])
    floor: np.ndarray = EPSILON * np.max(np.abs(known), axis=0)
    if len(known) < 9:
        return np.asarray(4.0 * floor)
    noise = floor
    for order in (4, 5, 6):
        difference = np.diff(known, n=order, axis=0)
        gain = float(np.prod(np.arange(order + 1, 2 * order + 1) / np.arange(1, order + 1)))
        noise = np.maximum(noise, np.sqrt(np.mean(difference**2, axis=0) / gain))
    return np.asarray(3.0 * noise)


def _points(
    values: Sampler, unit: np.ndarray, direction: np.ndarray, spacing: float
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Five points about one along a direction, within the cube, and their places in spacings."""
    moves = (direction != 0) & ~values.box.around
    speed = np.where(moves, np.abs(direction), 1.0)
    onwards = np.where(direction >= 0, 1.0 - unit, unit)
    room = (np.min(np.where(moves, one / speed, np.inf), initial=1.0) / spacing
            for one in (onwards, 1.0 - onwards))  # fmt: skip
    ahead, behind = (min(int(one), 2) for one in room)
    first = -2 if min(ahead, behind) == 2 else (-behind if ahead > behind else ahead - 4)
    nodes = np.arange(first, first + 5.0)
    return nodes, [unit + spacing * node * direction for node in nodes]


def _at_spacing(
    table: np.ndarray, nodes: np.ndarray, noise: np.ndarray, spacing: float
) -> tuple[Slope, np.ndarray]:
    """Derivatives from values (5, v) at nodes, and the truncation of the first one."""
    nearest = np.sort(np.argsort(np.abs(nodes), kind="stable")[:3])
    weights, bend = (_weights(nodes, order) / spacing**order for order in (1, 2))
    first, second = weights @ table, bend @ table
    rough, rough_second = (
        _weights(nodes[nearest], order) @ table[nearest] / spacing**order for order in (1, 2)
    )
    gap = np.abs(first - rough)
    size = np.abs(first) + spacing * np.abs(second) + gap
    truncation = gap * np.minimum(1.0, 6.0 * gap / np.where(size > 0, size, 1.0))
    scatter = np.maximum(noise, 2 * EPSILON * np.max(np.abs(table), axis=0))
    error = truncation + np.sum(np.abs(weights)) * scatter
    second_error = np.sum(np.abs(bend)) * scatter
    # a kink bends by its jump over the spacing, however small that is, and by 5 points unlike 3
    unlike = np.abs(second - rough_second)
    kinked = (unlike > 0.04 * np.abs(second) + 4 * second_error) & (unlike * spacing > KINK)
    return Slope(first, second, error, second_error, kinked), truncation


def _weights(nodes: np.ndarray, derivative: int) -> np.ndarray:
    """Weights on the nodes that give a derivative at 0 exactly for polynomials."""
    powers = nodes[None, :] ** np.arange(nodes.size)[:, None]
    target = np.zeros(nodes.size)
    target[derivative] = float(derivative)  # 1! and 2!
    return np.linalg.solve(powers, target)


# ----------------------------------------------------------------------------
# Which parts, limits and bounds hold a point in place, and how hard each of them pulls.
# ----------------------------------------------------------------------------

#: distances on the unit cube within which a limit or a bound may count as holding
CLOSENESS = (1e-6, 1e-4, 3e-3)


class Held(NamedTuple):
    """What holds a point (k,) of the cube in place.

    `weights` (v,) of the Lagrangian are > 0 for parts, which add up to 1, and < 0 for margins;
    `sides` (k,) are -1 and 1 for a lower and an upper bound, else 0. `total` (k,) is the sum of the
    gradients: the pull of a bound where one holds, and what is left to balance elsewhere, of which
    `residual` is the size, relative to the sum of magnitudes or to 1, the usual slope of a scaled
    objective, whichever is larger. `steepest` is the sum of lengths of gradients by weight.
    """

    weights: np.ndarray
    sides: np.ndarray
    total: np.ndarray
    residual: float
    steepest: float


def identify(values: Sampler, unit: np.ndarray, first: np.ndarray, closeness: float) -> Held:
    """The smallest set of near-active conditions whose gradients (v, k) balance at a point.

    `closeness` is the distance on the unit cube within which a condition counts as a candidate.
    Non-negative least squares over the candidates (Lawson and Hanson, 1974): it picks linearly
    independent ones, so that equal mounts or repeated limits do no harm.
    """
    vector, parts = values(unit), values.parts
    assert vector is not None
    is_part, top = np.arange(vector.size) < parts, int(np.argmax(vector[:parts]))
    steep = np.linalg.norm(first, axis=1)
    gap = np.where(is_part, vector[top] - vector, vector)
    near = np.flatnonzero(gap <= closeness * (steep + 1e-12 + is_part * steep[top]))
    sign = np.where(is_part, 1.0, -1.0)[near]
    lower, upper = (~values.box.around & (one <= closeness) for one in (unit, 1.0 - unit))
    walls = np.concatenate([np.flatnonzero(lower), np.flatnonzero(upper)])
    side = np.repeat([-1, 1], [np.sum(lower), np.sum(upper)])
    pulling = sign[:, None] * first[near] / max(float(steep[top]), 1e-300)
    table = np.vstack([pulling, side[:, None] * np.eye(unit.size)[walls]])
    table = np.column_stack([table, np.append(is_part[near], np.zeros(walls.size))]).T
    length = np.linalg.norm(table, axis=0)
    length = np.where(length > 0, length, 1.0)
    wanted = np.eye(unit.size + 1)[-1]
    chosen = nonnegative_least_squares(table / length, wanted) > 1e-9
    pulls = np.zeros(length.size)
    pulls[chosen] = np.linalg.lstsq((table / length)[:, chosen], wanted, rcond=1e-10)[0]
    weights, sides = np.zeros(vector.size), np.zeros(unit.size, dtype=int)
    weights[near] = sign * (pulls / length)[: near.size]
    weights /= np.sum(weights[:parts])
    held = chosen[near.size :]
    sides[walls[held]] = side[held]
    total = weights @ first
    pull = float(np.linalg.norm(np.abs(weights) @ np.abs(first)))
    residual = float(np.linalg.norm(total[sides == 0])) / max(1.0, pull)
    return Held(weights, sides, total, residual, float(np.abs(weights) @ steep))
