"""Claim: the pictures show the numbers of the result, with units."""

from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_samples import generator, optimised, quantity, rigid_body

pytest.importorskip("matplotlib")

import matplotlib
from drawn import coarse, figure, lines, words
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg

from vibecalc.core.report.canvas import plain_ticks
from vibecalc.core.report.paper import Frame, Sheet, lay_out
from vibecalc.core.report.plots import STYLE, _file_name, draw_file, every_picture, make, png
from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.results.record import Axis, entry
from vibecalc.core.results.store import read_result
from vibecalc.units import convert

RPM = 30.0 / np.pi
GOLDEN = Path(__file__).parent / "golden"


def test_force_over_the_cycle_sums_the_orders_with_phase() -> None:
    result = generator()
    still, mounted = figure(result, "force_over_cycle").axes
    for axes, name in ((still, "blocked"), (mounted, "steady")):
        drawn = lines(axes)
        parts = [
            drawn[f"{word} (order {n})"].get_ydata()
            for n, word in ((1, "primary"), (2, "secondary"))
        ]
        total = np.asarray(drawn["total"].get_ydata())
        np.testing.assert_allclose(total, parts[0] + parts[1], rtol=0, atol=1e-9)
        peak = float(result.record[f"isolation/couple_over_lever/{name}_peak"].values)
        assert np.abs(total).max() == pytest.approx(peak, rel=1e-4)


def test_shaking_reaches_the_peaks_of_the_result_in_time_and_along_its_path() -> None:
    result = read_result(GOLDEN / "pump.h5")
    force, path, couple = figure(result, "shaking").axes
    for axes, name in ((force, "force"), (couple, "couple")):
        peaks = result.record[f"excitation/{name}_peak"]
        shown = {label[0]: line.get_ydata() for label, line in lines(axes).items() if ":" in label}
        for direction, peak in zip("xyz", peaks.values, strict=True):
            drawn = np.abs(shown.get(direction, 0.0)).max()
            assert drawn == pytest.approx(float(peak), rel=1e-4, abs=1e-9)
    assert set(lines(force)) >= {"y: peak 115.5 N at 90 deg", "z: peak 222.9 N at 0 deg"}
    across, up = (np.asarray(one) for one in path.get_lines()[0].get_data())
    order = np.asarray(result.record["excitation/force"].axes[0].values)
    turned = np.exp(1j * np.outer(np.radians(np.linspace(0.0, 360.0, across.size)), order))
    whole = np.real(turned @ np.asarray(result.record["excitation/force"].values))
    np.testing.assert_allclose(np.transpose([across, up]), whole[:, 1:], atol=1e-9)
    assert (path.get_xlabel(), path.get_ylabel()) == ("y in N", "z in N")


def test_run_up_has_limits_and_resonances_over_the_speed_in_rpm() -> None:
    result = generator()
    picture = figure(result, "run_up")
    _, support = picture.axes
    natural = float(result.record["isolation/pitch/natural_frequency"].values)
    assert support.get_xlim() == pytest.approx((49.0, 4900.0))
    assert support.get_xlim()[0] < 0.5 * RPM * natural
    for text in ("order 1", "order 2", "run-up limit 400 N", "steady limit 100 N"):
        assert text in words(support)
    heights = [line.get_ydata() for line in support.get_lines()]
    assert any(np.all(np.asarray(y) == 400.0) for y in heights)
    assert "mounts 1 to 4" in lines(support)


def test_masked_speeds_are_shaded_and_leave_a_gap() -> None:
    result = generator()
    path = "isolation/couple_over_lever/run_up"
    old = result.record.quantities.pop(path)
    values = np.array(old.values)
    values[100:110] = np.inf
    result.record.add(quantity(path, values, "N", *old.axes))
    spans = Axis(name="resonance_skipped", values=np.array([1]))
    result.record.add(quantity("isolation/resonances_skipped/low", [20.0], "rad/s", spans))
    result.record.add(quantity("isolation/resonances_skipped/high", [22.0], "rad/s", spans))
    lever = figure(result, "run_up").axes[0]
    drawn = np.asarray(lever.get_lines()[0].get_ydata())
    assert np.isnan(drawn[100:110]).all()
    assert np.isfinite(drawn).sum() == drawn.size - 10
    assert np.isfinite(lever.get_ylim()).all()
    assert [patch.get_x() for patch in lever.patches] == [pytest.approx(20.0 * RPM)]


def test_a_row_of_the_catalogue_is_a_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [entry(f"isolation/{name}", "mount speed", "N*m", f"what {name} does", curve="two_loads")
            for name in ("bend", "twist")]  # fmt: skip
    monkeypatch.setattr("vibecalc.core.report.plots.CATALOGUE", {one.path: one for one in rows})
    result = generator()
    speed = Axis(name="speed", values=np.linspace(10.0, 600.0, 200), unit="rad/s")
    mount = Axis(name="mount", values=np.array([f"m{i}" for i in range(9)], object))
    values = np.outer(np.arange(1.0, 10.0), 3e4 * np.sin(speed.values))
    values[7] = values[8]
    values[:, 50] = np.inf
    result.record.add(quantity("isolation/bend", values, "N*m", mount, speed))
    result.record.add(quantity("isolation/twist", 1e-6 * values, "N*m", mount, speed))
    upper, lower = figure(result, "two_loads").axes
    drawn = lines(upper)
    # the six largest, of which two are one; both panels in the unit of the larger
    assert [name for name in drawn if name.startswith("m")] == [
        "m2",
        "m3",
        "m4",
        "m5",
        "m6",
        "m7, m8",
    ]
    np.testing.assert_allclose(
        drawn["m3"].get_ydata(), 1e-3 * np.where(np.isinf(values[3]), np.nan, values[3])
    )
    assert drawn["m3"].get_xdata()[-1] == pytest.approx(600.0 * RPM)
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("bend in kN m", "twist in kN m")
    assert (lower.get_title(loc="left"), lower.get_xlabel()) == (
        "what twist does",
        "crank speed in rpm",
    )
    assert "operating speed" in drawn and "two loads" in figure(result, "two_loads").get_suptitle()
    assert make(generator(), "two_loads") is None


def test_references_and_limits_stand_over_the_curve_that_they_are_on() -> None:
    result = read_result(GOLDEN / "compressor.h5")
    (axes,) = figure(result, "energy_by_order").axes
    rows = [row for row in judge_references(result)
            if row.quantity == "response/kinetic_energy/peak_by_order"]  # fmt: skip
    points = np.concatenate([np.asarray(one.get_offsets()) for one in axes.collections])
    drawn = {x: y for x, y in points if x % 1.0 > 0.5}
    wanted = {float(row.where["order"]) - 0.05: convert(row.value, row.unit, "J") for row in rows}
    assert drawn == pytest.approx(wanted, rel=1e-12)
    assert rows and "published" in axes.get_legend_handles_labels()[1]
    path = "kinematics/acceleration"
    limit = {"quantity": path, "max": "100 m/s^2", "source": "a limit"}
    limited = replace(result, case={**result.case, "limit": [limit]})
    heights = [
        line.get_ydata() for line in figure(limited, "piston_acceleration").axes[0].get_lines()
    ]
    assert any(np.all(np.asarray(y) == 100.0) for y in heights)


def test_start_and_optimum_against_bounds_and_limits() -> None:
    result = optimised()
    variables, uses = figure(result, "optimisation").axes
    found = float(result.record["optimisation/variable/machine.mounts.each.stiffness"].values)
    places = [float(np.ravel(line.get_xdata())[0]) for line in variables.get_lines()]
    assert 100.0 * (found - 2e3) / 498e3 in [pytest.approx(place) for place in places]
    widths = [bar.get_width() for bar in uses.patches]
    for bound, path in ((100.0, "steady_peak"), (400.0, "run_up_peak")):
        start = result.record[f"optimisation/start/isolation/support_force/{path}"].values[0]
        assert any(width == pytest.approx(100.0 * start / bound) for width in widths)
    assert sum(width == pytest.approx(100.0) for width in widths) == 3


@pytest.mark.parametrize(
    ("stem", "name"),
    [
        ("body", "body_modal_energy"),
        ("modal_test", "modal_test_energy"),
        ("energy_modal", "energy_modal_energy"),
    ],
)
def test_a_file_has_no_word_of_the_result_twice_but_the_last(
    stem: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse(monkeypatch)
    assert [path.stem for path in draw_file(replace(rigid_body(), name=stem), tmp_path)] == [name]


def test_pictures_of_all_shipped_cases_have_names_of_their_own() -> None:
    """So that `make plots` draws all of them into one folder."""
    every, files = every_picture(), list[str]()
    for path in sorted((GOLDEN.parent / "snapshots").glob("*.pictures.txt")):
        stem = path.name.partition(".")[0]
        drawn = [line.split()[0] for line in path.read_text(encoding="utf-8").splitlines()
                 if line[0] != " "]  # fmt: skip
        files += [_file_name(stem, name, every) for name in drawn]
    assert len(files) > 250 and sorted(set(files)) == sorted(files)
    assert _file_name("absorber_curves", "absorber_curves", every) == "absorber_curves_curves"


# ----------------------------------------------------------------------------
# Rulers show what matplotlib's own axes show, take as much room, and png files hold it.
# ----------------------------------------------------------------------------

DPI = 100


def pair(draw: Any) -> tuple[Any, Any]:
    """The same in a frame and in matplotlib's axes, both laid out."""
    made = []
    for kind in (Frame, Axes):
        figure = Sheet(figsize=(5.0, 3.0), layout="constrained", dpi=DPI)
        FigureCanvasAgg(figure)
        axes = figure.add_subplot(1, 1, 1, axes_class=kind)
        draw(axes)
        lay_out(figure, DPI)
        figure.canvas.draw()
        made.append(axes)
    return made[0], made[1]


def linear(axes: Any, low: float, span: float) -> None:
    axes.plot([low, low + span], [span, -3.0 * span])
    axes.set_xlabel("below")
    axes.set_ylabel("beside\nin two lines")


def logarithmic(axes: Any, low: float, span: float) -> None:
    axes.loglog([abs(low) + 1e-3, abs(low) + 1.0 + 50.0 * span], [0.02, 70.0 * span])
    for one in (axes.xaxis, axes.yaxis):
        plain_ticks(one)
    axes.set_ylabel("beside")


def named(axes: Any, low: float, span: float) -> None:
    axes.plot(range(4), [low, span, low, 0.0])
    axes.set_xticks(range(4), ["one", "two", "a long name", "four"])
    axes.tick_params(axis="x", labelrotation=90)
    axes.set_title("over it")


@pytest.mark.parametrize("kind", [linear, logarithmic, named])
def test_a_ruler_has_the_numbers_of_an_axis_where_it_has_them(kind: Any) -> None:
    rng = np.random.default_rng(7)
    for low, span in zip(rng.normal(0.0, 40.0, 3), 10.0 ** rng.uniform(-2.0, 4.0, 3), strict=True):
        with matplotlib.rc_context(STYLE):
            own, theirs = pair(lambda axes, low=low, span=span: kind(axes, low, span))
            # the frame is as large, but for a pixel that labels are rounded to
            a, b = (axes.get_window_extent().extents for axes in (own, theirs))
            np.testing.assert_allclose(a, b, atol=2.0)
            both = ((own.xaxis, theirs.xaxis), (own.yaxis, theirs.yaxis))
            for i, (ruler, axis) in enumerate(both):
                seen = {
                    tick.label1.get_text(): axis.axes.transData.transform([tick.get_loc()] * 2)[i]
                    for tick in axis.get_major_ticks()
                }
                inside = {word: place for word, place in seen.items() if b[i] - 0.5 <= place
                          <= b[i + 2] + 0.5}  # fmt: skip
                places, words = ruler.ticks()
                assert words == list(inside)
                np.testing.assert_allclose(places, list(inside.values()), atol=2.0)
                if axis.label.get_text():
                    boxes = [one.label.get_window_extent().extents for one in (ruler, axis)]
                    np.testing.assert_allclose(*boxes, atol=2.5)


def test_a_png_holds_what_was_drawn() -> None:
    image = pytest.importorskip("PIL.Image")
    with matplotlib.rc_context(STYLE):
        figure = Sheet(figsize=(3.0, 2.0), dpi=DPI)
        FigureCanvasAgg(figure)
        figure.subplots().plot([0.0, 1.0], [2.0, 1.0], color="#0072B2")
        read = image.open(BytesIO(png(figure, DPI)))
        drawn = np.asarray(figure.canvas.buffer_rgba())
    assert read.info["dpi"] == pytest.approx((DPI, DPI), abs=0.01)
    np.testing.assert_array_equal(np.asarray(read), drawn[..., :3])
