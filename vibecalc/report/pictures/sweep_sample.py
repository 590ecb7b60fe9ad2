"""Results of a sampling: how they scatter, and which keys bring the scatter about."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.pictures.sweep_parts import (
    Shown,
    entry_words,
    failure_marks,
    hatch_style,
    legend_below,
    limit_words,
    logarithmic,
    panels,
)
from vibecalc.report.sweep.limits import Limit, judge
from vibecalc.report.sweep.sampled import axis_names, indices_of, sample_statistics
from vibecalc.report.sweep.view import SweepView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 5
_BINS = (8, 60)


def picture(sweep: SweepView) -> "Figure | None":
    """A histogram for each result, with its Sobol indices beside it; None for a grid."""
    if sweep.grid:
        return None
    from matplotlib.lines import Line2D

    limits, _ = judge(sweep)
    everywhere = np.arange(sweep.count)
    chosen = panels(sweep, limits, everywhere, _MOST if sweep.indices else 2 * _MOST)
    if not chosen:
        return None
    columns = 1 if len(chosen) == 1 and not sweep.indices else 2
    rows = len(chosen) if sweep.indices else -(-len(chosen) // columns)
    method = sweep.sampling.replace("_", " ")
    subtitle = f"{sweep.count} points, {method} sampling of " + ", ".join(axis_names(sweep))
    figure = canvas(sweep, subtitle, 10.0 if columns == 2 else 7.4, 2.0 + 2.9 * rows)
    grid = figure.subplots(rows, columns, squeeze=False)
    left = list(grid[:, 0]) if sweep.indices else list(grid.ravel())
    for axes, one in zip(left, chosen, strict=False):
        _histogram(axes, sweep, one, [x for x in limits if x.quantity == one.path])
    for axes in left[len(chosen) :]:
        axes.set_visible(False)
    if sweep.indices:
        for axes, one in zip(grid[:, 1], chosen, strict=True):
            _bars(axes, sweep, one)
    marks = failure_marks(sweep, np.arange(sweep.count))
    crosses = {
        mark.words: Line2D([], [], color=mark.colour, marker=mark.marker, ls="none", mew=1.8)
        for mark in marks
    }
    legend_below(figure, list(grid.ravel()), crosses)
    return figure


def _histogram(axes: "Axes", sweep: SweepView, one: Shown, own: Sequence[Limit]) -> None:
    chosen = sweep.independent & np.isfinite(one.values)
    values = one.values[chosen]
    log = logarithmic(values)
    count = int(np.clip(np.sqrt(values.size), *_BINS))
    low, high = float(values.min()), float(values.max())
    if low == high:
        low, high = low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0)
    edges = np.geomspace(low, high, count + 1) if log else np.linspace(low, high, count + 1)
    axes.hist(
        np.clip(values, low, high), edges.tolist(), color=COLOURS[0], alpha=0.75, label="samples"
    )
    if log:
        from vibecalc.report.pictures.scales import plain_ticks

        axes.set_xscale("log")
        if high < 1e4 * low:
            plain_ticks(axes.xaxis)
    found = sample_statistics(sweep, one.worst)
    lines = [entry_words(one.worst, np.flatnonzero(chosen))]
    if not isinstance(found, str):
        centre, ranks = found
        middle, spread = (
            float(part) * one.factor for part in (centre.value, centre.standard_error)
        )
        axes.axvline(middle, color=TOTAL, linewidth=1.6, label="mean and its standard error")
        axes.axvspan(middle - spread, middle + spread, color=TOTAL, alpha=0.25, linewidth=0.0)
        quantile = np.ravel(ranks.value) * one.factor
        words = "5, 25, 50, 75 and 95 % quantiles"
        for place, value in enumerate(quantile):
            axes.axvline(value, color=COLOURS[1], linestyle=":", linewidth=1.4,
                         label=words if place == 0 else None)  # fmt: skip
        lines.append(f"mean {show(middle, digits=4)} ± {show(spread, digits=2)} {one.unit}")
    infinite = int(np.count_nonzero(np.isinf(one.values) & sweep.independent))
    if infinite:
        lines.append(f"{infinite} unbounded, not drawn")
    for limit in own:
        lines.append(_limit(axes, sweep, one, limit))
    note = "; ".join(line.rstrip() for line in lines if line)
    axes.set_title(f"{one.path}\n{note}", fontsize=9.5)
    axes.set_xlabel(one.unit or sweep.kept[one.path].long_name)
    axes.set_ylabel("samples")
    axes.set_ylim(bottom=0.0)


def _limit(axes: "Axes", sweep: SweepView, one: Shown, limit: Limit) -> str:
    bound = limit.bound * one.factor
    counted = sweep.independent & sweep.done
    many = max(int(np.count_nonzero(counted)), 1)
    broken, kept = (int(np.count_nonzero(counted & one)) for one in (limit.broken, limit.kept))
    share, open_ = 100.0 * broken / many, 100.0 * (many - broken - kept) / many
    left, right = axes.get_xlim()
    reach = 0.6 * (right - left)
    if left - reach <= bound <= right + reach and not (bound <= 0.0 and axes.get_xscale() == "log"):
        left, right = min(left, bound - 0.03 * reach), max(right, bound + 0.1 * reach)
        axes.axvline(bound, color=LIMIT, linewidth=1.6, label="limit, broken on the hatched side")
        ends = (bound, right) if limit.side == "max" else (left, bound)
        axes.axvspan(*ends, zorder=0.5, **hatch_style())
        axes.set_xlim(left, right)
    words = f", undecided by {open_:.3g} %" if open_ else ""
    return f"{limit_words(limit)}: broken by {share:.3g} %{words}"


def _bars(axes: "Axes", sweep: SweepView, one: Shown) -> None:
    found = indices_of(sweep, one.worst)
    names = axis_names(sweep)
    if isinstance(found, str):
        axes.set_axis_off()
        axes.annotate(found, (0.5, 0.5), xycoords="axes fraction", ha="center", va="center",
                      color=QUIET, wrap=True)  # fmt: skip
        return
    place = np.arange(len(names))
    parts = (
        ("first order (alone)", found.first, -0.2),
        ("total (with interactions)", found.total, 0.2),
    )
    for i, (words, part, aside) in enumerate(parts):
        axes.barh(place + aside, part.value, 0.36, color=COLOURS[2 + 2 * i], label=words,
                  xerr=part.standard_error, ecolor=TOTAL, capsize=3)  # fmt: skip
    axes.set_yticks(place, names)
    axes.invert_yaxis()
    axes.set_xlim(left=min(0.0, float(np.min(found.first.value)) - 0.05))
    axes.axvline(0.0, color=QUIET, linewidth=0.8)
    axes.set_xlabel("Sobol index, share of the variance")
    axes.grid(visible=False, axis="y")
