"""Run a case to its optimum: the stage groups hold the optimum, `optimisation/start` the start."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.pipeline.run import run_case
from vibecalc.results.record import Axis, Method, Quantity, Record
from vibecalc.study.binding import Binding
from vibecalc.study.optimise_paths import ROOT, optimisation_entries

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase
    from vibecalc.case.schema import Case
    from vibecalc.optimisation.optimum import Optimum

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
            )
        except NumericalFailure as error:
            raise NumericalFailure(f"{error} {_legend(binding)}") from error
    seconds = time.perf_counter() - started
    record = run_case(binding.case_at(found.variables), timings=timings)
    timings["optimisation"] = seconds
    _add_optimum(record, loaded.case, binding, found)
    if found.failures:
        why = "; ".join(found.failure_messages[:3])
        record.warnings.append(
            f"{found.failures} of {found.evaluations} points could not be evaluated: {why}"
        )
    record.warnings += [note for note in found.notes if note not in record.warnings]
    _add_start(record, binding)
    record.methods.append(
        Method(
            name="sequential quadratic programming from many starts, refined by Newton's method",
            purpose="constrained optimum",
            citation="Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, ch. 12 and 18",
        )
    )
    return record


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


def _add_optimum(record: Record, case: "Case", binding: Binding, found: "Optimum") -> None:
    searches, optima = found.history, found.optima
    axes = {
        "search": np.arange(1, len(searches) + 1),
        "optimum": np.arange(1, len(optima) + 1),
        "limit": np.array(binding.margin_names(), dtype=object),
    }
    values: dict[str, tuple[Any, float]] = {
        "objective": (binding.sign * found.objective, found.objective_error),
        "kkt_residual": (found.kkt_residual, 0.0),
        "evaluations": (found.evaluations, 0.0),
        "failures": (found.failures, 0.0),
        "history/objective": (
            [_known(binding.sign * s.objective) for s in searches],
            found.objective_error,
        ),
        "history/feasible": ([int(s.feasible) for s in searches], 0.0),
        "history/evaluations": ([s.evaluations for s in searches], 0.0),
        "optima/objective": ([binding.sign * o.objective for o in optima], found.objective_error),
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
    entries = optimisation_entries(case)
    for name, (value, error) in values.items():
        entry = entries[f"{ROOT}/{name}"]
        record.add(
            Quantity(
                path=entry.path,
                values=np.asarray(value),
                unit=entry.unit,
                long_name=entry.long_name,
                axes=tuple(Axis(name=axis, values=axes[axis]) for axis in entry.axes),
                amplitude=entry.amplitude,
                error_estimate=error,
            )
        )


def _legend(binding: Binding) -> str:
    """What the numbers in a message of the search stand for."""
    parts = [f"variables: {', '.join(binding.keys)} (SI)"]
    parts += [f"margin {i}: {name}" for i, name in enumerate(binding.margin_names())]
    return f"Here {'; '.join(parts)}."


def _price_error(found: "Optimum") -> float:
    """Error of the multipliers: slopes known ten times worse, relatively, than the variables."""
    size = np.abs(found.variables)
    doubt = np.max(found.variables_error[size > 0.0] / size[size > 0.0], initial=0.0)
    largest = np.max(np.abs(found.margin_multipliers), initial=0.0)
    return float(largest * (found.kkt_residual + 10.0 * doubt))


def _known(objective: float) -> float:
    """A start that could not be evaluated has no objective: infinitely bad, never NaN."""
    return objective if np.isfinite(objective) else np.inf


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
