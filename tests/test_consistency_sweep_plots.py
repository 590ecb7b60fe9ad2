"""Claim: pictures of a sweep show its numbers: lines, maps, samples, limits, failures, the best."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from sweep_views import (
    BOTH,
    FAILED_POINTS,
    LIMITS,
    PEAK,
    SAG,
    STIFFNESS,
    along_speed,
    axis_of,
    key,
    mounts,
    results,
    sampled,
    view,
)

pytest.importorskip("matplotlib")

from matplotlib import rc_context

from vibecalc.core.report.plots import STYLE, make
from vibecalc.core.report.sweep.limits import best, judge
from vibecalc.core.report.sweep.view import SweepView

OWN = {
    "sweep_line": lambda: mounts(21, 4, failed=FAILED_POINTS),
    "sweep_map": lambda: mounts(failed=FAILED_POINTS),
    "sweep_sample": sampled,
}
MORE = {
    "speed": ("sweep_line", along_speed),
    "smooth": ("sweep_map", mounts),
    "no indices": ("sweep_sample", lambda: sampled(80, indices=False)),
}


def figure(sweep: SweepView, name: str, dpi: float | None = None) -> Any:
    with rc_context(STYLE):
        made = make(sweep, name)
        assert made is not None
        if dpi is not None:
            made.set_dpi(dpi)
            made.draw_without_rendering()
    return made


@cache
def own(name: str) -> tuple[SweepView, Any]:
    """The sweep that a picture suits and its figure, for tests that look and change nothing."""
    picture, build = MORE.get(name) or (name, OWN[name])
    sweep = build()
    return sweep, figure(sweep, picture, 130)


def panel(made: Any, title: str) -> Any:
    (found,) = (axes for axes in made.axes if title_of(axes).startswith(title))
    return found


def title_of(axes: Any) -> str:
    return str(axes.get_title(loc="left") or axes.get_title())


def labelled(axes: Any) -> dict[str, Any]:
    return {line.get_label(): line for line in axes.get_lines()}


def is_limit_colour(colours: Any) -> bool:
    """Whether this is the one colour of limits."""
    from matplotlib.colors import to_hex

    return [to_hex(colour).upper() for colour in colours] == ["#B00020"]


def legend(made: Any) -> list[str]:
    return [text.get_text() for text in made.legends[0].get_texts()]


def test_lines_are_the_results_one_for_each_value_of_the_short_axis() -> None:
    sweep, made = own("sweep_line")
    axes = panel(made, PEAK)
    lines = labelled(axes)
    values = np.where(sweep.done, sweep.read(PEAK).values, np.nan).reshape(21, 4)
    for place in range(4):
        value = sweep.keys[1].shown(sweep.grid[1].table[place, 0])
        line = lines[f"damping = {value.replace('*', ' ')}"]
        np.testing.assert_allclose(line.get_ydata(), values[:, place])
        np.testing.assert_allclose(line.get_xdata(), 1e-3 * sweep.grid[0].table[:, 0])
    assert axes.get_xscale() == "log" and axes.get_xlabel() == "stiffness in N/mm"
    assert axes.get_ylabel() == "force in N"
    assert panel(made, SAG).get_ylabel() == "mm"
    assert title_of(panel(made, BOTH)) == f"{BOTH}\nlargest: mount=2"


def test_a_limit_is_a_line_with_its_words() -> None:
    axes = panel(own("sweep_line")[1], SAG)
    (level,) = {float(line.get_ydata()[0]) for line in axes.get_lines()
                if len(set(line.get_ydata())) == 1 and line.get_color() == "#B00020"}  # fmt: skip
    assert level == pytest.approx(30.0)
    assert "max 30 mm" in [text.get_text() for text in axes.texts]
    # one that is far off is said, and leaves the lines their room
    axes = panel(own("sweep_line")[1], BOTH)
    assert axes.get_ylim()[1] < 20.0
    assert "limit max 400 N: kept everywhere" in [text.get_text() for text in axes.texts]


@pytest.mark.parametrize("name", ["sweep_line", "sweep_map"])
def test_failed_points_are_marks_with_their_cause(name: str) -> None:
    sweep, made = own(name)
    words = legend(made)
    assert "2 points: numerical failure, such as: order 2 meets mode 1 at 31.5 rad/s" in words
    axes = panel(made, PEAK)
    line = next(line for text, line in labelled(axes).items() if "such as" in text)
    stiffness, damping = sweep.values_of(np.array([40, 41])).T
    np.testing.assert_allclose(line.get_xdata(), 1e-3 * stiffness)
    if name == "sweep_map":
        np.testing.assert_allclose(line.get_ydata(), damping)


@pytest.mark.parametrize("name", ["sweep_line", "sweep_map"])
def test_the_best_point_within_all_limits_is_marked(name: str) -> None:
    sweep, made = own(name)
    found = best(sweep, judge(sweep))
    assert found is not None
    stiffness, damping = sweep.values_of(np.array([found[0]]))[0]
    axes = panel(made, SAG)
    (star,) = (line for line in axes.get_lines() if line.get_marker() == "*")
    assert star.get_xdata()[0] == pytest.approx(1e-3 * stiffness)
    value = 1e3 * sweep.read(SAG).values[found[0]]
    assert star.get_ydata()[0] == pytest.approx(damping if name == "sweep_map" else value)
    assert f"the smallest sag, isolation of these points, {value:.4g}" in " ".join(
        star.get_label().split()
    )


def test_resonances_are_marked_over_the_speed() -> None:
    axes = panel(figure(along_speed(), "sweep_line"), "response/kinetic_energy/mean")
    marks = [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == ":"]
    rpm = 60.0 / (2.0 * np.pi)
    assert sorted(marks) == pytest.approx(sorted(rpm * np.array([90.0, 140.0, 70.0])))
    assert {"mode 1 / 1", "mode 2 / 1", "mode 2 / 2"} <= {text.get_text() for text in axes.texts}
    assert axes.get_ylabel() == "energy in J"


def test_unbounded_points_are_triangles() -> None:
    keys = (key(*STIFFNESS),)
    sweep = view([axis_of(keys, np.arange(1.0, 5.0)[:, None])], keys,
                 {PEAK: np.array([1.0, np.inf, 2.0, 3.0])})  # fmt: skip
    (axes,) = figure(sweep, "sweep_line").axes
    assert labelled(axes)["unbounded"].get_xdata() == pytest.approx([2e-3])
    sweep = mounts()
    force = sweep.read(PEAK).values.copy()
    force[7] = np.inf
    unbounded = view(sweep.grid, sweep.keys, {PEAK: force}, limits=[LIMITS[1]])
    axes = panel(figure(unbounded, "sweep_map"), PEAK)
    assert labelled(axes)["unbounded"].get_ydata() == pytest.approx([10.0])


def test_the_line_of_a_limit_runs_where_it_is_just_kept() -> None:
    sweep = mounts()
    axes = panel(figure(sweep, "sweep_map"), PEAK)
    (contour,) = (
        part for part in axes.collections
        if part.get_linewidth() == [2.0] and is_limit_colour(part.get_edgecolor())
    )  # fmt: skip
    places = contour.get_paths()[0].vertices
    found = results(1e3 * places[:, 0], places[:, 1])[PEAK]
    # straight between neighbours of the grid, which are 12 % apart
    np.testing.assert_allclose(found, 12.0, rtol=5e-3)
    assert len(places) >= 10


def test_the_region_is_green_where_all_limits_are_kept() -> None:
    sweep, made = own("sweep_map")
    axes = panel(made, "green: all limits")
    (cells,) = (part for part in axes.collections if hasattr(part, "get_coordinates"))
    drawn = np.ma.filled(cells.get_array().astype(float), -2.0).reshape(15, 21)
    kept = judge(sweep).kept
    wanted = np.where(sweep.done, 2.0 * kept - 1.0, -2.0).reshape(21, 15).T
    np.testing.assert_array_equal(drawn, wanted)
    assert "sag, isolation max 30 mm" in labelled(axes)
    here = labelled(axes)["the case as written"]
    assert (here.get_xdata()[0], here.get_ydata()[0]) == pytest.approx((20.0, 20.0))


def test_samples_are_counted_and_their_limit_drawn() -> None:
    sweep = sampled(64, failed={1: (2, "no")})
    made = figure(sweep, "sweep_sample")
    axes = panel(made, PEAK)
    heights = [patch.get_height() for patch in axes.patches]
    counted = sweep.done & sweep.independent
    assert sum(heights[: int(np.sqrt(counted.sum()))]) == counted.sum() == 127
    forces = sweep.read(PEAK).values[counted]
    share = 100.0 * np.mean(forces > 12.0)
    assert f"max 12 N: broken by {share:.3g} %" in title_of(axes)
    assert "1 point: numerical failure: no" in legend(made)
    assert labelled(axes)["limit"].get_xdata()[0] == pytest.approx(12.0)
