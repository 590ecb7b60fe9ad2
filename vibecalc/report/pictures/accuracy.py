"""Error against seconds: a panel for each topic, a line for each method."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibecalc.report.accuracy.view import RungView, TopicView, topics_of
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, TOTAL, canvas
from vibecalc.report.tables import fold
from vibecalc.results.accuracy_layout import is_accuracy
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ACROSS = 3
#: more methods than these are named beside the panel
_INSIDE = 5
#: letters of a title in an inch
_LETTERS = 9
_WORDS = (
    "worst relative error over seconds; filled: the front; ring: what vibecalc takes; "
    "dotted: the truth is known to it"
)
_MARKERS = ("o", "s", "^", "D", "v", "P")

#: errors are drawn from here on; what is exact sits on the lower edge
_LEAST = 1e-17


def picture(result: Result) -> "Figure | None":
    """Log-log panels of worst relative error over seconds, None for a result of another kind.

    The front in seconds is filled, what vibecalc takes is ringed, failed settings are crosses on
    the upper edge, at the seconds that the failure took.
    """
    if not is_accuracy(result):
        return None
    topics = topics_of(result)
    across = min(_ACROSS, len(topics))
    down = -(-len(topics) // across)
    widest = max(len(topic.methods) for topic in topics)
    width = (5.4 if widest <= _INSIDE else 7.2) * across
    words = "\n".join(fold(_WORDS, int(_LETTERS * width)))
    figure = canvas(result, words, width, 0.6 + 4.1 * down)
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for axes, topic in zip(panels, topics, strict=False):
        _panel(axes, topic)
    for axes in panels[len(topics) :]:
        axes.set_visible(False)
    return figure


def _panel(axes: "Axes", topic: TopicView) -> None:
    done = [rung for rung in topic.rungs if rung.done and rung.seconds]
    errors = [_height(rung) for rung in done] or [1.0]
    low, top = _span(errors, 2.0)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(*_span([_across(rung) for rung in topic.rungs if rung.seconds] or [1.0], 1.0))
    axes.set_ylim(low, top)
    axes.minorticks_off()
    for place, method in enumerate(topic.methods):
        colour, marker = COLOURS[place % len(COLOURS)], _MARKERS[place % len(_MARKERS)]
        line = "-" if place < len(COLOURS) else "--"
        rungs = [rung for rung in topic.of(method.name) if rung.seconds]
        measured = [rung for rung in rungs if rung.done]
        front = [rung for rung in measured if rung.in_seconds]
        failed = [rung for rung in rungs if not rung.done]
        style: dict[str, Any] = {"color": colour, "marker": marker, "ms": 5}
        _dots(
            axes, measured, linestyle=line, linewidth=1.2, mfc="white", label=method.name, **style
        )
        _dots(axes, front, linestyle="none", **style)
        if failed:
            edge = [_across(rung) for rung in failed]
            axes.plot(edge, [top] * len(edge), "x", color=colour, ms=7, clip_on=False)
    defaults = [rung for rung in done if rung.is_default]
    _dots(axes, defaults, linestyle="none", marker="o", color=TOTAL, mfc="none", ms=12, mew=1.4)
    if topic.agreement > low:
        axes.axhline(topic.agreement, color=LIMIT, linestyle=":", linewidth=1.0)
    axes.set_title("\n".join(fold(f"{topic.words['stage']}: {topic.words['name']}", 44)))
    axes.set_xlabel("seconds")
    axes.set_ylabel("worst relative error")
    if len(topic.methods) <= _INSIDE:
        axes.legend(fontsize=7, loc="best")
    else:
        axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.01, 0.5), frameon=False)


def _dots(axes: "Axes", rungs: Sequence[RungView], **style: Any) -> None:
    axes.plot([_across(rung) for rung in rungs], [_height(rung) for rung in rungs], **style)


def _across(rung: RungView) -> float:
    return rung.seconds or 0.0


def _height(rung: RungView) -> float:
    return max(rung.relative, _LEAST) if math.isfinite(rung.relative) else 1.0


def _span(values: Sequence[float], decades: float) -> tuple[float, float]:
    """Ends of an axis around the values, at least so many decades apart."""
    low, high = math.log10(min(values)) - 0.3, math.log10(max(values)) + 0.3
    more = max(0.5 * (decades - (high - low)), 0.0)
    return 10.0 ** (low - more), 10.0 ** (high + more)
