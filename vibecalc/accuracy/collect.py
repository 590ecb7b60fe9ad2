"""The topics of a case: those of every stage that it has, of its studies, and of its tolerance."""

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from vibecalc.accuracy.table import OF_WHOLE_CASE, STUDIES, TOPICS, WHOLE_CASE
from vibecalc.accuracy.topic import Topic
from vibecalc.errors import NumericalFailure, UsageError
from vibecalc.pipeline.plan import plan_case
from vibecalc.pipeline.run import run_scene
from vibecalc.results.named import named

if TYPE_CHECKING:
    from vibecalc.case.load import LoadedCase
    from vibecalc.case.schema import Case

#: a run that takes longer [s] is not run again at other tolerances
LONGEST_RUN = 5.0


class Collected(NamedTuple):
    """Topics in the order of the stages, what was left out and why, seconds of the run."""

    topics: tuple[Topic, ...]
    notes: tuple[str, ...]
    timings: dict[str, float]


def stages_of(case: "Case") -> tuple[str, ...]:
    """What can be measured of `case`: its stages, its studies, and the whole of it."""
    stages = [stage.stage for stage in plan_case(case)]
    if case.optimisation is not None:
        stages.append("optimisation")
    if case.find:
        stages.append("find")
    return (*stages, WHOLE_CASE)


def chosen_stages(case: "Case", asked: Sequence[str]) -> tuple[str, ...]:
    """Those asked for, all without any; blanks, hyphens and underscores are the same.

    Raises UsageError, with the list, for a stage that the case does not have.
    """
    stages = stages_of(case)
    if not asked:
        return stages
    by_key = {_key(stage): stage for stage in stages}
    unknown = [name for name in asked if _key(name) not in by_key]
    if unknown:
        raise UsageError(f"this case has no stage {unknown[0][:40]!r}; it has: {', '.join(stages)}")
    wanted = {_key(name) for name in asked}
    return tuple(stage for stage in stages if _key(stage) in wanted)


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
        for stage in stages:
            _add(found, notes, TOPICS.get(stage, ()), stage, scene)
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


def chosen_topics(topics: Sequence[Topic], asked: Sequence[str]) -> tuple[Topic, ...]:
    """Those whose names were asked for, all without any; UsageError with the list."""
    if not asked:
        return tuple(topics)
    names = {_key(topic.name): topic.name for topic in topics}
    unknown = [name for name in asked if _key(name) not in names]
    if unknown:
        raise UsageError(
            f"there is no topic {unknown[0][:60]!r}; there are: {', '.join(names.values())}"
        )
    wanted = {_key(name) for name in asked}
    return tuple(topic for topic in topics if _key(topic.name) in wanted)


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
