"""Run a case to its optimum: the stage groups hold the optimum, `optimisation/start` the start."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.results.record import Method, Record
from vibecalc.core.run.run import run_case
from vibecalc.core.study.balancing import balance, balances
from vibecalc.core.study.binding import Binding
from vibecalc.core.study.combine import Combined, combine
from vibecalc.core.study.planned import ROOT, search_runs
from vibecalc.core.study.record import (
    Studied,
    add_combinations,
    add_nearest,
    add_optimum,
    add_sensitivity,
)
from vibecalc.core.study.search.problem import Evaluate, Infeasible
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.core.study.search.problem import Optimum
    from vibecalc.schema import Case

#: what a search calls for a binding, counted where somebody looks
Shown = Callable[[Binding], Evaluate]


def optimise(loaded: "LoadedCase", *, timings: dict[str, float], progress: bool = False) -> Record:
    """Search from the case as written and from starts spread over the bounds.

    Returns the record of the optimum with `optimisation/...` added. Where no point keeps the
    limits it is that of the point that comes nearest, and says so as its `failure`. Raises
    NumericalFailure if no search ends in a point that can be shown to be an optimum.
    """
    case, binding = loaded.case, Binding(loaded)
    as_written, started = binding, time.perf_counter()
    combined: Combined | None = None
    optimum: Optimum | None = None
    with _shown(case, progress) as shown:
        balanced = balance(binding, case) if balances(case) else None
        try:
            if balanced is not None and balanced.allowed:
                optimum = balanced.optimum
            elif binding.choices:
                combined = combine(binding, case, partial(_searched, case, shown), shown)
                binding = binding.with_picked(combined.best.picked)
                optimum = combined.optimum()
            else:
                # where the optimum without limits is known, also from there
                further = None if balanced is None else balanced.optimum.variables[None, :]
                optimum = _searched(case, shown, binding, further)
            variables = optimum.variables
        except Infeasible as failure:
            nearest, variables = failure, failure.variables
        except NumericalFailure as error:
            parts = [f"variables: {', '.join(binding.keys)} (SI)"]
            parts += [f"margin {i}: {name}" for i, name in enumerate(binding.margin_names())]
            raise NumericalFailure(f"{error} Here {'; '.join(parts)}.") from error
    seconds = time.perf_counter() - started
    record = run_case(binding.case_at(variables), timings=timings)
    timings["optimisation"] = seconds
    out = Studied(record, case, timings, binding, as_written)
    if optimum is None:
        _say_nearest(out, nearest)
    else:
        add_optimum(out, optimum)
        if balanced is not None:
            out.add({"lower_bound": (balanced.lower_bound, 0.0)})
        if optimum.failures:
            why = "; ".join(optimum.failure_messages[:3])
            points = f"{optimum.failures} of {optimum.evaluations} points"
            out.warn(f"{points} could not be evaluated: {why}")
        record.warnings += [note for note in optimum.notes if note not in record.warnings]
    if combined is not None:
        add_combinations(out, combined)
    _add_start(record, as_written)
    if optimum is not None:
        _add_further(out, optimum)
    return record


def _add_further(out: Studied, optimum: "Optimum") -> None:
    """What the study asks for beside its optimum."""
    if out.study.robust:
        from vibecalc.core.study.robust import add_robust

        add_robust(out, optimum.variables)
    out.record.methods.append(_CONVEX if optimum.method == "convex" else _SEARCH)
    if out.study.sensitivity:
        with out.timed("sensitivity"):
            add_sensitivity(out, optimum)
    if out.study.second_objective:
        from vibecalc.core.study.fronts import add_front

        add_front(out, optimum.variables)


def _searched(
    case: "Case", shown: Shown, binding: Binding, further: np.ndarray | None
) -> "Optimum":
    """The search from the case as written, `further` (k, n) and the starts of the case."""
    from vibecalc.core.study.search.minimise import minimise

    study = case.optimisation
    assert study is not None
    problem = replace(binding.problem(), evaluate=shown(binding))
    return minimise(problem, study.starts, further=further, rtol=case.accuracy.rtol)


def _say_nearest(out: Studied, nearest: Infeasible) -> None:
    """That all results are those of the point that comes nearest to keeping the limits."""
    words = out.binding.broken(nearest.variables)
    add_nearest(out, nearest)
    out.record.failure = "no values of the variables between their bounds keep all limits"
    out.record.warnings.insert(
        0,
        f"{out.record.failure}; these come nearest, and all results are theirs: "
        f"{out.binding.words(nearest.variables)}. {words}. Widen the bounds of the variables or "
        "relax these limits.",
    )


_CONVEX = Method(
    name="linear least squares within bounds, by Newton's method along a barrier",
    purpose="optimum, proven by its dual",
    citation="Boyd and Vandenberghe, Convex Optimization, 2004, ch. 5 and 11",
)
_SEARCH = Method(
    name="sequential quadratic programming from many starts, refined by Newton's method",
    purpose="constrained optimum",
    citation="Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, ch. 12 and 18",
)


def _add_start(record: Record, binding: Binding) -> None:
    """What the case as written gives; a start that has no result is said, not fatal."""
    try:
        start = run_case(binding.case_at(binding.first))
    except NumericalFailure as error:
        record.warnings.append(f"{ROOT}/start is left out, the case as written fails: {error}")
        return
    for path, quantity in start.items():
        record.add(replace(quantity, path=f"{ROOT}/start/{path}"))
    warnings = [f"at the start: {text}" for text in start.warnings]
    record.warnings += [text for text in warnings if text not in record.warnings]


@contextmanager
def _shown(case: "Case", wanted: bool) -> Iterator[Shown]:
    """Count evaluations on stderr while they run, with the best objective so far."""
    best = np.inf
    with counted("optimising", wanted, search_runs(case)) as advance:

        def shown(binding: Binding) -> Evaluate:
            def evaluate(variables: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
                nonlocal best
                objective, margins = binding.evaluate(variables)
                if np.max(objective) < best and all((one >= 0.0).all() for one in margins):
                    best = float(np.max(objective))
                advance(f", best {binding.sign * best:.6g}" if np.isfinite(best) else "")
                return objective, margins

            return evaluate

        yield shown
