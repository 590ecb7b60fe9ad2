"""Local searches from all starts, on one scale of the objective."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.feasibility import feasible_point
from vibecalc.optimisation.local_search import local_search
from vibecalc.optimisation.sampler import Sampler, Values
from vibecalc.optimisation.starts import spread

#: violation up to which the end of a local search counts as feasible, before it is refined
NEARLY_KEPT = 1e-6
#: an objective whose change is a smaller share of it than this counts as constant
UNRESOLVED = 2e-11


class End(NamedTuple):
    """Start and end of a local search on the unit cube; objective and violation at its end."""

    start: np.ndarray
    unit: np.ndarray
    objective: float
    violation: float
    reason: str
    evaluations: int


class Ends(NamedTuple):
    """All local searches, and what there is to say about them."""

    ends: list[End]
    notes: tuple[str, ...]
    flat: bool = False


class Walked(Protocol):
    """What a search hands back: the end on the unit cube, and in words why it stopped."""

    @property
    def unit(self) -> np.ndarray: ...

    @property
    def reason(self) -> str: ...


def search_all(
    sampler: Sampler,
    points: np.ndarray,
    searcher: Callable[[Values, np.ndarray], Walked] = local_search,
    most: int | None = None,
) -> Ends:
    """Search from every start that can be evaluated; `sampler.scale` is set on the way.

    Parameters
    ----------
    sampler : Sampler
    points : (k, n) array
        Starts on the unit cube.
    searcher : callable
        The search from one start.
    most : int, optional
        Most searches, where fewer than k do.

    Raises
    ------
    NumericalFailure
        If no start can be evaluated, or no point keeps all limits.
    """
    vectors, flat = set_scale(sampler, points)
    known = [vector for vector in vectors if vector is not None]
    if not known:
        raise NumericalFailure(
            f"none of the {len(points)} starting points of the search can be evaluated; the first "
            f"says: {next(iter(sampler.failures.values()))}"
        )
    ends: list[End] = []
    notes: tuple[str, ...] = ()
    walks = 0
    for point, vector in zip(points, vectors, strict=True):
        before = sampler.count
        if walks == most:
            break
        if vector is None:
            reason = f"cannot be evaluated: {sampler.failures[(point + 0.0).tobytes()]}"
            ends.append(End(point, point, np.nan, np.inf, reason, 0))
        elif sampler.left < sampler.reserve and any(end.violation < np.inf for end in ends):
            notes = (f"the budget ended the search after {len(ends)} of {len(points)} starts",)
            break
        else:
            walk = searcher(sampler, point)
            walks += 1
            ends.append(_end(sampler, point, walk.unit, walk.reason, sampler.count - before))
    if not any(end.violation <= NEARLY_KEPT for end in ends):
        ends += _from_feasible(sampler, ends, known[0].size - sampler.entries)
    return Ends(ends, notes, flat)


def set_scale(sampler: Sampler, points: np.ndarray) -> tuple[list[np.ndarray | None], bool]:
    """Values (before scaling) at the points; `sampler.scale` becomes their typical change.

    Also whether the objective is flat: its change is too small a share of it to be resolved.
    """
    vectors = [sampler(point) for point in points]
    if all(vector is None for vector in vectors):
        return vectors, False
    change = _change(sampler, points, vectors)
    least = UNRESOLVED * sampler.largest
    # a power of two, so that scaling is exact
    sampler.scale = 2.0 ** round(np.log2(max(change, least))) if change > 0 or least > 0 else 1.0
    return vectors, change <= least


def _from_feasible(sampler: Sampler, ends: list[End], margins: int) -> list[End]:
    """Find a point that keeps all limits and search from it."""
    nearest = sorted(
        (end for end in ends if np.isfinite(end.violation)), key=lambda end: end.violation
    )
    before = sampler.count
    start = feasible_point(sampler, [end.unit for end in nearest], margins)
    unit, reason = local_search(sampler, start)
    found = _end(sampler, start, unit, reason, sampler.count - before)
    if found.violation <= NEARLY_KEPT:
        return [found]
    return [found, _end(sampler, start, start, "keeps the limits, not improved", 0)]


def _end(
    sampler: Sampler, start: np.ndarray, unit: np.ndarray, reason: str, evaluations: int
) -> End:
    unit = sampler.box.fold(unit)
    vector = sampler(unit)
    assert vector is not None
    objective = float(np.max(vector[: sampler.entries]))
    violation = float(np.max(-vector[sampler.entries :], initial=0.0))
    return End(start, unit, objective, violation, reason, evaluations)


def _change(sampler: Sampler, points: np.ndarray, vectors: list[np.ndarray | None]) -> float:
    """A typical change of the objective over the bounds: of the starts, or of a small step."""
    tops = np.array([np.max(v[: sampler.entries]) for v in vectors if v is not None])
    apart = np.abs(tops - np.median(tops))
    changes = [float(np.median(apart)), float(np.max(apart))]
    centre_point = next(p for p, v in zip(points, vectors, strict=True) if v is not None)
    for axis in range(points.shape[1]):
        beside = centre_point.copy()
        beside[axis] += 1e-2 if beside[axis] < 0.5 else -1e-2
        value = sampler(beside)
        if value is not None:
            changes.append(1e2 * abs(float(np.max(value[: sampler.entries]) - tops[0])))
    least = UNRESOLVED * sampler.largest
    if max(changes) <= least:  # a start of high symmetry may hide all change
        for point in spread(8, points.shape[1]):
            value = sampler(point)
            if value is not None:
                changes.append(abs(float(np.max(value[: sampler.entries]) - tops[0])))
    return next((change for change in changes if change > least), max(changes))
