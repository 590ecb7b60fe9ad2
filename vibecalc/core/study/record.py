"""What an optimisation puts into its record: the optimum, what was picked, slopes, deviations."""

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.results.record import Method, Record
from vibecalc.core.study.choices import in_words
from vibecalc.core.study.combine import MOST_KEPT
from vibecalc.core.study.planned import ROOT, optimisation_entries
from vibecalc.core.study.search.sensitivity import cost_of_deviation, slopes_at
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.study.binding import Binding
    from vibecalc.core.study.combine import Combined
    from vibecalc.core.study.search.problem import Infeasible, Optimum

#: name below `optimisation/` -> value and absolute error
Numbers = dict[str, tuple[Any, float]]


class Studied:
    """The record of an optimum, and the binding of what is picked there.

    `as_written` is the binding of the case, which may have other options.
    """

    def __init__(self, record: Record, binding: "Binding"):
        self.record, self.binding, self.study = record, binding, binding.study
        self.as_written = binding.with_picked(())
        self._entries = optimisation_entries(binding.case)
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

    def add_variables(self, root: str, values: np.ndarray, errors: np.ndarray, **axes: Any) -> None:
        """Add `root/<key>` for each variable, of which `values` has the last axis."""
        rows = zip(self.binding.keys, values.T, errors, strict=True)
        self.add({f"{root}/{key}": (value, float(error)) for key, value, error in rows}, **axes)

    def signed(self, objectives: Sequence[float]) -> np.ndarray:
        """Objectives as they are asked for; infinite where there is none."""
        given = np.array(objectives)
        return np.where(np.isfinite(given), self.binding.sign * given, np.inf)

    def warn(self, words: str) -> None:
        """Say something of the study, once."""
        if words not in self.record.warnings:
            self.record.warnings.append(words)

    def margin_error(self, variables: np.ndarray) -> float:
        """Error of the margins at a point; none where it has no result."""
        with suppress(NumericalFailure):
            return float(np.max(self.binding.evaluate(variables)[2][1:], initial=0.0))
        return 0.0


def add_optimum(out: Studied, optimum: "Optimum") -> None:
    """The optimum, what holds it, how the searches ended, and what is to be said of it."""
    binding, searches, optima = out.binding, optimum.history, optimum.optima
    # the objective is a result too, and as uncertain as that
    goal = out.record[binding.goal.quantity]
    off = max(optimum.objective_error, float(goal.error_estimate))
    values: Numbers = {
        "objective": (binding.sign * optimum.objective, off),
        "kkt_residual": (optimum.kkt_residual, 0.0),
        "evaluations": (optimum.evaluations, 0.0),
        "failures": (optimum.failures, 0.0),
        "history/objective": (out.signed([one.objective for one in searches]), off),
        "history/feasible": ([int(one.feasible) for one in searches], 0.0),
        "history/evaluations": ([one.evaluations for one in searches], 0.0),
        "optima/objective": (out.signed([one.objective for one in optima]), off),
        "optima/found_by": ([one.found_by for one in optima], 0.0),
    }
    if binding.held:
        values["margin"] = (optimum.margins, out.margin_error(optimum.variables))
        # slopes are known ten times worse, relatively, than the variables
        size, prices = np.abs(optimum.variables), optimum.margin_multipliers
        unsure = np.max(optimum.variables_error[size > 0.0] / size[size > 0.0], initial=0.0)
        error = (optimum.kkt_residual + 10.0 * unsure) * np.max(prices, initial=0.0)
        values["multiplier"] = (prices, float(error))
    count, exact = len(binding.keys), np.zeros(len(binding.keys))
    axes = {"search": np.arange(1, 1 + len(searches)), "optimum": np.arange(1, 1 + len(optima))}
    out.add(values, **axes)
    out.add_variables("variable", optimum.variables, optimum.variables_error)
    out.add_variables("active_bound", optimum.active_bounds, exact)
    for name in ("start", "end"):
        places = np.array([getattr(one, name) for one in searches]).reshape(len(searches), count)
        out.add_variables(f"history/{name}", places, exact, **axes)
    if optimum.failures:
        why = "; ".join(optimum.failure_messages[:3])
        points = f"{optimum.failures} of {optimum.evaluations} points"
        out.warn(f"{points} could not be evaluated: {why}")
    for note in optimum.notes:
        out.warn(note)


def add_combinations(out: Studied, combined: "Combined") -> None:
    """What was picked, and the combinations examined, best first."""
    picked = combined.best.picked
    ranked = sorted(combined.examined, key=lambda one: one.rank)[:MOST_KEPT]
    ends = [one.optimum for one in ranked]
    off = max((end.objective_error for end in ends if end), default=0.0)
    objectives = [end.objective if end else np.inf for end in ends]
    numbers: Numbers = {
        "combinations/possible": (combined.possible, 0.0),
        "combinations/examined": (len(combined.examined), 0.0),
        "combinations/kept": (sum(one.optimum is not None for one in combined.examined), 0.0),
        "combinations/objective": (out.signed(objectives), off),
        "combinations/feasible": ([int(end is not None) for end in ends], 0.0),
        "combinations/evaluations": ([one.evaluations for one in ranked], 0.0),
    }
    for place, choice in enumerate(combined.choices):
        numbers[choice.path] = (choice.value(picked[place]), 0.0)
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
    """That all results are those of the point that comes nearest to keeping the limits."""
    binding, variables = out.binding, nearest.variables
    out.add({
        "margin": (binding.worst(variables)[1], out.margin_error(variables)),
        "evaluations": (nearest.evaluations, 0.0),
    })  # fmt: skip
    out.add_variables("variable", variables, np.zeros(variables.size))
    out.record.failure = "no values of the variables between their bounds keep all limits"
    out.record.warnings.insert(
        0,
        f"{out.record.failure}; these come nearest, all results are for them: "
        f"{binding.words(variables)}. {binding.broken(variables)}. Widen the bounds of the "
        "variables or relax these limits.",
    )


# ----------------------------------------------------------------------------
# Slopes of the objective at the start and at the optimum, and what small deviations cost.
# ----------------------------------------------------------------------------


def add_sensitivity(out: Studied, optimum: "Optimum") -> None:
    """Add `optimisation/sensitivity/<key>`, `optimisation/deviation/...` and the gain.

    What has no value, as a slope on a kink, is left out and said.
    """
    written, at = out.as_written, out.binding
    slopes: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for name, here, point in (
        ("start", written, written.first),
        ("optimum", at, optimum.variables),
    ):
        if out.study.sensitivity in (name, "both"):
            try:
                slopes[name] = slopes_at(here.problem(), point)
            except NumericalFailure as failure:
                out.warn(f"no slopes of the objective at the {name}: {failure}")
    for i, key in enumerate(at.keys):
        known = [name for name, (slope, _) in slopes.items() if np.isfinite(slope[i])]
        if len(known) < len(slopes):
            lost = " and the ".join(name for name in slopes if name not in known)
            out.warn(
                f"the slope of the objective by {key} is undefined at the {lost}: kink, or no "
                "neighbouring values"
            )
        if known:
            values = np.array([slopes[name][0][i] for name in known])
            error = max(slopes[name][1][i] for name in known)
            point = np.array(known, dtype=object)
            out.add({f"sensitivity/{key}": (at.sign * values, error)}, point=point)
    if out.study.sensitivity != "start":
        _add_deviations(out, optimum)
    with suppress(NumericalFailure):  # said with `optimisation/start`
        start, _, off = written.evaluate(written.first)
        error = optimum.objective_error + float(off[0])
        out.add({"gain": (float(np.max(start)) - optimum.objective, error)})


def _add_deviations(out: Studied, optimum: "Optimum") -> None:
    at = out.binding
    rows = cost_of_deviation(at.problem(), optimum.variables)
    for i, (key, (size, loss, error, margin)) in enumerate(zip(at.keys, rows, strict=True)):
        if np.isnan(loss):
            out.warn(f"1 % more or less of {key} has no result at the optimum")
            continue
        numbers: Numbers = {
            f"deviation/size/{key}": (size, 0.0),
            f"deviation/loss/{key}": (loss, float(error) + optimum.objective_error),
        }
        if at.held:
            moved = optimum.variables + np.eye(len(at.keys))[i] * size
            numbers[f"deviation/margin/{key}"] = (margin, out.margin_error(moved))
        out.add(numbers)
