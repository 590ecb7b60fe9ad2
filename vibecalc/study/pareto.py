"""The front between the objective of a case and its second one."""

import time
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.results.record import Method, Record
from vibecalc.study.binding import sign_of
from vibecalc.study.optimise_further_paths import front_points
from vibecalc.study.optimise_record import Numbers, add_numbers

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.optimisation.optimum import Optimum
    from vibecalc.study.binding import Binding


def add_front(
    record: Record,
    case: "Case",
    binding: "Binding",
    optimum: "Optimum",
    timings: dict[str, float],
) -> None:
    """Trace the front from the optimum on and add `optimisation/front/...`.

    Raises NumericalFailure if an end of the front has no optimum.
    """
    from vibecalc.optimisation.pareto import front

    study = case.optimisation
    assert study is not None
    second = study.second_objective
    assert second is not None
    started = time.perf_counter()
    binding.evaluate_both(optimum.variables, second)  # how accurate the second objective is
    try:
        found = front(
            lambda variables: binding.evaluate_both(variables, second),
            binding.lower,
            binding.upper,
            first=optimum.variables,
            points=front_points(study),
            starts=study.starts,
            rtol=case.accuracy.rtol,
            accuracy=binding.accuracy,
            period=binding.period,
        )
    except NumericalFailure as failure:
        raise NumericalFailure(f"the front cannot be traced: {failure}") from failure
    timings["front"] = time.perf_counter() - started
    numbers: Numbers = {
        "front/objective": (binding.sign * found.objective, float(np.max(found.objective_error))),
        "front/second_objective": (
            sign_of(second) * found.second_objective,
            float(np.max(found.second_objective_error)),
        ),
        "front/evaluations": (found.evaluations, 0.0),
    }
    for i, key in enumerate(binding.keys):
        error = float(np.max(found.variables_error[:, i]))
        numbers[f"front/variable/{key}"] = (found.variables[:, i], error)
    axis = np.arange(1, found.objective.size + 1)
    add_numbers(record, case, numbers, {"front_point": axis})
    record.warnings += [f"front: {note}" for note in found.notes]
    record.methods.append(
        Method(
            name="epsilon-constraint method",
            purpose="front between two objectives",
            citation="Haimes, Lasdon and Wismer 1971, IEEE Trans. SMC-1, 296-297",
        )
    )
