"""Figure and axes of pictures: matplotlib's own, which measure their words once and not often.

matplotlib looks for the place of a label again whenever it measures or draws axes, next to those of
all its neighbours, and lays out twice since ticks depend on the size. Here the first time is a
guess, and the labels stay where they were found to have room.
"""

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox, ScaledTranslation

#: points around axes that words are thought to take before they are measured: labels, title
_LABEL, _TITLE = 32.0, 16.0


class Frame(Axes):
    """Axes that guess the room of their words, measure it once, and keep their labels there."""

    def __init__(self, *given: Any, **known: Any) -> None:
        super().__init__(*given, **known)
        self._guessed = False
        for spine in self.spines.values():
            spine.set_in_layout(False)  # ticks reach further, and each would look for all of them

    def get_tightbbox(self, renderer: Any = None, **how: Any) -> Bbox | None:
        """What axes and words cover, in pixels."""
        if how.get("for_layout_only") and self.get_visible() and self.get_aspect() == "auto":
            if not self._guessed:
                self._guessed = True
                return self._guess()
            self._place_labels(renderer)
        return super().get_tightbbox(renderer, **how)

    def _guess(self) -> Bbox:
        frame, point = self.get_window_extent(), self.get_figure(root=True).dpi / 72.0
        titled = any(self.get_title(loc=place) for place in ("left", "center", "right"))
        return Bbox.from_extents(
            frame.x0 - _LABEL * point * bool(self.get_ylabel()),
            frame.y0 - _LABEL * point * bool(self.get_xlabel()),
            frame.x1, frame.y1 + _TITLE * point * titled,
        )  # fmt: skip

    def _place_labels(self, renderer: Any) -> None:
        """Labels beyond the numbers of their axes, kept so far from the frame in inches."""
        frame, dots = self.get_window_extent(), self.get_figure(root=True).dpi
        for axis, upright in ((self.xaxis, False), (self.yaxis, True)):
            if not axis.label.get_text():
                continue
            far = axis.get_label_position() in ("top", "right")
            self.place_label(upright, far, 0.0)  # or matplotlib would look for a place
            axis.label.set_visible(False)
            box = axis.get_tightbbox(renderer) or frame
            axis.label.set_visible(True)
            reach = float((box.max - frame.max if far else frame.min - box.min)[int(not upright)])
            self.place_label(upright, far, max(reach, 0.0) / dots + axis.labelpad / 72.0)

    def place_label(self, upright: bool, far: bool, away: float) -> None:
        """The label of an axis so many inches `away` from it, at its near or far side."""
        axis, step, end = self.yaxis if upright else self.xaxis, away if far else -away, float(far)
        shift = (step, 0.0) if upright else (0.0, step)
        scale = self.get_figure(root=True).dpi_scale_trans
        axis.set_label_coords(
            *((end, 0.5) if upright else (0.5, end)), self.transAxes + ScaledTranslation(*shift, scale)
        )


class Sheet(Figure):
    """A figure whose axes are frames, unless it is said otherwise."""

    def add_subplot(self, *given: Any, **known: Any) -> Axes:
        """Axes in a grid."""
        if "projection" not in known:
            known.setdefault("axes_class", Frame)
        return super().add_subplot(*given, **known)
