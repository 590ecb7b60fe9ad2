"""The last digits of a local optimum, by the first of three methods that succeeds."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.kinks import reach_zero, settle
from vibecalc.core.study.search.local_search import local_search
from vibecalc.core.study.search.newton import Polished, polish
from vibecalc.core.study.search.problem import Sampler, SumOfSquares, spread
from vibecalc.numerics.rounding import EPSILON

#: an objective below this share of its change over the bounds may be on its way to zero
NEAR_ZERO = 3e-2
#: an objective this small next to the largest one met is zero
ZERO = 1e-11
#: margins are kept down to this
KEPT = 1e-9
#: fall that the planes may still promise, relative to radius and slope
SETTLED = 2e-2
MOST_RESTARTS = 3


class Refined(NamedTuple):
    """A local optimum on the unit cube, in scaled units, with what holds it and its error."""

    unit: np.ndarray
    error: np.ndarray
    rise: float
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
) -> Refined | None:
    """Refine the end of a local search and show that it is a local optimum, or return None.

    A norm that vanishes at its minimum has a cone there: its square is smooth and gives the zero
    to the last digit. Everything smooth goes to Newton's method (`active_set.polish`), and what
    is left, hidden kinks, to sampled planes (`planes.settle`). An end that Newton's method cannot
    hold is searched once more, and given up unless its objective is then smaller than `below`.
    """
    for _ in range(MOST_RESTARTS):
        if _may_vanish(sampler, unit):
            found = _zero(sampler, unit, accuracy)
            if found is not None:
                return found
            unit = local_search(sampler, unit, to_the_end=True).unit
        found = _newton(sampler, unit, accuracy)
        if found is None:
            unit = local_search(sampler, unit, to_the_end=True).unit
            if _top(sampler, unit) >= below:
                return None
            found = _newton(sampler, unit, accuracy) or _planes(sampler, unit, accuracy)
            if found is not None and found.method != "newton" and _may_vanish(sampler, found.unit):
                found = _kinked_zero(sampler, found.unit, accuracy) or found
        lower = _lower_nearby(sampler, unit if found is None else found.unit, found)
        if lower is None:
            return found
        unit = local_search(sampler, lower).unit
    return None


def _may_vanish(sampler: Sampler, unit: np.ndarray) -> bool:
    return sampler.smallest >= 0 and _top(sampler, unit) <= NEAR_ZERO


def _lower_nearby(sampler: Sampler, unit: np.ndarray, found: Refined | None) -> np.ndarray | None:
    """A clearly lower point in the surroundings, as next to a saddle, or None."""
    if found is not None and found.method == "newton" and found.free_directions == 0:
        return None  # its curvature is known
    margin = 1e-9 if found is None else 1e-9 + 2 * found.rise
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
    return vector is not None and bool(np.all(vector[sampler.entries :] >= -KEPT))


def _top(sampler: Sampler, unit: np.ndarray) -> float:
    vector = sampler(unit)
    return np.inf if vector is None else float(np.max(vector[: sampler.entries]))


def _zero(sampler: Sampler, unit: np.ndarray, accuracy: float) -> Refined | None:
    largest = sampler.largest / sampler.scale
    squares = SumOfSquares(sampler)
    found: Polished | None = None
    for _ in range(2):  # a second pass, as the first may come from far
        found = polish(squares, unit if found is None else found.unit, accuracy)
        if found is None:
            return _kinked_zero(sampler, unit, accuracy)
    assert found is not None
    objective = _top(sampler, found.unit)
    if objective > ZERO * largest:
        return _kinked_zero(sampler, unit, accuracy)
    if not _is_cone(sampler, found.unit):
        return None
    floor = 4 * max(EPSILON, accuracy) * largest
    away = floor * np.sqrt(2.0 / found.least_curvature)
    count = squares(found.unit)
    assert count is not None
    return Refined(
        unit=found.unit,
        error=found.error + np.where(found.active.sides == 0, away, 0.0),
        rise=objective + floor,
        objective=objective,
        margins=np.zeros(count.size - 1),
        bounds=np.zeros(unit.size),
        sides=found.active.sides,
        active_margins=(),
        active_entries=tuple(range(sampler.entries)),
        residual=objective / max(largest, 1e-300),
        free_directions=found.free_directions,
        method="zero",
    )


def _kinked_zero(sampler: Sampler, unit: np.ndarray, accuracy: float) -> Refined | None:
    """A zero whose square is not smooth enough, or bends too much, for Newton's method."""
    largest = sampler.largest / sampler.scale
    floor = 4 * max(EPSILON, accuracy) * largest
    found = reach_zero(sampler, unit, floor, ZERO * largest)
    if found is None or not keeps(sampler, found.unit):
        return None
    vector = sampler(found.unit)
    assert vector is not None
    sides = np.where(found.unit <= 0, -1, np.where(found.unit >= 1, 1, 0))
    # half the slope that was seen: it is sampled in some directions only
    away = (found.objective + floor) / (0.5 * found.slope)
    return Refined(
        unit=found.unit,
        error=np.full(unit.size, away),
        rise=found.objective + floor,
        objective=found.objective,
        margins=np.zeros(vector.size - sampler.entries),
        bounds=np.zeros(unit.size),
        sides=sides,
        active_margins=(),
        active_entries=tuple(range(sampler.entries)),
        residual=found.objective / max(largest, 1e-300),
        free_directions=found.free_directions,
        method="zero",
    )


def _is_cone(sampler: Sampler, unit: np.ndarray) -> bool:
    """Whether the objective grows with the distance from its zero, not with its square."""
    inwards = np.where(unit < 0.5, 1e-4, -1e-4)
    near = [_top(sampler, unit + inwards * axis) for axis in np.eye(unit.size)]
    steepest = int(np.argmax(near))
    far = _top(sampler, unit + 2 * inwards * np.eye(unit.size)[steepest])
    return bool(far < 3 * near[steepest])


def _newton(sampler: Sampler, unit: np.ndarray, accuracy: float) -> Refined | None:
    found = polish(sampler, unit, accuracy)
    if found is None or not keeps(sampler, found.unit):
        return None
    objective = _top(sampler, found.unit)
    return Refined(
        unit=found.unit,
        error=found.error,
        rise=found.rise,
        objective=objective,
        margins=found.pulls.margins,
        bounds=found.pulls.bounds,
        sides=found.active.sides,
        active_margins=tuple(sorted(found.active.margins)),
        active_entries=tuple(sorted(found.active.entries)),
        residual=found.pulls.residual,
        free_directions=found.free_directions,
        method="newton",
    )


def _planes(sampler: Sampler, unit: np.ndarray, accuracy: float) -> Refined | None:
    found = settle(sampler, unit)
    if found is None or found.residual > SETTLED:
        return None
    vector = sampler(found.unit)
    assert vector is not None
    entries = sampler.entries
    objective = float(np.max(vector[:entries]))
    pulling = (found.margins > 1e-6) & (vector[entries:] < 1e-6)
    sides = np.where(found.unit <= 0, -1, np.where(found.unit >= 1, 1, 0))
    sides = np.where(np.abs(found.bounds) > 1e-6, sides, 0)
    return Refined(
        unit=found.unit,
        error=np.where(sides == 0, found.error, 0.0),
        rise=found.rise + accuracy * (abs(objective) + float(np.sum(found.margins))),
        objective=objective,
        margins=np.where(pulling, found.margins, 0.0),
        bounds=np.where(sides != 0, found.bounds, 0.0),
        sides=sides,
        active_margins=tuple(int(index) for index in np.flatnonzero(pulling)),
        active_entries=tuple(
            int(index) for index in np.flatnonzero(vector[:entries] >= objective - 1e-6)
        ),
        residual=found.residual,
        free_directions=0,
        method="sampled planes",
    )
