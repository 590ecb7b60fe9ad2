"""A case to the finished measurement of all its methods."""

import importlib.util
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.accuracy.collect import chosen_stages, chosen_topics, collect
from vibecalc.accuracy.environment import machine, versions
from vibecalc.accuracy.measure import Timed, measure
from vibecalc.accuracy.progress import shown
from vibecalc.accuracy.record import as_record, measured_text, plan_rows
from vibecalc.accuracy.rung import Measured
from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.results.accuracy_layout import MEASURED
from vibecalc.results.record import Result
from vibecalc.study.execute import as_result

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase


class Asked(NamedTuple):
    """What to measure (everything without names) and how; `threads` is what was found of them."""

    stages: Sequence[str] = ()
    topics: Sequence[str] = ()
    timed: Timed = Timed()
    progress: bool = False
    threads: str = ""


def check_installed() -> None:
    """UsageError where the package of the references is missing."""
    if importlib.util.find_spec("mpmath") is None:
        raise UsageError(
            "trusted references need mpmath, which is not installed; "
            "install it with: pip install 'vibecalc[accuracy]'"
        )


def measure_case(loaded: "LoadedCase", asked: Asked | None = None) -> Result:
    """Measure every method of the stages of a case over its ladder of settings.

    Raises
    ------
    UsageError
        mpmath is missing; the case lacks a stage or topic asked for; nothing is to be measured.
    NumericalFailure
        The run fails, or no topic has a reference.
    """
    asked = asked or Asked()
    check_installed()
    stages = chosen_stages(loaded.case, asked.stages)
    found = collect(loaded, stages)
    topics = chosen_topics(found.topics, asked.topics)
    notes = list(found.notes)
    if not topics:
        why = "; ".join(notes) or f"no method has a ladder in {', '.join(stages)} of this case"
        raise UsageError(f"nothing to measure: {why}")
    done: list[Measured] = []
    timings = dict(found.timings)
    rungs = sum(len(ladder.settings) for topic in topics for ladder in topic.ladders)
    with shown(rungs, asked.progress) as advance:
        for topic in topics:
            try:
                measured = measure(topic, asked.timed, advance)
            except NumericalFailure as failure:
                notes.append(f"{topic.stage}, {topic.name}: no reference: {failure}")
                continue
            done.append(measured)
            timings[f"{topic.stage}, {topic.name}"] = measured.seconds
    if not done:
        raise NumericalFailure("; ".join(notes))
    result = as_result(loaded, as_record(done, notes), timings)
    provenance = {
        **result.provenance,
        "machine": machine(),
        "versions": versions(),
        "threads": asked.threads or "as found",
        "longest": asked.timed.longest,
        MEASURED: measured_text(done),
    }
    return _with(result, plan_rows(done), provenance)


def _with(
    result: Result, plan: tuple[dict[str, str], ...], provenance: dict[str, str | int | float]
) -> Result:
    from dataclasses import replace

    return replace(result, plan=plan, provenance=provenance)
