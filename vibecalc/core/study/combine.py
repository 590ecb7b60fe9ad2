"""The best combination of what is picked, with the variables between bounds at their best in each.

Where there are few combinations all are examined, which proves the best one to be the best as far
as each search does. Where there are many, differential evolution looks for a good one, and all
combinations next to it are examined until none is better: that proves no more than this.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.core.study.choices import (
    MOST_RUNS,
    Choice,
    combinations,
    examines_all,
    in_words,
    runs_of_one,
)
from vibecalc.core.study.search.methods import differential_evolution
from vibecalc.core.study.search.problem import Box, Evaluate, Infeasible, Optimum, Sampler
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding
    from vibecalc.schema import Case

Picked = tuple[int, ...]
#: binding of a combination, and further starts -> its optimum
Search = Callable[["Binding", np.ndarray], Optimum]

#: combinations kept in a result, best first
MOST_KEPT = 200
#: population of differential evolution for each choice and variable
_POPULATION = 10


class Examined(NamedTuple):
    """One combination: its optimum, or why it has none; `violation` of the nearest point."""

    picked: Picked
    optimum: Optimum | None
    objective: float
    violation: float
    evaluations: int
    why: str
    nearest: Infeasible | None = None


@dataclass
class Combined:
    """All combinations examined, the best with its binding and optimum (None: none keeps limits).

    `proven` is True where no combination was left out and all could be searched.
    """

    choices: tuple[Choice, ...]
    possible: int
    examined: list[Examined] = field(default_factory=list)
    further_runs: int = 0

    @property
    def ranked(self) -> list[Examined]:
        """Best first; those that keep no limits after all that do, and those without a result."""
        return sorted(self.examined, key=lambda one: (bool(one.why), one.violation, one.objective))

    @property
    def best(self) -> Examined:
        """The best combination."""
        return self.ranked[0]

    @property
    def evaluations(self) -> int:
        """Points evaluated in all."""
        return sum(one.evaluations for one in self.examined) + self.further_runs

    @property
    def notes(self) -> tuple[str, ...]:
        """What is not shown: combinations left out, and those that could not be searched."""
        notes = []
        if len(self.examined) < self.possible:
            notes.append(
                f"{len(self.examined)} of {self.possible} combinations were examined: no "
                "combination that differs from the one found in a single choice, by one step where "
                "they are numbers, is better; that none of the others is better is not shown"
            )
        lost = [one for one in self.examined if one.why and one.optimum is None]
        if lost:
            words = "; ".join(
                f"{in_words(self.choices, one.picked)}: {one.why}" for one in lost[:3]
            )
            more = f"; and {len(lost) - 3} more" if len(lost) > 3 else ""
            notes.append(
                f"{len(lost)} of the combinations examined have no optimum, so that the best is "
                f"that of the others: {words}{more}"
            )
        return tuple(notes)


def combine(
    binding: "Binding", case: "Case", search: Search, evaluate: Callable[["Binding"], Evaluate]
) -> Combined:
    """Examine combinations until the best is known.

    `search` brings the optimum of one combination, from further starts (k, n) or as the case has
    it; `evaluate` gives the function of a binding that is shown as it runs.
    """
    study = case.optimisation
    assert study is not None
    found = Combined(binding.choices, combinations(binding.choices))
    if examines_all(study, binding.choices):
        warm = np.empty((0, binding.lower.size))
        for picked in product(*(range(len(choice.options)) for choice in binding.choices)):
            one = _examined(binding, picked, search, warm)
            found.examined.append(one)
            if found.best.optimum is not None:
                warm = found.best.optimum.variables[None, :]
        return found
    first, point, found.further_runs = _evolved(binding, runs_of_one(study), evaluate)
    known = {first: _examined(binding, first, search, point[None, :])}
    while True:
        found.examined = list(known.values())
        best = found.best
        place = point if best.optimum is None else best.optimum.variables
        fresh = [one for one in _next_to(binding.choices, best.picked) if one not in known]
        if not fresh or found.evaluations > MOST_RUNS:
            break
        for near in fresh:
            known[near] = _examined(binding, near, search, place[None, :])
    return found


def _examined(binding: "Binding", picked: Picked, search: Search, warm: np.ndarray) -> Examined:
    try:
        optimum = search(binding.with_picked(picked), warm)
    except Infeasible as nearest:
        return Examined(picked, None, np.inf, nearest.violation, nearest.evaluations, "", nearest)
    except NumericalFailure as failure:
        return Examined(picked, None, np.inf, np.inf, 1, str(failure))
    return Examined(picked, optimum, optimum.objective, 0.0, optimum.evaluations, "")


def _next_to(choices: tuple[Choice, ...], picked: Picked) -> Iterator[Picked]:
    """Combinations that differ in one choice: by a step where its options are in order."""
    for place, choice in enumerate(choices):
        here = picked[place]
        others = (here - 1, here + 1) if choice.ordered else range(len(choice.options))
        for other in others:
            if other != here and 0 <= other < len(choice.options):
                yield (*picked[:place], other, *picked[place + 1 :])


def _evolved(
    binding: "Binding", each: int, evaluate: Callable[["Binding"], Evaluate]
) -> tuple[Picked, np.ndarray, int]:
    """A good combination, its variables, and the points evaluated.

    R. Storn and K. Price, J. Global Optim. 11 (1997), 341-359, with whole numbers, as in scipy.
    """
    choices, count = binding.choices, len(binding.choices)
    most = [len(choice.options) - 1.0 for choice in choices]
    box = Box(
        np.append(np.zeros(count), binding.lower),
        np.append(most, binding.upper),
        np.append(np.zeros(count), binding.period),
    )

    def picked(place: np.ndarray) -> Picked:
        return tuple(round(float(one)) for one in place[:count])

    sampler = Sampler(
        lambda place: evaluate(binding.with_picked(picked(place)))(place[count:]), box
    )
    unit, _ = differential_evolution(
        sampler,
        None,
        int(np.sum(box.moving[:count])),
        popsize=_POPULATION,
        maxiter=max(10, max(MOST_RUNS // 2, each) // (_POPULATION * box.size) - 1),
        tol=1e-6,
        atol=0.0,
    )
    if sampler(unit) is None:
        raise NumericalFailure("no combination that was tried can be evaluated")
    place = box.values(unit)
    return picked(place), place[count:], sampler.count


def of_all(found: Combined) -> Optimum:
    """The optimum of the best combination, with what all of them took.

    Raises Infeasible where none keeps the limits, NumericalFailure where none has an optimum.
    """
    best = found.best
    if best.nearest is not None:
        best.nearest.evaluations = found.evaluations
        raise best.nearest
    if best.optimum is None:
        raise NumericalFailure(
            f"no combination has an optimum; {in_words(found.choices, best.picked)}: {best.why}"
        )
    notes = (*best.optimum.notes, *found.notes)
    return replace(best.optimum, evaluations=found.evaluations, notes=notes)
