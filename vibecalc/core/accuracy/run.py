"""A case to the finished measurement of all its methods."""

import importlib.util
import math
import re
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from vibecalc.core.accuracy.environment import machine, versions
from vibecalc.core.accuracy.record import as_record, measured_text, plan_rows
from vibecalc.core.accuracy.topic import Measured, Topic, measure
from vibecalc.core.case.load import LoadedCase
from vibecalc.core.results.layout import MEASURED
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Result
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_scene
from vibecalc.core.study.execute import as_result
from vibecalc.core.study.variables import counted
from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# The topics of a case: those of every stage that it has, of its studies, and of its tolerance.
# ----------------------------------------------------------------------------

#: what the tolerance of the case costs, asked of every case
WHOLE_CASE = "whole case"
#: what is above the pipeline -> functions of a loaded case; those of a stage take its scene
STUDIES: dict[str, tuple[str, ...]] = {
    "optimisation": ("vibecalc.core.accuracy.frame_topics:optimisation_topics",),
    "find": ("vibecalc.core.accuracy.frame_topics:find_topics",),
    WHOLE_CASE: ("vibecalc.core.accuracy.frame_topics:whole_case_topics",),
}

#: a run that takes longer [s] is not run again at other tolerances
LONGEST_RUN = 5.0
#: a whole case takes so long [s], shared between its questions, and a question at least that much
LONGEST, LEAST = 30.0, 0.2


class Collected(NamedTuple):
    """Topics in the order of the stages, what was left out and why, seconds of the run."""

    topics: list[Topic]
    notes: list[str]
    seconds: float


def stages_of(case: Case) -> tuple[str, ...]:
    """What can be measured of `case`: its stages, its studies, and the whole of it."""
    asked = {"optimisation": case.optimisation is not None, "find": bool(case.find)}
    stages = [stage.name for stage in plan_case(case)]
    return (*stages, *(name for name, there in asked.items() if there), WHOLE_CASE)


def chosen(names: Sequence[str], asked: Sequence[str], missing: str, has: str) -> tuple[str, ...]:
    """Those asked for, all without any; blanks, hyphens and underscores are the same.

    Raises UsageError, with the list, for one that is not there.
    """
    wanted, there = {_key(name): name for name in asked}, {_key(name) for name in names}
    for key, name in wanted.items():
        if key not in there:
            raise UsageError(f"{missing} {name[:60]!r}; {has}: {', '.join(names)}")
    return tuple(name for name in names if not asked or _key(name) in wanted)


def collect(loaded: LoadedCase, stages: Sequence[str]) -> Collected:
    """Run the case as written and ask every stage for its topics.

    A case with an optimisation is measured as written, at the start of the search. Raises
    NumericalFailure where the run fails. A stage that cannot set up its topics leaves a note.
    """
    timings: dict[str, float] = {}
    topics: list[Topic] = []
    notes: list[str] = []
    asked = {stage.name: stage.topics for stage in plan_case(loaded.case)} | STUDIES
    scene = None
    if set(stages) - {"optimisation", "find"}:
        scene = run_scene(loaded.case, timings=timings)
    seconds = sum(timings.values())
    for stage in stages:
        if stage == WHOLE_CASE and seconds > LONGEST_RUN:
            notes.append(
                f"cost of the tolerance not measured: a run takes more than {LONGEST_RUN:g} s"
            )
            continue
        for where in asked[stage]:
            try:
                found = named(where)(loaded if stage in STUDIES else scene)
            except NumericalFailure as failure:
                notes.append(f"topics of {stage} are left out: {failure}")
            else:
                topics += [topic._replace(stage=stage) for topic in found]
    return Collected(topics, notes, seconds)


def _key(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.strip().lower())


# ----------------------------------------------------------------------------
# A case to the finished measurement of all its methods.
# ----------------------------------------------------------------------------


def check_installed() -> None:
    """UsageError where the package of the references is missing."""
    if importlib.util.find_spec("mpmath") is None:
        raise UsageError(
            "trusted references need mpmath, which is not installed; "
            "install it with: pip install 'vibecalc[accuracy]'"
        )


def measure_case(
    loaded: LoadedCase,
    stages: Sequence[str] = (),
    topics: Sequence[str] = (),
    *,
    longest: float = LONGEST,
    progress: bool = False,
    threads: str = "as found",
) -> Result:
    """Measure every method of the stages and topics asked for (all without names) of a case.

    `longest` is the time in s for the whole case; `threads` is what was found of them.

    Raises
    ------
    UsageError
        mpmath is missing; there is no time to measure in; the case lacks a stage or topic asked
        for; nothing is to be measured.
    NumericalFailure
        The run fails, or no topic has a reference.
    """
    if not 0.0 < longest < math.inf:
        raise UsageError(f"--longest needs a number of seconds above 0, found {longest:g}")
    check_installed()
    stages = chosen(stages_of(loaded.case), stages, "this case has no stage", "it has")
    found = collect(loaded, stages)
    every = list(dict.fromkeys(topic.ask.name for topic in found.topics))
    names = chosen(every, topics, "there is no topic", "there are")
    asked, notes = [topic for topic in found.topics if topic.ask.name in names], found.notes
    if not asked:
        why = "; ".join(notes) or f"there is no question of accuracy for {', '.join(stages)}"
        raise UsageError(f"nothing to measure: {why}")
    done: list[Measured] = []
    with counted("measuring", progress) as advance:
        # the rest is for what is drawn and written
        end = time.process_time() + 0.9 * longest - found.seconds
        for place, topic in enumerate(asked):
            share = max((end - time.process_time()) / (len(asked) - place), LEAST)
            try:
                done.append(measure(topic, share, advance=advance))
            except NumericalFailure as failure:
                notes.append(f"{topic.stage}, {topic.ask.name}: no reference: {failure}")
    if not done:
        raise NumericalFailure("; ".join(notes))
    timings = {f"{one.topic.stage}, {one.topic.ask.name}": one.seconds for one in done}
    result = as_result(loaded, as_record(done, notes), {"run": found.seconds} | timings)
    provenance = {
        **result.provenance,
        "machine": machine(),
        "versions": versions(),
        "threads": threads,
        "longest": longest,
        MEASURED: measured_text(done),
    }
    return replace(result, plan=plan_rows(done), provenance=provenance)
