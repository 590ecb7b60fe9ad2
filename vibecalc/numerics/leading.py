"""Leading axes: numbers of one case, or arrays (points,) of many, in the same formulas."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vibecalc.errors import PointsApart


def side_by_side(values: Sequence[Any], own: int = 0) -> np.ndarray:
    """Numbers, or arrays (..., own axes) that broadcast, along a new axis before their own ones.

    Numbers give (n,), numbers among arrays (points,) give (points, n).
    """
    if not any(np.ndim(value) > own for value in values):
        return np.array(values, dtype=float)
    return np.stack(np.broadcast_arrays(*values), axis=-1 - own)


def product(first: Any, second: Any) -> Any:
    """first @ second; of (..., m, 1) and (..., 1, n) without what a batch of matrices costs."""
    outer = np.shape(first)[-1] == 1 and np.ndim(first) > 1 and np.ndim(second) > 1
    return first * second if outer else first @ second


def agreed(values: Any) -> Any:
    """What all points share; raises PointsApart where they differ, so that each kind runs alone."""
    first = np.ravel(values)[0]
    if np.all(np.equal(values, first)):
        return first.item()
    raise PointsApart(np.asarray(values))


def leave_alone(points: Any) -> None:
    """Raise PointsApart where any of the points (points,) has to be run by itself.

    Nothing for one case without leading axes, which is by itself.
    """
    if np.ndim(points) and np.any(points):
        raise PointsApart(np.zeros(np.shape(points), dtype=int), np.asarray(points))
