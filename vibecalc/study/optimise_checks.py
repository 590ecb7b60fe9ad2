"""What is wrong with an [optimisation] beside its variables: the front and the methods."""

from dataclasses import replace
from typing import TYPE_CHECKING

from vibecalc.errors import Problem
from vibecalc.pipeline.targets import check_targets

if TYPE_CHECKING:
    from vibecalc.case.schema import Case


def study_problems(case: "Case") -> list[Problem]:
    """Problems of second_objective, front_points and compare; none without [optimisation]."""
    study = case.optimisation
    if study is None:
        return []
    problems: list[Problem] = []
    second = study.second_objective
    if second is None:
        if study.front_points is not None:
            problems.append(
                Problem(
                    path=("optimisation", "front_points"),
                    message="a front needs a second objective",
                    allowed="second_objective = { quantity = ... }",
                )
            )
    else:
        if second == study.objective:
            problems.append(
                Problem(
                    path=("optimisation", "second_objective"),
                    message="the second objective is the same as the first one",
                    hint="a front shows what one costs in the other",
                )
            )
        # the same checks as for the objective, under its own name
        swapped = study.model_copy(update={"objective": second})
        alone = case.model_copy(update={"optimisation": swapped, "reference": (), "limit": ()})
        problems += [
            replace(found, path=("optimisation", "second_objective", *found.path[2:]))
            for found in check_targets(alone)
            if found.path[:2] == ("optimisation", "objective")
        ]
    doubled = [name for name in dict.fromkeys(study.compare) if study.compare.count(name) > 1]
    problems += [
        Problem(path=("optimisation", "compare"), message=f"{name} is compared twice")
        for name in doubled
    ]
    return problems
