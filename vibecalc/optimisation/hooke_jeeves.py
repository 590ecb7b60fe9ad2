"""Direct search with exploratory and pattern moves."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Scalar = Callable[[np.ndarray], float]

#: points are multiples of its inverse: sums of such numbers within the unit cube are exact
_FINEST = 2.0**52


class Descent(NamedTuple):
    """Where a direct search stopped: point (n,) of the unit cube, value, points evaluated.

    `converged` says that the steps have become as small as was asked for.
    """

    point: np.ndarray
    value: float
    evaluations: int
    converged: bool


def hooke_jeeves(function: Scalar, start: np.ndarray, step: float, tolerance: float) -> Descent:
    """Search the unit cube for a low value without derivatives.

    Parameters
    ----------
    function : callable
        `function(unit (n,)) -> float`; infinity where there is no value. It is called once for
        each point.
    start : (n,) array
        First base point.
    step, tolerance : float
        First step of the exploratory moves, in units of the cube, and largest last one.

    Returns
    -------
    descent : Descent
        No point beside the last base, by the last step along an axis, is lower. On a
        smooth function that makes it nearly stationary; at a kink it may not even be that.

    Notes
    -----
    An exploratory move tries a step up and down each axis, the direction that helped last first,
    and keeps what is lower. While it helps, the pattern move goes on from the new base point by
    as much as it has moved, and explores there before it judges. Where nothing around the base
    is lower the step is halved. Steps that leave the cube end on its wall. All steps are powers
    of two and all points multiples of the smallest, so that a way back ends where it began, to
    the last bit: sums that round would let the search creep without end. R. Hooke and T. A.
    Jeeves, "Direct search" solution of numerical and statistical problems, J. ACM 8 (1961), 212.
    """
    step = float(2.0 ** np.round(np.log2(step)))
    start = np.round(start * _FINEST) / _FINEST
    seen: dict[bytes, float] = {}

    def value_at(point: np.ndarray) -> float:
        key = (point + 0.0).tobytes()
        if key not in seen:
            seen[key] = function(point)
        return seen[key]

    signs = np.ones(start.size)

    def explore(point: np.ndarray) -> tuple[np.ndarray, float]:
        best, lowest = point, value_at(point)
        for axis in range(start.size):
            for side in (signs[axis], -signs[axis]):
                trial = best.copy()
                trial[axis] = min(1.0, max(0.0, best[axis] + side * step))
                if trial[axis] != best[axis] and value_at(trial) < lowest:
                    best, lowest = trial, value_at(trial)
                    signs[axis] = side
                    break
        return best, lowest

    base, value = start, value_at(start)
    while True:
        found, lowest = explore(base)
        while lowest < value:
            before, base, value = base, found, lowest
            found, lowest = explore(np.clip(2.0 * base - before, 0.0, 1.0))
        if explore(base)[1] < value:
            continue
        if step <= tolerance:
            return Descent(base, value, len(seen), True)
        step = 0.5 * step
