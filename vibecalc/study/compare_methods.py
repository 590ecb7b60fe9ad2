"""Search methods side by side: each alone from the case as written, its end taken as it is."""

import time
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.results.record import Method, Record
from vibecalc.study.optimise_further_paths import COMPARE_BUDGET
from vibecalc.study.optimise_record import add_numbers

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.optimisation.methods import Found
    from vibecalc.optimisation.optimum import Optimum
    from vibecalc.study.binding import Binding

#: name of the seconds of one method in the timings of a result
TIMING = "method {}"


def compare_methods(
    record: Record,
    case: "Case",
    binding: "Binding",
    optimum: "Optimum",
    timings: dict[str, float],
) -> None:
    """Run the methods that the case names and add `optimisation/methods/...`.

    Nothing helps them: no further starts, no refinement. Seconds go into `timings`, as they
    change from run to run. A method that does not converge is said in a warning.
    """
    from vibecalc.optimisation.methods import METHODS, find

    study = case.optimisation
    assert study is not None
    names = list(study.compare)
    ends: list[Found] = []
    for name in names:
        started = time.perf_counter()
        try:
            end = find(
                name,
                binding.evaluate,
                binding.lower,
                binding.upper,
                first=binding.first,
                budget=COMPARE_BUDGET,
                period=binding.period,
            )
        except NumericalFailure as failure:
            record.warnings.append(f"no methods are compared: {failure}")
            return
        timings[TIMING.format(name)] = time.perf_counter() - started
        ends.append(end)
        if not end.converged:
            record.warnings.append(f"{name} has not converged: {end.reason}")
        method = METHODS[name]
        record.methods.append(
            Method(name=method.words, purpose="compared", citation=method.citation)
        )
    sizes = [abs(end.objective) for end in ends]
    error = binding.accuracy * max(sizes)
    width = binding.upper - binding.lower
    ways = [np.abs(binding.apart(optimum.variables, end.variables)) for end in ends]
    away = [float(np.max(way / width)) for way in ways]
    reach = float(np.max(optimum.variables_error / width))
    add_numbers(
        record,
        case,
        {
            "methods/objective": ([binding.sign * end.objective for end in ends], error),
            "methods/shortfall": (
                [end.objective - optimum.objective for end in ends],
                error + optimum.objective_error,
            ),
            "methods/distance": (away, reach),
            "methods/violation": ([end.violation for end in ends], binding.accuracy),
            "methods/kkt_residual": ([end.residual for end in ends], 0.0),
            "methods/converged": ([int(end.converged) for end in ends], 0.0),
            "methods/evaluations": ([end.evaluations for end in ends], 0.0),
            "methods/failures": ([end.failures for end in ends], 0.0),
        },
        {"method": np.array(names, dtype=object)},
    )
