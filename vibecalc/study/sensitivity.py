"""Slopes of the objective at the start and at the optimum, and what small deviations cost."""

import time
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.results.record import Record
from vibecalc.study.optimise_record import Numbers, add_numbers

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.optimisation.optimum import Optimum
    from vibecalc.study.binding import Binding


def add_sensitivity(
    record: Record,
    case: "Case",
    binding: "Binding",
    optimum: "Optimum",
    timings: dict[str, float],
) -> None:
    """Add `optimisation/sensitivity/<key>`, `optimisation/deviation/...` and the gain.

    What has no value, as a slope on a kink, is left out and said.
    """
    study = case.optimisation
    assert study is not None
    started = time.perf_counter()
    places = {"start": binding.first, "optimum": optimum.variables}
    if study.sensitivity in places:
        places = {study.sensitivity: places[study.sensitivity]}
    _slopes(record, case, binding, places)
    if "optimum" in places:
        _deviations(record, case, binding, optimum)
    try:
        start, _ = binding.evaluate(binding.first)
    except NumericalFailure:
        pass  # said with `optimisation/start`
    else:
        gain = start - optimum.objective
        error = optimum.objective_error + binding.accuracy * abs(start)
        add_numbers(record, case, {"gain": (gain, error)}, {})
    timings["sensitivity"] = time.perf_counter() - started


def _slopes(
    record: Record, case: "Case", binding: "Binding", places: dict[str, np.ndarray]
) -> None:
    from vibecalc.optimisation.sensitivity import slopes_at

    found = {}
    for name, point in places.items():
        try:
            found[name] = slopes_at(
                binding.evaluate, binding.lower, binding.upper, point, binding.accuracy
            )
        except NumericalFailure as failure:
            record.warnings.append(f"no slopes of the objective at the {name}: {failure}")
    for i, key in enumerate(binding.keys):
        known = [name for name, slopes in found.items() if slopes.known[i]]
        lost = [name for name in found if name not in known]
        if lost:
            places_lost = " and the ".join(lost)
            record.warnings.append(
                f"the slope of the objective by {key} is undefined at the {places_lost}: "
                "a kink, or no values beside it"
            )
        if known:
            values = [binding.sign * found[name].slope[i] for name in known]
            error = max(float(found[name].error[i]) for name in known)
            add_numbers(
                record,
                case,
                {f"sensitivity/{key}": (values, error)},
                {"point": np.array(known, dtype=object)},
            )


def _deviations(record: Record, case: "Case", binding: "Binding", optimum: "Optimum") -> None:
    from vibecalc.optimisation.sensitivity import cost_of_deviation

    cost = cost_of_deviation(
        binding.evaluate,
        binding.lower,
        binding.upper,
        optimum.variables,
        accuracy=binding.accuracy,
        period=binding.period,
    )
    numbers: Numbers = {}
    for i, key in enumerate(binding.keys):
        if not cost.known[i]:
            record.warnings.append(f"1 % more or less of {key} has no result at the optimum")
            continue
        loss_error = float(cost.rise_error[i]) + optimum.objective_error
        numbers[f"deviation/size/{key}"] = (cost.deviation[i], 0.0)
        numbers[f"deviation/loss/{key}"] = (cost.rise[i], loss_error)
        if binding.limits:
            numbers[f"deviation/margin/{key}"] = (cost.margin[i], binding.accuracy)
    add_numbers(record, case, numbers, {})
