"""Energies of the operations with each balance: mean, peak, what the weights' angle can do."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, QUIET, TOTAL, canvas
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/operations/"
_AXES = ("operation", "balance")
_KINDS = ("kinetic", "potential")
_GROUP = 0.68
#: places of a peak's diamond and, beside it, of its range, in widths of a bar from the middle
_PEAK, _BESIDE = 0.12, 0.37
#: a range below this share of the energy is none
_NARROW = 1e-6


def picture(result: Result) -> "Figure | None":
    """A panel for each kind of energy; None without combinations."""
    record = result.record
    found = [
        (kind, mean)
        for kind in _KINDS
        if (mean := having(record, f"{_STEM}{kind}_energy/mean", *_AXES)) is not None
    ]
    if not found:
        return None
    subtitle = "energies of the operations with each balance"
    figure = canvas(result, subtitle, 8.8, 1.5 + 3.4 * len(found))
    panels = list(figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0])
    for axes, (kind, mean) in zip(panels, found, strict=True):
        _bars(axes, record, kind, mean)
        _together(axes, record, kind, mean)
        axes.set_ylabel(f"{kind} energy in {mean.unit}")
        axes.set_ylim(bottom=0.0)
        axes.margins(y=0.12)
        axes.grid(visible=False, axis="x")
    balances = labels(found[0][1].axes[1])
    panels[-1].set_xticks(range(len(balances)), [f"balance {name}" for name in balances])
    # A few groups keep to the middle: bars as broad as the page are hard to compare.
    aside = max(0.5, 0.5 * (3.2 - len(balances)))
    panels[-1].set_xlim(-aside, len(balances) - 1.0 + aside + 0.12)
    _legend(figure, panels[0])
    return figure


def _legend(figure: "Figure", axes: "Axes") -> None:
    """Each entry once: bars, then diamonds, then lines."""
    once = {words: handle for handle, words in zip(*axes.get_legend_handles_labels(), strict=True)}
    ends = (": mean", ": peak", "of the weights", "weighted mean")
    ordered = [words for end in ends for words in once if words.endswith(end)]
    handles = [once[words] for words in ordered]
    figure.legend(handles, ordered, loc="outside lower center", ncols=3, fontsize=9)


def _bars(axes: "Axes", record: Record, kind: str, mean: Quantity) -> None:
    """One bar for each operation, its peak as a diamond, both with their range."""
    operations, balances = (labels(axis) for axis in mean.axes)
    stem = f"{_STEM}{kind}_energy/"
    peak = having(record, stem + "peak", *_AXES)
    width = _GROUP / len(operations)
    for i, name in enumerate(operations):
        place = np.arange(len(balances)) + (i - 0.5 * (len(operations) - 1)) * width - 0.06
        colour = COLOURS[i % len(COLOURS)]
        axes.bar(place, mean.values[i], 0.86 * width, color=colour, label=f"{name}: mean")
        _range(axes, record, stem + "mean", i, place - 0.2 * width, "mean")
        if peak is not None:
            axes.plot(
                place + _PEAK * width,
                peak.values[i],
                "D",
                color=colour,
                markeredgecolor="white",
                markersize=7,
                label=f"{name}: peak",
                zorder=4,
            )
            _range(axes, record, stem + "peak", i, place + _BESIDE * width, "peak")


def _range(axes: "Axes", record: Record, path: str, i: int, place: np.ndarray, what: str) -> None:
    """The range of means in full lines, that of peaks in dashes, so that the legend parts them."""
    low, high = (having(record, f"{path}_{end}", *_AXES) for end in ("low", "high"))
    if low is None or high is None:
        return
    least, most = np.asarray(low.values[i]), np.asarray(high.values[i])
    wide = most - least > _NARROW * np.abs(most)
    if not wide.any():
        return
    half = 0.5 * (most - least)[wide]
    drawn = axes.errorbar(
        place[wide],
        least[wide] + half,
        yerr=half,
        fmt="none",
        ecolor=TOTAL,
        elinewidth=1.2,
        capsize=4,
        label=f"range of the {what} over the angle of the weights",
        zorder=3,
    )
    if what == "peak":
        for bar in drawn[2]:
            bar.set_linestyle((0, (2, 1.5)))


def _together(axes: "Axes", record: Record, kind: str, mean: Quantity) -> None:
    """The weighted mean as a line across a group, and how far the operations are apart."""
    weighted = having(record, f"{_STEM}{kind}_energy/weighted", "balance")
    apart = having(record, f"{_STEM}{kind}_energy/difference", "balance")
    for j in range(mean.values.shape[1]):
        left, right = j - 0.5 * _GROUP - 0.06, j + 0.5 * _GROUP - 0.06
        if weighted is not None:
            height = float(weighted.values[j])
            words = "weighted mean" if j == 0 else None
            axes.plot([left, right], [height] * 2, "--", color=TOTAL, label=words, zorder=5)
        if apart is None:
            continue
        low, high = float(np.min(mean.values[:, j])), float(np.max(mean.values[:, j]))
        axes.annotate(
            "",
            (right + 0.05, high),
            (right + 0.05, low),
            arrowprops={"arrowstyle": "<->", "color": QUIET, "shrinkA": 0, "shrinkB": 0},
        )
        axes.annotate(
            f"{show(float(apart.values[j]), digits=3)} {apart.unit}\napart",
            (right + 0.05, 0.5 * (low + high)),
            xytext=(4, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
            color=QUIET,
        )
