"""Minimise a function of bounded variables while margins are kept, from many starts."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.local_search import (
    VANISHING,
    SearchEnds,
    local_search,
    search_all,
)
from vibecalc.core.study.search.methods import METHODS
from vibecalc.core.study.search.problem import (
    FEASIBLE_WITHIN,
    Ahead,
    Box,
    BudgetSpent,
    ErrorsAt,
    Evaluate,
    Infeasible,
    LocalOptimum,
    Optimum,
    Sampler,
    Search,
    spread,
)
from vibecalc.core.study.search.refine import RefinedOptimum, at_rest, keeps, refine
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Equally good end points that are one: what differs between them has no effect there.
# ----------------------------------------------------------------------------

#: objectives this close, in scaled units, are equal
EQUAL = 1e-9
#: places between two ends, spaced so that no even wave passes through all of them
_BETWEEN = (0.137, 0.381, 0.529, 0.734)


def groups(sampler: Sampler, points: list[LocalOptimum]) -> list[list[LocalOptimum]]:
    """Group the points between which the objective does not change; the order is kept.

    A weight of zero has no angle: searches that end there with different angles found the same
    thing. Two points are one if their objectives are equal, and stay so, with all limits kept,
    on the straight line between them. Where no evaluations are left, points stay apart.
    """
    found: list[list[LocalOptimum]] = []
    for point in points:
        group = next((one for one in found if _same(sampler, one[0], point)), None)
        if group is None:
            found.append([point])
        else:
            group.append(point)
    return found


def _same(sampler: Sampler, one: LocalOptimum, other: LocalOptimum) -> bool:
    if abs(one.objective - other.objective) > EQUAL:
        return False
    try:
        difference = sampler.box.apart(one.point, other.point)
        vectors = [sampler(one.point + part * difference) for part in _BETWEEN]
    except BudgetSpent:
        return False
    return all(
        vector is not None
        and abs(float(vector[0]) - one.objective) <= EQUAL
        and bool(np.all(vector[1:] >= -FEASIBLE_WITHIN))
        for vector in vectors
    )


# ----------------------------------------------------------------------------
# From the ends of all searches to one optimum, known to its last digits.
# ----------------------------------------------------------------------------

#: end points closer than this on the unit cube are one optimum
SAME = 1e-3
#: end points whose objectives are this close, in scaled units, compete for the last digits
RIVALS = 1e-2
#: and those this close to a refined optimum that is lower have stopped short of it
SHORT_OF = 3e-2
MOST_RIVALS = 4


class ChosenOptimum(NamedTuple):
    """The optimum, refined, and all distinct ends that keep the limits, lowest first."""

    best: RefinedOptimum
    distinct: tuple[LocalOptimum, ...]


def choose(sampler: Sampler, ends: list[Search], begin: np.ndarray) -> ChosenOptimum:
    """Refine the ends that compete and take the lowest; of equally low ones the nearest to begin.

    Raises
    ------
    NumericalFailure
        If none of them can be shown to be a local optimum.
    """
    distinct = _distinct(sampler.box, ends)
    lowest = distinct[0].objective
    # searches for a zero stop early: their ends are equal before they are refined
    vanishes = sampler.smallest >= 0 and lowest < VANISHING
    equal = VANISHING if vanishes else 1e-6

    def rank(point: np.ndarray) -> tuple[float, ...]:
        away = round(float(np.linalg.norm(sampler.box.apart(begin, point))), 6)
        return (away, *np.round(point, 6))

    level = sorted(
        (one for one in distinct if one.objective <= lowest + equal),
        key=lambda one: rank(one.point),
    )
    rivals = [one for one in distinct if lowest + equal < one.objective <= lowest + RIVALS]
    half = MOST_RIVALS // 2
    refined: list[RefinedOptimum] = []
    final = {id(one): one for one in distinct}
    for one in level[:half] + rivals[:half] + level[half:] + rivals[half:]:
        if len(refined) == MOST_RIVALS:
            break
        if any(_covers(sampler.box, done, one) for done in refined):
            continue
        below = min((done.objective for done in refined), default=np.inf)
        optimum = refine(sampler, one.point, below)
        if optimum is not None and keeps(sampler, optimum.unit):
            optimum = optimum._replace(unit=sampler.box.fold(optimum.unit))
            refined.append(optimum)
            final[id(one)] = one._replace(point=optimum.unit, objective=optimum.objective)
    if not refined:
        raise NumericalFailure(
            "no search ended in a point that can be shown to be an optimum; the lowest end is at "
            f"{sampler.box.values(distinct[0].point).tolist()} with the objective "
            f"{lowest * sampler.scale:.9g}. Ask for more starts or narrow the bounds."
        )
    least = min(one.objective + one.excess for one in refined)
    lowest_ones = [one for one in refined if one.objective - one.excess <= least]
    best = min(lowest_ones, key=lambda one: rank(one.unit))
    ordered = sorted(final.values(), key=lambda one: (one.objective, *one.point))
    joined = [
        group[0]._replace(found_by=sum(one.found_by for one in group))
        for group in groups(sampler, ordered)
    ]
    return ChosenOptimum(best, tuple(joined))


def anywhere(sampler: Sampler, ends: list[Search]) -> ChosenOptimum:
    """The choice where the objective is the same everywhere: the first end that keeps all limits.

    It counts as the same where its change is below `search.UNRESOLVED` of its magnitude.
    """
    distinct = _distinct(sampler.box, ends)
    end = next(end.end for end in ends if end.feasible)
    vector = sampler(end)
    assert vector is not None
    best = at_rest(end, vector, "flat")._replace(
        error=np.full(end.size, max(0.0, -float(np.min(vector[1:], initial=0.0)))),
        excess=2.0,  # the scale is the largest change seen, rounded to a power of two
        free_directions=end.size,
    )
    return ChosenOptimum(best, distinct)


def only_point(sampler: Sampler, held: str) -> tuple[SearchEnds, ChosenOptimum]:
    """The answer where all variables are `held`, as these words say: one evaluation.

    Raises
    ------
    NumericalFailure
        If it cannot be evaluated or breaks a limit.
    """
    nowhere = np.empty(0)
    vector = sampler(nowhere)
    if vector is None:
        raise NumericalFailure(
            f"{held}cannot be evaluated: {next(iter(sampler.failures.values()))}"
        )
    margins = vector[1:]
    if np.any(margins < 0):
        raise Infeasible(
            f"{held}breaks a limit: margin {int(np.argmin(margins))} is "
            f"{float(np.min(margins)):.6g}",
            nowhere,
            sampler.count,
        )
    objective = float(vector[0])
    best = at_rest(nowhere, vector, "fixed")._replace(excess=EPSILON * abs(objective))
    end = Search(nowhere, nowhere, objective, 0.0, "all variables are held", 1)
    return SearchEnds([end], ()), ChosenOptimum(best, (LocalOptimum(nowhere, objective, 1),))


def _distinct(box: Box, ends: list[Search]) -> tuple[LocalOptimum, ...]:
    feasible = [end for end in ends if end.feasible]
    distinct: list[LocalOptimum] = []
    for end in sorted(feasible, key=lambda end: (end.objective, *end.end)):
        for index, one in enumerate(distinct):
            if np.max(np.abs(box.apart(one.point, end.end)), initial=0.0) < SAME:
                distinct[index] = one._replace(found_by=one.found_by + 1)
                break
        else:
            distinct.append(LocalOptimum(end.end, end.objective, 1))
    return tuple(distinct)


def _covers(box: Box, done: RefinedOptimum, end: LocalOptimum) -> bool:
    """Whether an end is nearby and no lower: a search that stopped short of the same optimum."""
    near = np.max(np.abs(box.apart(done.unit, end.point)), initial=0.0) < SHORT_OF
    return bool(near) and done.objective <= end.objective


# ----------------------------------------------------------------------------
# From the unit cube back to variables, units and words.
# ----------------------------------------------------------------------------


def summary(
    sampler: Sampler,
    whole: Box,
    moving: np.ndarray,
    search: SearchEnds,
    choice: ChosenOptimum,
    rtol: float,
) -> Optimum:
    """Put the choice into the units of the caller.

    Parameters
    ----------
    sampler : Sampler
    whole : Box
        Bounds of all n variables.
    moving : (n,) array
        Which of them are not held by equal bounds.
    search, choice : SearchEnds, ChosenOptimum
    rtol : float
        As in `minimise`.
    """
    best = choice.best
    scale = sampler.scale

    def spread_out(part: np.ndarray, held: np.ndarray) -> np.ndarray:
        full = held.copy()
        full[moving] = part
        return full

    def variables(unit: np.ndarray) -> np.ndarray:
        return spread_out(sampler.box.values(unit), whole.lower)

    vector = sampler(best.unit)
    assert vector is not None
    optimum = variables(best.unit)
    inner = sampler.box.slope(optimum[moving])
    nothing = np.zeros(whole.lower.size)
    objective = float(vector[0]) * scale
    objective_error = best.excess * scale + 2 * EPSILON * abs(objective)
    return Optimum(
        variables=optimum,
        variables_error=spread_out(
            np.minimum(
                inner * best.error
                + np.where(best.sides == 0, 2 * EPSILON, 0.0) * np.abs(optimum[moving]),
                sampler.box.farthest(optimum[moving]),
            ),
            nothing,
        ),
        objective=objective,
        objective_error=objective_error,
        margins=vector[1:],
        active_margins=best.active_margins,
        margin_multipliers=best.margins * scale,
        active_bounds=spread_out(best.sides, np.zeros(whole.lower.size, dtype=int)),
        bound_multipliers=spread_out(best.bounds * scale / inner, nothing),
        kkt_residual=best.residual,
        free_directions=best.free_directions,
        method=best.method,
        evaluations=sampler.count,
        failures=len(sampler.failures),
        failure_messages=tuple(dict.fromkeys(sampler.failures.values())),
        history=tuple(
            end._replace(
                start=variables(end.start), end=variables(end.end), objective=end.objective * scale
            )
            for end in search.ends
        ),
        optima=tuple(
            one._replace(point=variables(one.point), objective=one.objective * scale)
            for one in choice.distinct
        ),
        notes=search.notes
        + _notes(
            best.free_directions, best.unit.size, objective_error, rtol * max(abs(objective), scale)
        ),
    )


def _notes(free_directions: int, size: int, error: float, tolerance: float) -> tuple[str, ...]:
    notes = []
    if size and free_directions == size:
        notes.append("the objective does not change with the variables here")
    elif free_directions:
        notes.append(
            f"equally good optima form a continuum with {free_directions} free direction"
            f"{'s' if free_directions > 1 else ''}; one of them is given"
        )
    if error > tolerance:
        notes.append(f"the objective is known to {error:.2g} only, {tolerance:.2g} was asked for")
    return tuple(notes)


# ----------------------------------------------------------------------------
# Minimise a function of bounded variables while margins are kept, from many starts.
# ----------------------------------------------------------------------------


def minimise(
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    first: ArrayLike | None = None,
    starts: int | np.ndarray = 8,
    rtol: float = 1e-9,
    budget: int = 20000,
    errors: ErrorsAt | None = None,
    method: str = "sequential_quadratic",
    period: ArrayLike = 0.0,
    ahead: Ahead | None = None,
) -> Optimum:
    """Find the smallest objective within bounds whose margins are all at least zero.

    Parameters
    ----------
    evaluate : callable
        `evaluate(variables (n,)) -> (objective, margins (m,))`. A margin, made dimensionless by
        its limit, is kept where it is >= 0. A point that raises NumericalFailure or gives NaN
        or an infinity is counted and the search goes around it. Values have to be repeatable.
    lower, upper : (n,) arrays
        Bounds. A variable whose bounds are equal is held there.
    first : (n,) array, optional
        The first start; the middle of the bounds without it. Of equally good ends of
        searches, the nearest to it is returned.
    starts : int or (k, n) array
        How many further starts of a fixed low-discrepancy sequence, or the starts themselves.
    rtol : float
        Error of the objective, relative to its magnitude or to its change over the bounds, above
        which a note says so.
    budget : int
        Most evaluations.
    errors : callable
        `errors(variables (n,)) -> (1 + m,)`, absolute errors of objective and margins, where known;
        round-off is always counted and noise is measured. An error of a variable is what they may
        move the optimum by in its direction, at most to the farther of its bounds.
    method : str
        Key of `methods.METHODS`: what searches from each start. The end is refined the same way
        whatever it is.
    period : (n,) array
        After how much a variable repeats itself, as an angle does; 0 where it does not. One whose
        bounds hold a whole period has no bounds, and is counted from its lower bound on.
    ahead : callable
        Told of variables (k, n) before they are evaluated one by one.

    Returns
    -------
    optimum : Optimum

    Raises
    ------
    Infeasible
        If no point keeps all margins.
    NumericalFailure
        If no start can be evaluated, the objective has no lower bound, or no search ends in a
        point that can be shown to be an optimum.

    Notes
    -----
    Local searches run from all starts. The best of their ends are refined by Newton's method on
    the conditions that hold them, or, on a kink, by sampled planes; that step is also what shows
    the point to be a local optimum and how well it is known. That it is the global one rests on
    the starts.
    """
    low = np.atleast_1d(np.asarray(lower, dtype=float))
    high = np.atleast_1d(np.asarray(upper, dtype=float))
    moving = high > low
    whole = Box(low, high, np.broadcast_to(np.asarray(period, dtype=float), low.shape))

    def of_moving(part: np.ndarray) -> tuple[float, ArrayLike]:
        variables = low.copy()
        variables[moving] = part
        return evaluate(variables)

    def ahead_of_moving(parts: np.ndarray) -> None:
        variables = np.tile(low, (len(parts), 1))
        variables[:, moving] = parts
        if ahead is not None:
            ahead(variables)

    def errors_of_moving(part: np.ndarray) -> np.ndarray:
        variables = low.copy()
        variables[moving] = part
        assert errors is not None
        return errors(variables)

    sampler = Sampler(
        of_moving, whole.only(moving), budget, ahead and ahead_of_moving,
        errors and errors_of_moving,
    )  # fmt: skip
    begin = np.full(low.size, 0.5) if first is None else whole.unit(np.asarray(first, dtype=float))
    if isinstance(starts, int):
        further = whole.start(spread(starts, low.size))
    else:
        further = whole.unit(starts)
    points = np.vstack([begin[None, :], further.reshape(len(further), low.size)])[:, moving]
    try:
        if not np.any(moving):
            held = "all variables are held by equal bounds, and that point "
            search, choice = only_point(sampler, held if low.size else "what is picked ")
        else:
            chosen = METHODS[method]
            searcher = local_search if method == "sequential_quadratic" else chosen.search
            most = 1 if chosen.everywhere else len(points)
            search = search_all(sampler, points, searcher, most)
            choice = (
                anywhere(sampler, search.ends)
                if search.flat
                else choose(sampler, search.ends, points[0])
            )
    except Infeasible as failure:
        nearest = low.copy()
        nearest[moving] = failure.variables
        raise Infeasible(str(failure), nearest, failure.evaluations) from None
    except BudgetSpent:
        raise NumericalFailure(
            f"the search had spent its {budget} evaluations before an optimum was pinned down; "
            f"{sampler.lowest_feasible()}. Allow more evaluations or ask for fewer starts."
        ) from None
    return summary(sampler, whole, moving, search, choice, rtol)
