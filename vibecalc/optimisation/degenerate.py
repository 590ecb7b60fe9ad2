"""Equally good end points that are one: what differs between them has no effect there."""

from typing import Protocol, TypeVar

import numpy as np

from vibecalc.optimisation.sampler import BudgetSpent, Sampler
from vibecalc.optimisation.search import NEARLY_KEPT

#: objectives this close, in scaled units, are equal
EQUAL = 1e-9
#: places between two ends, spaced so that no even wave passes through all of them
_BETWEEN = (0.137, 0.381, 0.529, 0.734)


class EndPoint(Protocol):
    """What is joined: a place on the unit cube and its objective in scaled units."""

    @property
    def unit(self) -> np.ndarray: ...

    @property
    def objective(self) -> float: ...


Point = TypeVar("Point", bound=EndPoint)


def groups(sampler: Sampler, points: list[Point]) -> list[list[Point]]:
    """Group the points between which the objective does not change; the order is kept.

    A weight of zero has no angle: searches that end there with different angles found the same
    thing. Two points are one if their objectives are equal, and stay so, with all limits kept,
    on the straight line between them. Where no evaluations are left, points stay apart.
    """
    found: list[list[Point]] = []
    for point in points:
        for group in found:
            if _same(sampler, group[0], point):
                group.append(point)
                break
        else:
            found.append([point])
    return found


def _same(sampler: Sampler, one: EndPoint, other: EndPoint) -> bool:
    if abs(one.objective - other.objective) > EQUAL:
        return False
    try:
        way = sampler.box.apart(one.unit, other.unit)
        vectors = [sampler(one.unit + part * way) for part in _BETWEEN]
    except BudgetSpent:
        return False
    return all(
        vector is not None
        and abs(float(np.max(vector[: sampler.entries])) - one.objective) <= EQUAL
        and bool(np.all(vector[sampler.entries :] >= -NEARLY_KEPT))
        for vector in vectors
    )
