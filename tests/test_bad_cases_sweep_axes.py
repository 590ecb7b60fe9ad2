"""Claim: a sweep that cannot be meant is refused before its first run, in words that help."""

import json

import pytest
from refused import problems_of as of_form
from refused import refusals, said_of
from shipped_cases import CASES
from sweep_samples import STIFFNESS, design_of, generator

from vibecalc.core.study.execute import load_checked
from vibecalc.core.study.sweep.checks import check_design, keep_problems
from vibecalc.core.study.sweep.prepare import axis_table, sampling_table
from vibecalc.errors import CaseError, Problem, UsageError


def problems_of(sweep: str) -> list[Problem]:
    """Problems of a sweep over the generator, those of its values included."""
    try:
        keys = json.loads(sweep)
        design = design_of(*keys.pop("axes"), **keys)
    except CaseError as error:
        return list(error.problems)
    return check_design(design, generator().resolved)


@pytest.mark.parametrize(("case", "sweep", "place", "words"), refusals("sweep", "grid"))
def test_sweeps_that_cannot_be_meant(case: str, sweep: str, place: str, words: list[str]) -> None:
    (problem,) = problems_of(sweep)
    keys = place.split(".") if place != "-" else []
    path = ("sweep", *(int(key) if key.isdigit() else key for key in keys))
    assert problem.path[: len(path)] == path
    assert words[0] in said_of(problem)


@pytest.mark.parametrize(("case", "changes", "key", "words"), refusals("sweep", "sampling"))
def test_samplings_that_are_none(case: str, changes: str, key: str, words: list[str]) -> None:
    sweep = {"axes": [{"key": STIFFNESS, "values": [1, 2]}], **json.loads(changes)}
    (problem,) = of_form({**generator().resolved, "sweep": sweep})
    assert problem.path[:2] == ("sweep", key)
    assert words[0] in problem.message


@pytest.mark.parametrize(("case", "sweep", "place", "words"), refusals("sweep", "kept"))
def test_results_that_cannot_be_kept(case: str, sweep: str, place: str, words: list[str]) -> None:
    loaded, keys = generator(), json.loads(sweep)
    design = design_of(*keys["axes"])
    (problem,) = keep_problems(keys["keep"], loaded.case, design, loaded.resolved)
    assert problem.path[:2] == ("sweep", "keep") and words[0] in said_of(problem)


@pytest.mark.parametrize(("case", "text", "place", "words"), refusals("sweep", "text"))
def test_texts_that_are_no_axis_and_no_sampling(
    case: str, text: str, place: str, words: list[str]
) -> None:
    with pytest.raises(UsageError) as caught:
        (axis_table if text.startswith("machine") else sampling_table)(text)
    assert words[0] in str(caught.value)


def test_check_looks_at_the_sweep_too(tmp_path) -> None:  # type: ignore[no-untyped-def]
    case = CASES["generator_mount_design"].read_text(encoding="utf-8")
    swept = """
[sweep]
axes = [{ key = "machine.mounts.each.stiffness", from = "5 N/mm", to = "50 N/mm", points = 3 }]
"""
    (tmp_path / "both.toml").write_text(case + swept, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        load_checked([tmp_path / "both.toml"])
    (problem,) = caught.value.problems
    assert problem.message == "a key that the sweep sets cannot be searched for as well"
    assert "both.toml:" in str(caught.value)
