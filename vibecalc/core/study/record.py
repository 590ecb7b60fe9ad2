"""What an optimisation puts into its record: optimum, methods side by side, front, slopes."""

import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.results.record import Axis, Method, Quantity, Record
from vibecalc.core.study.choices import in_words
from vibecalc.core.study.combine import MOST_KEPT
from vibecalc.core.study.planned import COMPARE_BUDGET, ROOT, optimisation_entries
from vibecalc.errors import NumericalFailure
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding
    from vibecalc.core.study.combine import Combined
    from vibecalc.core.study.search.methods import MethodEnd
    from vibecalc.core.study.search.problem import Infeasible, Optimum
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Numbers of a study into its record, under the entries of its paths.
# ----------------------------------------------------------------------------

#: name below `optimisation/` -> value and absolute error
Numbers = dict[str, tuple[Any, float]]
#: names of shares of a bound, which are what is left of 1
SHARES = ("margin",)


def add_numbers(
    record: Record, case: "Case", numbers: Numbers, axes: Mapping[str, np.ndarray]
) -> None:
    """Add one quantity for each name; units, words and axes come from the catalogue."""
    entries = optimisation_entries(case)
    study = case.optimisation
    spans = {f"variable/{one.key}": one for one in (study.moving if study else ())}
    goal = None if study is None else record.quantities.get(study.objective.quantity)
    for name, (value, error) in numbers.items():
        entry = entries[f"{ROOT}/{name}"]
        terms = 1.0 if name in SHARES else 0.0
        if goal is not None and name.endswith("objective") and entry.unit == goal.unit:
            terms = goal.terms
        if name in spans:
            ends = (spans[name].lower, spans[name].upper)
            terms = max(abs(parse_quantity(str(end), entry.unit)) for end in ends)
        record.add(
            Quantity(
                path=entry.path,
                values=np.asarray(value),
                unit=entry.unit,
                long_name=entry.long_name,
                axes=tuple(Axis(name=axis, values=axes[axis]) for axis in entry.axes),
                amplitude=entry.amplitude,
                error_estimate=error,
                terms=terms,
            )
        )


def add_optimum(record: Record, case: "Case", binding: "Binding", optimum: "Optimum") -> None:
    """The optimum, what holds it, and how the searches ended."""
    searches, optima = optimum.history, optimum.optima
    axes = {
        "search": np.arange(1, len(searches) + 1),
        "optimum": np.arange(1, len(optima) + 1),
        "limit": np.array(binding.margin_names(), dtype=object),
    }
    # the objective is a result too, and as uncertain as that
    goal = record[binding.goal.quantity]
    off = max(optimum.objective_error, float(goal.error_estimate))
    values: Numbers = {
        "objective": (binding.sign * optimum.objective, off),
        "kkt_residual": (optimum.kkt_residual, 0.0),
        "evaluations": (optimum.evaluations, 0.0),
        "failures": (optimum.failures, 0.0),
        "history/objective": (
            [_known(binding.sign * s.objective) for s in searches],
            off,
        ),
        "history/feasible": ([int(s.feasible) for s in searches], 0.0),
        "history/evaluations": ([s.evaluations for s in searches], 0.0),
        "optima/objective": ([binding.sign * o.objective for o in optima], off),
        "optima/found_by": ([o.found_by for o in optima], 0.0),
    }
    if binding.limits:
        values["margin"] = (optimum.margins, _margin_error(binding, optimum.variables))
        values["multiplier"] = (optimum.margin_multipliers, _price_error(optimum))
    for i, key in enumerate(binding.keys):
        values[f"variable/{key}"] = (optimum.variables[i], float(optimum.variables_error[i]))
        values[f"active_bound/{key}"] = (int(optimum.active_bounds[i]), 0.0)
        values[f"history/start/{key}"] = ([s.start[i] for s in searches], 0.0)
        values[f"history/end/{key}"] = ([s.end[i] for s in searches], 0.0)
    add_numbers(record, case, values, axes)


def add_combinations(
    record: Record, case: "Case", binding: "Binding", combined: "Combined"
) -> None:
    """What was picked, and the combinations examined, best first."""
    best, ranked = combined.best, combined.ranked[:MOST_KEPT]
    off = max((one.optimum.objective_error for one in ranked if one.optimum), default=0.0)
    numbers: Numbers = {
        "combinations/possible": (combined.possible, 0.0),
        "combinations/examined": (len(combined.examined), 0.0),
        "combinations/kept": (sum(one.optimum is not None for one in combined.examined), 0.0),
        "combinations/objective": ([_known(binding.sign * one.objective) for one in ranked], off),
        "combinations/feasible": ([int(one.optimum is not None) for one in ranked], 0.0),
        "combinations/evaluations": ([one.evaluations for one in ranked], 0.0),
    }
    for place, choice in enumerate(combined.choices):
        numbers[choice.path] = (choice.value(best.picked[place]), 0.0)
        along = [choice.value(one.picked[place]) for one in ranked]
        numbers[f"combinations/{choice.path}"] = (along, 0.0)
    labels = [in_words(combined.choices, one.picked) for one in ranked]
    add_numbers(record, case, numbers, {"combination": np.array(labels, dtype=object)})
    if len(combined.examined) < combined.possible:
        record.methods.append(
            Method(
                name="differential evolution with whole numbers, then all combinations next to it",
                purpose="what is picked",
                citation="Storn and Price 1997, J. Global Optim. 11, 341-359",
            )
        )


def add_nearest(
    record: Record,
    case: "Case",
    binding: "Binding",
    nearest: "Infeasible",
) -> None:
    """The point that comes nearest to keeping all limits: its variables and how far it is off."""
    _, margins = binding.worst(nearest.variables)
    values: Numbers = {
        "margin": (margins, _margin_error(binding, nearest.variables)),
        "evaluations": (nearest.evaluations, 0.0),
    }
    for key, value in zip(binding.keys, nearest.variables, strict=True):
        values[f"variable/{key}"] = (value, 0.0)
    add_numbers(record, case, values, {"limit": np.array(binding.margin_names(), dtype=object)})


def _errors(binding: "Binding", variables: np.ndarray) -> np.ndarray:
    """Errors of objective and margins (1 + m,) at a point; none where it has no result."""
    try:
        return binding.errors(variables)
    except NumericalFailure:
        return np.zeros(1 + len(binding.margin_names()))


def _margin_error(binding: "Binding", variables: np.ndarray) -> float:
    return float(np.max(_errors(binding, variables)[1:], initial=0.0))


def _price_error(optimum: "Optimum") -> float:
    """Error of the multipliers: slopes known ten times worse, relatively, than the variables."""
    size = np.abs(optimum.variables)
    uncertainty = np.max(optimum.variables_error[size > 0.0] / size[size > 0.0], initial=0.0)
    largest = np.max(np.abs(optimum.margin_multipliers), initial=0.0)
    return float(largest * (optimum.kkt_residual + 10.0 * uncertainty))


def _known(objective: float) -> float:
    """A start that could not be evaluated has no objective: infinitely bad, never NaN."""
    return objective if np.isfinite(objective) else np.inf


# ----------------------------------------------------------------------------
# Search methods side by side: each alone from the case as written, its end taken as it is.
# ----------------------------------------------------------------------------

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
    from vibecalc.core.study.search.methods import METHODS, find

    study = case.optimisation
    assert study is not None
    names = list(study.compare)
    ends: list[MethodEnd] = []
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
                ahead=binding.ahead,
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
    off = np.array([_errors(binding, end.variables) for end in ends])
    error = float(np.max(off[:, 0]))
    width = binding.upper - binding.lower
    differences = [np.abs(binding.apart(optimum.variables, end.variables)) for end in ends]
    away = [float(np.max(difference / width)) for difference in differences]
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
            "methods/violation": (
                [end.violation for end in ends],
                float(np.max(off[:, 1:], initial=0.0)),
            ),
            "methods/kkt_residual": ([end.residual for end in ends], 0.0),
            "methods/converged": ([int(end.converged) for end in ends], 0.0),
            "methods/evaluations": ([end.evaluations for end in ends], 0.0),
            "methods/failures": ([end.failures for end in ends], 0.0),
        },
        {"method": np.array(names, dtype=object)},
    )


# ----------------------------------------------------------------------------
# Slopes of the objective at the start and at the optimum, and what small deviations cost.
# ----------------------------------------------------------------------------


def add_sensitivity(
    record: Record,
    case: "Case",
    binding: "Binding",
    optimum: "Optimum",
    timings: dict[str, float],
    as_written: "Binding",
) -> None:
    """Add `optimisation/sensitivity/<key>`, `optimisation/deviation/...` and the gain.

    The start is the case `as_written`, which may have other options than are picked. What has no
    value, as a slope on a kink, is left out and said.
    """
    study = case.optimisation
    assert study is not None
    started = time.perf_counter()
    places = {
        "start": (as_written, binding.first),
        "optimum": (binding, optimum.variables),
    }
    if study.sensitivity in places:
        places = {study.sensitivity: places[study.sensitivity]}
    _slopes(record, case, places)
    if "optimum" in places:
        _deviations(record, case, binding, optimum)
    try:
        start, _ = as_written.worst(binding.first)
    except NumericalFailure:
        pass  # said with `optimisation/start`
    else:
        gain = start - optimum.objective
        error = optimum.objective_error + float(as_written.errors(binding.first)[0])
        add_numbers(record, case, {"gain": (gain, error)}, {})
    timings["sensitivity"] = time.perf_counter() - started


def _slopes(record: Record, case: "Case", places: dict[str, tuple["Binding", np.ndarray]]) -> None:
    from vibecalc.core.study.search.sensitivity import slopes_at

    slopes_of = {}
    for name, (binding, point) in places.items():
        try:
            slopes_of[name] = slopes_at(
                binding.evaluate,
                binding.lower,
                binding.upper,
                point,
                binding.errors,
                binding.ahead,
            )
        except NumericalFailure as failure:
            record.warnings.append(f"no slopes of the objective at the {name}: {failure}")
    for i, key in enumerate(binding.keys):
        known = [name for name, slopes in slopes_of.items() if slopes.known[i]]
        lost = [name for name in slopes_of if name not in known]
        if lost:
            places_lost = " and the ".join(lost)
            record.warnings.append(
                f"the slope of the objective by {key} is undefined at the {places_lost}: "
                "a kink, or no values next to it"
            )
        if known:
            values = [binding.sign * slopes_of[name].slope[i] for name in known]
            error = max(float(slopes_of[name].error[i]) for name in known)
            add_numbers(
                record,
                case,
                {f"sensitivity/{key}": (values, error)},
                {"point": np.array(known, dtype=object)},
            )


def _deviations(record: Record, case: "Case", binding: "Binding", optimum: "Optimum") -> None:
    from vibecalc.core.study.search.sensitivity import cost_of_deviation

    cost = cost_of_deviation(
        binding.evaluate,
        binding.lower,
        binding.upper,
        optimum.variables,
        errors=binding.errors,
        period=binding.period,
    )
    numbers: Numbers = {}
    for i, key in enumerate(binding.keys):
        if not cost.known[i]:
            record.warnings.append(f"1 % more or less of {key} has no result at the optimum")
            continue
        loss_error = float(cost.loss_error[i]) + optimum.objective_error
        numbers[f"deviation/size/{key}"] = (cost.deviation[i], 0.0)
        numbers[f"deviation/loss/{key}"] = (cost.loss[i], loss_error)
        if binding.limits:
            moved = optimum.variables + np.eye(len(binding.keys))[i] * cost.deviation[i]
            off = _margin_error(binding, moved)
            numbers[f"deviation/margin/{key}"] = (cost.margin[i], off)
    add_numbers(record, case, numbers, {})
