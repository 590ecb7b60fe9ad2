"""Claim: a measurement survives its file, reads the same again, and equals its repetition."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from accuracy_topics import FULL, ONCE, euler, solver, topic
from shipped_cases import CASES

from vibecalc.core.accuracy.record import as_record, folder_of, measured_text, plan_rows
from vibecalc.core.accuracy.topic import measure
from vibecalc.core.report.accuracy import accuracy_object, render_answer, topics_of
from vibecalc.core.results.layout import MEASURED, TRIAL_DONE, TRIAL_FAILED
from vibecalc.core.results.record import Result
from vibecalc.core.results.store import write_result
from vibecalc.core.study.execute import as_result, load_checked

PEAK = topic(solver(euler, 4, 8), position="crank angle [rad]", name="peak")


def made() -> Result:
    (loaded,) = load_checked([CASES["generator"]])
    measured = [measure(one, *ONCE) for one in (FULL, PEAK)]
    result = as_result(loaded, as_record(measured, ["something is left out"]), {"run": 0.1})
    provenance = {"machine": "a computer", "versions": "1", MEASURED: measured_text(measured)}
    return replace(result, plan=plan_rows(measured), provenance=provenance)


@pytest.fixture(scope="module")
def result() -> Result:
    return made()


def test_the_file_has_every_trial_with_its_cause(result: Result) -> None:
    folder = folder_of(FULL)
    assert folder == "accuracy/rotation/after_one_unit"
    status = result.record[f"{folder}/status"]
    assert [axis.name for axis in status.axes] == ["trial"]
    labels = status.axes[0].values.tolist()
    assert labels[0] == "euler | 4" and "exact" in labels
    failed = [labels[i] for i in np.flatnonzero(status.values == TRIAL_FAILED)]
    assert failed == ["unstable | 2", "unstable | 4", "undefined | 1", "undefined | 2"]
    error = result.record[f"{folder}/worst_relative"].values
    assert (np.isfinite(error) == (status.values == TRIAL_DONE)).all()
    assert not np.isnan(error).any()


def test_the_view_and_the_object_agree(result: Result) -> None:
    found = accuracy_object(result, Path("one.h5"))
    json.dumps(found, allow_nan=False)
    views = topics_of(result)
    assert [one["name"] for one in found["topics"]] == [one.words["name"] for one in views]
    full = found["topics"][0]
    assert full["trials"][0]["method"] == "euler" and full["trials"][0]["setting"] == 4.0
    cheapest = full["cheapest"][2]
    assert full["trials"][cheapest["in_work"]]["method"] == "exact"
    assert [trial["status"] for trial in full["trials"]].count("failed") == 4
    assert full["extra_work"] == pytest.approx(5.0)
    assert "position_error" in found["topics"][1]["trials"][0]
    assert len(views[0].failed) == 4


def test_the_answer_fits_on_a_screen(result: Result) -> None:
    lines = render_answer(result).splitlines()
    assert len(lines) <= 40
    assert any(re.search(r"rotation: after one unit .* exact +\d", one) for one in lines)
    assert "failed settings: 4" in " ".join(lines)
    many = [measure(topic(*FULL.solvers, name=f"question {k}"), *ONCE) for k in range(45)]
    provenance = {MEASURED: measured_text(many)}
    long = replace(result, record=as_record(many, []), plan=plan_rows(many), provenance=provenance)
    assert len(render_answer(long).splitlines()) <= 40
    assert "more topics: 17" in render_answer(long)


def test_a_picture_has_a_panel_for_each_topic(result: Result, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from vibecalc.core.report.plots import draw_accuracy as picture
    from vibecalc.core.report.plots import draw_file

    path = write_result(result, tmp_path / "one.accuracy.h5")
    figure = picture(result)
    assert figure is not None
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == 2 and panels[0].get_xscale() == panels[0].get_yscale() == "log"
    names = [text.get_text() for text in panels[0].get_legend().get_texts()]
    assert names == [one.name for one in FULL.solvers]
    assert draw_file(path, tmp_path) == [tmp_path / "one.accuracy.png"]
    assert (tmp_path / "one.accuracy.png").stat().st_size > 10_000
