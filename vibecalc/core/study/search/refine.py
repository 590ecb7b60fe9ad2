"""The last digits of a local optimum, by the first of three methods that succeeds."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.kinks import reach_zero, settle
from vibecalc.core.study.search.local_search import local_search
from vibecalc.core.study.search.newton import PolishedOptimum, polish
from vibecalc.core.study.search.problem import Sampler, SumOfSquares, spread
from vibecalc.numerics.rounding import EPSILON

#: an objective below this share of its change over the bounds may be on its way to zero
NEAR_ZERO = 3e-2
#: an objective this small next to the largest one met is zero
ZERO = 1e-11
#: margins are kept down to this
MARGIN_WITHIN = 1e-9
#: fall that the planes may still promise, relative to radius and slope
SETTLED = 2e-2
MOST_RESTARTS = 3


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
    active_entries: tuple[int, ...]
    residual: float
    free_directions: int
    method: str


def refine(
    sampler: Sampler, unit: np.ndarray, accuracy: float, below: float = np.inf
) -> RefinedOptimum | None:
    """Refine the end of a local search and show that it is a local optimum, or return None.

    A norm that vanishes at its minimum has a cone there: its square is smooth and gives the zero
    to the last digit. Everything smooth goes to Newton's method (`active_set.polish`), and what
    is left, hidden kinks, to sampled planes (`planes.settle`). An end that Newton's method cannot
    hold is searched once more, and given up unless its objective is then smaller than `below`.
    """
    for _ in range(MOST_RESTARTS):
        if _may_vanish(sampler, unit):
            optimum = _zero(sampler, unit, accuracy)
            if optimum is not None:
                return optimum
            unit = local_search(sampler, unit, to_the_end=True).unit
        optimum = _newton(sampler, unit, accuracy)
        if optimum is None:
            unit = local_search(sampler, unit, to_the_end=True).unit
            if _top(sampler, unit) >= below:
                return None
            optimum = _newton(sampler, unit, accuracy) or _planes(sampler, unit, accuracy)
            if (
                optimum is not None
                and optimum.method != "newton"
                and _may_vanish(sampler, optimum.unit)
            ):
                optimum = _kinked_zero(sampler, optimum.unit, accuracy) or optimum
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
            if vector is not None and np.all(vector[sampler.entries :] >= 0):
                top = float(np.max(vector[: sampler.entries]))
                if top < lowest:
                    lowest, where = top, point
    return where


def keeps(sampler: Sampler, unit: np.ndarray) -> bool:
    """Whether all margins are kept at a point of the unit cube, but for round-off."""
    vector = sampler(unit)
    return vector is not None and bool(np.all(vector[sampler.entries :] >= -MARGIN_WITHIN))


def _top(sampler: Sampler, unit: np.ndarray) -> float:
    vector = sampler(unit)
    return np.inf if vector is None else float(np.max(vector[: sampler.entries]))


def _zero(sampler: Sampler, unit: np.ndarray, accuracy: float) -> RefinedOptimum | None:
    largest = sampler.largest / sampler.scale
    squares = SumOfSquares(sampler)
    minimum: PolishedOptimum | None = None
    for _ in range(2):  # a second pass, as the first may come from far
        minimum = polish(squares, unit if minimum is None else minimum.unit, accuracy)
        if minimum is None:
            return _kinked_zero(sampler, unit, accuracy)
    assert minimum is not None
    objective = _top(sampler, minimum.unit)
    if objective > ZERO * largest:
        return _kinked_zero(sampler, unit, accuracy)
    if not _is_cone(sampler, minimum.unit):
        return None
    floor = 4 * max(EPSILON, accuracy) * largest
    away = floor * np.sqrt(2.0 / minimum.least_curvature)
    count = squares(minimum.unit)
    assert count is not None
    return RefinedOptimum(
        unit=minimum.unit,
        error=minimum.error + np.where(minimum.active.sides == 0, away, 0.0),
        excess=objective + floor,
        objective=objective,
        margins=np.zeros(count.size - 1),
        bounds=np.zeros(unit.size),
        sides=minimum.active.sides,
        active_margins=(),
        active_entries=tuple(range(sampler.entries)),
        residual=objective / max(largest, 1e-300),
        free_directions=minimum.free_directions,
        method="zero",
    )


def _kinked_zero(sampler: Sampler, unit: np.ndarray, accuracy: float) -> RefinedOptimum | None:
    """A zero whose square is not smooth enough, or bends too much, for Newton's method."""
    largest = sampler.largest / sampler.scale
    floor = 4 * max(EPSILON, accuracy) * largest
    zero = reach_zero(sampler, unit, floor, ZERO * largest)
    if zero is None or not keeps(sampler, zero.unit):
        return None
    vector = sampler(zero.unit)
    assert vector is not None
    sides = np.where(zero.unit <= 0, -1, np.where(zero.unit >= 1, 1, 0))
    # half the slope that was seen: it is sampled in some directions only
    away = (zero.objective + floor) / (0.5 * zero.slope)
    return RefinedOptimum(
        unit=zero.unit,
        error=np.full(unit.size, away),
        excess=zero.objective + floor,
        objective=zero.objective,
        margins=np.zeros(vector.size - sampler.entries),
        bounds=np.zeros(unit.size),
        sides=sides,
        active_margins=(),
        active_entries=tuple(range(sampler.entries)),
        residual=zero.objective / max(largest, 1e-300),
        free_directions=zero.free_directions,
        method="zero",
    )


def _is_cone(sampler: Sampler, unit: np.ndarray) -> bool:
    """Whether the objective grows with the distance from its zero, not with its square."""
    inwards = np.where(unit < 0.5, 1e-4, -1e-4)
    near = [_top(sampler, unit + inwards * axis) for axis in np.eye(unit.size)]
    steepest = int(np.argmax(near))
    far = _top(sampler, unit + 2 * inwards * np.eye(unit.size)[steepest])
    return bool(far < 3 * near[steepest])


def _newton(sampler: Sampler, unit: np.ndarray, accuracy: float) -> RefinedOptimum | None:
    polished = polish(sampler, unit, accuracy)
    if polished is None or not keeps(sampler, polished.unit):
        return None
    objective = _top(sampler, polished.unit)
    return RefinedOptimum(
        unit=polished.unit,
        error=polished.error,
        excess=polished.excess,
        objective=objective,
        margins=polished.pulls.margins,
        bounds=polished.pulls.bounds,
        sides=polished.active.sides,
        active_margins=tuple(sorted(polished.active.margins)),
        active_entries=tuple(sorted(polished.active.entries)),
        residual=polished.pulls.residual,
        free_directions=polished.free_directions,
        method="newton",
    )


def _planes(sampler: Sampler, unit: np.ndarray, accuracy: float) -> RefinedOptimum | None:
    end = settle(sampler, unit)
    if end is None or end.residual > SETTLED:
        return None
    vector = sampler(end.unit)
    assert vector is not None
    entries = sampler.entries
    objective = float(np.max(vector[:entries]))
    pulling = (end.margins > 1e-6) & (vector[entries:] < 1e-6)
    sides = np.where(end.unit <= 0, -1, np.where(end.unit >= 1, 1, 0))
    sides = np.where(np.abs(end.bounds) > 1e-6, sides, 0)
    return RefinedOptimum(
        unit=end.unit,
        error=np.where(sides == 0, end.error, 0.0),
        excess=end.excess + accuracy * (abs(objective) + float(np.sum(end.margins))),
        objective=objective,
        margins=np.where(pulling, end.margins, 0.0),
        bounds=np.where(sides != 0, end.bounds, 0.0),
        sides=sides,
        active_margins=tuple(int(index) for index in np.flatnonzero(pulling)),
        active_entries=tuple(
            int(index) for index in np.flatnonzero(vector[:entries] >= objective - 1e-6)
        ),
        residual=end.residual,
        free_directions=0,
        method="sampled planes",
    )
