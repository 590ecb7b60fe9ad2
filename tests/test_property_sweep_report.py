"""Claim: the report of a sweep says where extremes are, which limits break, and what failed."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shipped_cases import result_of as result_at
from sweep_blocks import made
from sweep_samples import axis, design_of, generator, spread
from sweep_views import (
    BOTH,
    DAMPING,
    FAILED_POINTS,
    LIMITS,
    PEAK,
    SPEED,
    STIFFNESS,
    along_speed,
    axis_of,
    key,
    mounts,
    sampled,
    view,
)
from sweep_views import SAG as DEFLECTION

from vibecalc.core.report.sections import read_as
from vibecalc.core.report.sweep.limits import (
    best,
    judge,
    least_broken,
    limit_lines,
    share_within_limits,
)
from vibecalc.core.report.sweep.picture_lines import draw_sweep_line
from vibecalc.core.report.sweep.statistics import (
    entries,
    extreme_lines,
    first_of,
    point_lines,
    worst,
)
from vibecalc.core.report.sweep.text import render_sweep
from vibecalc.core.report.sweep.view import SweepView, causes, failure_lines, view_of
from vibecalc.core.report.writing import show, text_of
from vibecalc.core.results.layout import DONE, FAILED, NOT_RUN, REFUSED
from vibecalc.core.results.sweep_file import open_sweep
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.study.sweep.assemble import assemble
from vibecalc.core.study.sweep.evaluate import Evaluator
from vibecalc.errors import ResultError

VIEWS = {
    "grid": lambda: mounts(failed=FAILED_POINTS),
    "speed": along_speed,
    "indices": sampled,
    "samples": lambda: sampled(40, indices=False, failed=FAILED_POINTS),
    "nothing": lambda: mounts(3, 2, failed=dict.fromkeys(range(6), (FAILED, "no"))),
}


def one_axis(values: Any, **more: Any) -> SweepView:
    """A sweep of the stiffness from 1 N/m on with these forces."""
    forces = np.asarray(values, dtype=float)
    keys = (key(*STIFFNESS),)
    axis = axis_of(keys, 1.0 + np.arange(len(forces))[:, None])
    return view([axis], keys, {PEAK: forces}, **more)


@pytest.mark.parametrize("name", VIEWS)
def test_pages_are_narrow_and_clean(name: str) -> None:
    text = render_sweep(VIEWS[name]())
    assert max(len(line) for line in text.splitlines()) <= 100
    assert all(line == line.rstrip() for line in text.splitlines())
    assert not re.search(r"\b(nan|inf|None|array|np\.)\b", text)
    assert text == render_sweep(VIEWS[name]())


@settings(max_examples=50)
@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=30), st.floats(0.0, 10.0))
def test_of_values_that_are_the_same_the_first_counts(values: list[float], error: float) -> None:
    """Within errors that exceed them, else to rounding: what is left out makes none equal."""
    array, errors = np.array(values), np.full(len(values), error)
    for side, extreme in (("max", array.max()), ("min", array.min())):
        found = int(first_of(array, errors, side))
        apart = np.abs(array - extreme)
        known = abs(extreme) > error
        slack = 2.0 * (min(error, 1e-8 * abs(extreme)) if known else error)
        assert apart[found] <= slack * (1.0 + 1e-12) + 1e-12
        assert np.all(apart[:found] > slack * (1.0 - 1e-12) - 1e-12)


def test_values_that_errors_do_not_tell_apart_are_no_constant() -> None:
    text = text_of(extreme_lines(one_axis([2.0, 2.5, 3.0], errors=0.5)))
    assert "constant" not in text and "2.00 +-1.50" in text and "3.00 +-1.50" in text
    text = text_of(extreme_lines(one_axis([2.0, 2.5, 3.0], errors=1.5)))
    assert "constant" not in text and "unresolved" in text


def test_unbounded_values_are_counted_nearby_the_largest_finite_one() -> None:
    text = "\n".join(extreme_lines(one_axis([1.0, np.inf, 7.0, np.inf])))
    assert "largest   unbounded  N     stiffness = 0.002 N/mm" in text
    assert "unbounded at 2 points; the largest finite value is 7.000 N" in text


def test_own_axes_come_down_to_their_worst_entry_with_its_name() -> None:
    sweep = mounts()
    counted = worst(sweep, BOTH)
    by_mount = sweep.read(BOTH).values
    np.testing.assert_array_equal(counted.values, by_mount.max(axis=1))
    assert {counted.label(point) for point in range(sweep.count)} == {"mount 2"}
    first = worst(sweep, BOTH, {"mount": "1"})
    np.testing.assert_array_equal(first.values, by_mount[:, 0])
    least = worst(sweep, BOTH, None, "min")
    np.testing.assert_array_equal(least.values, by_mount[:, 0])
    assert least.label(0) == "mount 1"
    found, names = entries(sweep, BOTH)
    np.testing.assert_array_equal(found, by_mount)
    assert names == ("mount=1", "mount=2")
    with pytest.raises(ResultError, match="no entry mount = '3'"):
        worst(sweep, BOTH, {"mount": "3"})


def test_limits_are_judged_at_every_point() -> None:
    sweep = mounts(failed=FAILED_POINTS)
    judged = judge(sweep)
    sag, force = (sweep.read(path).values for path in (DEFLECTION, PEAK))
    inside = sweep.done & (sag <= 0.03) & (force <= 12.0) & (0.6 * force <= 400.0)
    np.testing.assert_array_equal(judged.kept, inside)
    assert not judged.missing and 0 < inside.sum() < sweep.done.sum()
    assert f"kept at {inside.sum()} of {sweep.done.sum()} (" in share_within_limits(sweep, judged)
    found = best(sweep, judged)
    assert found is not None
    point, words = found
    assert read_as(DEFLECTION, "m")[0] in words
    assert sag[point] == np.min(sag[inside])
    assert inside[point]


@pytest.mark.parametrize("study", ["sweep", "optimisation"])
@pytest.mark.parametrize("sense", ["min", "max"])
@pytest.mark.parametrize("path", [PEAK, DEFLECTION])
def test_an_objective_chooses_the_best_point(path: str, sense: str, study: str) -> None:
    objective = {"quantity": path, "sense": sense}
    sweep = mounts(limits=LIMITS[:2], case={study: {"objective": objective}})
    judged = judge(sweep)
    found = best(sweep, judged)
    assert found is not None
    values = sweep.read(path).values
    wanted = getattr(np, sense)(values[judged.kept])
    assert values[found[0]] == pytest.approx(wanted, rel=1e-11)


def test_nothing_is_best_where_no_objective_is_named() -> None:
    sweep = mounts(case={})
    assert judge(sweep).kept.any() and best(sweep, judge(sweep)) is None
    assert "best:" not in render_sweep(sweep)


def test_a_margin_within_the_error_keeps_a_limit_and_an_infinite_value_breaks_it() -> None:
    limit = {"quantity": PEAK, "max": "0.01 kN"}
    sweep = one_axis([10.0, 10.0 + 1e-12, 10.0 + 1e-9, np.inf, 1.0], limits=[limit])
    (judged,) = judge(sweep).limits
    assert judged.kept.tolist() == [True, True, False, False, True]
    assert judged.words == "max 0.01 kN" and judged.bound == 10.0
    at_least = one_axis([1.0, 3.0], limits=[{"quantity": PEAK, "min": 2.0}])
    assert judge(at_least).limits[0].kept.tolist() == [False, True]


def test_a_limit_of_two_sides_counts_once_as_in_a_run() -> None:
    band = {"quantity": PEAK, "min": 2.0, "max": 4.0}
    sweep = one_axis([1.0, 3.0, 5.0], limits=[band])
    judged = judge(sweep)
    assert [one.side for one in judged.limits] == ["max", "min"]
    assert share_within_limits(sweep, judged).startswith("the limit is kept at 1 of 3 ")
    sweep = one_axis([1.0, 3.0, 5.0], limits=[band, {"quantity": PEAK, "max": 9.0}])
    assert share_within_limits(sweep, judge(sweep)).startswith("both limits are kept at 1 of 3 ")


def test_the_region_is_the_box_around_all_points_that_keep_the_limits() -> None:
    sweep = mounts()
    judged = judge(sweep)
    inside = judged.kept
    values = sweep.values_of(np.flatnonzero(inside))
    low, high = values.min(axis=0), values.max(axis=0)
    text = "\n".join(limit_lines(sweep, judged))
    row = next(line for line in text.splitlines() if line.startswith("  stiffness"))
    assert row.split()[1:] == ["5", "50", f"{1e-3 * low[0]:.6g}", f"{1e-3 * high[0]:.6g}", "N/mm"]
    # damping keeps them from end to end
    row = next(line for line in text.splitlines() if line.startswith("  damping"))
    assert row.endswith("<>")


def test_where_no_point_keeps_all_limits_the_least_broken_one_is_named() -> None:
    limits = [{"quantity": PEAK, "max": "2 N"}]
    sweep = one_axis([5.0, 3.0, 4.0], limits=limits, failed={2: (REFUSED, "no")})
    judged = judge(sweep)
    assert best(sweep, judged) is None
    found = least_broken(sweep, judged.limits)
    assert found is not None and (found[0], found[2]) == (1, pytest.approx(0.5))
    text = "\n".join(limit_lines(sweep, judged))
    assert "No computed point meets all limits." in text
    assert "closest: stiffness = 0.002 N/mm; peak, force, isolation: 3.000 N, max 2 N" in text


def test_a_limit_on_what_is_not_kept_is_said() -> None:
    sweep = mounts(limits=[{"quantity": "isolation/other", "max": 1.0}])
    judged = judge(sweep)
    assert not judged.limits and judged.missing == ["isolation/other"]
    assert "the limit on isolation/other is not judged" in render_sweep(sweep)


def test_failures_are_grouped_by_their_words_but_for_numbers() -> None:
    sweep = mounts(failed=FAILED_POINTS)
    found = causes(sweep)
    assert [cause.points.tolist() for cause in found] == [[40, 41], [3], [90]]
    assert [cause.alike for cause in found] == [False, True, True]
    assert sum(cause.points.size for cause in found) == np.count_nonzero(sweep.status != DONE)
    text = " ".join(" ".join(failure_lines(sweep)).split())
    assert "numerical failure, such as: order 2" in text and "0.635 %" in text
    assert "input refused: machine.mounts" in text and "timed out" in text
    # names that carry digits are no numbers
    other = one_axis(np.ones(2), failed={0: (FAILED, "mode1 x"), 1: (FAILED, "mode2 x")})
    assert len(causes(other)) == 2


def test_points_that_were_not_run_are_no_failures() -> None:
    sweep = one_axis([1.0, 2.0, 3.0], failed={1: (NOT_RUN, "")})
    assert not causes(sweep)
    assert "2 of 3 points are computed; 1 was not run" in render_sweep(sweep)


def test_limits_of_a_sweep_are_those_of_single_runs(tmp_path: Path) -> None:
    case = generator()
    design = design_of(
        spread(STIFFNESS[0], "10 N/mm", "100 N/mm", 2, spacing="log"),
        axis(DAMPING[0], "0 N*s/m", "200 N*s/m"),
    )
    paths = tuple(sorted({limit.quantity for limit in case.case.limit}))
    sweep = made(tmp_path, design, size=3, kept=paths)
    sweep.journal.start()
    for number in range(sweep.journal.chunks):
        points = sweep.journal.points(number)
        sweep.journal.write(number, Evaluator(case, design, paths)(points))
    target = tmp_path / "generator.sweep.h5"
    assemble(target, sweep.head, sweep.journal)
    with open_sweep(target) as opened:
        whole = dataclasses.replace(sweep.head.result, case=case.resolved)
        head = dataclasses.replace(sweep.head, result=whole)
        found = dataclasses.replace(view_of(opened), head=head)
        judged = judge(found).limits
        assert not judge(found).missing and len(judged) == 4
        for point in range(design.count):
            chosen = design.settings(point)
            single = result_at("generator", *(f"{key}={value}" for key, value in chosen.items()))
            for ours, row in zip(judged, verdicts_of(single), strict=True):
                assert (ours.quantity, ours.kept[point]) == (row.quantity, row.kept)
                assert ours.margin[point] == pytest.approx(row.margin, rel=1e-12)
                assert ours.worst.errors[point] == pytest.approx(row.error_estimate, rel=1e-12)
        # without damping the run-up passes a resonance without bound
        assert np.isinf(judged[1].margin).tolist() == [True, False] * 2


@pytest.mark.parametrize(("ratio", "words"), [(0.0, "unbounded"), (0.02, ""), (None, "> ")])
def test_a_peak_between_two_points_next_to_an_undamped_mode(ratio: Any, words: str) -> None:
    speed, natural, energy = np.linspace(50.0, 140.0, 37), 91.0, "response/energy"
    away = 1.0 - (speed / natural) ** 2
    values = {energy: away**-2.0, "response/modes/natural_frequency": np.full(37, natural)}
    if ratio is not None:
        values["response/modes/damping_ratio"] = np.full(37, ratio)
    sweep = view([axis_of((key(*SPEED),), speed[:, None])], [key(*SPEED)], values,
                 units={energy: "J", "response/modes/natural_frequency": "rad/s"})  # fmt: skip
    lines = " ".join(" ".join(extreme_lines(sweep)).split())
    assert f"largest {words or show(values[energy].max())}" in lines
    assert ("order 1 on mode 1" in lines) == bool(words)
    axes = draw_sweep_line(sweep).axes[0]
    marks = [line.get_xdata().tolist() for line in axes.get_lines() if line.get_marker() == "^"]
    middle = pytest.approx(0.5 * (90.0 + 92.5) * 30.0 / np.pi)
    assert marks == ([[middle]] if ratio == 0.0 else [])


def test_results_with_entries_that_nobody_asked_to_keep_are_said() -> None:
    """A grid keeps single numbers: what gears and couplings have is not lost without a word."""
    path = "response/torsion/coupling/utilisation"
    keys = (key(*STIFFNESS),)
    swept = view([axis_of(keys, np.array([[1.0], [2.0]]))], keys, {DEFLECTION: np.ones(2)})
    plan = ({"stage": "torsion", "quantities": f"{path}, {DEFLECTION}"},)
    with_plan = dataclasses.replace(swept.head.result, plan=plan)
    told = dataclasses.replace(swept, head=dataclasses.replace(swept.head, result=with_plan))
    text = render_sweep(told)
    assert "Not stored" in text and "1 result with several entries, along coupling" in text
    kept = dataclasses.replace(with_plan, case={**with_plan.case, "sweep": {"keep": [DEFLECTION]}})
    told = dataclasses.replace(swept, head=dataclasses.replace(swept.head, result=kept))
    assert "Not stored" not in render_sweep(told)


def test_a_sweep_along_one_axis_lists_its_results_point_by_point() -> None:
    def rows(sweep: SweepView) -> list[list[str]]:
        return [line.split() for line in text_of(point_lines(sweep)).splitlines()]

    few = rows(one_axis([5.0, np.inf, 3.0], errors=0.0, failed={2: (REFUSED, "no")}))
    assert few[-3:] == [["0.001", "5.000"], ["0.002", "unbounded"], ["0.003", "-"]]
    many = rows(one_axis(np.linspace(1.0, 2.0, 60)))
    assert [row[0] for row in many[-21:]] == [f"{0.001 + 0.003 * i:.6g}" for i in range(20)] + [
        "0.06"
    ]
    assert point_lines(mounts()) == []
