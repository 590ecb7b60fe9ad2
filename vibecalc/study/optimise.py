"""Run a case to its optimum: the stage groups hold the optimum, `optimisation/start` the start."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.pipeline.run import run_case
from vibecalc.results.record import Method, Record
from vibecalc.study.binding import Binding
from vibecalc.study.compare_methods import compare_methods
from vibecalc.study.optimise_paths import ROOT
from vibecalc.study.optimise_record import add_optimum
from vibecalc.study.pareto import add_front
from vibecalc.study.sensitivity import add_sensitivity

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase

#: the method of a case that names none
STANDARD = "sequential_quadratic"

Evaluate = Callable[[np.ndarray], tuple[float, np.ndarray]]


def optimise(loaded: "LoadedCase", *, timings: dict[str, float], progress: bool = False) -> Record:
    """Search from the case as written and from starts spread over the bounds.

    Returns the record of the optimum with `optimisation/...` added. Raises NumericalFailure if no
    point keeps the limits or no search ends in a point that can be shown to be an optimum.
    """
    from vibecalc.optimisation.constrained import minimise

    study = loaded.case.optimisation
    if study is None:
        raise ValueError("the case has no [optimisation]")
    binding = Binding(loaded)
    started = time.perf_counter()
    with _shown(binding.evaluate, progress) as evaluate:
        with suppress(NumericalFailure):
            binding.evaluate(binding.first)
        try:
            found = minimise(
                evaluate,
                binding.lower,
                binding.upper,
                first=binding.first,
                starts=study.starts,
                rtol=loaded.case.accuracy.rtol,
                accuracy=binding.accuracy,
                method=study.method or STANDARD,
            )
        except NumericalFailure as error:
            raise NumericalFailure(f"{error} {_legend(binding)}") from error
    seconds = time.perf_counter() - started
    record = run_case(binding.case_at(found.variables), timings=timings)
    timings["optimisation"] = seconds
    add_optimum(record, loaded.case, binding, found)
    if found.failures:
        why = "; ".join(found.failure_messages[:3])
        record.warnings.append(
            f"{found.failures} of {found.evaluations} points could not be evaluated: {why}"
        )
    record.warnings += [note for note in found.notes if note not in record.warnings]
    _add_start(record, binding)
    record.methods.append(_method(study.method))
    for asked, part in (
        (study.compare, compare_methods),
        (study.sensitivity, add_sensitivity),
        (study.second_objective, add_front),
    ):
        if asked:
            part(record, loaded.case, binding, found, timings)
    return record


def _method(name: str | None) -> Method:
    from vibecalc.optimisation.methods import METHODS

    method = METHODS[name or STANDARD]
    starts = "" if method.everywhere else " from many starts"
    refined = "" if name in (None, STANDARD) else "; refined: Nocedal and Wright 2006, ch. 12, 18"
    citation = "Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, ch. 12 and 18"
    return Method(
        name=f"{method.words}{starts}, refined by Newton's method",
        purpose="constrained optimum",
        citation=method.citation + refined if refined else citation,
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


def _legend(binding: Binding) -> str:
    """What the numbers in a message of the search stand for."""
    parts = [f"variables: {', '.join(binding.keys)} (SI)"]
    parts += [f"margin {i}: {name}" for i, name in enumerate(binding.margin_names())]
    return f"Here {'; '.join(parts)}."


@contextmanager
def _shown(evaluate: Evaluate, wanted: bool) -> Iterator[Evaluate]:
    """Count evaluations on stderr while they run, on a terminal only."""
    if not (wanted and sys.stderr.isatty()):
        yield evaluate
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(),
        TextColumn("optimising: {task.completed:.0f} runs, best {task.fields[best]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, best="none yet")
        best = np.inf

        def counted(variables: np.ndarray) -> tuple[float, np.ndarray]:
            nonlocal best
            objective, margins = evaluate(variables)
            if objective < best and (margins >= 0.0).all():
                best = objective
            shown = f"{abs(best):.6g}" if np.isfinite(best) else "none yet"
            bar.update(task, advance=1, best=shown)
            return objective, margins

        yield counted
