"""Numbers of a study into its record, under the entries of its paths."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.results.record import Axis, Quantity, Record
from vibecalc.study.optimise_paths import ROOT, optimisation_entries
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.case.schema import Case
    from vibecalc.optimisation.optimum import Optimum
    from vibecalc.study.binding import Binding

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
    spans = {f"variable/{one.key}": one for one in (study.variables if study else ())}
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


def add_optimum(record: Record, case: "Case", binding: "Binding", found: "Optimum") -> None:
    """The optimum, what holds it, and how the searches ended."""
    searches, optima = found.history, found.optima
    axes = {
        "search": np.arange(1, len(searches) + 1),
        "optimum": np.arange(1, len(optima) + 1),
        "limit": np.array(binding.margin_names(), dtype=object),
    }
    # the objective is a result too, and as uncertain as that
    goal = record[binding.goal.quantity]
    off = max(found.objective_error, float(goal.error_estimate))
    values: Numbers = {
        "objective": (binding.sign * found.objective, off),
        "kkt_residual": (found.kkt_residual, 0.0),
        "evaluations": (found.evaluations, 0.0),
        "failures": (found.failures, 0.0),
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
        values["margin"] = (found.margins, binding.accuracy)
        values["multiplier"] = (found.margin_multipliers, _price_error(found))
    for i, key in enumerate(binding.keys):
        values[f"variable/{key}"] = (found.variables[i], float(found.variables_error[i]))
        values[f"active_bound/{key}"] = (int(found.active_bounds[i]), 0.0)
        values[f"history/start/{key}"] = ([s.start[i] for s in searches], 0.0)
        values[f"history/end/{key}"] = ([s.end[i] for s in searches], 0.0)
    add_numbers(record, case, values, axes)


def add_nearest(
    record: Record,
    case: "Case",
    binding: "Binding",
    variables: np.ndarray,
    margins: np.ndarray,
    evaluations: int,
) -> None:
    """The point that comes nearest to keeping all limits: its variables and how far it is off."""
    values: Numbers = {"margin": (margins, binding.accuracy), "evaluations": (evaluations, 0.0)}
    for key, value in zip(binding.keys, variables, strict=True):
        values[f"variable/{key}"] = (value, 0.0)
    add_numbers(record, case, values, {"limit": np.array(binding.margin_names(), dtype=object)})


def _price_error(found: "Optimum") -> float:
    """Error of the multipliers: slopes known ten times worse, relatively, than the variables."""
    size = np.abs(found.variables)
    doubt = np.max(found.variables_error[size > 0.0] / size[size > 0.0], initial=0.0)
    largest = np.max(np.abs(found.margin_multipliers), initial=0.0)
    return float(largest * (found.kkt_residual + 10.0 * doubt))


def _known(objective: float) -> float:
    """A start that could not be evaluated has no objective: infinitely bad, never NaN."""
    return objective if np.isfinite(objective) else np.inf
