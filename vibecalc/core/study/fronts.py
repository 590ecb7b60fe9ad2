"""What an optimisation adds to its record for several objectives: the front between them."""

from dataclasses import replace
from itertools import product

import numpy as np

from vibecalc.core.results.record import FRONT_NAMES, Method
from vibecalc.core.study.binding import Binding, sign_of
from vibecalc.core.study.choices import MOST_RUNS, in_words
from vibecalc.core.study.planned import FRONT_POINTS, front_runs
from vibecalc.core.study.record import Numbers, Studied
from vibecalc.core.study.search.fronts import FrontPoints, front, knee, undominated
from vibecalc.core.study.search.problem import Infeasible
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# The front of one combination of what is picked, or of all.
# ----------------------------------------------------------------------------


def _fronts(
    out: Studied, first: np.ndarray
) -> tuple[list[tuple[tuple[int, ...], FrontPoints]], list[str]]:
    """Fronts with what is picked there, and notes: all combinations, or the best of too many."""
    study, choices, rtol = out.study, out.binding.choices, out.binding.case.accuracy.rtol

    def traced(binding: Binding) -> FrontPoints:
        problem = replace(binding.problem(study.goals), first=first)
        points = study.front_points or FRONT_POINTS
        return front(
            problem,
            len(study.goals),
            points=points,
            starts=study.starts,
            rtol=rtol,
            searched=binding is out.binding,
        )

    if not choices or front_runs(study, every=True) > MOST_RUNS:
        found = traced(out.binding)
        words = f"the front is for {in_words(choices, out.binding.picked)} only"
        return [(out.binding.picked, found)], [words] if choices else found.notes
    fronts: list[tuple[tuple[int, ...], FrontPoints]] = []
    notes: list[str] = []
    for picked in product(*(range(len(choice.options)) for choice in choices)):
        words = in_words(choices, picked)
        try:
            found = traced(out.binding.with_picked(picked))
        except Infeasible:
            continue
        except NumericalFailure as failure:
            notes.append(f"{words} has no front: {failure}")
            continue
        fronts.append((picked, found))
        if len(found.values) > 1:  # one point is said by the front
            notes.extend(f"{words}: {note}" for note in found.notes)
    if not fronts:
        raise NumericalFailure("; ".join(notes) or "no combination keeps the limits")
    return fronts, notes


def add_front(out: Studied, optimum: np.ndarray) -> None:
    """Trace the front from the optimum (n,) on and add `optimisation/front/...`.

    Raises NumericalFailure if an end of the front has no optimum.
    """
    try:
        fronts, notes = _fronts(out, optimum)
    except NumericalFailure as failure:
        raise NumericalFailure(f"the front cannot be traced: {failure}") from failure
    values, errors, variables, away = (
        np.concatenate([getattr(one, name) for _, one in fronts])
        for name in ("values", "errors", "variables", "variables_error")
    )
    picked = [picked for picked, of in fronts for _ in of.values]
    kept = undominated(values) if len(fronts) > 1 else np.arange(len(values))
    axis = {"front_point": np.arange(1, len(kept) + 1)}
    count = sum(one.evaluations for _, one in fronts)
    numbers: Numbers = {"front/evaluations": (count, 0.0)}
    for place, (name, goal) in enumerate(zip(FRONT_NAMES, out.study.goals, strict=False)):
        error = float(np.max(errors[kept, place]))
        numbers[f"front/{name}"] = (sign_of(goal) * values[kept, place], error)
    for i, choice in enumerate(out.binding.choices):
        along = [choice.value(picked[place][i]) for place in kept.tolist()]
        numbers[f"front/{choice.path}"] = (along, 0.0)
    deepest = knee(values[kept])
    if deepest is not None:
        numbers["front/knee"] = (deepest + 1, 0.0)
    out.add(numbers, **axis)
    out.add_variables("front/variable", variables[kept], np.max(away[kept], axis=0), **axis)
    out.record.warnings += [f"front: {note}" for note in notes]
    out.record.methods.append(_EPSILON if len(out.study.goals) == 2 else _BOUNDARY)


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
