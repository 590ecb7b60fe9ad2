"""Minimise a function of bounded variables while margins are kept, from many starts."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.local_search import search_all
from vibecalc.core.study.search.newton import BALANCED, Refined, walls
from vibecalc.core.study.search.problem import (
    FEASIBLE_WITHIN,
    LocalOptimum,
    Optimum,
    Problem,
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


class _Choice:
    """The optimum of all searches of a sampler, and of equally low ones that nearest to a point."""

    def __init__(self, sampler: Sampler, begin: np.ndarray):
        self.sampler, self.begin = sampler, begin

    def rank(self, end: Refined) -> tuple[float, ...]:
        """Distance from the first start, then the place itself, to six digits."""
        away = float(np.linalg.norm(self.sampler.box.apart(self.begin, end.unit)))
        return (round(away, 6), *np.round(end.unit, 6))

    def of(self, searches: list[Search]) -> tuple[Refined, list[Refined]]:
        """The lowest of the optima that the ends are refined to, and all of these, lowest first.

        What is not refined to an optimum is none. Raises NumericalFailure where all are not.
        """
        sampler = self.sampler
        ends = self._joined([_at_rest(sampler, one.end) for one in searches if one.feasible])
        lowest = ends[0].objective
        equal = EQUAL_ZERO if sampler.smallest >= 0 and lowest < EQUAL_ZERO else EQUAL
        level = sorted((one for one in ends if one.objective <= lowest + equal), key=self.rank)
        optima: list[Refined] = []
        for end in level[:MOST_LEVEL] + ends[len(level) :] + level[MOST_LEVEL:]:
            self._refine(end, optima, end.objective <= lowest + RIVALS)
            if len(optima) == MOST_REFINED:
                break
        if not optima:
            raise NumericalFailure(
                "no search ended in a point that can be shown to be an optimum; the lowest end is "
                f"at {sampler.box.values(ends[0].unit).tolist()} with the objective "
                f"{lowest * sampler.scale:.9g}. Ask for more starts or narrow the bounds."
            )
        least = min(one.objective + one.excess for one in optima)
        low = [one for one in optima if one.objective - one.excess <= least]
        return min(low, key=self.rank), self._joined(optima)

    def _refine(self, end: Refined, optima: list[Refined], rival: bool) -> None:
        """Add the optimum that an end leads to; one that stopped short of another counts there.

        Only a rival of the lowest is searched further, and may be one of many that are as good. Of
        others an optimum is one for certain: no direction is free, no bound holds without a pull. A
        weight of zero has an angle that is free: at another it may have to grow.
        """
        for place, done in enumerate(optima):
            apart = np.max(np.abs(self.sampler.box.apart(done.unit, end.unit)), initial=0.0)
            if apart < SHORT_OF and done.objective <= end.objective:
                optima[place] = done._replace(count=done.count + end.count)
                return
        below = min((one.objective for one in optima), default=np.inf)
        how = refine(self.sampler, end.unit, below) if rival else by_newton(self.sampler, end.unit)
        if how is not None:
            certain = how.free_directions == 0 and np.all(
                np.abs(how.bounds[how.sides != 0]) > BALANCED
            )
            if rival or certain:
                optima.append(how._replace(count=end.count))

    def _joined(self, ends: list[Refined]) -> list[Refined]:
        """Ends that are one, the lowest first: near, or as good with all between them as good.

        A weight of zero has no angle: searches that end there with different angles found the same
        thing. Of equally low ones the one nearest to the first start stands for all.
        """
        joined: list[list[Refined]] = []
        for end in sorted(ends, key=lambda one: (one.objective, *one.unit)):
            group = next((one for one in joined if self._one(one[0], end)), None)
            if group is None:
                joined.append([end])
            else:
                group.append(end)
        found = []
        for group in joined:
            most = group[0].objective + EQUAL_REFINED
            first = min((one for one in group if one.objective <= most), key=self.rank)
            found.append(first._replace(count=sum(one.count for one in group)))
        return found

    def _one(self, one: Refined, other: Refined) -> bool:
        sampler = self.sampler
        way = sampler.box.apart(one.unit, other.unit)
        if np.max(np.abs(way), initial=0.0) < SAME:
            return True
        if abs(one.objective - other.objective) > EQUAL_REFINED:
            return False
        return all(
            abs(sampler.top(unit) - one.objective) <= EQUAL_REFINED
            and sampler.violation(unit) <= FEASIBLE_WITHIN
            for unit in (one.unit + share * way for share in _BETWEEN)
        )


def _at_rest(sampler: Sampler, unit: np.ndarray, method: str = "", off: float = 0.0) -> Refined:
    """A point that is not refined: an end, all variables held, or the same value everywhere."""
    top, nothing = sampler.top(unit), np.zeros(unit.size)
    return Refined(
        unit=unit,
        error=nothing + sampler.violation(unit),
        excess=off + EPSILON * abs(top),
        objective=top,
        margins=np.zeros(sum(sampler.entries)),
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
    return [Search(nowhere, nowhere, sampler.top(nowhere), 0.0, 1)]


# ----------------------------------------------------------------------------
# From the unit cube back to variables, units and words.
# ----------------------------------------------------------------------------


def _summary(
    sampler: Sampler, searches: list[Search], best: Refined, optima: list[Refined], rtol: float
) -> Optimum:
    """Put what was found into the units of the caller; `rtol` as in `minimise`."""
    scale, box = sampler.scale, sampler.box
    vector = sampler(best.unit)
    assert vector is not None
    optimum, nothing = box.values(best.unit), np.zeros(box.lower.size)
    objective = best.objective * scale
    error = best.excess * scale + 2 * EPSILON * abs(objective)
    rounding = np.where(best.sides == 0, 2 * EPSILON, 0.0) * np.abs(optimum[box.moving])
    off = np.minimum(box.slope(optimum) * best.error + rounding, box.farthest(optimum))
    notes, free = list(sampler.notes), best.free_directions
    if free and free == box.size:
        notes.append("the objective does not change with the variables here")
    elif free:
        notes.append(
            f"equally good optima form a continuum with {free} free direction"
            f"{'s' if free > 1 else ''}; one of them is given"
        )
    tolerance = rtol * max(abs(objective), scale)
    if error > tolerance:
        notes.append(f"the objective is known to {error:.2g} only, {tolerance:.2g} was asked for")
    return Optimum(
        variables=optimum,
        variables_error=box.whole(off, nothing),
        objective=objective,
        objective_error=error,
        margins=sampler.of_limits(vector[sampler.parts :], np.min),
        margin_multipliers=sampler.of_limits(best.margins, np.sum) * scale,
        active_bounds=box.whole(best.sides, np.zeros(box.lower.size, dtype=int)),
        kkt_residual=best.residual,
        free_directions=free,
        method=best.method,
        evaluations=sampler.count,
        failures=len(sampler.failures),
        failure_messages=tuple(dict.fromkeys(sampler.failures.values())),
        history=tuple(
            one._replace(
                start=box.values(one.start),
                end=box.values(one.end),
                objective=one.objective * scale,
            )
            for one in searches
        ),
        optima=tuple(
            LocalOptimum(box.values(one.unit), one.objective * scale, one.count) for one in optima
        ),
        notes=tuple(notes),
    )


# ----------------------------------------------------------------------------
# Minimise a function of bounded variables while margins are kept, from many starts.
# ----------------------------------------------------------------------------


def minimise(
    problem: Problem, starts: int = 8, *, further: ArrayLike | None = None, rtol: float = 1e-9
) -> Optimum:
    """Find the smallest objective within bounds whose margins are all at least zero.

    Parameters
    ----------
    problem : Problem
    starts : int
        How many starts of a fixed low-discrepancy sequence, besides the first.
    further : (k, n) array, optional
        Starts before these.
    rtol : float
        Error of the objective, relative to its magnitude or to its change over the bounds, above
        which a note says so.

    Returns
    -------
    optimum : Optimum
        An error of a variable is what errors of the values may move the optimum by in its
        direction, at most to the farther of its bounds.

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
    sampler = Sampler(problem)
    box, first = sampler.box, problem.first
    count = box.lower.size
    # the first start is the middle of the cube where none is given
    begin = np.full(box.size, 0.5) if first is None else box.unit(np.asarray(first, dtype=float))
    given = np.empty((0, box.size)) if further is None else box.unit(np.asarray(further, float))
    points = np.vstack([begin, given, spread(starts, count)[:, box.moving]])
    if box.size == 0:
        held = "all variables are held by equal bounds, and that point " if count else ""
        searches = _only_point(sampler, held or "what is picked ")
    else:
        searches = search_all(sampler, points)
    if box.size == 0 or sampler.flat:
        kept = [one for one in searches if one.feasible]
        # of a flat one the scale is the largest change seen, rounded to a power of two
        off = (2.0 if box.size else 0.0) + float(np.max(sampler.bias(kept[0].end)[: sampler.parts]))
        best = _at_rest(sampler, kept[0].end, "flat" if box.size else "fixed", off)
        optima = [best._replace(count=len(kept))]
    else:
        best, optima = _Choice(sampler, points[0]).of(searches)
    return _summary(sampler, searches, best, optima, rtol)
