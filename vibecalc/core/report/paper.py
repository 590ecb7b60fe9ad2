"""Figure and axes of pictures: matplotlib's own, with rulers that are cheap to measure and draw.

matplotlib makes five artists of each tick, and brings all of them up to date several times whenever
it measures or draws axes. A ruler here draws grid, marks and numbers of an axis as they follow from
its locator and formatter. Room is measured once, at nearly the final size; labels stay there.

Imported where a figure is made, for it needs matplotlib.
"""

from typing import Any

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Bbox, IdentityTransform, ScaledTranslation

#: points: marks of numbers and between them, their distance from the numbers, width of marks
_LONG, _SHORT, _PAD, _THIN = 3.5, 2.0, 3.5, 0.8
#: points around axes that words are thought to take before they are measured: at the left, above
_BESIDE, _ABOVE = 32.0, 16.0
#: of a pixel, how far beyond the end of an axis a tick is at it
_AT_END = 0.5


class Ruler(Artist):
    """Grid, marks, numbers and label of an axis, `upright` or not, at its near or far side."""

    def __init__(self, axis: Axis, upright: bool) -> None:
        super().__init__()
        self.axis, self.upright = axis, upright
        self.frame: Any = axis.axes
        #: inches from the frame to the label, once it is placed
        self.away: float | None = None
        self._words = Text()
        self.set_zorder(0.5)  # as of axes below what is drawn in them

    def draw(self, renderer: Any) -> None:
        """Draw all of it."""
        if not self._shown():
            return
        look, far = self._look(), self._far()
        places, words = self.ticks()
        frame = self.frame.get_window_extent()
        low, high = (frame.x0, frame.x1) if self.upright else (frame.y0, frame.y1)
        if look["gridOn"]:
            self._lines(renderer, places, low, high, rcParams["grid.linewidth"],
                        rcParams["grid.color"])  # fmt: skip
        if self._marked():
            edge, out = (high, 1.0) if far else (low, -1.0)
            long = renderer.points_to_pixels(look.get("length", _LONG))
            self._lines(renderer, places, edge, edge + out * long, _THIN, "black")
            short = renderer.points_to_pixels(_SHORT)
            self._lines(renderer, self._between(), edge, edge + out * short, 0.6, "black")
        for one in self.numbers(places, words):
            one.draw(renderer)
        if self.axis.label.get_text():
            if self.away is None:
                self.place(renderer)
            self.axis.label.draw(renderer)

    def get_tightbbox(self, renderer: Any = None) -> Bbox | None:
        """What numbers and label cover, in pixels; the label takes no room along its axis."""
        if not self._shown():
            return None
        frame, long = self.frame.get_window_extent(), self._look().get("length", _LONG)
        out = renderer.points_to_pixels(long) * self._marked()
        ends = frame.extents.copy()
        ends[(2 if self._far() else 0) + (not self.upright)] += out if self._far() else -out
        boxes = [Bbox.from_extents(*ends)]
        if (numbers := self.place(renderer)) is not None:
            boxes.append(numbers)
        if self.axis.label.get_text():
            box = self.axis.label.get_window_extent(renderer)
            (x0, y0), (x1, y1) = box.min, box.max
            boxes.append(Bbox([(x0, y1), (x1, y1)] if self.upright else [(x1, y0), (x1, y1)]))
        return Bbox.union(boxes)

    def place(self, renderer: Any) -> Bbox | None:
        """Put the label beyond the numbers; what these cover."""
        boxes = [one.get_window_extent(renderer) for one in self.numbers(*self.ticks())]
        box = Bbox.union(boxes) if boxes else None
        frame, far, dots = self.frame.get_window_extent(), self._far(), self._dots()
        reach = 0.0
        if box is not None:
            beyond = box.max - frame.max if far else frame.min - box.min
            reach = max(float(beyond[0 if self.upright else 1]), 0.0) / dots
        self.move_label(reach + self.axis.labelpad / 72.0)
        return box

    def move_label(self, away: float) -> None:
        """The label so many inches from the frame."""
        self.away, end = away, float(self._far())
        step = away if end else -away
        shift = (step, 0.0) if self.upright else (0.0, step)
        scale = self.frame.figure.dpi_scale_trans
        self.axis.set_label_coords(
            *((end, 0.5) if self.upright else (0.5, end)),
            self.frame.transAxes + ScaledTranslation(*shift, scale),
        )

    def _shown(self) -> bool:
        return bool(self.get_visible() and self.frame.axison and self.frame.get_visible())

    def _marked(self) -> bool:
        look, sides = self._look(), ("left", "right") if self.upright else ("bottom", "top")
        return any(look[side] for side in sides)

    def _dots(self) -> float:
        return float(self.frame.figure.dpi)

    def _far(self) -> bool:
        return self.axis.get_label_position() in ("top", "right")

    def _look(self) -> dict[str, Any]:
        return self.axis.get_tick_params(which="major")

    def _pixels(self, values: Any) -> np.ndarray:
        """Where values of the axis are in the picture, in pixels, those within the frame."""
        values = np.asarray(values, dtype=float)
        along = (
            self.frame.get_yaxis_transform() if self.upright else self.frame.get_xaxis_transform()
        )
        both = np.zeros((values.size, 2))
        both[:, int(self.upright)] = values
        return np.asarray(along.transform(both)[:, int(self.upright)])

    def _within(self, places: np.ndarray) -> np.ndarray:
        frame, i = self.frame.get_window_extent(), int(self.upright)
        return np.asarray((places >= frame.min[i] - _AT_END) & (places <= frame.max[i] + _AT_END))

    def ticks(self) -> tuple[np.ndarray, list[str]]:
        """Places in pixels of what has a number, and the numbers."""
        values = self.axis.get_majorticklocs()
        words = self.axis.get_major_formatter().format_ticks(list(values))
        places = self._pixels(values)
        inside = self._within(places)
        return places[inside], [word for word, kept in zip(words, inside, strict=True) if kept]

    def _between(self) -> np.ndarray:
        """Places of marks without a number."""
        places = self._pixels(self.axis.get_minorticklocs())
        return np.asarray(places[self._within(places)])

    def numbers(self, places: np.ndarray, words: list[str]) -> Any:
        """The numbers one after the other, all of them one text that moves on."""
        look, far, one = self._look(), self._far(), self._words
        named = ("right" if far else "left") if self.upright else ("top" if far else "bottom")
        if not look[f"label{named}"]:
            return
        frame, gap = self.frame.get_window_extent(), self._dots() / 72.0
        gap *= look.get("length", _LONG) + look.get("pad", _PAD)
        turned = float(look.get("rotation", 0.0))
        one.set_figure(self.frame.figure)
        one.set_transform(IdentityTransform())
        one.set_rotation(turned)
        one.set_fontsize(look.get("labelsize", rcParams["xtick.labelsize"]))
        if self.upright:
            edge = frame.x1 + gap if far else frame.x0 - gap
            one.set(ha="left" if far else "right", va="center_baseline")
        else:
            edge = frame.y1 + gap if far else frame.y0 - gap
            slanted = turned % 90.0 != 0.0
            one.set(ha="right" if slanted else "center", va="bottom" if far else "top",
                    rotation_mode="anchor" if slanted else "default")  # fmt: skip
        for place, word in zip(places, words, strict=True):
            if word:
                one.set_text(word)
                one.set_position((edge, place) if self.upright else (place, edge))
                yield one
        more = self.axis.get_major_formatter().get_offset()
        if more:
            one.set_text(more)
            one.set(ha="left" if self.upright else "right", va="bottom", rotation=0.0)
            one.set_position((frame.x0, frame.y1 + gap) if self.upright else
                             (frame.x1, frame.y0 + gap))  # fmt: skip
            yield one

    def _lines(
        self, renderer: Any, places: np.ndarray, low: float, high: float, width: float, colour: str
    ) -> None:
        """Lines across the axis at places of it, all of them one path."""
        if not places.size:
            return
        ends = np.empty((places.size, 2, 2))
        ends[:, :, int(self.upright)] = places[:, None]
        ends[:, :, int(not self.upright)] = low, high
        codes = np.tile(np.array([Path.MOVETO, Path.LINETO], Path.code_type), places.size)
        pen = renderer.new_gc()
        pen.set_linewidth(width)
        pen.set_foreground(colour)
        pen.set_capstyle("butt")
        pen.set_snap(True)
        renderer.draw_path(pen, Path(ends.reshape(-1, 2), codes), IdentityTransform())
        pen.restore()


class Frame(Axes):
    """Axes with rulers, which guess the room of their words before they measure it."""

    def __init__(self, *given: Any, **known: Any) -> None:
        super().__init__(*given, **known)
        self._guessed = False
        self.rulers = tuple(
            Ruler(axis, upright) for axis, upright in ((self.xaxis, False), (self.yaxis, True))
        )
        for one in self.rulers:
            one.axis.set_visible(False)
            self.add_artist(one).set_clip_on(False)
        for spine in self.spines.values():
            spine.set_in_layout(False)  # ticks reach further, and each would look for all of them

    def get_tightbbox(self, renderer: Any = None, **how: Any) -> Bbox | None:
        """What axes and words cover, in pixels: ticks depend on the size, which is not known yet
        when it is asked for the first time.
        """
        if not self._guessed and how.get("for_layout_only") and self.get_visible():
            self._guessed = True
            return self._guess(renderer)
        return super().get_tightbbox(renderer, **how)

    def _guess(self, renderer: Any) -> Bbox:
        """Of long numbers below, and about as much as usual beside and above."""
        figure: Any = self.figure
        frame, point = self.get_window_extent(), figure.dpi / 72.0
        titled = any(self.get_title(loc=place) for place in ("left", "center", "right"))
        beside = Bbox.from_extents(
            frame.x0 - _BESIDE * point * bool(self.get_ylabel()), frame.y0,
            frame.x1, frame.y1 + _ABOVE * point * titled,
        )  # fmt: skip
        below = self.rulers[0].get_tightbbox(renderer)
        return beside if below is None else Bbox.union([beside, below])

    def twinx(self, *given: Any, **known: Any) -> Axes:
        """Axes over the same abscissa, which is drawn once."""
        other = super().twinx(*given, **known)
        if isinstance(other, Frame):
            other.rulers[0].set_visible(False)
        return other


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
    if engine is None:
        return
    figure.set_dpi(dpi)
    engine.execute(figure)
    figure.set_layout_engine(None)
    columns: dict[tuple[float, str], list[Ruler]] = {}
    for one in (axes.rulers[1] for axes in figure.axes if isinstance(axes, Frame)):
        if one.away is not None and one.axis.label.get_text():
            place = round(one.frame.get_position().x0, 3), one.axis.get_label_position()
            columns.setdefault(place, []).append(one)
    for rulers in columns.values():
        away = max(other.away or 0.0 for other in rulers)
        for one in rulers:
            one.move_label(away)
