"""Local searches by sequential quadratic programming, from many starts and on one scale."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial

import numpy as np

from vibecalc.core.study.search.problem import Sampler, Search, spread
from vibecalc.core.study.search.side_by_side import Ask, side_by_side
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# One local search by sequential quadratic programming.
# ----------------------------------------------------------------------------

#: forward step on the unit cube: square root of the relative noise expected of a pipeline
STEP = 1e-6
ACCURACY = 1e-7
FINE_ACCURACY = 1e-13
MOST_STEPS = 60
#: steps without gain that end a search, and the share of a violation whose loss is none
IDLE, SLIGHT = 2, 1e-3
#: a norm below this, in scaled units, is left to the method for zeros
VANISHING = 1e-3


class Stranded(Exception):
    """A search cannot go on next to points that cannot be evaluated, or has nothing to gain."""


def local_search(values: Sampler, start: np.ndarray, *, to_the_end: bool = False) -> np.ndarray:
    """Where a search downhill from a start with SLSQP ends (k,), whatever the reason.

    Parameters
    ----------
    values : Sampler
    start : (k,) array
        Point of the unit cube at which there are values.
    to_the_end : bool
        Without it the search ends where it gains little, or where a norm is about to vanish.

    Notes
    -----
    D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28 (1988), as
    in scipy. Of several parts the largest is made small as the least number that none exceeds: each
    part is smooth where their largest has a kink. Points that cannot be evaluated look worse than
    all others, and the line search turns back from them.
    """
    from scipy.optimize import minimize

    size, parts, box = start.size, values.parts, values.box
    best, first = start, values(start)
    assert first is not None
    is_part = np.arange(first.size) < parts
    top = float(np.max(first[:parts]))
    bad = np.where(is_part, top + 1e3, -1.0)
    several, idle = parts > 1, 0
    accuracy = FINE_ACCURACY if to_the_end else ACCURACY

    def at(place: np.ndarray) -> np.ndarray:
        unit = box.inside(place[:size])
        values.ahead(with_steps(unit))  # the derivatives are asked for next, as a rule
        vector = values(unit)
        return bad if vector is None else vector

    def jacobian(place: np.ndarray) -> np.ndarray:
        nonlocal best, idle
        unit = box.inside(place[:size])
        centre = values(unit)
        if centre is None:
            raise Stranded
        if not np.array_equal(unit, best):
            idle = idle + 1 if _is_level(values(best), centre, parts, accuracy) else 0
        best = unit
        if idle >= IDLE or (not to_the_end and _vanishing(values, centre)):
            raise Stranded
        return forward_slopes(values, unit)

    def limits(place: np.ndarray) -> np.ndarray:
        vector = at(place)
        return np.append(place[size] - vector[:parts], vector[parts:]) if several else vector[1:]

    def limit_slopes(place: np.ndarray) -> np.ndarray:
        slopes = jacobian(place)
        if not several:
            return slopes[1:]
        return np.column_stack([np.where(is_part[:, None], -slopes, slopes), is_part])

    bounds = [(None, None) if around else (0.0, 1.0) for around in box.around]
    limited = {"type": "ineq", "fun": limits, "jac": limit_slopes}
    with suppress(Stranded):
        end = minimize(
            lambda place: float(place[size] if several else at(place)[0]),
            np.append(start, top) if several else start,
            jac=lambda place: np.eye(size + 1)[size] if several else jacobian(place)[0],
            method="SLSQP",
            bounds=bounds + [(None, None)] * several,
            constraints=limited if first.size > 1 else (),
            options={"ftol": accuracy, "maxiter": MOST_STEPS},
        ).x[:size]
        if np.all(np.isfinite(end)) and values(end) is not None:
            best = end
    return box.fold(best)


def _is_level(before: np.ndarray | None, after: np.ndarray, parts: int, accuracy: float) -> bool:
    """Whether a step changed neither the objective nor, by much, how far limits are broken.

    SLSQP ends by itself where it gains little and limits hold; where none can be kept it goes on.
    """
    if before is None:
        return False
    tops = [float(np.max(one[:parts])) for one in (before, after)]
    broken = [float(np.max(-one[parts:], initial=0.0)) for one in (before, after)]
    return abs(tops[1] - tops[0]) <= accuracy and broken[1] >= (1.0 - SLIGHT) * broken[0]


def _vanishing(values: Sampler, vector: np.ndarray) -> bool:
    """Whether an objective that was never negative is almost zero, with all margins kept."""
    one = values.parts == 1 and values.smallest >= 0
    return one and 0 <= vector[0] < VANISHING and bool(np.all(vector[1:] >= 0))


def with_steps(unit: np.ndarray, step: float = STEP) -> list[np.ndarray]:
    """A point and those that its `forward_slopes` ask for first."""
    return [unit, *(unit + _sides(unit, step))]


def _sides(unit: np.ndarray, step: float) -> np.ndarray:
    return np.diag(np.where(unit < 0.5, step, -step))


def forward_slopes(values: Sampler, unit: np.ndarray, step: float = STEP) -> np.ndarray:
    """Slopes (v, k), each from the side that stays inside and can be evaluated; else Stranded."""
    columns, centre = [], values(unit)
    for side in _sides(unit, step):
        for nearby in (unit + side, unit - side):
            value = values(nearby) if np.array_equal(nearby, values.box.inside(nearby)) else None
            if value is not None and centre is not None:
                columns.append((value - centre) / np.sum(nearby - unit))
                break
        else:
            raise Stranded
    return np.stack(columns, axis=1)


# ----------------------------------------------------------------------------
# Local searches from all starts, on one scale of the objective.
# ----------------------------------------------------------------------------

#: an objective whose change is a smaller share of it than this counts as constant
UNRESOLVED = 2e-11
#: evaluations after which no further start is searched from, and starts searched from side by side
MOST_EVALUATIONS, TOGETHER = 20_000, 16


def search_all(sampler: Sampler, points: np.ndarray) -> list[Search]:
    """Search from every start that can be evaluated; `sampler.scale` is set on the way.

    Parameters
    ----------
    sampler : Sampler
    points : (j, k) array
        Starts on the unit cube.

    Raises
    ------
    NumericalFailure
        If no start can be evaluated, or no point keeps all limits.
    """
    set_scale(sampler, points)
    if len(sampler.failures) == sampler.count:
        raise NumericalFailure(
            f"none of the {len(points)} starting points of the search can be evaluated; the first "
            f"says: {next(iter(sampler.failures.values()))}"
        )
    ends: list[Search] = []
    together = TOGETHER if sampler.problem.ahead else 1
    for first in range(0, len(points), together):
        if ends and sampler.count > MOST_EVALUATIONS:
            sampler.notes.append(
                f"{sampler.count} points ended the search after {len(ends)} of {len(points)} starts"
            )
            break
        begun = points[first : first + together]
        if len(begun) == 1:
            ends.append(_searched(sampler, begun[0], local_search))
            continue
        searches = [partial(_among, sampler, point) for point in begun]
        ends += side_by_side(searches, sampler.ahead)
    if not any(end.feasible for end in ends):
        start = _feasible_point(sampler, [end for end in ends if np.isfinite(end.violation)])
        ends.append(_searched(sampler, start, local_search))
        if not ends[-1].feasible:  # that point keeps the limits, as it is
            ends.append(_searched(sampler, start, lambda values, unit: unit))
    return ends


def _among(sampler: Sampler, start: np.ndarray, ask: Ask) -> Search:
    """One of several searches side by side."""
    return _searched(sampler.asking(ask), start, local_search)


def _searched(
    sampler: Sampler, start: np.ndarray, search: Callable[[Sampler, np.ndarray], np.ndarray]
) -> Search:
    before = sampler.spent
    view = sampler.largest_part() if sampler.problem.of_maxima else sampler
    unit = start if sampler(start) is None else search(view, start)
    spent = sampler.spent - before
    return Search(start, unit, sampler.top(unit), sampler.violation(unit), spent)


#: ends of searches from which a point that keeps all limits is sought
MOST_TRIES = 3


def _feasible_point(sampler: Sampler, ends: list[Search]) -> np.ndarray:
    """Make the worst margin as large as can be, from the least violated ends.

    Infeasible, with the least violated point and what it breaks, where none keeps all limits.
    """
    tried = [ends[0].end]
    for end in sorted(ends, key=lambda end: end.violation)[:MOST_TRIES]:

        def missing(vector: np.ndarray, most: float = end.violation) -> np.ndarray:
            return -vector[sampler.parts :] / most

        margins = sampler.view(missing, lambda off: off[sampler.parts :], sum(sampler.entries))
        unit = local_search(margins, end.end)
        tried.append(unit)
        if sampler.violation(unit) == 0.0:
            return unit
    raise sampler.infeasible(
        min(tried, key=sampler.violation),
        "no point within the bounds keeps all limits. The least violated one found is at {at}: "
        "{worst} (relative to the limit, needs >= 0). "
        "Widen the bounds of the variables or relax these limits.",
    )


def set_scale(sampler: Sampler, points: np.ndarray) -> None:
    """Take as `sampler.scale` the typical change of the objective at the points, and around.

    `sampler.flat` becomes whether that is too small a share of the objective to be resolved.
    """
    sampler.ahead(list(points))
    known = [point for point in points if sampler(point) is not None]
    if not known:
        return
    tops, centre = np.array([sampler.top(point) for point in known]), known[0]

    def changes_to(points: np.ndarray, factor: float) -> list[float]:
        sampler.ahead(list(points))
        there = np.array([sampler.top(point) for point in points])
        return list(factor * np.abs(there[np.isfinite(there)] - tops[0]))

    apart = np.abs(tops - np.median(tops))
    steps = np.diag(np.where(centre < 0.5, 1e-2, -1e-2))
    changes = [float(np.median(apart)), float(np.max(apart)), *changes_to(centre + steps, 1e2)]
    least = UNRESOLVED * sampler.largest
    if max(changes) <= least:  # a start of high symmetry may hide all change
        changes += changes_to(spread(8, centre.size), 1.0)
    change = next((change for change in changes if change > least), max(changes))
    sampler.flat = change <= least
    # a power of two, so that scaling is exact
    sampler.scale = 2.0 ** round(np.log2(max(change, least))) if change > 0 or least > 0 else 1.0
