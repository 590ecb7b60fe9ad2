"""What an optimisation puts into its record: the optimum, what was picked, slopes, deviations."""

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.results.record import Method, Record
from vibecalc.core.study.choices import in_words
from vibecalc.core.study.combine import MOST_KEPT
from vibecalc.core.study.planned import ROOT, optimisation_entries
from vibecalc.errors import NumericalFailure

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


class Studied:
    """The record of an optimum, its case and timings, and the binding of what is picked there.

    `as_written` is the binding of the case, which may have other options; `study` is what is asked.
    """

    def __init__(
        self, record: Record, case: "Case", timings: dict[str, float], binding: "Binding",
        as_written: "Binding",
    ):  # fmt: skip
        assert case.optimisation is not None
        self.record, self.case, self.timings = record, case, timings
        self.study: Optimisation = case.optimisation
        self.binding, self.as_written = binding, as_written
        self._entries = optimisation_entries(case)
        # what cancels in a margin, which is what is left of 1, and in a variable next to zero
        ends = np.maximum(np.abs(binding.lower), np.abs(binding.upper)).tolist()
        named = (f"variable/{key}" for key in binding.keys)
        self._terms = {"margin": 1.0, **dict(zip(named, ends, strict=True))}

    def add(self, numbers: Numbers, **axes: Any) -> None:
        """Add one quantity for each name; units, words and axes come from the catalogue."""
        goal = self.record.quantities.get(self.binding.goal.quantity)
        labels = {"limit": np.array(self.binding.margin_names(), dtype=object)} | axes
        for name, (value, error) in numbers.items():
            entry, terms = self._entries[f"{ROOT}/{name}"], self._terms.get(name, 0.0)
            if goal is not None and name.endswith("objective") and entry.unit == goal.unit:
                terms = goal.terms
            self.record.add(entry.quantity(value, error, labels, terms=terms))

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
        # slopes are known ten times worse, relatively, than the variables
        size, prices = np.abs(optimum.variables), optimum.margin_multipliers
        unsure = np.max(optimum.variables_error[size > 0.0] / size[size > 0.0], initial=0.0)
        error = (optimum.kkt_residual + 10.0 * unsure) * np.max(prices, initial=0.0)
        values["multiplier"] = (prices, float(error))
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
    numbers: Numbers = {
        "combinations/possible": (combined.possible, 0.0),
        "combinations/examined": (len(combined.examined), 0.0),
        "combinations/kept": (sum(one.optimum is not None for one in combined.examined), 0.0),
        "combinations/objective": ([_known(out.binding.sign * o.objective) for o in ranked], off),
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
        out.record.methods.append(_EVOLUTION)


_EVOLUTION = Method(
    name="differential evolution with whole numbers, then all combinations next to it",
    purpose="what is picked",
    citation="Storn and Price 1997, J. Global Optim. 11, 341-359",
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


def _margin_error(binding: "Binding", variables: np.ndarray) -> float:
    """Error of the margins at a point; none where it has no result."""
    with suppress(NumericalFailure):
        return float(np.max(binding.errors(variables)[1:], initial=0.0))
    return 0.0


def _known(objective: float) -> float:
    """A start that could not be evaluated has no objective: infinitely bad."""
    return objective if np.isfinite(objective) else np.inf


# ----------------------------------------------------------------------------
# Slopes of the objective at the start and at the optimum, and what small deviations cost.
# ----------------------------------------------------------------------------


def add_sensitivity(out: Studied, optimum: "Optimum") -> None:
    """Add `optimisation/sensitivity/<key>`, `optimisation/deviation/...` and the gain.

    What has no value, as a slope on a kink, is left out and said.
    """
    written = out.as_written
    places = {"start": (written, written.first), "optimum": (out.binding, optimum.variables)}
    if out.study.sensitivity in places:
        places = {out.study.sensitivity: places[out.study.sensitivity]}
    _add_slopes(out, places)
    if "optimum" in places:
        _add_deviations(out, optimum)
    with suppress(NumericalFailure):  # said with `optimisation/start`
        start, _ = written.worst(written.first)
        error = optimum.objective_error + float(written.errors(written.first)[0])
        out.add({"gain": (start - optimum.objective, error)})


def _add_slopes(out: Studied, places: dict[str, tuple["Binding", np.ndarray]]) -> None:
    from vibecalc.core.study.search.sensitivity import slopes_at

    found = {}
    for name, (at, point) in places.items():
        try:
            found[name] = slopes_at(at.problem(), point)
        except NumericalFailure as failure:
            out.warn(f"no slopes of the objective at the {name}: {failure}")
    for i, key in enumerate(out.binding.keys):
        known = {name: (slope[i], error[i]) for name, (slope, error) in found.items()
                 if np.isfinite(slope[i])}  # fmt: skip
        lost = " and the ".join(name for name in found if name not in known)
        if lost:
            out.warn(
                f"the slope of the objective by {key} is undefined at the {lost}: a kink, or no "
                "values next to it"
            )
        if known:
            slopes, errors = np.array([*known.values()]).T
            numbers: Numbers = {f"sensitivity/{key}": (out.binding.sign * slopes, max(errors))}
            out.add(numbers, point=np.array([*known], dtype=object))


def _add_deviations(out: Studied, optimum: "Optimum") -> None:
    from vibecalc.core.study.search.sensitivity import cost_of_deviation

    at, numbers = out.binding, Numbers()
    rows = cost_of_deviation(at.problem(), optimum.variables)
    for i, (key, (size, loss, error, margin)) in enumerate(zip(at.keys, rows, strict=True)):
        if np.isnan(loss):
            out.warn(f"1 % more or less of {key} has no result at the optimum")
            continue
        numbers[f"deviation/size/{key}"] = (size, 0.0)
        numbers[f"deviation/loss/{key}"] = (loss, float(error) + optimum.objective_error)
        if at.limits:
            moved = optimum.variables + np.eye(len(at.keys))[i] * size
            numbers[f"deviation/margin/{key}"] = (margin, _margin_error(at, moved))
    out.add(numbers)
