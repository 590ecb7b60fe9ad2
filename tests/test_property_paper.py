"""Claim: rulers show what matplotlib's own axes show, take as much room, and png files hold it."""

from io import BytesIO
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg

from vibecalc.core.report.canvas import plain_ticks
from vibecalc.core.report.paper import Frame, Sheet, lay_out
from vibecalc.core.report.plots import STYLE, png

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
