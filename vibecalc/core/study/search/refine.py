"""The last digits of a local optimum, by the first of three methods that succeeds."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.kinks import reach, settle
from vibecalc.core.study.search.local_search import local_search
from vibecalc.core.study.search.newton import polish
from vibecalc.core.study.search.problem import Sampler, spread, squared
from vibecalc.numerics.rounding import EPSILON

#: an objective below this share of its change over the bounds may be on its way to zero
NEAR_ZERO = 3e-2
#: an objective this small next to the largest one met is zero
ZERO = 1e-11
#: difference step on the way to a zero, over what is left of it
NEARER = 1e-2
#: margins are kept down to this
MARGIN_WITHIN = 1e-9
#: fall that the planes may still promise, relative to radius and slope
SETTLED = 2e-2
MOST_RESTARTS = 3
MOST_STEPS = 30


class RefinedOptimum(NamedTuple):
    """A local optimum on the unit cube, in scaled units, with what holds it and its error."""

    unit: np.ndarray
    error: np.ndarray
    excess: float
    objective: float
    margins: np.ndarray
    bounds: np.ndarray
    sides: np.ndarray
    active_margins: tuple[int, ...]
    residual: float
    free_directions: int
    method: str


def at_rest(unit: np.ndarray, vector: np.ndarray, method: str) -> RefinedOptimum:
    """A point (n,) with its values (1 + m,) that nothing pulls on; on the walls where it is."""
    return RefinedOptimum(
        unit=unit,
        error=np.zeros(unit.size),
        excess=0.0,
        objective=float(vector[0]),
        margins=np.zeros(vector.size - 1),
        bounds=np.zeros(unit.size),
        sides=np.where(unit <= 0, -1, np.where(unit >= 1, 1, 0)),
        active_margins=(),
        residual=0.0,
        free_directions=0,
        method=method,
    )


def refine(sampler: Sampler, unit: np.ndarray, below: float = np.inf) -> RefinedOptimum | None:
    """Refine the end of a local search and show that it is a local optimum, or return None.

    A norm that vanishes at its minimum has a cone there: its square is smooth and gives the zero
    to the last digit. Everything smooth goes to Newton's method (`newton.polish`), and what is
    left, hidden kinks, to sampled planes (`kinks.settle`). An end that Newton's method cannot
    hold is searched once more, and given up unless its objective is then smaller than `below`.
    """
    for _ in range(MOST_RESTARTS):
        if _may_vanish(sampler, unit):
            optimum = _zero(sampler, unit)
            if optimum is not None:
                return optimum
            unit = local_search(sampler, unit, to_the_end=True).unit
        optimum = _newton(sampler, unit)
        if optimum is None:
            unit = local_search(sampler, unit, to_the_end=True).unit
            if _top(sampler, unit) >= below:
                return None
            optimum = _newton(sampler, unit) or _planes(sampler, unit)
            if (
                optimum is not None
                and optimum.method != "newton"
                and _may_vanish(sampler, optimum.unit)
            ):
                optimum = _zero(sampler, optimum.unit) or optimum
        lower = _lower_nearby(sampler, unit if optimum is None else optimum.unit, optimum)
        if lower is None:
            return optimum
        unit = local_search(sampler, lower).unit
    return None


def _may_vanish(sampler: Sampler, unit: np.ndarray) -> bool:
    return sampler.smallest >= 0 and _top(sampler, unit) <= NEAR_ZERO


def _lower_nearby(
    sampler: Sampler, unit: np.ndarray, optimum: RefinedOptimum | None
) -> np.ndarray | None:
    """A clearly lower point in the surroundings, as next to a saddle, or None."""
    if optimum is not None and optimum.method == "newton" and optimum.free_directions == 0:
        return None  # its curvature is known
    margin = 1e-9 if optimum is None else 1e-9 + 2 * optimum.excess
    lowest, where = _top(sampler, unit) - margin, None
    directions = np.concatenate(
        [np.eye(unit.size), -np.eye(unit.size), 2 * spread(4 * unit.size, unit.size) - 1]
    )
    for direction in directions:
        for radius in (1e-2, 1e-3):
            point = np.clip(unit + radius * direction, 0, 1)
            vector = sampler(point)
            if vector is not None and np.all(vector[1:] >= 0) and vector[0] < lowest:
                lowest, where = float(vector[0]), point
    return where


def keeps(sampler: Sampler, unit: np.ndarray) -> bool:
    """Whether all margins are kept at a point of the unit cube, but for round-off."""
    vector = sampler(unit)
    return vector is not None and bool(np.all(vector[1:] >= -MARGIN_WITHIN))


def _top(sampler: Sampler, unit: np.ndarray) -> float:
    vector = sampler(unit)
    return np.inf if vector is None else float(vector[0])


def _zero(sampler: Sampler, unit: np.ndarray) -> RefinedOptimum | None:
    """A zero of an objective that is never negative and leaves it as a cone; None without one."""
    largest = sampler.largest / sampler.scale
    near = _nearer(sampler, unit)
    bias, leaning = sampler.bias(near), sampler.leaning(near)
    # of a square the error is that of the zero, which counts below
    bias[0], leaning[0] = 0.0, 0.0
    minimum = polish(squared(sampler), near, bias, leaning)
    if minimum is None:
        return None
    vector = sampler(minimum.unit)
    assert vector is not None
    objective = float(vector[0])
    if objective > ZERO * largest or not keeps(sampler, minimum.unit):
        return None
    if not _is_cone(sampler, minimum.unit):
        return None
    floor = max(4 * EPSILON * largest, float(sampler.bias(minimum.unit)[0]))
    away = np.sqrt(2.0) * floor * minimum.reach
    return at_rest(minimum.unit, vector, "zero")._replace(
        error=minimum.error + np.where(minimum.active.sides == 0, away, 0.0),
        excess=objective + floor,
        sides=minimum.active.sides,
        residual=objective / max(largest, 1e-300),
        free_directions=minimum.free_directions,
    )


def _nearer(sampler: Sampler, unit: np.ndarray) -> np.ndarray:
    """The point nearest to a zero that scipy's least squares come to, broken margins added.

    A step against the gradient as long as the zero is far on a straight slope doubles the digits
    of a difference without its sign; the differences stay short next to what is left of the way.
    """
    from scipy.optimize import least_squares

    lowest, nearest = np.inf, unit

    def height(at: np.ndarray) -> np.ndarray:
        nonlocal lowest, nearest
        vector = sampler(at)
        if vector is None:
            return np.array([1e3])
        total = float(vector[0] + np.sum(np.maximum(0.0, -vector[1:])))
        if total < lowest:
            lowest, nearest = total, at.copy()
        return np.array([total])

    def slopes(at: np.ndarray) -> np.ndarray:
        here = height(at)
        step = float(np.clip(NEARER * here[0], 1e-12, 1e-7))
        sides = np.where(at < 0.5, step, -step)
        return np.array([(height(at + move) - here) / side for move, side in
                         zip(np.diag(sides), sides, strict=True)]).T  # fmt: skip

    least_squares(height, unit, slopes, bounds=(0, 1), xtol=1e-15, ftol=1e-15, gtol=1e-15,
                  max_nfev=MOST_STEPS)  # fmt: skip
    return nearest


def _is_cone(sampler: Sampler, unit: np.ndarray) -> bool:
    """Whether the objective grows with the distance from its zero, not with its square."""
    inwards = np.where(unit < 0.5, 1e-4, -1e-4)
    near = [_top(sampler, unit + inwards * axis) for axis in np.eye(unit.size)]
    steepest = int(np.argmax(near))
    far = _top(sampler, unit + 2 * inwards * np.eye(unit.size)[steepest])
    return bool(far < 3 * near[steepest])


def _newton(sampler: Sampler, unit: np.ndarray) -> RefinedOptimum | None:
    polished = polish(sampler, unit, sampler.bias(unit), sampler.leaning(unit))
    if polished is None or not keeps(sampler, polished.unit):
        return None
    vector = sampler(polished.unit)
    assert vector is not None
    return at_rest(polished.unit, vector, "newton")._replace(
        error=polished.error,
        excess=polished.excess,
        margins=polished.pulls.margins,
        bounds=polished.pulls.bounds,
        sides=polished.active.sides,
        active_margins=tuple(sorted(polished.active.margins)),
        residual=polished.pulls.residual,
        free_directions=polished.free_directions,
    )


def _planes(sampler: Sampler, unit: np.ndarray) -> RefinedOptimum | None:
    end = settle(sampler, unit)
    if end is None or end.residual > SETTLED:
        return None
    vector = sampler(end.unit)
    assert vector is not None
    pulling = (end.margins > 1e-6) & (vector[1:] < 1e-6)
    bias = sampler.bias(end.unit)
    away = reach(sampler, end.unit, bias, sampler.leaning(end.unit))
    optimum = at_rest(end.unit, vector, "sampled planes")
    sides = np.where(np.abs(end.bounds) > 1e-6, optimum.sides, 0)
    return optimum._replace(
        error=np.where(sides == 0, end.error + away, 0.0),
        excess=end.excess + float(bias[0] + end.margins @ bias[1:]),
        margins=np.where(pulling, end.margins, 0.0),
        bounds=np.where(sides != 0, end.bounds, 0.0),
        sides=sides,
        active_margins=tuple(int(index) for index in np.flatnonzero(pulling)),
        residual=end.residual,
    )
