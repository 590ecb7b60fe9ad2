"""Objectives that fall to an exact zero with a kink, as a difference without its sign does."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.sampler import Values
from vibecalc.optimisation.starts import spread

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
    """Forward differences short beside the way to the zero; None on level ground.

    On a wall of the cube a component that points out of it is dropped.
    """
    slope = np.zeros(unit.size)
    step = 1e-7
    for _ in range(8):  # the step is only known to be short once the slope is
        for axis in range(unit.size):
            beside = unit.copy()
            beside[axis] += step if unit[axis] < 0.5 else -step
            slope[axis] = (_height(sampler, beside) - value) / (beside[axis] - unit[axis])
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
        beside = unit.copy()
        beside[axis] += 1e-8 if unit[axis] < 0.5 else -1e-8
        value = sampler(beside)
        if value is None:
            return None
        slope[axis] = (float(np.max(value[: sampler.entries])) - top) / (beside[axis] - unit[axis])
    return slope if np.any(slope) else None
