"""Claim: `accuracy` measures a case from file to table, twice the same, and refuses in words."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from fuzzing import command
from shipped_cases import CASES

from vibecalc.core.accuracy import run as collect
from vibecalc.core.accuracy.run import stages_of
from vibecalc.core.accuracy.topic import measure
from vibecalc.core.results.store import read_result
from vibecalc.core.study.execute import load_checked
from vibecalc.errors import EXIT_FINE, EXIT_USAGE, NumericalFailure, UsageError

CASE = str(CASES["generator"])
QUICK = ("--stage", "kinematics")


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # repeats give better seconds and nothing else
    monkeypatch.setattr("vibecalc.core.accuracy.topic._ENOUGH", 0.0)
    monkeypatch.setattr("vibecalc.core.report.plots.draw_file", _without_matplotlib)


def _without_matplotlib(result: object, path: Path) -> Path:
    raise UsageError("pictures need matplotlib")


def test_a_case_is_measured_twice_the_same() -> None:
    outcome = command("accuracy", CASE, *QUICK)
    assert outcome.code == EXIT_FINE, outcome.err
    text = Path("outputs/generator.accuracy.txt").read_text(encoding="utf-8")
    assert "kinematics: harmonics of the acceleration" in outcome.out
    assert len(outcome.out.splitlines()) <= 40 < len(text.splitlines())
    assert outcome.out.endswith("wrote outputs/generator.accuracy.h5, generator.accuracy.txt\n")
    assert "no picture: pictures need matplotlib" in outcome.err
    assert max(map(len, text.splitlines())) <= 110
    again = command("accuracy", CASE, *QUICK, "--json", "-o", "again.h5")
    assert again.code == EXIT_FINE
    found = json.loads(again.out)
    assert {one["stage"] for one in found["topics"]} == {"kinematics"}
    assert found["machine"]["versions"].startswith("python 3.")
    outcome = command("diff", "outputs/generator.accuracy.h5", "again.h5")
    assert outcome.code == EXIT_FINE, outcome.out
    shown = command("report", "outputs/generator.accuracy.h5")
    assert shown.out == text
    result = read_result("outputs/generator.accuracy.h5")
    assert result.name == "generator" and result.timings["run"] > 0.0
    for path, quantity in result.record.items():
        if path.endswith("/extra_work"):
            assert np.isfinite(quantity.values), path


def test_only_the_topic_asked_for() -> None:
    name = "true error of a run"
    outcome = command("accuracy", CASE, "--stage", "whole_case", "--topic", name, "--json", "-q")
    assert outcome.code == EXIT_FINE, outcome.err
    assert [one["name"] for one in json.loads(outcome.out)["topics"]] == [name]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--stage", "torsion"), "no stage 'torsion'; it has: kinematics, excitation, isolation"),
        (("--stage", "whole case", "--topic", "x"), "no topic 'x'; there are: true error of a run"),
        (("--longest", "0"), "--longest needs a number of seconds above 0"),
        (("--longest", "nan"), "--longest needs a number of seconds above 0"),
        (("-o", "table.txt"), "a result file ends in .h5"),
        (("--set", "machine.speed=-1"), "machine.speed"),
    ],
)
def test_bad_usage_is_refused_in_words(words: tuple[str, ...], said: str) -> None:
    outcome = command("accuracy", CASE, *words)
    assert outcome.code == EXIT_USAGE
    assert said in outcome.err
    assert not Path("outputs").exists()


def test_a_missing_package_is_named_with_the_extra_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    find_spec = importlib.util.find_spec

    def without(name: str, package: str | None = None) -> object:
        return None if name == "mpmath" else find_spec(name, package)

    monkeypatch.setattr(importlib.util, "find_spec", without)
    outcome = command("accuracy", CASE)
    assert outcome.code == EXIT_USAGE
    assert "pip install 'vibecalc[accuracy]'" in outcome.err


def test_a_long_run_is_not_repeated_and_a_failing_module_leaves_a_note(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def failing(_: object) -> None:
        raise NumericalFailure("there is no such thing")

    monkeypatch.setattr("vibecalc.excitation.accuracy.excitation_topics", failing)
    monkeypatch.setattr(collect, "LONGEST_RUN", 0.0)
    (loaded,) = load_checked([CASES["generator"]])
    found = collect.collect(loaded, (*stages_of(loaded.case)[:2], "whole case"))
    assert [topic.stage for topic in found.topics] == ["kinematics"]
    assert found.notes == [
        "topics of excitation are left out: there is no such thing",
        "cost of the tolerance not measured: a run takes more than 0 s",
    ]


def test_what_a_run_leaves_out_at_its_tolerance_is_no_error_of_it() -> None:
    (loaded,) = load_checked([CASES["four_cylinder"]])
    error, estimate = collect.collect(loaded, ("whole case",)).topics
    measured = [measure(topic, 60.0, 0) for topic in (error, estimate)]
    assert all(trial.done for one in measured for trial in one.trials)
    coarsest = measured[0].trials[0]
    assert coarsest.setting == 1e-3 and coarsest.worst_relative < 1e-3
    (default,) = [trial for trial in measured[0].trials if trial.is_default]
    (claimed,) = [trial for trial in measured[1].trials if trial.is_default]
    finest = measured[1].trials[-1]
    # the finest run is the truth here, so its own estimate counts, too
    assert default.worst_relative <= claimed.worst_relative + finest.worst_relative
    assert [trial.setting for trial in measured[1].trials] == [1e-3, 1e-6, 1e-9, 1e-12]
