"""Claim: every stage and study that a case can have is measured by some topic."""

from functools import cache

import pytest
from shipped_cases import CASES

from vibecalc.core.accuracy.run import STUDIES, WHOLE_CASE, Collected, collect, stages_of
from vibecalc.core.accuracy.topic import measure
from vibecalc.core.case.load import load_case
from vibecalc.core.results.named import named
from vibecalc.core.results.trials import extra
from vibecalc.core.run.plan import plan_case
from vibecalc.core.study.execute import load_checked
from vibecalc.schema import Case

#: nothing of theirs is one of the kinds of problems
WITHOUT = {
    *(
        "absorber motion",
        "balance",
        "body",
        "friction damper",
        "friction damper of the line",
        "hardware",
        "isolation efficiency",
        "measurement",
        "modal route as published",
    ),
    # orders one by one, over speed and of several conditions: those at one speed are measured
    *("torsion curves", "torsion irregularity", "torsion conditions", "speeds"),
}
NAMES = [name for name in CASES if not name.endswith("_sweep")]
#: whose stages run in seconds
QUICK = (
    *("absorber_damped", "absorber_friction", "absorber_mass", "balance_i4", "balance_v8"),
    *("compressor_a", "compressor_b", "compressor_motor", "engine_bearing_loads"),
    *("generator", "generator_180", "radial_articulated"),
)


@cache
def cases() -> dict[str, Case]:
    """Shipped cases as they are planned, without the checks of their machines."""
    return {name: load_case(CASES[name]).case for name in NAMES}


@cache
def planned() -> dict[str, tuple[str, ...]]:
    """Stages and studies of each shipped case."""
    return {name: tuple(stages_of(case)) for name, case in cases().items()}


@cache
def topics() -> dict[str, tuple[str, ...]]:
    """Stage -> functions that give its topics."""
    return {stage.name: stage.topics for case in cases().values() for stage in plan_case(case)}


def test_every_planned_stage_is_in_the_table() -> None:
    asked = {stage for stages in planned().values() for stage in stages}
    assert asked == {*topics(), *STUDIES}


def test_their_modules_are_there() -> None:
    for stage, functions in {**topics(), **STUDIES}.items():
        assert functions or stage in WITHOUT, stage
        for where in functions:
            assert callable(named(where)), where


@cache
def topics_of(name: str) -> Collected:
    (loaded,) = load_checked([CASES[name]])
    wanted = tuple(stage for stage in planned()[name] if stage != WHOLE_CASE)
    return collect(loaded, wanted)


@cache
def pairs() -> list[str]:
    """Quick cases, and those that alone have a stage."""
    have = {stage for name in QUICK for stage in planned()[name]}
    return [*QUICK, *(name for name in NAMES if set(planned()[name]) - have)]


@pytest.mark.long
def test_every_stage_has_topics_in_some_case() -> None:
    found = {topic.stage for name in pairs() for topic in topics_of(name).topics}
    assert found == {*topics(), *STUDIES} - WITHOUT - {WHOLE_CASE}
    assert not {name: topics_of(name).notes for name in pairs() if topics_of(name).notes}


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_the_default_of_every_topic_is_on_the_front(name: str) -> None:
    if name not in pairs():
        return
    beaten = {}
    for topic in topics_of(name).topics:
        measured = measure(topic, 5.0, 0)
        found = extra(measured.trials, measured.reference.noise, "work")
        if found > 1.001 * topic.ask.extra:
            beaten[topic.stage, topic.ask.name] = (found, topic.ask.extra)
    assert not beaten
