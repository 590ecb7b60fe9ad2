"""Local searches by sequential quadratic programming, from a point that keeps all limits."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from vibecalc.core.study.search.problem import Infeasible, Sampler, Values, Violations, spread
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


class LocalEnd(NamedTuple):
    """Where a local search stopped, on the unit cube, and in words why."""

    unit: np.ndarray
    reason: str


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
    Several entries of an objective become the smallest t with t >= entry, so that the corner of
    their maximum is smooth to the method. D. Kraft, A software package for sequential quadratic
    programming, DFVLR-FB 88-28 (1988), as in scipy. Points that cannot be evaluated look worse
    than all others, and the line search turns back from them.
    """
    from scipy.optimize import minimize

    accuracy = FINE_ACCURACY if to_the_end else ACCURACY
    minimax = sampler.entries > 1
    size = start.size
    best: list[np.ndarray] = [start]
    first = sampler(start)
    assert first is not None
    worst = float(np.max(first[: sampler.entries])) + 1e3

    def values(unit: np.ndarray) -> np.ndarray:
        vector = sampler(np.clip(unit, 0, 1))
        if vector is not None:
            return vector
        bad = np.full_like(first, -1.0)
        bad[: sampler.entries] = worst
        return bad

    def jacobian(unit: np.ndarray) -> np.ndarray:
        unit = np.clip(unit, 0, 1)
        centre = sampler(unit)
        if centre is None:
            raise _Stranded
        best[0] = unit
        if not to_the_end and _vanishing(sampler, centre):
            raise _NearZero
        columns = [_forward(sampler, unit, centre, axis) for axis in range(size)]
        return np.stack(columns, axis=1)

    entries = sampler.entries
    if minimax:
        point = np.append(start, np.max(first[:entries]))
        slack = np.concatenate([np.ones(entries), np.zeros(first.size - entries)])[:, None]
        sign = np.concatenate([-np.ones(entries), np.ones(first.size - entries)])
        gradient = np.append(np.zeros(size), 1.0)
        arguments = {
            "fun": lambda z: float(z[-1]),
            "jac": lambda z: gradient,
            "constraints": {
                "type": "ineq",
                "fun": lambda z: sign * values(z[:-1]) + slack[:, 0] * z[-1],
                "jac": lambda z: np.hstack([sign[:, None] * jacobian(z[:-1]), slack]),
            },
            "bounds": [(0.0, 1.0)] * size + [(None, None)],
        }
    else:
        point = start
        limits = {
            "type": "ineq",
            "fun": lambda z: values(z)[1:],
            "jac": lambda z: jacobian(z)[1:],
        }
        arguments = {
            "fun": lambda z: float(values(z)[0]),
            "jac": lambda z: jacobian(z)[0],
            "constraints": limits if first.size > 1 else (),
            "bounds": [(0.0, 1.0)] * size,
        }
    try:
        solution = minimize(
            x0=point, method="SLSQP", options={"ftol": accuracy, "maxiter": MOST_STEPS}, **arguments
        )
    except _NearZero:
        return LocalEnd(best[0], "near zero")
    except _Stranded:
        return LocalEnd(best[0], "stopped next to points that cannot be evaluated")
    end = np.clip(solution.x[:size], 0, 1)
    if not np.all(np.isfinite(end)) or sampler(end) is None:
        return LocalEnd(best[0], "stopped next to points that cannot be evaluated")
    return LocalEnd(end, REASONS.get(int(solution.status), str(solution.message).lower()))


def _vanishing(sampler: Values, vector: np.ndarray) -> bool:
    """Whether a single entry that was never negative is almost zero, with all margins kept."""
    never_negative = getattr(sampler, "smallest", -1.0) >= 0
    small = sampler.entries == 1 and 0 <= vector[0] < VANISHING
    return never_negative and small and bool(np.all(vector[1:] >= 0))


#: scipy's status of SLSQP in our words
REASONS = {
    0: "converged",
    2: "more equations than variables",
    3: "the inner problem took too long",
    4: "the limits contradict each other here",
    5: "the inner problem is singular",
    6: "the inner problem is singular",
    7: "the inner problem is rank deficient",
    8: "no descent along the last direction",
    9: f"stopped after {MOST_STEPS} steps",
}


def _forward(sampler: Values, unit: np.ndarray, centre: np.ndarray, axis: int) -> np.ndarray:
    """One column of the Jacobian, from the side that stays inside and can be evaluated."""
    for side in (1.0, -1.0) if unit[axis] < 0.5 else (-1.0, 1.0):
        step = side * STEP
        nearby = unit.copy()
        nearby[axis] += step
        if 0 <= nearby[axis] <= 1:
            value = sampler(nearby)
            if value is not None:
                return np.asarray((value - centre) / (nearby[axis] - unit[axis]))
    raise _Stranded


# ----------------------------------------------------------------------------
# A point that keeps all limits, or the proof of the nearest miss.
# ----------------------------------------------------------------------------

MOST_TRIES = 3


def feasible_point(sampler: Sampler, ends: list[np.ndarray], margins: int) -> np.ndarray:
    """Make the worst margin as large as can be, from the least violated points known.

    Parameters
    ----------
    sampler : Sampler
    ends : list of (n,) arrays
        Points of the unit cube, the least violated first.
    margins : int
        m.

    Returns
    -------
    unit : (n,) array
        A point with all margins >= 0.

    Raises
    ------
    Infeasible
        If there is none: it names the least violated point and what is violated there.
    """
    view = Violations(sampler, margins)
    best, least = ends[0], np.inf
    for start in ends[:MOST_TRIES]:
        end = local_search(view, start).unit
        vector = view(end)
        assert vector is not None
        if np.max(vector) < least:
            best, least = end, float(np.max(vector))
        if least <= 0:
            return best
    values = sampler(best)
    assert values is not None
    margin_values = values[sampler.entries :]
    worst = ", ".join(
        f"margin {index} is {margin_values[index]:.6g}"
        for index in np.flatnonzero(margin_values < 0)
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

#: violation up to which the end of a local search counts as feasible, before it is refined
FEASIBLE_WITHIN = 1e-6
#: an objective whose change is a smaller share of it than this counts as constant
UNRESOLVED = 2e-11


class SearchEnd(NamedTuple):
    """Start and end of a local search on the unit cube; objective and violation at its end."""

    start: np.ndarray
    unit: np.ndarray
    objective: float
    violation: float
    reason: str
    evaluations: int


class SearchEnds(NamedTuple):
    """All local searches, and what there is to say about them."""

    ends: list[SearchEnd]
    notes: tuple[str, ...]
    flat: bool = False


class SearchOutcome(Protocol):
    """What a search hands back: the end on the unit cube, and in words why it stopped."""

    @property
    def unit(self) -> np.ndarray: ...

    @property
    def reason(self) -> str: ...


def search_all(
    sampler: Sampler,
    points: np.ndarray,
    searcher: Callable[[Values, np.ndarray], SearchOutcome] = local_search,
    most: int | None = None,
) -> SearchEnds:
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
    ends: list[SearchEnd] = []
    notes: tuple[str, ...] = ()
    walks = 0
    for point, vector in zip(points, vectors, strict=True):
        before = sampler.count
        if walks == most:
            break
        if vector is None:
            reason = f"cannot be evaluated: {sampler.failures[(point + 0.0).tobytes()]}"
            ends.append(SearchEnd(point, point, np.nan, np.inf, reason, 0))
        elif sampler.left < sampler.reserve and any(end.violation < np.inf for end in ends):
            notes = (f"the budget ended the search after {len(ends)} of {len(points)} starts",)
            break
        else:
            walk = searcher(sampler, point)
            walks += 1
            ends.append(_end(sampler, point, walk.unit, walk.reason, sampler.count - before))
    if not any(end.violation <= FEASIBLE_WITHIN for end in ends):
        ends += _from_feasible(sampler, ends, known[0].size - sampler.entries)
    return SearchEnds(ends, notes, flat)


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


def _from_feasible(sampler: Sampler, ends: list[SearchEnd], margins: int) -> list[SearchEnd]:
    """Find a point that keeps all limits and search from it."""
    nearest = sorted(
        (end for end in ends if np.isfinite(end.violation)), key=lambda end: end.violation
    )
    before = sampler.count
    start = feasible_point(sampler, [end.unit for end in nearest], margins)
    unit, reason = local_search(sampler, start)
    improved = _end(sampler, start, unit, reason, sampler.count - before)
    if improved.violation <= FEASIBLE_WITHIN:
        return [improved]
    return [improved, _end(sampler, start, start, "keeps the limits, not improved", 0)]


def _end(
    sampler: Sampler, start: np.ndarray, unit: np.ndarray, reason: str, evaluations: int
) -> SearchEnd:
    unit = sampler.box.fold(unit)
    vector = sampler(unit)
    assert vector is not None
    objective = float(np.max(vector[: sampler.entries]))
    violation = float(np.max(-vector[sampler.entries :], initial=0.0))
    return SearchEnd(start, unit, objective, violation, reason, evaluations)


def _change(sampler: Sampler, points: np.ndarray, vectors: list[np.ndarray | None]) -> float:
    """A typical change of the objective over the bounds: of the starts, or of a small step."""
    tops = np.array([np.max(v[: sampler.entries]) for v in vectors if v is not None])
    apart = np.abs(tops - np.median(tops))
    changes = [float(np.median(apart)), float(np.max(apart))]
    centre_point = next(p for p, v in zip(points, vectors, strict=True) if v is not None)
    for axis in range(points.shape[1]):
        nearby = centre_point.copy()
        nearby[axis] += 1e-2 if nearby[axis] < 0.5 else -1e-2
        value = sampler(nearby)
        if value is not None:
            changes.append(1e2 * abs(float(np.max(value[: sampler.entries]) - tops[0])))
    least = UNRESOLVED * sampler.largest
    if max(changes) <= least:  # a start of high symmetry may hide all change
        for point in spread(8, points.shape[1]):
            value = sampler(point)
            if value is not None:
                changes.append(abs(float(np.max(value[: sampler.entries]) - tops[0])))
    return next((change for change in changes if change > least), max(changes))
