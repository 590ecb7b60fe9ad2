"""Topic of [optimisation]: how near the proven optimum each search comes for its evaluations."""

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibecalc.accuracy.topic import Answer, Ladder, Reference, Topic
from vibecalc.accuracy.yardsticks.searches import NEARLY_KEPT, within_budget
from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.constrained import minimise
from vibecalc.optimisation.methods import METHODS, find
from vibecalc.optimisation.variables import Box
from vibecalc.study.binding import Binding
from vibecalc.study.optimise import STANDARD

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase

#: evaluations that a search may spend: a part of what the case itself would
_BUDGETS = (20.0, 40.0, 80.0)
_PLAIN = ("SLSQP", "COBYLA", "differential evolution")
#: evaluations of the search that confirms the optimum, and digits of the optimum it starts from
_CONFIRM, _DIGITS = 60, 4
#: to which a limit is kept while the optimum is confirmed
_KEPT = 1e-10
#: what the proof of the ends takes over the search of them
_REFINED = 1.5
_WHY = (
    "searches from all the starts that the case asks for, since the global optimum rests on them, "
    "and refines their best ends until the optimum is proven"
)


class _Optimum(NamedTuple):
    """The proven optimum on the unit cube, its objective and how well another search agrees."""

    unit: np.ndarray
    objective: float
    agreement: float


def study_topics(loaded: "LoadedCase") -> list[Topic]:
    """One topic for a case with [optimisation], of the shortfall and of the distance."""
    study = loaded.case.optimisation
    if study is None:
        return []
    binding = Binding(loaded)
    # bounds that leave a variable no room make it no variable
    if not np.all(binding.upper > binding.lower):
        return []
    box = Box(binding.lower, binding.upper, binding.period)
    goal, starts = study.objective.quantity, study.starts
    sign = binding.sign

    @cache
    def optimum() -> _Optimum:
        return _proven(loaded, box)

    def reference() -> Reference:
        found = optimum()
        words = f"the search of the case, refined and proven; held against SLSQP from {_DIGITS} "
        words += "digits of it, which confirms a local optimum and not that there is no better one"
        return Reference(np.array([sign * found.objective]), found.agreement, words, 0.0)

    def answer(objective: float, unit: np.ndarray, work: int) -> Answer:
        away = float(np.linalg.norm(box.apart(optimum().unit, unit)))
        return Answer(np.array([sign * objective]), float(work), away)

    ladders = [_own(loaded, box, answer), *(_bare(loaded, box, answer, name) for name in METHODS)]
    ladders += [_scipy(loaded, box, answer, name) for name in _PLAIN]
    return [
        Topic(
            stage="optimisation",
            name="optimum",
            words=f"{goal} at the best point that keeps the limits, within some evaluations",
            quantity="optimisation/objective",
            unit=_unit(loaded, goal),
            work="evaluations of the case",
            reference=reference,
            ladders=tuple(ladders),
            position="distance from the optimum within bounds of 0 to 1 []",
            default_extra=_REFINED * (1.0 + starts),
            default_why=_WHY,
        )
    ]


_Answer = Callable[[float, np.ndarray, int], Answer]


def _own(loaded: "LoadedCase", box: Box, answer: _Answer) -> Ladder:
    study = loaded.case.optimisation
    assert study is not None
    method = study.method or STANDARD

    def solve(starts: float) -> Answer:
        binding = Binding(loaded)
        found = minimise(
            binding.evaluate, binding.lower, binding.upper, first=binding.first,
            starts=int(starts), rtol=loaded.case.accuracy.rtol, method=method,
            period=binding.period,
        )  # fmt: skip
        return answer(found.objective, box.unit(found.variables), found.evaluations)

    settings = sorted({1.0, 2.0, 4.0, float(study.starts)} - {0.0})
    return Ladder(
        f"{METHODS[method].words}, refined", "as the case is run", "starts",
        tuple(one for one in settings if one <= study.starts), solve, float(study.starts),
        citation=METHODS[method].citation,
    )  # fmt: skip


def _bare(loaded: "LoadedCase", box: Box, answer: _Answer, name: str) -> Ladder:
    method = METHODS[name]

    def solve(budget: float) -> Answer:
        binding = Binding(loaded)
        found = find(
            name, binding.evaluate, binding.lower, binding.upper,
            first=binding.first, budget=int(budget), period=binding.period,
        )  # fmt: skip
        if found.violation > NEARLY_KEPT:
            raise NumericalFailure(
                f"the point reached breaks a limit by {found.violation:.2g} of it: {found.reason}"
            )
        return answer(found.objective, box.unit(found.variables), found.evaluations)

    return Ladder(
        method.words, "from the case as written, its end not refined", "evaluations",
        _BUDGETS, solve, citation=method.citation,
    )  # fmt: skip


def _scipy(loaded: "LoadedCase", box: Box, answer: _Answer, name: str) -> Ladder:
    def solve(budget: float) -> Answer:
        binding = Binding(loaded)
        first = box.unit(binding.first)
        found = within_budget(
            name, lambda unit: binding.evaluate(box.values(unit)),
            [(0.0, 1.0)] * len(first), first, int(budget),
        )  # fmt: skip
        return answer(found.value, found.place, found.evaluations)

    words = f"on bounds of 0 to 1, best point met that keeps the limits to {NEARLY_KEPT:g}"
    return Ladder(f"{name} of scipy", words, "evaluations", _BUDGETS, solve)


def _proven(loaded: "LoadedCase", box: Box) -> _Optimum:
    """The case's own search, and SLSQP of scipy from the optimum cut to a few digits."""
    study = loaded.case.optimisation
    assert study is not None
    binding = Binding(loaded)
    found = minimise(
        binding.evaluate, binding.lower, binding.upper, first=binding.first,
        starts=study.starts, rtol=loaded.case.accuracy.rtol, method=study.method or STANDARD,
        period=binding.period,
    )  # fmt: skip
    unit = box.unit(found.variables)
    cut = np.clip(np.round(unit, _DIGITS), 0.0, 1.0)
    again = within_budget(
        "SLSQP", lambda at: binding.evaluate(box.values(at)), [(0.0, 1.0)] * len(unit), cut,
        _CONFIRM, _KEPT,
    )  # fmt: skip
    size = abs(found.objective) or 1.0
    apart = abs(again.value - found.objective) / size
    return _Optimum(unit, found.objective, max(apart, float(found.objective_error) / size))


def _unit(loaded: "LoadedCase", goal: str) -> str:
    from vibecalc.pipeline.plan import planned_quantities

    return planned_quantities(loaded.case)[goal].unit
