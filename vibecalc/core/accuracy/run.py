"""A case to the finished measurement of all its methods."""

import importlib.util
import math
import re
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.core.accuracy.environment import machine, versions
from vibecalc.core.accuracy.record import as_record, measured_text, plan_rows
from vibecalc.core.accuracy.topic import Measured, Timed, Topic, measure
from vibecalc.core.results.layout import MEASURED
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Result
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_scene
from vibecalc.core.study.execute import as_result
from vibecalc.errors import NumericalFailure, UsageError

if TYPE_CHECKING:
    from vibecalc.core.case.load import LoadedCase
    from vibecalc.schema import Case

# ----------------------------------------------------------------------------
# Which functions give the topics of a stage; each is imported when it is asked for.
# ----------------------------------------------------------------------------

#: studies above the pipeline -> functions of a loaded case
STUDIES: dict[str, tuple[str, ...]] = {
    "optimisation": ("vibecalc.core.accuracy.frame_topics:optimisation_topics",),
    "find": ("vibecalc.core.accuracy.frame_topics:find_topics",),
}

#: what the tolerance of the case costs, asked of every case
WHOLE_CASE = "whole case"
OF_WHOLE_CASE = "vibecalc.core.accuracy.frame_topics:whole_case_topics"

# ----------------------------------------------------------------------------
# The topics of a case: those of every stage that it has, of its studies, and of its tolerance.
# ----------------------------------------------------------------------------

#: a run that takes longer [s] is not run again at other tolerances
LONGEST_RUN = 5.0
#: a whole case takes so long [s], shared between its questions, and a question at least that much
LONGEST, LEAST = 30.0, 0.2


class Collected(NamedTuple):
    """Topics in the order of the stages, what was left out and why, seconds of the run."""

    topics: tuple[Topic, ...]
    notes: tuple[str, ...]
    timings: dict[str, float]


def stages_of(case: "Case") -> tuple[str, ...]:
    """What can be measured of `case`: its stages, its studies, and the whole of it."""
    stages = [stage.name for stage in plan_case(case)]
    if case.optimisation is not None:
        stages.append("optimisation")
    if case.find:
        stages.append("find")
    return (*stages, WHOLE_CASE)


def chosen(names: Sequence[str], asked: Sequence[str], missing: str, has: str) -> tuple[str, ...]:
    """Those asked for, all without any; blanks, hyphens and underscores are the same.

    Raises UsageError, with the list, for one that is not there.
    """
    wanted, there = {_key(name): name for name in asked}, {_key(name) for name in names}
    for key, name in wanted.items():
        if key not in there:
            raise UsageError(f"{missing} {name[:60]!r}; {has}: {', '.join(names)}")
    return tuple(name for name in names if not asked or _key(name) in wanted)


def collect(loaded: "LoadedCase", stages: Sequence[str]) -> Collected:
    """Run the case as written and ask every module of the table for its topics.

    A case with an optimisation is measured as written, at the start of the search. Raises
    NumericalFailure where the run fails. A module that cannot set up its topics leaves a note.
    """
    case = loaded.case
    timings: dict[str, float] = {}
    found: list[Topic] = []
    notes: list[str] = []
    if set(stages) - set(STUDIES):
        scene = run_scene(case, timings=timings)
        topics = {stage.name: stage.topics for stage in plan_case(case)}
        for stage in stages:
            _add(found, notes, topics.get(stage, ()), stage, scene)
    for study in stages:
        _add(found, notes, STUDIES.get(study, ()), study, loaded)
    if WHOLE_CASE in stages:
        if sum(timings.values()) > LONGEST_RUN:
            notes.append(
                f"what the tolerance costs is left out: a run takes more than {LONGEST_RUN:g} s"
            )
        else:
            _add(found, notes, (OF_WHOLE_CASE,), WHOLE_CASE, case)
    return Collected(tuple(found), tuple(notes), {"run": sum(timings.values())})


def _add(
    found: list[Topic], notes: list[str], topics: Iterable[str], stage: str, given: object
) -> None:
    for where in topics:
        try:
            found += named(where)(given)
        except NumericalFailure as failure:
            notes.append(f"topics of {stage} are left out: {failure}")


def _key(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.strip().lower())


# ----------------------------------------------------------------------------
# How far the measurement is, on stderr and on a terminal only.
# ----------------------------------------------------------------------------


@contextmanager
def shown(trials: int, wanted: bool) -> Iterator[Callable[[], None]]:
    """A bar over all trials; what is yielded is called after each of them."""
    if not (wanted and sys.stderr.isatty()):
        yield lambda: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("measuring"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=trials)
        yield lambda: bar.advance(task)


# ----------------------------------------------------------------------------
# A case to the finished measurement of all its methods.
# ----------------------------------------------------------------------------


class Asked(NamedTuple):
    """What to measure (everything without names) and how; `threads` is what was found of them."""

    stages: Sequence[str] = ()
    topics: Sequence[str] = ()
    longest: float = LONGEST
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
    """Measure every method of the stages of a case over its settings.

    Raises
    ------
    UsageError
        mpmath is missing; there is no time to measure in; the case lacks a stage or topic asked
        for; nothing is to be measured.
    NumericalFailure
        The run fails, or no topic has a reference.
    """
    asked = asked or Asked()
    if not 0.0 < asked.longest < math.inf:
        raise UsageError(f"--longest needs a number of seconds above 0, found {asked.longest:g}")
    check_installed()
    stages = chosen(stages_of(loaded.case), asked.stages, "this case has no stage", "it has")
    found = collect(loaded, stages)
    every = list(dict.fromkeys(topic.name for topic in found.topics))
    names = chosen(every, asked.topics, "there is no topic", "there are")
    topics = [topic for topic in found.topics if topic.name in names]
    notes = list(found.notes)
    if not topics:
        why = "; ".join(notes) or f"there is no question of accuracy for {', '.join(stages)}"
        raise UsageError(f"nothing to measure: {why}")
    done: list[Measured] = []
    timings = dict(found.timings)
    trials = sum(len(solver.settings) for topic in topics for solver in topic.solvers)
    with shown(trials, asked.progress) as advance:
        # the rest is for what is drawn and written
        left = 0.9 * asked.longest - timings["run"]
        for place, topic in enumerate(topics):
            share = max(left / (len(topics) - place), LEAST)
            started = time.process_time()
            try:
                measured = measure(topic, Timed(share), advance)
            except NumericalFailure as failure:
                notes.append(f"{topic.stage}, {topic.name}: no reference: {failure}")
                continue
            finally:
                left -= time.process_time() - started
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
        "longest": asked.longest,
        MEASURED: measured_text(done),
    }
    return replace(result, plan=plan_rows(done), provenance=provenance)
