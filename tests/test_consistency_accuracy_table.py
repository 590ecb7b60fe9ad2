"""Claim: every stage and study that a case can have is measured by some topic."""

import tomllib
from functools import cache

import pytest
from shipped_cases import CASES, SLOW, table_of

from vibecalc.core.accuracy.record import extra_work
from vibecalc.core.accuracy.run import STUDIES, WHOLE_CASE, Collected, collect, stages_of
from vibecalc.core.accuracy.topic import Timed, Topic, measure
from vibecalc.core.case.load import validate
from vibecalc.core.results.named import named
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.run import run_scene
from vibecalc.core.study.execute import load_checked
from vibecalc.response.accuracy.forced import response_speeds_topics

#: stages and studies of each shipped case
PLANNED = {
    name: stages_of(load_checked([path])[0].case)
    for name, path in CASES.items()
    if not name.endswith("_sweep")
}
#: stage -> functions that give its topics
TOPICS = {
    stage.name: stage.topics
    for name in PLANNED
    for stage in plan_case(load_checked([CASES[name]])[0].case)
}


def test_every_planned_stage_is_in_the_table() -> None:
    planned = {stage for stages in PLANNED.values() for stage in stages}
    assert planned == {*TOPICS, *STUDIES, WHOLE_CASE}


@pytest.mark.parametrize("stage", [*TOPICS, *STUDIES])
def test_its_modules_are_there(stage: str) -> None:
    for where in {**TOPICS, **STUDIES}[stage]:
        assert callable(named(where)), where
    assert {**TOPICS, **STUDIES}[stage]


@cache
def topics_of(name: str) -> Collected:
    (loaded,) = load_checked([CASES[name]])
    wanted = tuple(stage for stage in PLANNED[name] if stage != WHOLE_CASE)
    return collect(loaded, wanted)


def pairs() -> list[str]:
    """Cases whose stages run in seconds, and those that alone have a stage."""
    quick = [name for name in PLANNED if name not in SLOW]
    have = {stage for name in quick for stage in PLANNED[name]}
    alone = [name for name in SLOW & set(PLANNED) if set(PLANNED[name]) - have]
    return [*quick, *sorted(alone)]


@pytest.mark.long
def test_every_stage_has_topics_in_some_case() -> None:
    found = {topic.stage for name in pairs() for topic in topics_of(name).topics}
    assert found == {*TOPICS, *STUDIES}
    assert not {name: topics_of(name).notes for name in pairs() if topics_of(name).notes}


@pytest.mark.long
@pytest.mark.parametrize("name", pairs())
def test_the_default_of_every_topic_is_on_the_front(name: str) -> None:
    beaten = {}
    for topic in topics_of(name).topics:
        found = extra_work(topic, measure(topic, Timed(repeat=False)).rungs)
        if found > 1.001 * topic.default_extra:
            beaten[topic.stage, topic.name] = (found, topic.default_extra)
    assert not beaten


def test_topics_have_names_of_their_own_in_each_stage() -> None:
    names = [(topic.stage, topic.name) for topic in _quick_topics()]
    assert names and len(set(names)) == len(names)


def _quick_topics() -> tuple[Topic, ...]:
    return topics_of("generator").topics


def test_energies_over_speed_have_a_topic_with_its_default_on_the_front() -> None:
    left_out = ("reference", "reference_table", "limit")
    case = {key: part for key, part in table_of("compressor_b").items() if key not in left_out}
    case["response"] = {**case["response"], "run_up": {"from": "5 rad/s", "to": "120 rad/s"}}
    case["excitation"] = {**case.get("excitation", {}), "orders": 4}
    (topic,) = response_speeds_topics(run_scene(validate(case)))
    measured = measure(topic, Timed(repeat=False))
    assert measured.reference.agreement < 1e-25
    assert extra_work(topic, measured.rungs) <= topic.default_extra
    assert [rung.worst_relative < 1e-13 for rung in measured.rungs] == [True, True] + [False] * 6
    # order 2 would be nine times as good with each; resonances between the points hold it up
    errors = [rung.worst_relative for rung in measured.rungs[2:]]
    assert errors[-1] < 0.35 * errors[-2] and errors[-1] < 0.1 * errors[-3]


def test_a_bare_case_still_has_its_tolerance() -> None:
    text = CASES["absorber"].read_text(encoding="utf-8")
    assert stages_of(validate(tomllib.loads(text)))[-1] == WHOLE_CASE
