"""What an optimisation puts into its record: optimum, methods side by side, front, slopes."""

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.results.record import Method, Record
from vibecalc.core.study.choices import in_words
from vibecalc.core.study.combine import MOST_KEPT
from vibecalc.core.study.planned import COMPARE_BUDGET, ROOT, optimisation_entries
from vibecalc.errors import NumericalFailure
from vibecalc.units import parse_quantity

if TYPE_CHECKING:
    from vibecalc.core.case.study_tables import Optimisation
    from vibecalc.core.study.binding import Binding
    from vibecalc.core.study.combine import Combined
    from vibecalc.core.study.search.problem import Infeasible, Optimum
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Numbers of a study into its record, under the entries of its paths.
# ----------------------------------------------------------------------------

#: name below `optimisation/` -> value and absolute error
Numbers = dict[str, tuple[Any, float]]
#: names of shares of a bound, which are what is left of 1
SHARES = ("margin",)


@dataclass
class Studied:
    """The record of an optimum, its case and timings, and the binding of what is picked there.

    `as_written` is the binding of the case, which may have other options.
    """

    record: Record
    case: "Case"
    timings: dict[str, float]
    binding: "Binding"
    as_written: "Binding"

    @property
    def study(self) -> "Optimisation":
        """What is asked for."""
        assert self.case.optimisation is not None
        return self.case.optimisation

    def add(self, numbers: Numbers, **axes: Any) -> None:
        """Add one quantity for each name; units, words and axes come from the catalogue."""
        entries = optimisation_entries(self.case)
        spans = {f"variable/{one.key}": one for one in self.study.moving}
        goal = self.record.quantities.get(self.study.objective.quantity)
        labels = {"limit": np.array(self.binding.margin_names(), dtype=object)}
        for name, (value, error) in numbers.items():
            entry = entries[f"{ROOT}/{name}"]
            terms = 1.0 if name in SHARES else 0.0
            if goal is not None and name.endswith("objective") and entry.unit == goal.unit:
                terms = goal.terms
            if name in spans:
                ends = (spans[name].lower, spans[name].upper)
                terms = max(abs(parse_quantity(str(end), entry.unit)) for end in ends)
            self.record.add(entry.quantity(value, error, labels | axes, terms=terms))

    def warn(self, words: str) -> None:
        """Say something of the study."""
        self.record.warnings.append(words)

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Put the seconds of a part into the timings, as they change from run to run."""
        started = time.perf_counter()
        yield
        self.timings[name] = time.perf_counter() - started


def add_optimum(out: Studied, optimum: "Optimum") -> None:
    """The optimum, what holds it, and how the searches ended."""
    binding, searches, optima = out.binding, optimum.history, optimum.optima
    sign = binding.sign
    # the objective is a result too, and as uncertain as that
    goal = out.record[binding.goal.quantity]
    off = max(optimum.objective_error, float(goal.error_estimate))
    values: Numbers = {
        "objective": (sign * optimum.objective, off),
        "kkt_residual": (optimum.kkt_residual, 0.0),
        "evaluations": (optimum.evaluations, 0.0),
        "failures": (optimum.failures, 0.0),
        "history/objective": ([_known(sign * s.objective) for s in searches], off),
        "history/feasible": ([int(s.feasible) for s in searches], 0.0),
        "history/evaluations": ([s.evaluations for s in searches], 0.0),
        "optima/objective": ([sign * o.objective for o in optima], off),
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
    counts = np.arange(1, 1 + max(len(searches), len(optima)))
    out.add(values, search=counts[: len(searches)], optimum=counts[: len(optima)])


def add_combinations(out: Studied, combined: "Combined") -> None:
    """What was picked, and the combinations examined, best first."""
    best, ranked = combined.best, combined.ranked[:MOST_KEPT]
    off = max((one.optimum.objective_error for one in ranked if one.optimum), default=0.0)
    sign = out.binding.sign
    numbers: Numbers = {
        "combinations/possible": (combined.possible, 0.0),
        "combinations/examined": (len(combined.examined), 0.0),
        "combinations/kept": (sum(one.optimum is not None for one in combined.examined), 0.0),
        "combinations/objective": ([_known(sign * one.objective) for one in ranked], off),
        "combinations/feasible": ([int(one.optimum is not None) for one in ranked], 0.0),
        "combinations/evaluations": ([one.evaluations for one in ranked], 0.0),
    }
    for place, choice in enumerate(combined.choices):
        numbers[choice.path] = (choice.value(best.picked[place]), 0.0)
        along = [choice.value(one.picked[place]) for one in ranked]
        numbers[f"combinations/{choice.path}"] = (along, 0.0)
    labels = [in_words(combined.choices, one.picked) for one in ranked]
    out.add(numbers, combination=np.array(labels, dtype=object))
    if len(combined.examined) < combined.possible:
        out.record.methods.append(
            Method(
                name="differential evolution with whole numbers, then all combinations next to it",
                purpose="what is picked",
                citation="Storn and Price 1997, J. Global Optim. 11, 341-359",
            )
        )


def add_nearest(out: Studied, nearest: "Infeasible") -> None:
    """The point that comes nearest to keeping all limits: its variables and how far it is off."""
    binding = out.binding
    _, margins = binding.worst(nearest.variables)
    values: Numbers = {
        "margin": (margins, _margin_error(binding, nearest.variables)),
        "evaluations": (nearest.evaluations, 0.0),
    }
    for key, value in zip(binding.keys, nearest.variables, strict=True):
        values[f"variable/{key}"] = (value, 0.0)
    out.add(values)


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


def compare_methods(out: Studied, optimum: "Optimum") -> None:
    """Run the methods that the case names and add `optimisation/methods/...`.

    Nothing helps them: no further starts, no refinement. A method that does not converge is said
    in a warning.
    """
    from vibecalc.core.study.search.methods import METHODS
    from vibecalc.core.study.search.minimise import find

    binding, names, ends = out.binding, list(out.study.compare), []
    for name in names:
        method = METHODS[name]
        try:
            with out.timed(TIMING.format(name)):
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
            out.warn(f"no methods are compared: {failure}")
            return
        ends.append(end)
        if not end.history[0].converged:
            out.warn(f"{name} has not converged: {end.history[0].reason}")
        out.record.methods.append(
            Method(name=method.words, purpose="compared", citation=method.citation)
        )
    off = np.max([_errors(binding, end.variables) for end in ends], axis=0)
    width, unsure = binding.upper - binding.lower, optimum.variables_error
    apart = [np.abs(binding.apart(optimum.variables, end.variables)) / width for end in ends]
    columns: Numbers = {
        "objective": ([binding.sign * end.objective for end in ends], off[0]),
        "shortfall": (
            [end.objective - optimum.objective for end in ends],
            off[0] + optimum.objective_error,
        ),
        "distance": ([np.max(one) for one in apart], float(np.max(unsure / width))),
        "violation": (
            [end.history[0].violation for end in ends],
            float(np.max(off[1:], initial=0.0)),
        ),
        "kkt_residual": ([end.kkt_residual for end in ends], 0.0),
        "converged": ([int(end.history[0].converged) for end in ends], 0.0),
        "evaluations": ([end.evaluations for end in ends], 0.0),
        "failures": ([end.failures for end in ends], 0.0),
    }
    numbers = {f"methods/{name}": column for name, column in columns.items()}
    out.add(numbers, method=np.array(names, dtype=object))


# ----------------------------------------------------------------------------
# Slopes of the objective at the start and at the optimum, and what small deviations cost.
# ----------------------------------------------------------------------------


def add_sensitivity(out: Studied, optimum: "Optimum") -> None:
    """Add `optimisation/sensitivity/<key>`, `optimisation/deviation/...` and the gain.

    What has no value, as a slope on a kink, is left out and said.
    """
    as_written = out.as_written
    places = {
        "start": (as_written, as_written.first),
        "optimum": (out.binding, optimum.variables),
    }
    if out.study.sensitivity in places:
        places = {out.study.sensitivity: places[out.study.sensitivity]}
    _add_slopes(out, places)
    if "optimum" in places:
        _add_deviations(out, optimum)
    with suppress(NumericalFailure):  # said with `optimisation/start`
        start, _ = as_written.worst(as_written.first)
        error = optimum.objective_error + float(as_written.errors(as_written.first)[0])
        out.add({"gain": (start - optimum.objective, error)})


def _add_slopes(out: Studied, places: dict[str, tuple["Binding", np.ndarray]]) -> None:
    from vibecalc.core.study.search.sensitivity import slopes_at

    found = {}
    for name, (at, point) in places.items():
        try:
            found[name] = slopes_at(at.evaluate, at.lower, at.upper, point, at.errors, at.ahead)
        except NumericalFailure as failure:
            out.warn(f"no slopes of the objective at the {name}: {failure}")
    for i, key in enumerate(out.binding.keys):
        known = {name: slopes for name, slopes in found.items() if slopes.known[i]}
        lost = " and the ".join(name for name in found if name not in known)
        if lost:
            out.warn(
                f"the slope of the objective by {key} is undefined at the {lost}: a kink, or no "
                "values next to it"
            )
        if known:
            values = [out.binding.sign * one.slope[i] for one in known.values()]
            error = max(float(one.error[i]) for one in known.values())
            out.add({f"sensitivity/{key}": (values, error)}, point=np.array([*known], dtype=object))


def _add_deviations(out: Studied, optimum: "Optimum") -> None:
    from vibecalc.core.study.search.sensitivity import cost_of_deviation

    at, numbers = out.binding, Numbers()
    cost = cost_of_deviation(
        at.evaluate, at.lower, at.upper, optimum.variables, errors=at.errors, period=at.period
    )
    for i, key in enumerate(at.keys):
        if not cost.known[i]:
            out.warn(f"1 % more or less of {key} has no result at the optimum")
            continue
        loss_error = float(cost.loss_error[i]) + optimum.objective_error
        numbers[f"deviation/size/{key}"] = (cost.deviation[i], 0.0)
        numbers[f"deviation/loss/{key}"] = (cost.loss[i], loss_error)
        if at.limits:
            moved = optimum.variables + np.eye(len(at.keys))[i] * cost.deviation[i]
            numbers[f"deviation/margin/{key}"] = (cost.margin[i], _margin_error(at, moved))
    out.add(numbers)
