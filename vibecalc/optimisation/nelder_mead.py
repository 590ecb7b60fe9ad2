"""Direct search with a simplex that crawls downhill."""

import numpy as np

from vibecalc.optimisation.hooke_jeeves import Descent, Scalar

MOST_RESTARTS = 20
MOST_MOVES = 400


def nelder_mead(function: Scalar, start: np.ndarray, step: float, tolerance: float) -> Descent:
    """Search the unit cube for a low value without derivatives.

    Parameters and result as of `hooke_jeeves`; `step` is the first edge of the simplex and
    `tolerance` the last one.

    Notes
    -----
    Factors of reflection, expansion, contraction and shrinking follow the dimension (F. Gao and
    L. Han, Comput. Optim. Appl. 51 (2012), 259-277). Corners that leave the cube are moved onto
    its wall, which may flatten the simplex: a search is begun again with a fresh, smaller one
    around its best corner until that gains nothing. J. A. Nelder and R. Mead, A simplex method
    for function minimization, Computer Journal 7 (1965), 308-313.
    """
    evaluations = 0

    def counted(point: np.ndarray) -> float:
        nonlocal evaluations
        evaluations += 1
        return function(point)

    point, value = start, counted(start)
    edge = step
    for _ in range(MOST_RESTARTS):
        found, lowest, settled = _crawl(counted, point, value, edge, tolerance)
        gained = lowest < value
        point, value = found, lowest
        if not gained and settled and edge <= 10.0 * tolerance:
            return Descent(point, value, evaluations, True)
        edge = max(10.0 * tolerance, edge if not settled else 0.1 * edge)
    return Descent(point, value, evaluations, False)


def _crawl(
    function: Scalar, start: np.ndarray, value: float, edge: float, tolerance: float
) -> tuple[np.ndarray, float, bool]:
    """Best corner, its value, and whether the simplex shrank below the tolerance."""
    size = start.size
    corners = np.tile(start, (size + 1, 1))
    for axis in range(size):
        corners[axis + 1, axis] += edge if start[axis] + edge <= 1.0 else -edge
    corners = np.clip(corners, 0.0, 1.0)
    values = np.array([value, *(function(corner) for corner in corners[1:])])
    several = max(2, size)
    expand, contract, shrink = 1 + 2 / several, 0.75 - 0.5 / several, 1 - 1 / several

    for _ in range(MOST_MOVES * size):
        order = np.argsort(values, kind="stable")
        corners, values = corners[order], values[order]
        if np.max(np.abs(corners[1:] - corners[0])) <= tolerance:
            return corners[0], float(values[0]), True
        middle = np.mean(corners[:-1], axis=0)

        def at(
            factor: float, middle: np.ndarray = middle, last: np.ndarray = corners[-1]
        ) -> tuple[np.ndarray, float]:
            point = np.clip(middle + factor * (middle - last), 0.0, 1.0)
            return point, function(point)

        best, value_best = at(1.0)
        if value_best < values[0]:
            further, value_further = at(expand)
            if value_further < value_best:
                best, value_best = further, value_further
        elif not value_best < values[-2]:
            best, value_best = at(contract if value_best < values[-1] else -contract)
        if value_best < values[-2] or (value_best < values[-1] and size > 1):
            corners[-1], values[-1] = best, value_best
        else:
            corners[1:] = corners[0] + shrink * (corners[1:] - corners[0])
            values[1:] = [function(corner) for corner in corners[1:]]
    best_one = int(np.argmin(values))
    return corners[best_one], float(values[best_one]), False
