"""Claim: a measurement has errors in three norms, names what failed, and survives its file."""

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.accuracy.record import as_record, folder_of, measured_text, plan_rows
from vibecalc.core.accuracy.topic import Answer, Ask, Reference, Solver, Topic, errors_of, measure
from vibecalc.core.report.accuracy import accuracy_object, render_answer, topics_of
from vibecalc.core.results.layout import MEASURED, TRIAL_DONE, TRIAL_FAILED, TRIAL_NOT_RUN
from vibecalc.core.results.record import Result
from vibecalc.core.results.store import write_result
from vibecalc.core.results.trials import Trial
from vibecalc.core.study.execute import as_result, load_checked
from vibecalc.errors import NumericalFailure

Solve = Callable[[float], Answer]

#: one run of each level within so many seconds: tests count work, not seconds
ONCE = (60.0, 0)

#: x' = i x from 1 over one unit of time
TRUTH = np.array([np.exp(1j)])


def euler(steps: float) -> Answer:
    """Order 1."""
    return Answer(np.array([(1.0 + 1j / steps) ** int(steps)]), steps)


def runge_kutta(steps: float) -> Answer:
    """The classical method, order 4: its amplification is the series to the fourth power."""
    step = 1j / steps
    growth = 1.0 + step + step**2 / 2.0 + step**3 / 6.0 + step**4 / 24.0
    return Answer(np.array([growth ** int(steps)]), 4.0 * steps)


def gauss(points: float) -> Answer:
    """1 + the integral of i exp(i t), by Gauss's rule: geometric."""
    node, weight = np.polynomial.legendre.leggauss(int(points))
    half = 0.5 * (node + 1.0)
    return Answer(np.array([1.0 + 0.5 * np.sum(weight * 1j * np.exp(1j * half))]), points)


def exact(_: float) -> Answer:
    return Answer(TRUTH.copy(), 2.0)


def unstable(steps: float) -> Answer:
    if steps < 3:
        raise NumericalFailure("the step is above the limit of stability")
    if steps < 5:
        raise np.linalg.LinAlgError("singular matrix")
    return Answer(np.array([np.exp(1j) + 0.1 / steps]), steps)


def undefined(setting: float) -> Answer:
    return Answer(np.array([complex(np.nan if setting < 2 else np.inf)]), 1.0)


class Clock:
    """Time that passes in `slow` only."""

    now = 0.0

    def perf_counter(self) -> float:
        return self.now

    process_time = perf_counter

    def slow(self, setting: float) -> Answer:
        """As many seconds as the setting says."""
        self.now += setting
        return Answer(TRUTH + 0.1, setting)


def solver(
    solve: Solve, *settings: float, setting: str = "steps", default: float | None = None
) -> Solver:
    name, what = solve.__name__.replace("_", " "), setting if settings else ""
    return Solver(name, solve, what, settings or (1.0,), default, "as its name says")


def topic(
    *solvers: Solver, agreement: float = 1e-16, position: str = "", name: str = "after one unit"
) -> Topic:
    ask = Ask(name, "the end of x' = i x from 1", "rotation/end")
    truth = Reference(TRUTH, agreement, "closed form", 0.5 if position else None)
    return Topic(ask, "evaluations", lambda: truth, solvers, position, "rotation")


#: everything at once, for files and reports
FULL = topic(
    solver(euler, 4, 8, 16, 32, 64, 128),
    solver(runge_kutta, 4, 8, 16, 32, 64),
    solver(gauss, 2, 3, 4, 5, 6, 8, 10, setting="points", default=10),
    solver(exact),
    solver(unstable, 2, 4, 8),
    solver(undefined, 1, 2),
)
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
    causes = [trial["cause"] for trial in full["trials"] if trial["status"] == "failed"]
    assert causes == [
        "the step is above the limit of stability", "LinAlgError: singular matrix",
        "the answer is not a number", "the answer is infinite",
    ]  # fmt: skip
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


# ----------------------------------------------------------------------------
# Errors, failures and time.
# ----------------------------------------------------------------------------


def measured(asked: Topic) -> tuple[Trial, ...]:
    return measure(asked, *ONCE).trials


def test_three_norms() -> None:
    truth = np.array([3.0 + 4.0j, 0.0, 1e-7])

    def errors(values: np.ndarray, true: np.ndarray) -> tuple[float, float, float]:
        return errors_of(Answer(values, 1.0, 0.3), Reference(true, 0.0, "", 0.1))

    found = errors(truth * np.array([1.01, 1.0, 2.0]), truth)
    assert found == pytest.approx((0.01, 20.0 * math.log10(1.01), 0.2))
    assert errors(np.array([0.0, 5.0]), np.array([2.0, 5.0]))[1] == math.inf
    assert errors(np.zeros(2), np.zeros(2))[:2] == (0.0, 0.0)
    assert errors(np.ones(2), np.zeros(2))[0] == math.inf
    with pytest.raises(ValueError, match=r"shape \(2,\) for a truth of shape \(1,\)"):
        errors(np.ones(2), np.ones(1))


def test_a_series_ends_where_its_time_does_and_the_default_is_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    monkeypatch.setattr("vibecalc.core.accuracy.topic.time", clock)
    asked = topic(solver(clock.slow, 1.5, 6, 7, 8, default=8), solver(exact))
    trials = measure(asked, 20.0, 0).trials
    done, late = TRIAL_DONE, TRIAL_NOT_RUN
    assert [one.status for one in trials] == [done, done, late, done, done]
    assert trials[2].cause == "the time limit of its topic was reached"
    assert [one.seconds for one in trials] == [1.5, 6.0, math.inf, 8.0, 0.0]


def test_a_reference_that_is_not_finite_is_a_failure() -> None:
    broken = FULL._replace(reference=lambda: Reference(np.array([np.nan]), 0.0, ""))
    with pytest.raises(NumericalFailure, match="not finite"):
        measured(broken)
