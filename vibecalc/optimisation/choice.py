"""From the ends of all searches to one optimum, known to its last digits."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.optimisation.degenerate import groups
from vibecalc.optimisation.local_search import VANISHING
from vibecalc.optimisation.optimum import Infeasible
from vibecalc.optimisation.refine import Refined, keeps, refine
from vibecalc.optimisation.sampler import Sampler
from vibecalc.optimisation.search import NEARLY_KEPT, End, Ends
from vibecalc.optimisation.variables import Box

#: end points closer than this on the unit cube are one optimum
SAME = 1e-3
#: end points whose objectives are this close, in scaled units, compete for the last digits
RIVALS = 1e-2
#: and those this close to a refined optimum that is lower have stopped short of it
SHORT_OF = 3e-2
MOST_RIVALS = 4


class Distinct(NamedTuple):
    """An end point apart from all others, and how many searches ended there."""

    unit: np.ndarray
    objective: float
    found_by: int


class Choice(NamedTuple):
    """The optimum, refined, and all distinct ends that keep the limits, lowest first."""

    best: Refined
    distinct: tuple[Distinct, ...]


def choose(sampler: Sampler, ends: list[End], begin: np.ndarray, accuracy: float) -> Choice:
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

    def rank(one: Distinct) -> tuple[float, ...]:
        away = round(float(np.linalg.norm(sampler.box.apart(begin, one.unit))), 6)
        return (away, *np.round(one.unit, 6))

    level = sorted((one for one in distinct if one.objective <= lowest + equal), key=rank)
    rivals = [one for one in distinct if lowest + equal < one.objective <= lowest + RIVALS]
    half = MOST_RIVALS // 2
    refined: list[Refined] = []
    final = {id(one): one for one in distinct}
    for one in level[:half] + rivals[:half] + level[half:] + rivals[half:]:
        if len(refined) == MOST_RIVALS:
            break
        if any(_covers(sampler.box, done, one) for done in refined):
            continue
        below = min((done.objective for done in refined), default=np.inf)
        found = refine(sampler, one.unit, accuracy, below)
        if found is not None and keeps(sampler, found.unit):
            found = found._replace(unit=sampler.box.fold(found.unit))
            refined.append(found)
            final[id(one)] = one._replace(unit=found.unit, objective=found.objective)
    if not refined:
        raise NumericalFailure(
            "no search ended in a point that can be shown to be an optimum; the lowest end is at "
            f"{sampler.box.values(distinct[0].unit).tolist()} with the objective "
            f"{lowest * sampler.scale:.9g}. Ask for more starts or narrow the bounds."
        )
    least = min(one.objective + one.rise for one in refined)
    lowest_ones = [one for one in refined if one.objective - one.rise <= least]
    best = min(lowest_ones, key=lambda one: rank(Distinct(one.unit, one.objective, 1)))
    ordered = sorted(final.values(), key=lambda one: (one.objective, *one.unit))
    joined = [
        group[0]._replace(found_by=sum(one.found_by for one in group))
        for group in groups(sampler, ordered)
    ]
    return Choice(best, tuple(joined))


def anywhere(sampler: Sampler, ends: list[End]) -> Choice:
    """The choice where the objective is the same everywhere: the first end that keeps all limits.

    It counts as the same where its change is below `search.UNRESOLVED` of its magnitude.
    """
    distinct = _distinct(sampler.box, ends)
    end = next(end for end in ends if end.violation <= NEARLY_KEPT)
    vector = sampler(end.unit)
    assert vector is not None
    margins = np.maximum(0.0, -vector[sampler.entries :])
    best = Refined(
        unit=end.unit,
        error=np.full(end.unit.size, float(np.max(margins, initial=0.0))),
        rise=2.0,  # the scale is the largest change seen, rounded to a power of two
        objective=end.objective,
        margins=np.zeros(margins.size),
        bounds=np.zeros(end.unit.size),
        sides=np.where(end.unit <= 0, -1, np.where(end.unit >= 1, 1, 0)),
        active_margins=(),
        active_entries=tuple(range(sampler.entries)),
        residual=0.0,
        free_directions=end.unit.size,
        method="flat",
    )
    return Choice(best, distinct)


def only_point(sampler: Sampler) -> tuple[Ends, Choice]:
    """The answer where all variables are held: one evaluation.

    Raises
    ------
    NumericalFailure
        If it cannot be evaluated or breaks a limit.
    """
    nowhere = np.empty(0)
    vector = sampler(nowhere)
    if vector is None:
        raise NumericalFailure(
            "all variables are held by equal bounds, and that point cannot be evaluated: "
            f"{next(iter(sampler.failures.values()))}"
        )
    margins = vector[sampler.entries :]
    if np.any(margins < 0):
        raise Infeasible(
            "all variables are held by equal bounds, and that point breaks a limit: margin "
            f"{int(np.argmin(margins))} is {float(np.min(margins)):.6g}",
            nowhere,
            sampler.count,
        )
    objective = float(np.max(vector[: sampler.entries]))
    floor = EPSILON * abs(objective)
    best = Refined(
        unit=nowhere,
        error=nowhere,
        rise=floor,
        objective=objective,
        margins=np.zeros(margins.size),
        bounds=nowhere,
        sides=np.empty(0, dtype=int),
        active_margins=(),
        active_entries=(int(np.argmax(vector[: sampler.entries])),),
        residual=0.0,
        free_directions=0,
        method="fixed",
    )
    end = End(nowhere, nowhere, objective, 0.0, "all variables are held", 1)
    return Ends([end], ()), Choice(best, (Distinct(nowhere, objective, 1),))


def _distinct(box: Box, ends: list[End]) -> tuple[Distinct, ...]:
    kept = [end for end in ends if end.violation <= NEARLY_KEPT]
    found: list[Distinct] = []
    for end in sorted(kept, key=lambda end: (end.objective, *end.unit)):
        for index, one in enumerate(found):
            if np.max(np.abs(box.apart(one.unit, end.unit)), initial=0.0) < SAME:
                found[index] = one._replace(found_by=one.found_by + 1)
                break
        else:
            found.append(Distinct(end.unit, end.objective, 1))
    return tuple(found)


def _covers(box: Box, done: Refined, end: Distinct) -> bool:
    """Whether an end is nearby and no lower: a search that stopped short of the same optimum."""
    near = np.max(np.abs(box.apart(done.unit, end.unit)), initial=0.0) < SHORT_OF
    return bool(near) and done.objective <= end.objective
