"""Minimise a function of bounded variables while margins are kept, from many starts."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.local_search import search_all
from vibecalc.core.study.search.newton import Refined, walls
from vibecalc.core.study.search.problem import (
    FEASIBLE_WITHIN,
    LocalOptimum,
    Optimum,
    Problem,
    Sampler,
    Search,
    spread,
)
from vibecalc.core.study.search.refine import refine
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
#: ends whose objectives are this close, in scaled units, to the lowest may be one of many as good
RIVALS = 1e-2
#: end points this close to a refined optimum that is lower have stopped short of it
SHORT_OF = 3e-2
#: ends that are refined, and of equally low ones how many before any other
MOST_REFINED, MOST_LEVEL = 6, 3
#: places between two ends, spaced so that no even wave passes through all of them
_BETWEEN = (0.137, 0.381, 0.529, 0.734)


def _optima(
    sampler: Sampler, begin: np.ndarray, searches: list[Search]
) -> tuple[Refined, list[Refined]]:
    """The lowest of the optima that the ends are refined to, and all of these, lowest first.

    Of equally low ones it is that nearest to the first start, `begin` (k,). What is not refined to
    an optimum is none. Raises NumericalFailure where all are not.
    """

    def rank(end: Refined) -> tuple[float, ...]:
        """Distance from the first start, then the place itself, to six digits."""
        away = float(np.linalg.norm(sampler.box.apart(begin, end.unit)))
        return (round(away, 6), *np.round(end.unit, 6))

    ends = [_at_rest(sampler, one.end) for one in searches if one.feasible]
    lowest = min(one.objective for one in ends)
    equal = EQUAL_ZERO if sampler.smallest >= 0 and lowest < EQUAL_ZERO else EQUAL
    level = sorted((one for one in ends if one.objective <= lowest + equal), key=rank)
    others = sorted(
        (one for one in ends if one.objective > lowest + equal),
        key=lambda one: (one.objective, *one.unit),
    )
    found: list[Refined] = []  # optima, and ends that lead to none
    for end in level[:MOST_LEVEL] + others + level[MOST_LEVEL:]:
        optima = [one for one in found if one.method]
        home = _home(sampler, found, end)
        if home is None and len(optima) < MOST_REFINED:
            below = min((one.objective for one in optima), default=np.inf)
            refined = refine(sampler, end.unit, below)
            # a weight of zero has an angle that is free: at another it may have to grow
            rival = end.objective <= lowest + RIVALS
            if refined is not None and (rival or not refined.free_directions):
                end = refined
            home = _home(sampler, found, end)
            if home is None:
                home = len(found)
                found.append(end)
        if home is not None:
            same = found[home]
            nearer = end.method and abs(end.objective - same.objective) <= EQUAL_REFINED
            same = min(same, end, key=rank) if nearer else same
            found[home] = same._replace(found_by=found[home].found_by + 1)
    optima = sorted((one for one in found if one.method), key=lambda one: one.objective)
    if not optima:
        at = sampler.box.values(min(ends, key=lambda one: one.objective).unit)
        raise NumericalFailure(
            "no search ended in a point that can be shown to be an optimum; the lowest end is "
            f"at {at.tolist()} with the objective {lowest * sampler.scale:.9g}. "
            "Ask for more starts or narrow the bounds."
        )
    least = min(one.objective + one.excess for one in optima)
    return min((one for one in optima if one.objective - one.excess <= least), key=rank), optima


def _home(sampler: Sampler, found: list[Refined], end: Refined) -> int | None:
    """The one of those found that an end is: near, as good with all between as good, or short of.

    A weight of zero has no angle: searches that end there with different angles found the same
    thing.
    """
    for place, one in enumerate(found):
        way = sampler.box.apart(one.unit, end.unit)
        far = float(np.max(np.abs(way), initial=0.0))
        short = one.method and not end.method and one.objective <= end.objective
        if far < SAME or (short and far < SHORT_OF):
            return place
        if abs(one.objective - end.objective) <= EQUAL_REFINED and all(
            abs(sampler.top(unit) - one.objective) <= EQUAL_REFINED
            and sampler.violation(unit) <= FEASIBLE_WITHIN
            for unit in (one.unit + share * way for share in _BETWEEN)
        ):
            return place
    return None


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
            LocalOptimum(box.values(one.unit), one.objective * scale, one.found_by)
            for one in optima
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
        optima = [best._replace(found_by=len(kept))]
    else:
        best, optima = _optima(sampler, points[0], searches)
    return _summary(sampler, searches, best, optima, rtol)
