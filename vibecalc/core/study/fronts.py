"""What an optimisation adds to its record for several objectives: the front between them."""

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.results.record import Method
from vibecalc.core.study.binding import sign_of
from vibecalc.core.study.choices import MOST_RUNS, combinations, in_words
from vibecalc.core.study.planned import FRONT_NAMES, FRONT_RUNS, front_points, goals_of
from vibecalc.core.study.record import Numbers, Studied
from vibecalc.core.study.search.fronts import FrontPoints, front, knee, undominated
from vibecalc.core.study.search.problem import FEASIBLE_WITHIN, Infeasible
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The front of one combination of what is picked, and that of all.
# ----------------------------------------------------------------------------


def _of_one(case: "Case", binding: "Binding", first: np.ndarray) -> FrontPoints:
    """The front where nothing is left to pick."""
    study = case.optimisation
    assert study is not None
    goals = goals_of(study)
    if binding.lower.size == 0:
        parts, margins = binding.evaluate_all(first, goals)
        if any(np.any(one < -FEASIBLE_WITHIN) for one in margins):
            raise Infeasible("breaks a limit", first, 1, 0.0)
        values = np.array([[np.max(one) for one in parts]])
        error, nothing = binding.errors(first, goals)[: len(goals)], np.empty((1, 0))
        return FrontPoints(values, error[None, :], nothing, nothing, 1, ())
    return front(
        lambda variables: binding.evaluate_all(variables, goals),
        binding.lower,
        binding.upper,
        len(goals),
        first=first,
        points=front_points(study),
        starts=study.starts,
        rtol=case.accuracy.rtol,
        errors=lambda variables: binding.errors(variables, goals),
        period=binding.period,
        ahead=lambda points: binding.ahead(points, goals),
    )


def _of_all(
    case: "Case", binding: "Binding", first: np.ndarray
) -> tuple[list[tuple[int, ...]], list[FrontPoints], list[str]]:
    """What is picked, the fronts of it, and notes: all combinations, or the best of too many."""
    study = case.optimisation
    assert study is not None
    each = front_points(study) * FRONT_RUNS if study.moving else 1
    if not binding.choices or combinations(binding.choices) * each > MOST_RUNS:
        found = _of_one(case, binding, first)
        words = in_words(binding.choices, binding.picked)
        notes = [f"the front is that of {words} alone"] if binding.choices else list(found.notes)
        return [binding.picked], [found], notes
    every, fronts, notes = [], [], []
    for picked in product(*(range(len(choice.options)) for choice in binding.choices)):
        words = in_words(binding.choices, picked)
        try:
            found = _of_one(case, binding.with_picked(picked), first)
        except Infeasible:
            continue
        except NumericalFailure as failure:
            notes.append(f"{words} has no front: {failure}")
            continue
        every.append(picked)
        fronts.append(found)
        if len(found.values) > 1:  # one point is said by the front
            notes.extend(f"{words}: {note}" for note in found.notes)
    if not fronts:
        raise NumericalFailure("; ".join(notes) or "no combination keeps the limits")
    return every, fronts, notes


# ----------------------------------------------------------------------------
# Into the record.
# ----------------------------------------------------------------------------


def add_front(out: Studied, optimum: np.ndarray) -> None:
    """Trace the front from the optimum (n,) on and add `optimisation/front/...`.

    Raises NumericalFailure if an end of the front has no optimum.
    """
    goals, binding = goals_of(out.study), out.binding
    try:
        with out.timed("front"):
            every, fronts, notes = _of_all(out.case, binding, optimum)
    except NumericalFailure as failure:
        raise NumericalFailure(f"the front cannot be traced: {failure}") from failure
    values, errors, variables, away = (
        np.concatenate([getattr(one, name) for one in fronts])
        for name in ("values", "errors", "variables", "variables_error")
    )
    picked = [one for one, of in zip(every, fronts, strict=True) for _ in of.values]
    kept = undominated(values) if len(fronts) > 1 else np.arange(len(values))
    numbers: Numbers = {"front/evaluations": (sum(one.evaluations for one in fronts), 0.0)}
    for place, (name, goal) in enumerate(zip(FRONT_NAMES, goals, strict=False)):
        error = float(np.max(errors[kept, place]))
        numbers[f"front/{name}"] = (sign_of(goal) * values[kept, place], error)
    for i, key in enumerate(binding.keys):
        numbers[f"front/variable/{key}"] = (variables[kept, i], float(np.max(away[kept, i])))
    for i, choice in enumerate(binding.choices):
        along = [choice.value(picked[place][i]) for place in kept.tolist()]
        numbers[f"front/{choice.path}"] = (along, 0.0)
    deepest = knee(values[kept])
    if deepest is not None:
        numbers["front/knee"] = (deepest + 1, 0.0)
    out.add(numbers, front_point=np.arange(1, len(kept) + 1))
    out.record.warnings += [f"front: {note}" for note in notes]
    out.record.methods.append(_EPSILON if len(goals) == 2 else _BOUNDARY)


_EPSILON = Method(
    name="epsilon-constraint method",
    purpose="front between two objectives",
    citation="Haimes, Lasdon and Wismer 1971, IEEE Trans. SMC-1, 296-297",
)
_BOUNDARY = Method(
    name="normal boundary intersection",
    purpose="front between several objectives",
    citation="Das and Dennis 1998, SIAM J. Optim. 8, 631-657",
)
