"""Solve for the changes that bring wanted results: what [[find]] in a case asks for."""

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.pipeline.stage_cache import StageCache
from vibecalc.results.record import Axis, Method, Quantity, Record
from vibecalc.study.find_along import Along
from vibecalc.study.find_choice import Choice, choose
from vibecalc.study.find_paths import MACHINE, ROOT, find_entries, machine_paths
from vibecalc.study.sweep.place import NOT_COMPUTED
from vibecalc.study.variables import period_of

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase

#: of the way to the farther bound, for slopes at the key found
_STEP = 1e-4
_CITATION = "Brent, Algorithms for Minimization without Derivatives, 1973, ch. "


def add_found(
    record: Record, loaded: "LoadedCase", *, timings: dict[str, float], progress: bool = False
) -> None:
    """Add `find/...` of all searches to the record of the case as written.

    A search that fails, where nothing between the bounds brings what is wanted or no point can be
    computed, leaves a warning, and what the others found stands. Raises NumericalFailure, with all
    of them, where none found anything.
    """
    started = time.perf_counter()
    resolved = {k: v for k, v in loaded.resolved.items() if k not in NOT_COMPUTED}
    cache = StageCache()  # searches along different keys share the stages that these do not touch
    chosen: list[tuple[Along, Choice]] = []
    failures: list[str] = []
    with _shown(progress) as count:
        for search in loaded.case.find:
            period = period_of(search.key, loaded.case.machine)
            along = Along(search, resolved, cache, count, period)
            try:
                choice = choose(along, along.read(record), record[search.quantity].unit)
            except NumericalFailure as failure:
                failures.append(f"find {search.name!r}: {failure}")
            else:
                chosen.append((along, choice))
    if not chosen:
        raise NumericalFailure("; ".join(failures))
    record.warnings += failures
    entries = find_entries(loaded.case)
    for along, choice in chosen:
        name = along.search.name
        for path, (value, error) in _numbers(along, choice).items():
            entry = entries[f"{ROOT}/{name}/{path}"]
            solutions = np.arange(1, len(choice.others) + 1)
            record.add(
                Quantity(
                    path=entry.path,
                    values=np.asarray(value),
                    unit=entry.unit,
                    long_name=entry.long_name,
                    axes=tuple(Axis(name=axis, values=solutions) for axis in entry.axes),
                    amplitude=entry.amplitude,
                    error_estimate=error,
                )
            )
        _add_machine(record, along, choice, machine_paths(loaded.case, along.search))
        record.warnings += [f"find {name!r}: {note}" for note in choice.notes]
    seeks = [along.search.seek is not None for along, _ in chosen]
    if not all(seeks):
        record.methods.append(_method("root finding", "values that bring a wanted result", "4"))
    if any(seeks):
        record.methods.append(_method("minimisation", "extremes along a key", "5"))
    timings[ROOT] = time.perf_counter() - started


def _add_machine(record: Record, along: Along, choice: Choice, paths: tuple[str, ...]) -> None:
    """Results of the machine that was found, beside those of the case as written.

    Their errors count that of the key, by the slope towards the farther bound.
    """
    root, wanted = f"{ROOT}/{along.search.name}/{MACHINE}", frozenset(paths)
    key, error = choice.solution.sample.key, choice.solution.error
    far = along.upper if along.upper - key > key - along.lower else along.lower
    step = _STEP * (far - key)
    try:
        found, beside = along.results(key, wanted), along.results(key + step, wanted)
    except NumericalFailure as failure:  # of what was not sought
        record.warnings.append(f"{root} is left out: {failure}")
        return
    for path, quantity in found.items():
        moved = abs(beside[path].values - quantity.values) if path in beside else 0.0
        doubt = quantity.error_estimate + float(moved) * abs(error / step)
        record.add(replace(quantity, path=f"{root}/{path}", error_estimate=doubt))


def _numbers(along: Along, choice: Choice) -> dict[str, tuple[Any, float]]:
    """Names below `find/<name>/` with value and absolute error."""
    (sample, error), others = choice.solution, choice.others
    numbers: dict[str, tuple[Any, float]] = {"value": (sample.key, error)}
    is_written = math.isfinite(along.written)
    if is_written and along.written != 0.0:
        numbers["ratio"] = (sample.key / along.written, error / abs(along.written))
    numbers["reached"] = (sample.value, sample.error)
    if choice.level is not None:
        numbers["wanted"] = (choice.level.wanted, choice.level.doubt)
    if is_written:
        numbers["written"] = (along.written, 0.0)
    numbers["others"] = (
        np.array([other.sample.key for other in others], dtype=float),
        max((other.error for other in others), default=0.0),
    )
    numbers["others_reached"] = (
        np.array([other.sample.value for other in others], dtype=float),
        max((other.sample.error for other in others), default=0.0),
    )
    for key, value in along.changed(sample.key).items():
        if key != along.search.key:
            numbers[f"also/{key}"] = (value, error * abs(value / sample.key))
    numbers["evaluations"] = (choice.course.evaluations, 0.0)
    numbers["failures"] = (len(choice.course.failed()), 0.0)
    return numbers


def _method(what: str, purpose: str, chapter: str) -> Method:
    name = f"Brent's {what} on brackets between samples along a key"
    return Method(name=name, purpose=purpose, citation=_CITATION + chapter)


@contextmanager
def _shown(wanted: bool) -> Iterator[Callable[[], None]]:
    """Count runs on stderr while the searches go on, on a terminal only."""
    if not (wanted and sys.stderr.isatty()):
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (
        SpinnerColumn(),
        TextColumn("finding: {task.completed:.0f} runs"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None)
        yield lambda: bar.advance(task)
