"""Mean force in the joint against its clearance, with standard error and spread."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, QUIET, canvas
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.report.sections.impact import standard_errors
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/impact/"
#: ratio of the largest to the smallest from which an axis is logarithmic
_WIDE = 8.0
_WORDS = 8
_OTHERS = (
    ("peak_force", "largest force of a turn, mean", COLOURS[1], "s--"),
    ("average_amplitude", "mean of the joint force's spectrum over its orders", COLOURS[2], "D:"),
)


def picture(result: Result) -> "Figure | None":
    """Mean with error bars and the band of single turns, peak, mean of the spectrum; None without.

    Where forces or clearances span decades their axis is logarithmic.
    """
    record = result.record
    quantity = having(record, _STEM + "mean_force", "clearance")
    if quantity is None:
        return None
    play = 1e3 * np.asarray(quantity.axes[0].values, dtype=float)
    order = np.argsort(play)
    play = play[order]
    figure = canvas(result, "force of impacts against clearance", 7.8, 5.4)
    axes = figure.subplots()
    drawn = [_mean(axes, record, quantity, play, order)]
    for name, words, colour, mark in _OTHERS:
        other = having(record, _STEM + name, "clearance")
        if other is not None:
            values = np.asarray(other.values, dtype=float)[order]
            axes.plot(play, values, mark, color=colour, label=words, linewidth=1.3)
            drawn.append(values)
    _scales(axes, play, np.concatenate(drawn))
    axes.set_xlabel("clearance in mm")
    axes.set_ylabel(f"force in {quantity.unit}")
    figure.legend(loc="outside lower center", fontsize=9, ncols=2)
    return figure


def _mean(
    axes: "Axes", record: Record, quantity: Quantity, play: np.ndarray, order: np.ndarray
) -> np.ndarray:
    """Draw the mean force, its standard error and the band of single turns; return the mean."""
    force = np.asarray(quantity.values, dtype=float)[order]
    low, high = (having(record, f"{_STEM}mean_force_{end}", "clearance") for end in ("low", "high"))
    if low is not None and high is not None:
        ends = np.asarray(low.values)[order], np.asarray(high.values)[order]
        words = "mean force, 5 to 95 % of turns"
        if play.size > 1:
            axes.fill_between(play, *ends, color=COLOURS[5], alpha=0.35, linewidth=0.0, label=words)
        else:
            axes.vlines(play, *ends, color=COLOURS[5], linewidth=9.0, label=words)
    spread = standard_errors(record, "mean_force")
    words, bars = "mean force", None
    if spread is not None:
        words = "mean force and its standard error"
        # A bar that reaches below zero would have no end on a logarithmic axis.
        bars = np.array([np.minimum(spread[order], 0.9 * np.abs(force)), spread[order]])
    axes.errorbar(play, force, bars, fmt="o-", color=COLOURS[0], capsize=5, label=words)
    # Above its point, or beside the band that a single point stands on.
    place: dict[str, Any] = (
        {"xytext": (0, 9), "ha": "center"} if play.size > 1 else {"xytext": (14, -4)}
    )
    if play.size <= _WORDS:
        for x, y in zip(play, force, strict=True):
            axes.annotate(
                f"{show(y, digits=3)} {quantity.unit}",
                (x, y),
                textcoords="offset points",
                fontsize=9,
                **place,
            )
    return np.asarray(force)


def _scales(axes: "Axes", play: np.ndarray, force: np.ndarray) -> None:
    if play.min() > 0.0 and play.max() / play.min() > _WIDE:
        axes.set_xscale("log")
        axes.set_xlim(play.min() / 1.6, 1.6 * play.max())
        plain_ticks(axes.xaxis)
    elif play.size == 1:
        axes.set_xlim(0.0, 2.0 * play[0])
    else:
        axes.margins(x=0.12)
    if force.min() > 0.0 and force.max() / force.min() > _WIDE:
        axes.set_yscale("log")
        plain_ticks(axes.yaxis)
        axes.set_ylim(force.min() / 2.0, 2.0 * force.max())
    else:
        axes.set_ylim(bottom=0.0)
        axes.margins(y=0.15)
    axes.axhline(0.0, color=QUIET, linewidth=0.6)
