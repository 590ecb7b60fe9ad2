"""Local searches by sequential quadratic programming, from a point that keeps all limits."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.problem import (
    CONVERGED,
    Infeasible,
    LocalEnd,
    Sampler,
    Search,
    Values,
    foresee,
    spread,
)
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# One local search by sequential quadratic programming.
# ----------------------------------------------------------------------------

#: forward step on the unit cube: square root of the relative noise expected of a pipeline
STEP = 1e-6
ACCURACY = 1e-7
FINE_ACCURACY = 1e-13
MOST_STEPS = 60
#: a norm below this, in scaled units, is left to the method for zeros
VANISHING = 1e-3


class _NearZero(Exception):
    """A norm is about to vanish; its square is better for what is left."""


class _Stranded(Exception):
    """The search stands where no derivative can be formed."""


def local_search(sampler: Values, start: np.ndarray, *, to_the_end: bool = False) -> LocalEnd:
    """Search downhill from a start with SLSQP until it stops, whatever the reason.

    Parameters
    ----------
    sampler : Values
    start : (n,) array
        Point of the unit cube at which the sampler gives values.
    to_the_end : bool
        Without it the search ends where it gains little, or where a norm is about to vanish.

    Notes
    -----
    D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28 (1988), as
    in scipy. Points that cannot be evaluated look worse than all others, and the line search
    turns back from them.
    """
    from scipy.optimize import minimize

    accuracy = FINE_ACCURACY if to_the_end else ACCURACY
    size = start.size
    best: list[np.ndarray] = [start]
    first = sampler(start)
    assert first is not None
    bad = np.full_like(first, -1.0)
    bad[0] = first[0] + 1e3

    def steps(unit: np.ndarray) -> list[np.ndarray]:
        return [_stepped(unit, axis, _sides(unit, axis)[0]) for axis in range(size)]

    def values(unit: np.ndarray) -> np.ndarray:
        unit = np.clip(unit, 0, 1)
        foresee(sampler, [unit, *steps(unit)])  # the derivatives are asked for next, as a rule
        vector = sampler(unit)
        return bad if vector is None else vector

    def jacobian(unit: np.ndarray) -> np.ndarray:
        unit = np.clip(unit, 0, 1)
        centre = sampler(unit)
        if centre is None:
            raise _Stranded
        best[0] = unit
        if not to_the_end and _vanishing(sampler, centre):
            raise _NearZero
        foresee(sampler, steps(unit))
        columns = [_forward(sampler, unit, centre, axis) for axis in range(size)]
        return np.stack(columns, axis=1)

    limits = {
        "type": "ineq",
        "fun": lambda unit: values(unit)[1:],
        "jac": lambda unit: jacobian(unit)[1:],
    }
    try:
        solution = minimize(
            lambda unit: float(values(unit)[0]),
            start,
            jac=lambda unit: jacobian(unit)[0],
            method="SLSQP",
            bounds=[(0.0, 1.0)] * size,
            constraints=limits if first.size > 1 else (),
            options={"ftol": accuracy, "maxiter": MOST_STEPS},
        )
    except _NearZero:
        return LocalEnd(best[0], "near zero")
    except _Stranded:
        return LocalEnd(best[0], "stopped next to points that cannot be evaluated")
    end = np.clip(solution.x, 0, 1)
    if not np.all(np.isfinite(end)) or sampler(end) is None:
        return LocalEnd(best[0], "stopped next to points that cannot be evaluated")
    return LocalEnd(end, REASONS.get(int(solution.status), str(solution.message).lower()))


def _vanishing(sampler: Values, vector: np.ndarray) -> bool:
    """Whether an objective that was never negative is almost zero, with all margins kept."""
    never_negative = getattr(sampler, "smallest", -1.0) >= 0
    return never_negative and 0 <= vector[0] < VANISHING and bool(np.all(vector[1:] >= 0))


#: scipy's status of SLSQP in our words
REASONS = {
    0: CONVERGED,
    2: "more equations than variables",
    3: "the inner problem took too long",
    4: "the limits contradict each other here",
    5: "the inner problem is singular",
    6: "the inner problem is singular",
    7: "the inner problem is rank deficient",
    8: "no descent along the last direction",
    9: f"stopped after {MOST_STEPS} steps",
}


def _sides(unit: np.ndarray, axis: int) -> tuple[float, float]:
    return (1.0, -1.0) if unit[axis] < 0.5 else (-1.0, 1.0)


def _stepped(unit: np.ndarray, axis: int, side: float) -> np.ndarray:
    nearby = unit.copy()
    nearby[axis] += side * STEP
    return nearby


def _forward(sampler: Values, unit: np.ndarray, centre: np.ndarray, axis: int) -> np.ndarray:
    """One column of the Jacobian, from the side that stays inside and can be evaluated."""
    for side in _sides(unit, axis):
        nearby = _stepped(unit, axis, side)
        if 0 <= nearby[axis] <= 1:
            value = sampler(nearby)
            if value is not None:
                return np.asarray((value - centre) / (nearby[axis] - unit[axis]))
    raise _Stranded


# ----------------------------------------------------------------------------
# A point that keeps all limits, or the proof of the nearest miss.
# ----------------------------------------------------------------------------

MOST_TRIES = 3


def feasible_point(sampler: Sampler, ends: list[np.ndarray]) -> np.ndarray:
    """Make the worst margin as large as can be, from the least violated points known.

    Parameters
    ----------
    sampler : Sampler
    ends : list of (n,) arrays
        Points of the unit cube, the least violated first.

    Returns
    -------
    unit : (n,) array
        A point with all margins >= 0.

    Raises
    ------
    Infeasible
        If there is none: it names the least violated point and what is violated there.

    Notes
    -----
    One more variable is what all margins are granted, as a share of what the start breaks.
    """
    best, least = ends[0], np.array([-np.inf])
    for start in ends[:MOST_TRIES]:
        vector = sampler(start)
        assert vector is not None
        most = -float(np.min(vector[1:]))

        def relaxed(wide: np.ndarray, most: float = most) -> np.ndarray | None:
            values = sampler(wide[:-1])
            return None if values is None else np.append(wide[-1], values[1:] + most * wide[-1])

        unit = local_search(relaxed, np.append(start, 1.0)).unit[:-1]
        vector = sampler(unit)
        if vector is not None and np.min(vector[1:]) > np.min(least):
            best, least = unit, vector[1:]
        if np.min(least) >= 0:
            return best
    worst = ", ".join(
        f"margin {index} is {least[index]:.6g}" for index in np.flatnonzero(least < 0)
    )
    nearest = sampler.box.values(best)
    raise Infeasible(
        f"no point within the bounds keeps all limits. The least violated one found is at "
        f"{nearest.tolist()}: {worst} (relative to the limit, needs >= 0). "
        "Widen the bounds of the variables or relax these limits.",
        nearest,
        sampler.count,
    )


# ----------------------------------------------------------------------------
# Local searches from all starts, on one scale of the objective.
# ----------------------------------------------------------------------------

#: an objective whose change is a smaller share of it than this counts as constant
UNRESOLVED = 2e-11


class SearchEnds(NamedTuple):
    """All local searches, and what there is to say about them."""

    ends: list[Search]
    notes: tuple[str, ...]
    flat: bool = False


def search_all(
    sampler: Sampler,
    points: np.ndarray,
    searcher: Callable[[Values, np.ndarray], LocalEnd] = local_search,
    most: int = 1 << 30,
) -> SearchEnds:
    """Search from every start that can be evaluated; `sampler.scale` is set on the way.

    Parameters
    ----------
    sampler : Sampler
    points : (k, n) array
        Starts on the unit cube.
    searcher : callable
        The search from one start.
    most : int
        Most searches, where fewer than k do.

    Raises
    ------
    NumericalFailure
        If no start can be evaluated, or no point keeps all limits.
    """
    vectors, flat = set_scale(sampler, points)
    if all(vector is None for vector in vectors):
        raise NumericalFailure(
            f"none of the {len(points)} starting points of the search can be evaluated; the first "
            f"says: {next(iter(sampler.failures.values()))}"
        )
    ends: list[Search] = []
    notes: tuple[str, ...] = ()
    walks = 0
    for point, vector in zip(points, vectors, strict=True):
        before = sampler.count
        if walks == most:
            break
        if vector is None:
            reason = f"cannot be evaluated: {sampler.failures[(point + 0.0).tobytes()]}"
            ends.append(Search(point, point, np.nan, np.inf, reason, 0))
        elif sampler.left < sampler.reserve and any(end.violation < np.inf for end in ends):
            notes = (f"the budget ended the search after {len(ends)} of {len(points)} starts",)
            break
        else:
            walk = searcher(sampler, point)
            walks += 1
            ends.append(_end(sampler, point, walk.unit, walk.reason, sampler.count - before))
    if not any(end.feasible for end in ends):
        ends += _from_feasible(sampler, ends)
    return SearchEnds(ends, notes, flat)


def set_scale(sampler: Sampler, points: np.ndarray) -> tuple[list[np.ndarray | None], bool]:
    """Values (before scaling) at the points; `sampler.scale` becomes their typical change.

    Also whether the objective is flat: its change is too small a share of it to be resolved.
    """
    foresee(sampler, list(points))
    vectors = [sampler(point) for point in points]
    if all(vector is None for vector in vectors):
        return vectors, False
    change = _change(sampler, points, vectors)
    least = UNRESOLVED * sampler.largest
    # a power of two, so that scaling is exact
    sampler.scale = 2.0 ** round(np.log2(max(change, least))) if change > 0 or least > 0 else 1.0
    return vectors, change <= least


def _from_feasible(sampler: Sampler, ends: list[Search]) -> list[Search]:
    """Find a point that keeps all limits and search from it."""
    nearest = sorted(
        (end for end in ends if np.isfinite(end.violation)), key=lambda end: end.violation
    )
    before = sampler.count
    start = feasible_point(sampler, [end.end for end in nearest])
    unit, reason = local_search(sampler, start)
    improved = _end(sampler, start, unit, reason, sampler.count - before)
    if improved.feasible:
        return [improved]
    return [improved, _end(sampler, start, start, "keeps the limits, not improved", 0)]


def _end(
    sampler: Sampler, start: np.ndarray, unit: np.ndarray, reason: str, evaluations: int
) -> Search:
    unit = sampler.box.fold(unit)
    vector = sampler(unit)
    assert vector is not None
    violation = float(np.max(-vector[1:], initial=0.0))
    return Search(start, unit, float(vector[0]), violation, reason, evaluations)


def _change(sampler: Sampler, points: np.ndarray, vectors: list[np.ndarray | None]) -> float:
    """A typical change of the objective over the bounds: of the starts, or of a small step."""
    tops = np.array([v[0] for v in vectors if v is not None])
    apart = np.abs(tops - np.median(tops))
    changes = [float(np.median(apart)), float(np.max(apart))]
    centre_point = next(p for p, v in zip(points, vectors, strict=True) if v is not None)
    for axis in range(points.shape[1]):
        nearby = centre_point.copy()
        nearby[axis] += 1e-2 if nearby[axis] < 0.5 else -1e-2
        value = sampler(nearby)
        if value is not None:
            changes.append(1e2 * abs(float(value[0] - tops[0])))
    least = UNRESOLVED * sampler.largest
    if max(changes) <= least:  # a start of high symmetry may hide all change
        for point in spread(8, points.shape[1]):
            value = sampler(point)
            if value is not None:
                changes.append(abs(float(value[0] - tops[0])))
    return next((change for change in changes if change > least), max(changes))
