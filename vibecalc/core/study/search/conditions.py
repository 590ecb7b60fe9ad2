"""The conditions that hold an optimum: derivatives from values, and what pulls on a point."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.problem import Values, foresee
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
    """First and second derivative along a direction, (1 + m,) each, with their errors.

    `kinked` marks values whose derivative jumps here.
    """

    first: np.ndarray
    second: np.ndarray
    error: np.ndarray
    second_error: np.ndarray
    kinked: np.ndarray


class Gradient(NamedTuple):
    """Derivatives by the coordinates of the unit cube, (1 + m, n), their errors, and kinks."""

    first: np.ndarray
    error: np.ndarray
    kinked: np.ndarray


def slope(sampler: Values, unit: np.ndarray, direction: np.ndarray, noise: np.ndarray) -> Slope:
    """Differentiate along a unit direction through five equispaced points inside the unit cube.

    Parameters
    ----------
    unit, direction : (n,) arrays
        Point of the unit cube and direction.
    noise : (1 + m,) array
        Absolute noise of the values.

    Notes
    -----
    Near a wall the five points shift inwards. Truncation is judged from the difference to the
    formula through the three nearest of them; where it exceeds the noise the spacing shrinks.
    """
    best: Slope | None = None
    for spacing in SPACINGS:
        spaced = _at_spacing(sampler, unit, direction, noise, spacing)
        if spaced is None:
            continue
        candidate, truncation = spaced
        if best is None:
            best = candidate
        else:
            better = (best.kinked & ~candidate.kinked) | (
                (best.kinked == candidate.kinked) & (candidate.error < best.error)
            )
            best = Slope(*(np.where(better, n, o) for n, o in zip(candidate, best, strict=True)))
        if not np.any(best.kinked) and np.all(
            truncation <= np.maximum(candidate.error - truncation, 1e-9)
        ):
            break
    if best is None:
        raise NumericalFailure(
            f"no derivative at {unit.tolist()} of the unit cube: points around it have no value"
        )
    return best


def gradient(sampler: Values, unit: np.ndarray, noise: np.ndarray) -> Gradient:
    """Derivatives of objective and margins by all coordinates, with `slope`."""
    directions = np.eye(unit.size)
    first = SPACINGS[0]
    foresee(
        sampler,
        [
            point
            for direction in directions
            for point in _around(unit, direction, first, _nodes(unit, direction, first))
        ],
    )
    slopes = [slope(sampler, unit, direction, noise) for direction in directions]
    return Gradient(
        first=np.stack([one.first for one in slopes], axis=1),
        error=np.stack([one.error for one in slopes], axis=1),
        kinked=np.any([one.kinked for one in slopes], axis=0),
    )


def measured_noise(sampler: Values, unit: np.ndarray) -> np.ndarray:
    """Absolute noise of the values, (1 + m,), from high differences of nine close points.

    Round-off of the values is the floor. J. J. More and S. M. Wild, Estimating computational
    noise, SIAM J. Sci. Comput. 33 (2011), 1292-1314.
    """
    direction = np.where(unit < 0.5, 1.0, -1.0) / np.sqrt(unit.size)
    points = [unit + 1e-7 * step * direction for step in range(9)]
    foresee(sampler, points)
    values = [sampler(point) for point in points]
    known = np.array([value for value in values if value is not None])
    floor: np.ndarray = EPSILON * np.max(np.abs(known), axis=0)
    if len(known) < 9:
        return np.asarray(4.0 * floor)
    noise = floor
    for order in (4, 5, 6):
        difference = np.diff(known, n=order, axis=0)
        gain = float(np.prod(np.arange(order + 1, 2 * order + 1) / np.arange(1, order + 1)))
        noise = np.maximum(noise, np.sqrt(np.mean(difference**2, axis=0) / gain))
    return np.asarray(3.0 * noise)


def _nodes(unit: np.ndarray, direction: np.ndarray, spacing: float) -> np.ndarray:
    """Places (5,) about a point in spacings along a direction, within the cube."""
    speed = np.where(direction == 0, 1.0, np.abs(direction))
    upwards = np.where(direction >= 0, 1.0 - unit, unit)
    downwards = np.where(direction >= 0, unit, 1.0 - unit)
    moves = direction != 0
    ahead = float(np.min(np.where(moves, upwards / speed, np.inf))) / spacing
    behind = float(np.min(np.where(moves, downwards / speed, np.inf))) / spacing
    first_node = (
        -2
        if min(ahead, behind) >= 2
        else (-min(int(behind), 2) if ahead > behind else min(int(ahead), 2) - 4)
    )
    return np.arange(first_node, first_node + 5.0)


def _around(
    unit: np.ndarray, direction: np.ndarray, spacing: float, nodes: np.ndarray
) -> list[np.ndarray]:
    return [np.clip(unit + spacing * node * direction, 0, 1) for node in nodes]


def _at_spacing(
    sampler: Values, unit: np.ndarray, direction: np.ndarray, noise: np.ndarray, spacing: float
) -> tuple[Slope, np.ndarray] | None:
    nodes = _nodes(unit, direction, spacing)
    points = _around(unit, direction, spacing, nodes)
    foresee(sampler, points)
    values = [sampler(point) for point in points]
    if any(value is None for value in values):
        return None
    table = np.array(values)
    weights = _weights(nodes, 1) / spacing
    nearest = np.sort(np.argsort(np.abs(nodes), kind="stable")[:3])
    rough = _weights(nodes[nearest], 1) @ table[nearest] / spacing
    first = weights @ table
    bend = _weights(nodes, 2) / spacing**2
    second = bend @ table
    rough_second = _weights(nodes[nearest], 2) @ table[nearest] / spacing**2
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
# Which limits and bounds hold a point in place, and how hard each of them pulls.
# ----------------------------------------------------------------------------


class Active(NamedTuple):
    """What is taken to hold with equality: indices of margins, and sides of bounds (n,)."""

    margins: tuple[int, ...]
    sides: np.ndarray


class Pulls(NamedTuple):
    """Multipliers of margins (m,) and bounds (n,).

    `left` (n,) is what remains of the sum of gradients, `residual` its size relative to the sum
    of magnitudes or to 1, the usual slope of a scaled objective, whichever is larger.
    """

    margins: np.ndarray
    bounds: np.ndarray
    left: np.ndarray
    residual: float

    @property
    def weights(self) -> np.ndarray:
        """Weights of objective and margins in the Lagrangian, (1 + m,)."""
        return np.append(1.0, -self.margins)


def identify(
    vector: np.ndarray, first: np.ndarray, unit: np.ndarray, closeness: float
) -> tuple[Active, Pulls]:
    """Find the smallest set of near-active conditions whose gradients balance.

    Parameters
    ----------
    vector : (1 + m,) array
        Objective and margins at the point.
    first : (1 + m, n) array
        Their gradients on the unit cube.
    unit : (n,) array
        The point.
    closeness : float
        Distance on the unit cube within which a condition counts as a candidate.

    Notes
    -----
    Non-negative least squares over the candidates (Lawson and Hanson, 1974): it picks linearly
    independent ones, so that equal mounts or repeated limits do no harm.
    """
    reach = closeness * (np.linalg.norm(first[1:], axis=1) + 1e-12)
    near = np.flatnonzero(vector[1:] <= reach)
    lower, upper = np.flatnonzero(unit <= closeness), np.flatnonzero(unit >= 1 - closeness)
    axes = np.eye(unit.size)
    columns = np.concatenate([first[1 + near], axes[lower], -axes[upper]]).T
    length = np.linalg.norm(columns, axis=0)
    table = columns / np.where(length > 0, length, 1.0)
    size = max(float(np.linalg.norm(first[0])), 1e-300)
    # scipy does not survive a table without columns
    pulls = nonnegative_least_squares(table, first[0] / size) if table.size else np.empty(0)
    chosen = pulls > 1e-9
    pick, pick_lower, pick_upper = np.split(chosen, [near.size, near.size + lower.size])
    sides = np.zeros(unit.size, dtype=int)
    sides[lower[pick_lower]] = -1
    sides[upper[pick_upper]] = 1
    active = Active(tuple(int(i) for i in near[pick]), sides)
    return active, balance(first, active)


def balance(first: np.ndarray, active: Active) -> Pulls:
    """Multipliers of a given active set: least squares, signs as they come out.

    `first` (1 + m, n) are the gradients of objective and margins.
    """
    free = active.sides == 0
    chosen = list(active.margins)
    columns = first[1:][chosen][:, free].T
    length = np.linalg.norm(columns, axis=0)
    length = np.where(length > 0, length, 1.0)
    margins = np.zeros(first.shape[0] - 1)
    margins[chosen] = np.linalg.lstsq(columns / length, first[0][free], rcond=1e-10)[0] / length
    total = first[0] - margins @ first[1:]
    left = np.where(free, total, 0.0)
    pull = np.linalg.norm(first[0]) + np.linalg.norm(np.abs(margins) @ np.abs(first[1:]))
    residual = float(np.linalg.norm(left) / max(1.0, float(pull)))
    return Pulls(margins, np.where(free, 0.0, total), left, residual)


# ----------------------------------------------------------------------------
# How far a point is from a stationary one, whoever found it.
# ----------------------------------------------------------------------------

#: distances on the unit cube within which a limit or a bound may count as holding
CLOSENESS = (1e-6, 1e-4, 3e-3)


def stationarity(sampler: Values, unit: np.ndarray) -> float:
    """What is left of the gradients that should balance, relative to their magnitudes.

    Parameters
    ----------
    sampler : Values
    unit : (n,) array
        Point of the unit cube at which the sampler gives values.

    Returns
    -------
    residual : float
        0 at a point that satisfies the first-order conditions, 1 or so far from any; infinity
        where they cannot be formed, as on a kink or next to points that cannot be evaluated.
    """
    try:
        noise = measured_noise(sampler, unit)
        slopes = gradient(sampler, unit, noise)
    except NumericalFailure:
        return np.inf
    vector = sampler(unit)
    assert vector is not None
    residual = np.inf
    for closeness in CLOSENESS:
        _, pulls = identify(vector, slopes.first, unit, closeness)
        if not np.any(slopes.kinked & (np.abs(pulls.weights) > 1e-9)):
            residual = min(residual, pulls.residual)
    return residual
