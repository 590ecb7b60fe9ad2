"""Figure and axes of pictures: matplotlib's own, whose ticks are cheap to measure and draw.

matplotlib makes five artists of each tick, and brings all of them up to date several times whenever
it measures or draws axes. Here an axis draws its grid, marks and numbers as they follow from its
locator and formatter; where labels stand, and what all of it covers, is left to matplotlib.

Imported where a figure is made, for it needs matplotlib.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.axis import Axis, XAxis, YAxis
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator
from matplotlib.transforms import Bbox, IdentityTransform

#: points: marks of numbers and between them, their distance from the numbers, width of marks
_LONG, _SHORT, _PAD, _THIN = 3.5, 2.0, 3.5, 0.8
#: points around axes that words are thought to take before they are measured: beside, above
_BESIDE, _ABOVE = 32.0, 16.0
#: of a pixel, how far beyond the end of an axis a tick is at it
_AT_END = 0.5


class Ruler(Axis):
    """An axis without objects for its ticks."""

    _measured: tuple[Any, tuple[list[Bbox], list[Bbox]]]

    def __init__(self, *given: Any, **known: Any) -> None:
        super().__init__(*given, **known)
        self._text, self._measured = Text(), (None, ([], []))

    def _update_ticks(self) -> list[Any]:
        return []

    def _get_ticklabel_bboxes(self, ticks: Any, renderer: Any) -> Any:
        """What the numbers cover at the near and at the far side; as long as the frame stays."""
        now = (*self.get_view_interval(), *self.axes.bbox.extents)
        if self._measured[0] != now:
            ends = np.array([one.get_window_extent(renderer).extents for one in self._numbers()])
            boxes = (
                [Bbox.from_extents(*ends[:, :2].min(0), *ends[:, 2:].max(0))] if ends.size else []
            )
            self._measured = now, ([], boxes) if self._far() else (boxes, [])
        return self._measured[1]

    def pin(self) -> None:
        """Keep the ticks of now: a locator would choose others, with wider numbers, at a size that
        differs little from the one that was measured."""
        self.set_major_locator(FixedLocator(list(self.get_majorticklocs())))

    def draw(self, renderer: Any) -> None:
        """Grid, marks and numbers, and what matplotlib draws without them: the label."""
        look, far, places = self.get_tick_params(which="major"), self._far(), self.ticks()[0]
        low, high = self._ends(across=True)
        if self.get_visible():
            if look["gridOn"]:
                self._lines(renderer, places, low, high, rcParams["grid.linewidth"],
                            rcParams["grid.color"])  # fmt: skip
            edge, out = (high, 1.0) if far else (low, -1.0)
            minor = self._inside(self.get_minorticklocs())[0]
            for some, long, width in (
                (places, look.get("length", _LONG), _THIN),
                (minor, _SHORT, 0.6),
            ):
                if any(look[side] for side in self._sides()):
                    end = edge + out * renderer.points_to_pixels(long)
                    self._lines(renderer, some, edge, end, width, "black")
            for one in self._numbers():
                one.draw(renderer)
        super().draw(renderer)

    def ticks(self) -> tuple[np.ndarray, list[str]]:
        """Places in pixels of what has a number, and the numbers."""
        values = self.get_majorticklocs()
        words = self.get_major_formatter().format_ticks(list(values))
        places, kept = self._inside(values)
        return places, [words[i] for i in kept]

    def _upright(self) -> bool:
        return isinstance(self, YAxis)

    def _sides(self) -> tuple[str, str]:
        return ("left", "right") if self._upright() else ("bottom", "top")

    def _far(self) -> bool:
        return self.get_label_position() == self._sides()[1]

    def _ends(self, across: bool = False) -> Any:
        """Of the frame in pixels, along the axis or across it."""
        return self.axes.bbox.extents[int(self._upright() != across) :: 2]

    def _inside(self, values: Any) -> tuple[np.ndarray, np.ndarray]:
        """Places in pixels of the values within the frame, and which these are."""
        i, both, (low, high) = int(self._upright()), np.zeros((len(values), 2)), self._ends()
        both[:, i] = values
        along = self.axes.get_yaxis_transform() if i else self.axes.get_xaxis_transform()
        places = np.asarray(along.transform(both)[:, i])
        kept = np.flatnonzero((places >= low - _AT_END) & (places <= high + _AT_END))
        return places[kept], kept

    def _numbers(self) -> Iterator[Any]:
        """The numbers one after the other, all of them one text that moves on."""
        look, far, upright = self.get_tick_params(which="major"), self._far(), self._upright()
        if not look[f"label{self._sides()[far]}"]:
            return
        one, turned, ends = self._text, float(look.get("rotation", 0.0)), self._ends(across=True)
        gap = self.axes.figure.dpi / 72.0 * (look.get("length", _LONG) + look.get("pad", _PAD))
        edge = ends[1] + gap if far else ends[0] - gap
        one.set_figure(self.axes.figure)
        one.set_transform(IdentityTransform())
        one.set(rotation=turned, fontsize=look.get("labelsize", rcParams["xtick.labelsize"]))
        if upright:
            one.set(ha="left" if far else "right", va="center_baseline")
        else:
            slanted = turned % 90.0 != 0.0
            one.set(ha="right" if slanted else "center", va="bottom" if far else "top",
                    rotation_mode="anchor" if slanted else "default")  # fmt: skip
        for place, word in zip(*self.ticks(), strict=True):
            if word:
                one.set_text(word)
                one.set_position((edge, place) if upright else (place, edge))
                yield one

    def _lines(
        self, renderer: Any, places: np.ndarray, low: float, high: float, width: float, colour: str
    ) -> None:
        """Lines across the axis at places of it, all of them one path."""
        ends, i = np.empty((places.size, 2, 2)), int(self._upright())
        ends[:, :, i], ends[:, :, 1 - i] = places[:, None], (low, high)
        codes = np.tile(np.array([Path.MOVETO, Path.LINETO], Path.code_type), places.size)
        pen = renderer.new_gc()
        pen.set_linewidth(width)
        pen.set_foreground(colour)
        pen.set_capstyle("butt")
        pen.set_snap(True)
        renderer.draw_path(pen, Path(ends.reshape(-1, 2), codes), IdentityTransform())
        pen.restore()


class _Level(Ruler, XAxis):
    """The axis below."""


class _Upright(Ruler, YAxis):
    """The axis beside."""


class Frame(Axes):
    """Axes with rulers, which guess the room of some words before they measure it."""

    _placed = False

    def _init_axis(self) -> None:
        self.xaxis, self.yaxis = _Level(self, clear=False), _Upright(self, clear=False)
        for axis in (self.xaxis, self.yaxis):
            for side in axis._sides():
                self.spines[side].register_axis(axis)
                self.spines[side].set_in_layout(False)  # ticks reach further

    def get_tightbbox(self, renderer: Any = None, **how: Any) -> Any:
        """What axes and words cover, in pixels.

        A layout asks twice. What stands beside and above depends on the height, which it does not
        know at first: then that is as much as usual. What is measured the second time is drawn.
        """
        if not how.get("for_layout_only") or not self.get_visible():
            return super().get_tightbbox(renderer, **how)
        if self._placed:
            for axis in (self.xaxis, self.yaxis):
                if isinstance(axis, Ruler):
                    axis.pin()
            return super().get_tightbbox(renderer, **how)
        self._placed = True
        point, (x0, y0, x1, y1) = self.figure.dpi / 72.0, self.bbox.extents
        titled = any(self.get_title(loc=place) for place in ("left", "center", "right"))
        usual = Bbox.from_extents(
            x0 - _BESIDE * point * bool(self.get_ylabel()), y0, x1, y1 + _ABOVE * point * titled
        )
        below = self.xaxis.get_tightbbox(renderer, for_layout_only=True)
        return usual if below is None else Bbox.union([usual, below])


class Sheet(Figure):
    """A figure whose axes are frames, unless it is said otherwise."""

    def add_subplot(self, *given: Any, **known: Any) -> Axes:
        """Axes in a grid."""
        if "projection" not in known:
            known.setdefault("axes_class", Frame)
        made: Axes = super().add_subplot(*given, **known)
        return made


def lay_out(figure: Figure, dpi: int) -> None:
    """Make room for all words once, for all formats, which else lay out and draw everything twice.

    Labels of panels above each other stand in one line.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        figure.set_dpi(dpi)
        figure.align_ylabels([axes for axes in figure.axes if axes.get_ylabel()])
        engine.execute(figure)
        figure.set_layout_engine(None)
