"""Run a case to its optimum: the stage groups hold the optimum, `optimisation/start` the start."""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from vibecalc.core.case.load import LoadedCase
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
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Infeasible, Optimum
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure


def optimise(loaded: LoadedCase, *, timings: dict[str, float], progress: bool = False) -> Record:
    """Search from the case as written and from starts spread over the bounds.

    Returns the record of the optimum with `optimisation/...` added. Where no point keeps the
    limits it is that of the point that comes nearest, and says so as its `failure`. Raises
    NumericalFailure if no search ends in a point that can be shown to be an optimum.
    """
    case, binding, started = loaded.case, Binding(loaded), time.perf_counter()
    study, rtol = binding.study, case.accuracy.rtol
    combined: Combined | None = None
    end: Optimum | Infeasible

    def search(binding: Binding, further: np.ndarray | None) -> Optimum:
        """From the case as written, `further` starts (k, n) and those of the case."""
        return minimise(binding.problem(), study.starts, further=further, rtol=rtol)

    with counted("optimising", progress, search_runs(case)) as advance:
        binding.shown = _with_the_best(advance, binding.sign)
        balanced = balance(binding) if balances(case) else None
        try:
            if balanced is not None and balanced[2]:
                end = balanced[0]
            elif binding.choices:
                combined = combine(binding, study, search)
                binding = binding.with_picked(combined.best.picked)
                end = combined.optimum()
            else:
                # where the optimum without limits is known, also from there
                further = None if balanced is None else balanced[0].variables[None, :]
                end = search(binding, further)
        except Infeasible as failure:
            end = failure
        except NumericalFailure as error:
            parts = [f"variables: {', '.join(binding.keys)} (SI)"]
            parts += [f"margin {i}: {name}" for i, name in enumerate(binding.margin_names())]
            raise NumericalFailure(f"{error} Here {'; '.join(parts)}.") from error
    seconds = time.perf_counter() - started
    record = run_case(binding.case_at(end.variables), timings=timings)
    timings["optimisation"] = seconds
    out = Studied(record, binding)
    if isinstance(end, Infeasible):
        add_nearest(out, end)
    else:
        add_optimum(out, end)
        if balanced is not None:
            out.add({"lower_bound": (balanced[1], 0.0)})
    if combined is not None:
        add_combinations(out, combined)
    _add_start(out)
    if isinstance(end, Optimum):
        _add_further(out, end, timings)
    return record


def _with_the_best(advance: Callable[[str], None], sign: float) -> Callable[[float, bool], None]:
    """What counts evaluations on stderr while they run, with the best objective so far."""
    best = np.inf

    def shown(objective: float, keeps: bool) -> None:
        nonlocal best
        if keeps and objective < best:
            best = objective
        advance(f", best {sign * best:.6g}" if np.isfinite(best) else "")

    return shown


def _add_start(out: Studied) -> None:
    """What the case as written gives; a start that has no result is said, not fatal."""
    try:
        start = run_case(out.as_written.case_at(out.as_written.first))
    except NumericalFailure as error:
        out.warn(f"{ROOT}/start is left out, the case as written fails: {error}")
        return
    for path, quantity in start.items():
        out.record.add(replace(quantity, path=f"{ROOT}/start/{path}"))
    for text in start.warnings:
        out.warn(f"at the start: {text}")


def _add_further(out: Studied, optimum: Optimum, timings: dict[str, float]) -> None:
    """What the study asks for beside its optimum."""
    if out.study.robust:
        from vibecalc.core.study.robust import add_robust

        add_robust(out, optimum.variables)
    out.record.methods.append(_CONVEX if optimum.method == "convex" else _SEARCH)
    if out.study.sensitivity:
        started = time.perf_counter()
        add_sensitivity(out, optimum)
        timings["sensitivity"] = time.perf_counter() - started
    if out.study.second_objective:
        from vibecalc.core.study.fronts import add_front

        started = time.perf_counter()
        add_front(out, optimum.variables)
        timings["front"] = time.perf_counter() - started


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
