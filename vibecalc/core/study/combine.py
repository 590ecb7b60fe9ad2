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
from vibecalc.core.study.search.problem import AMPLE_MARGIN, Box, Infeasible, Optimum
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Optimisation
    from vibecalc.core.study.binding import Binding

Picked = tuple[int, ...]
#: binding of a combination, and further starts -> its optimum
Search = Callable[["Binding", np.ndarray], Optimum]

#: combinations kept in a result, best first
MOST_KEPT = 200
#: population of differential evolution for each choice and variable, and a seed that never changes
_POPULATION, _SEED = 10, 20000301


class Examined(NamedTuple):
    """One combination, and its optimum or why it has none."""

    picked: Picked
    end: Optimum | NumericalFailure

    @property
    def optimum(self) -> Optimum | None:
        """The optimum, if it keeps the limits."""
        return self.end if isinstance(self.end, Optimum) else None

    @property
    def evaluations(self) -> int:
        """Points evaluated for it."""
        return self.end.evaluations if isinstance(self.end, Optimum | Infeasible) else 1

    @property
    def rank(self) -> tuple[float, float]:
        """Those that keep no limits after all that do, and those without a result last."""
        if isinstance(self.end, Optimum):
            return 0.0, self.end.objective
        return (self.end.violation, np.inf) if isinstance(self.end, Infeasible) else (np.inf, 0.0)


@dataclass
class Combined:
    """All combinations examined, of how many are possible, and points evaluated besides."""

    choices: tuple[Choice, ...]
    possible: int
    examined: list[Examined] = field(default_factory=list)
    further_runs: int = 0

    @property
    def best(self) -> Examined:
        """The best combination."""
        return min(self.examined, key=lambda one: one.rank)

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
                f"{len(self.examined)} of {self.possible} combinations were examined: none that "
                "differs in a single choice, by one step where they are numbers, is better; "
                "that none of the others is better is not shown"
            )
        lost = [one for one in self.examined if np.isinf(one.rank[0])]
        if lost:
            words = [f"{in_words(self.choices, one.picked)}: {one.end}" for one in lost[:3]]
            words += [f"and {len(lost) - 3} more"] * (len(lost) > 3)
            notes.append(
                f"{len(lost)} of the combinations examined have no optimum and do not "
                f"compete: {'; '.join(words)}"
            )
        return tuple(notes)

    def optimum(self) -> Optimum:
        """The optimum of the best combination, with what all of them took.

        Raises Infeasible where none keeps the limits, NumericalFailure where none has an optimum.
        """
        picked, end = self.best
        if isinstance(end, Optimum):
            notes = (*end.notes, *self.notes)
            return replace(end, evaluations=self.evaluations, notes=notes)
        if isinstance(end, Infeasible):
            end.evaluations = self.evaluations
            raise end
        words = in_words(self.choices, picked)
        raise NumericalFailure(f"no combination has an optimum; {words}: {end}")


def combine(binding: "Binding", study: "Optimisation", search: Search) -> Combined:
    """Examine combinations until the best is known.

    `search` brings the optimum of one combination, from further starts (k, n) or as the case has
    it.
    """
    choices = binding.choices
    found = Combined(choices, combinations(choices))

    def examine(picked: Picked, warm: np.ndarray) -> None:
        end: Optimum | NumericalFailure
        try:
            end = search(binding.with_picked(picked), warm)
        except NumericalFailure as failure:
            end = failure
        found.examined.append(Examined(picked, end))

    if examines_all(study, choices):
        warm = np.empty((0, binding.lower.size))
        for picked in product(*(range(len(choice.options)) for choice in choices)):
            examine(picked, warm)
            if found.best.optimum is not None:
                warm = found.best.optimum.variables[None, :]
        return found
    first, point, found.further_runs = _evolved(binding, runs_of_one(study))
    fresh = [first]
    while fresh and found.evaluations <= MOST_RUNS:
        for near in fresh:
            examine(near, point[None, :])
        best, known = found.best, {one.picked for one in found.examined}
        point = point if best.optimum is None else best.optimum.variables
        fresh = [one for one in _next_to(choices, best.picked) if one not in known]
    return found


def _next_to(choices: tuple[Choice, ...], picked: Picked) -> Iterator[Picked]:
    """Combinations that differ in one choice: by a step where its options are in order."""
    for place, choice in enumerate(choices):
        here = picked[place]
        others = (here - 1, here + 1) if choice.ordered else range(len(choice.options))
        for other in others:
            if other != here and 0 <= other < len(choice.options):
                yield (*picked[:place], other, *picked[place + 1 :])


def _evolved(binding: "Binding", each: int) -> tuple[Picked, np.ndarray, int]:
    """A good combination, its variables, and the points evaluated.

    Points that break a limit lose against any that keep all of them, and among themselves by how
    far they break it. R. Storn and K. Price, J. Global Optim. 11 (1997), 341-359, with whole
    numbers, as in scipy.
    """
    from scipy.optimize import NonlinearConstraint, differential_evolution

    count, box = len(binding.choices), Box(binding.lower, binding.upper, binding.period)
    whole = np.arange(count + box.size) < count
    known: dict[bytes, tuple[float, float]] = {}

    def point(place: np.ndarray) -> tuple[Picked, np.ndarray]:
        return tuple(np.rint(place[:count]).astype(int).tolist()), box.values(place[count:])

    def at(place: np.ndarray) -> tuple[float, float]:
        """The objective, infinite where there is none, and the least margin."""
        key = place.tobytes()
        if key not in known:
            picked, variables = point(place)
            known[key] = np.inf, -AMPLE_MARGIN
            try:
                parts, margins, *_ = binding.with_picked(picked).evaluate(variables)
            except NumericalFailure:
                return known[key]
            least = min((float(np.min(one)) for one in margins), default=0.0)
            if np.isfinite(np.max(parts)) and not np.isnan(least):
                known[key] = float(np.max(parts)), float(np.clip(least, -AMPLE_MARGIN, 0.0))
        return known[key]

    solution = differential_evolution(
        lambda place: at(place)[0],
        [(0, len(one.options) - 1) for one in binding.choices] + [(0.0, 1.0)] * box.size,
        integrality=whole,
        constraints=(NonlinearConstraint(lambda place: at(place)[1], 0.0, np.inf),),
        polish=False,
        rng=np.random.default_rng(_SEED),
        popsize=_POPULATION,
        maxiter=max(10, max(MOST_RUNS // 2, each) // (_POPULATION * whole.size) - 1),
        tol=1e-6,
    )
    if not np.isfinite(at(solution.x)[0]):
        raise NumericalFailure("no combination that was tried can be evaluated")
    return *point(solution.x), len(known)
