"""Minimise a function of bounded variables while margins are kept, from many starts."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.derivatives import stationarity
from vibecalc.core.study.search.local_search import local_search, search_all, set_scale
from vibecalc.core.study.search.methods import METHODS
from vibecalc.core.study.search.newton import BALANCED, Refined, walls
from vibecalc.core.study.search.problem import (
    FEASIBLE_WITHIN,
    Ahead,
    Box,
    BudgetSpent,
    ErrorsAt,
    Evaluate,
    LocalOptimum,
    Optimum,
    Sampler,
    Search,
    spread,
)
from vibecalc.core.study.search.refine import by_newton, refine
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# From the ends of all searches to one optimum, known to its last digits.
# ----------------------------------------------------------------------------

#: end points closer than this on the unit cube are one optimum
SAME = 1e-3
#: objectives this close, in scaled units, are equal: of ends of searches, of searches for a zero,
#: which stop early, and of refined optima
EQUAL, EQUAL_ZERO, EQUAL_REFINED = 1e-6, 1e-3, 1e-9
#: end points whose objectives are this close, in scaled units, compete for the last digits
RIVALS = 1e-2
#: and those this close to a refined optimum that is lower have stopped short of it
SHORT_OF = 3e-2
#: ends that are refined, and of equally low ones how many before any other
MOST_REFINED, MOST_LEVEL = 6, 3
#: places between two ends, spaced so that no even wave passes through all of them
_BETWEEN = (0.137, 0.381, 0.529, 0.734)


@dataclass
class _End:
    """A point of the cube where so many searches ended, refined or as it was."""

    at: Refined
    count: int = 1


class _Choice:
    """The optimum of all searches of a sampler, and of equally low ones that nearest to a point."""

    def __init__(self, sampler: Sampler, begin: np.ndarray):
        self.sampler, self.begin = sampler, begin

    def rank(self, end: _End) -> tuple[float, ...]:
        """Distance from the first start, then the place itself, to six digits."""
        away = float(np.linalg.norm(self.sampler.box.apart(self.begin, end.at.unit)))
        return (round(away, 6), *np.round(end.at.unit, 6))

    def of(self, searches: list[Search]) -> tuple[Refined, list[_End]]:
        """The lowest of the optima that the ends are refined to, and all of these, lowest first.

        What is not refined to an optimum is none. Raises NumericalFailure where all are not.
        """
        sampler = self.sampler
        ends = self._joined([_End(_at_rest(sampler, one.end)) for one in searches if one.feasible])
        lowest = ends[0].at.objective
        equal = EQUAL_ZERO if sampler.smallest >= 0 and lowest < EQUAL_ZERO else EQUAL
        level = sorted((one for one in ends if one.at.objective <= lowest + equal), key=self.rank)
        optima: list[_End] = []
        for end in level[:MOST_LEVEL] + ends[len(level) :] + level[MOST_LEVEL:]:
            self._refine(end, optima, end.at.objective <= lowest + RIVALS)
            if len(optima) == MOST_REFINED:
                break
        if not optima:
            raise NumericalFailure(
                "no search ended in a point that can be shown to be an optimum; the lowest end is "
                f"at {sampler.box.values(ends[0].at.unit).tolist()} with the objective "
                f"{lowest * sampler.scale:.9g}. Ask for more starts or narrow the bounds."
            )
        least = min(one.at.objective + one.at.excess for one in optima)
        low = [one for one in optima if one.at.objective - one.at.excess <= least]
        return min(low, key=self.rank).at, self._joined(optima)

    def _refine(self, end: _End, optima: list[_End], rival: bool) -> None:
        """Add the optimum that an end leads to; one that stopped short of another counts there.

        Only a rival of the lowest is searched further, and may be one of many that are as good. Of
        others an optimum is one for certain: no direction is free, no bound holds without a pull. A
        weight of zero has an angle that is free: at another it may have to grow.
        """
        unit, objective = end.at.unit, end.at.objective
        for done in optima:
            apart = np.max(np.abs(self.sampler.box.apart(done.at.unit, unit)), initial=0.0)
            if apart < SHORT_OF and done.at.objective <= objective:
                done.count += end.count
                return
        if rival:
            below = min((one.at.objective for one in optima), default=np.inf)
            refined = refine(self.sampler, unit, below)
        else:
            refined = by_newton(self.sampler, unit)
        if refined is not None:
            pulls = np.abs(refined.bounds[refined.sides != 0])
            if rival or (refined.free_directions == 0 and np.all(pulls > BALANCED)):
                optima.append(_End(refined, end.count))

    def _joined(self, ends: list[_End]) -> list[_End]:
        """Ends that are one, the lowest first: near, or as good with all between them as good.

        A weight of zero has no angle: searches that end there with different angles found the same
        thing. Of equally low ones the one nearest to the first start stands for all.
        """
        joined: list[list[_End]] = []
        for end in sorted(ends, key=lambda one: (one.at.objective, *one.at.unit)):
            group = next((one for one in joined if self._one(one[0].at, end.at)), None)
            if group is None:
                joined.append([end])
            else:
                group.append(end)
        found = []
        for group in joined:
            most = group[0].at.objective + EQUAL_REFINED
            first = min((one for one in group if one.at.objective <= most), key=self.rank)
            found.append(_End(first.at, sum(one.count for one in group)))
        return found

    def _one(self, one: Refined, other: Refined) -> bool:
        sampler = self.sampler
        way = sampler.box.apart(one.unit, other.unit)
        if np.max(np.abs(way), initial=0.0) < SAME:
            return True
        if abs(one.objective - other.objective) > EQUAL_REFINED:
            return False
        with suppress(BudgetSpent):
            between = [one.unit + share * way for share in _BETWEEN]
            return all(
                abs(sampler.top(unit) - one.objective) <= EQUAL_REFINED
                and sampler.violation(unit) <= FEASIBLE_WITHIN
                for unit in between
            )
        return False


def _at_rest(sampler: Sampler, unit: np.ndarray, method: str = "") -> Refined:
    """A point that is not refined: an end, all variables held, or the same value everywhere."""
    top, nothing = sampler.top(unit), np.zeros(unit.size)
    return Refined(
        unit=unit,
        error=nothing + sampler.violation(unit),
        # the scale is the largest change seen, rounded to a power of two
        excess=2.0 if method == "flat" else EPSILON * abs(top),
        objective=top,
        margins=np.zeros(sum(sampler.entries or [])),
        bounds=nothing,
        sides=walls(sampler.box, unit),
        free_directions=unit.size,
        method=method,
    )


def _only_point(sampler: Sampler, held: str) -> list[Search]:
    """The one search where all variables are `held`, as these words say: one evaluation.

    Raises NumericalFailure where it cannot be evaluated, Infeasible where it breaks a limit.
    """
    nowhere = np.empty(0)
    if sampler(nowhere) is None:
        raise NumericalFailure(f"{held}cannot be evaluated: {sampler.failure(nowhere)}")
    if sampler.violation(nowhere) > 0.0:
        raise sampler.infeasible(nowhere, f"{held}breaks a limit: {{worst}}")
    return [Search(nowhere, nowhere, sampler.top(nowhere), 0.0, "all variables are held", 1)]


# ----------------------------------------------------------------------------
# From the unit cube back to variables, units and words.
# ----------------------------------------------------------------------------


def _summary(
    sampler: Sampler, searches: list[Search], best: Refined, optima: list[_End], rtol: float
) -> Optimum:
    """Put what was found into the units of the caller; `rtol` as in `minimise`."""
    scale, box = sampler.scale, sampler.box
    vector = sampler(best.unit)
    assert vector is not None
    optimum, nothing = box.values(best.unit), np.zeros(box.lower.size)
    inner = box.slope(optimum)
    objective = best.objective * scale
    error = best.excess * scale + 2 * EPSILON * abs(objective)
    rounding = np.where(best.sides == 0, 2 * EPSILON, 0.0) * np.abs(optimum[box.moving])
    prices = sampler.of_limits(best.margins, np.sum)
    return Optimum(
        variables=optimum,
        variables_error=box.whole(
            np.minimum(inner * best.error + rounding, box.farthest(optimum)), nothing
        ),
        objective=objective,
        objective_error=error,
        margins=sampler.of_limits(vector[sampler.parts :], np.min),
        active_margins=tuple(np.flatnonzero(prices).tolist()),
        margin_multipliers=prices * scale,
        active_bounds=box.whole(best.sides, np.zeros(box.lower.size, dtype=int)),
        bound_multipliers=box.whole(best.bounds * scale / inner, nothing),
        kkt_residual=best.residual,
        free_directions=best.free_directions,
        method=best.method,
        evaluations=sampler.count,
        failures=len(sampler.failures),
        failure_messages=tuple(dict.fromkeys(sampler.failures.values())),
        history=tuple(
            end._replace(
                start=box.values(end.start),
                end=box.values(end.end),
                objective=end.objective * scale,
            )
            for end in searches
        ),
        optima=tuple(
            LocalOptimum(box.values(one.at.unit), one.at.objective * scale, one.count)
            for one in optima
        ),
        notes=tuple(sampler.notes)
        + _notes(best.free_directions, box.size, error, rtol * max(abs(objective), scale)),
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
        `evaluate(variables (n,)) -> (objective, margins (m,))`. The objective is a number, or
        those of its parts (p,) of which the largest counts. A margin, made dimensionless by its
        limit, is kept where it is >= 0; it is a number, or those of all entries of the limit. The
        largest of smooth parts has kinks, so that parts and entries are better given each. A point
        that raises NumericalFailure or gives NaN or an infinity is counted and the search goes
        around it. Values have to be repeatable.
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
    box = Box(lower, upper, period)
    sampler = Sampler(evaluate, box, budget, ahead, errors)
    count = box.lower.size
    further = spread(starts, count)[:, box.moving] if isinstance(starts, int) else box.unit(starts)
    points = np.vstack([_begin(box, first), further])
    chosen = METHODS[method]
    searcher = local_search if method == "sequential_quadratic" else chosen.search
    try:
        if box.size == 0:
            held = "all variables are held by equal bounds, and that point "
            searches = _only_point(sampler, held if count else "what is picked ")
        else:
            most = 1 if chosen.everywhere else len(points)
            searches = search_all(sampler, points, searcher, most)
        if box.size == 0 or sampler.flat:
            kept = [one for one in searches if one.feasible]
            best = _at_rest(sampler, kept[0].end, "flat" if box.size else "fixed")
            optima = [_End(best, len(kept))]
        else:
            best, optima = _Choice(sampler, points[0]).of(searches)
    except BudgetSpent:
        raise NumericalFailure(
            f"the search had spent its {budget} evaluations before an optimum was pinned down; "
            f"{sampler.lowest_feasible()}. Allow more evaluations or ask for fewer starts."
        ) from None
    return _summary(sampler, searches, best, optima, rtol)


#: evaluations kept back for the residual at the end, for each variable
_RESERVE = 40


def find(
    name: str,
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    first: ArrayLike | None = None,
    budget: int = 20000,
    period: ArrayLike = 0.0,
    ahead: Ahead | None = None,
) -> Optimum:
    """Search with one method of `METHODS` from one start, and take its end as it is.

    Parameters
    ----------
    name : str
        Key of `METHODS`.
    evaluate, lower, upper, first, period, ahead
        As of `minimise`; lower < upper.
    budget : int
        Most evaluations; a method that spends them gives its best point and has not converged.

    Returns
    -------
    end : Optimum
        The end and the `history` of its one search. Nothing is refined: `kkt_residual` is how far
        it is from a stationary point (`stationarity`), which takes no part in the evaluations.

    Raises
    ------
    NumericalFailure
        If the start cannot be evaluated.
    """
    box = Box(lower, upper, period)
    sampler, start = Sampler(evaluate, box, budget, ahead), _begin(box, first)
    set_scale(sampler, start[None, :])
    if sampler(start) is None:
        raise NumericalFailure(
            f"the start of the search cannot be evaluated: {sampler.failure(start)}"
        )
    try:
        unit, reason = METHODS[name].search(sampler, start)
    except BudgetSpent:
        unit, reason = sampler.best, f"spent its {budget} evaluations"
    top, broken = sampler.top(unit), sampler.violation(unit)
    end = Search(start, unit, top, broken, reason, sampler.count)
    found = _summary(sampler, [end], _at_rest(sampler, unit), [], np.inf)
    sampler.budget += _RESERVE * (box.size + 1)
    residual = np.inf
    with suppress(BudgetSpent):
        residual = stationarity(sampler, unit)
    return replace(found, kkt_residual=residual)


def _begin(box: Box, first: ArrayLike | None) -> np.ndarray:
    """The first start on the cube, its middle where none is given."""
    return np.full(box.size, 0.5) if first is None else box.unit(np.asarray(first, dtype=float))
