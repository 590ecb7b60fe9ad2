"""Results of a sweep over two axes as maps, of a sampling as histograms."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    palette,
    panels_of,
    plain_ticks,
    ticks,
)
from vibecalc.core.report.sections import read_as
from vibecalc.core.report.sweep.limits import Limit, judge
from vibecalc.core.report.sweep.picture_parts import (
    BEST,
    Picture,
    Shown,
    along,
    axis_title,
    entry_words,
    failure_marks,
    is_map,
    legend_below,
    logarithmic,
    panels,
    pictured,
)
from vibecalc.core.report.sweep.statistics import axis_names, indices_of, sample_statistics
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import show
from vibecalc.core.results.sweep_file import SweptAxis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Results of a sweep over two axes as maps, and the region where all limits are kept.
# ----------------------------------------------------------------------------

_MOST = 5
_LEVELS = 14
#: axes from which on filled contours say more than cells
_SMOOTH = 9
_BROKEN, _UNDECIDED, _KEPT = "#f4d9dc", "#f2e6b8", "#cfe8cf"
_BEYOND = "limit, broken on the hatched side"


def draw_sweep_map(sweep: SweepView) -> "Figure | None":
    """A map for each result that varies, and one of the limits; None without two long axes."""
    wide = bool(sweep.grid) and is_map(sweep)
    picture = pictured(sweep, max(sweep.shape), _MOST) if wide else None
    if picture is None or len(picture.grid) < 2:
        return None
    count = len(picture.shown) + bool(picture.judged.limits)
    columns = min(2, count)
    first, second = (axis.keys[0].label for axis in picture.grid)
    held = f"; {picture.held}" if picture.held else ""
    figure = canvas(sweep, f"over {first} and {second}{held}", 1.7 + 3.6 * -(-count // columns))
    # the names of bars of colour are wider than the layout takes them for
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 0.985, 1.0))
    grid = panels_of(figure, count, columns)
    for axes, one in zip(grid, picture.shown, strict=False):
        _map(figure, axes, picture, one)
    if picture.judged.limits:
        _region(grid[-1], picture)
    star, here, (x, y) = picture.star, picture.here, map(along, picture.grid)
    for axes in grid:
        for mark in picture.marks:
            across, up = np.nonzero(np.isin(picture.points, mark.points))
            axes.plot(x[across], y[up], mark.marker, color=mark.colour, ms=6, mew=1.4, ls="none",
                      label=mark.words, zorder=6)  # fmt: skip
        if here is not None:
            axes.plot(here[:1], here[1:], "o", mfc="white", mec="black", ms=7, ls="none", zorder=7,
                      clip_on=False, label="the case as written")  # fmt: skip
        if star is not None:
            axes.plot(star[1][:1], star[1][1:], **BEST, label=star[2])
        for direction, axis in zip("xy", picture.grid, strict=True):
            _name_axis(axes, axis, direction)
        axes.grid(visible=False)
    legend_below(figure, grid)
    return figure


def _name_axis(axes: "Axes", axis: SweptAxis, direction: str) -> None:
    """Title, scale and, for choices, names of the x or y axis."""
    key, upright = axis.keys[0], getattr(axes, f"{direction}axis")
    upright.set_label_text(axis_title(axis))
    if key.choices:
        ticks(upright, along(axis), [key.shown(value) for value in axis.table[:, 0]])
    elif axis.logarithmic:
        getattr(axes, f"set_{direction}scale")("log")
        plain_ticks(upright)


def _map(figure: "Figure", axes: "Axes", picture: Picture, one: Shown) -> None:
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.ticker import MaxNLocator

    x, y = map(along, picture.grid)
    values = one.values[picture.points].T
    finite = values[np.isfinite(values)]
    log = logarithmic(values)
    ends = float(finite.min()), float(finite.max())
    norm: Any = (LogNorm if log else Normalize)(*ends)
    if finite.size == values.size and min(values.shape) >= _SMOOTH and ends[0] < ends[1]:
        inner = MaxNLocator(_LEVELS).tick_values(*ends)
        levels = np.geomspace(*ends, _LEVELS) if log else inner
        drawn: Any = axes.contourf(x, y, values, levels=levels, norm=norm, cmap="viridis")
    else:
        cells = np.ma.masked_invalid(values)
        drawn = axes.pcolormesh(x, y, cells, shading="nearest", norm=norm, cmap="viridis")
    bar = figure.colorbar(drawn, ax=axes, pad=0.02)
    bar.set_label(one.label)
    if log:
        plain_ticks(bar.ax.yaxis)
    rows, columns = np.nonzero(np.isinf(values))
    if rows.size:
        axes.plot(x[columns], y[rows], "^", color=LIMIT, ls="none", label="unbounded")
    for limit in one.limits:
        _boundary(axes, (x, y, values), limit, limit.bound * one.factor)
    words = ", ".join(limit.words for limit in one.limits)
    note = entry_words(one.worst, picture.points)
    axes.set_title(one.title(f"limit: {words}" if words else "", note), fontsize=8)


def _boundary(
    axes: "Axes", over: tuple[np.ndarray, ...], limit: Limit, bound: float, colour: str = ""
) -> None:
    """The line on which a limit is just kept, of this colour, else its far side hatched.

    Between points that span decades it is drawn straight in the logarithm.
    """
    x, y, values = over
    if bound > 0.0 and logarithmic(values):
        values, bound = np.log(values), float(np.log(bound))
    room = values - bound if limit.side == "max" else bound - values
    beyond = float(np.max(np.abs(room[np.isfinite(room)]), initial=1.0))
    room = np.ma.masked_invalid(np.where(np.isposinf(room), 2.0 * beyond, room))
    if not colour and room.max() > 0.0:
        import matplotlib

        with matplotlib.rc_context({"hatch.color": LIMIT, "hatch.linewidth": 0.6}):
            axes.contourf(x, y, room, levels=[0.0, np.inf], colors="none", hatches=["//"])
    if room.min() < 0.0 < room.max():
        axes.contour(x, y, room, levels=[0.0], colors=[colour or LIMIT], linewidths=2.0)
        words = f"{read_as(limit.quantity, '')[0]} {limit.words}" if colour else _BEYOND
        axes.plot([], [], color=colour or LIMIT, linewidth=2.0, label=words)


def _region(axes: "Axes", picture: Picture) -> None:
    """Green where all limits are kept, red where one is broken, yellow where that is undecided.

    A line for each limit.
    """
    from matplotlib.colors import ListedColormap

    (x, y), judged, points = map(along, picture.grid), picture.judged, picture.points.T
    state = np.ma.masked_invalid(judged.state[points])
    colours = ListedColormap([_BROKEN, _UNDECIDED, _KEPT])
    axes.pcolormesh(x, y, state, shading="nearest", cmap=colours, vmin=-1.0, vmax=1.0)
    title = "green: all limits are met"
    if np.any(judged.open[points]):
        title += "\nyellow: undecided, the error reaches over a limit"
    for i, limit in enumerate(judged.limits):
        _boundary(axes, (x, y, limit.worst.values[points]), limit, limit.bound, palette(i)[0])
    axes.set_title(title, fontsize=8)


# ----------------------------------------------------------------------------
# Results of a sampling: how they scatter, and which keys bring the scatter about.
# ----------------------------------------------------------------------------

_BINS = (8, 60)


def draw_sweep_sample(sweep: SweepView) -> "Figure | None":
    """A histogram for each result, with its Sobol indices next to it; None for a grid."""
    if sweep.grid:
        return None
    from matplotlib.lines import Line2D

    everywhere = np.arange(sweep.count)
    chosen = panels(sweep, judge(sweep), everywhere, _MOST if sweep.indices else 2 * _MOST)
    if not chosen:
        return None
    method = sweep.head.sampling.replace("_", " ")
    subtitle = f"{sweep.count} points, {method} sampling of " + ", ".join(axis_names(sweep))
    columns = 1 if len(chosen) == 1 and not sweep.indices else 2
    count = len(chosen) * (1 + sweep.indices)
    figure = canvas(sweep, subtitle, 2.0 + 2.9 * -(-count // columns))
    grid = panels_of(figure, count, columns)
    for axes, one in zip(grid[:: 1 + sweep.indices], chosen, strict=True):
        _histogram(axes, sweep, one)
    for axes, one in zip(grid[1::2] if sweep.indices else (), chosen, strict=False):
        _bars(axes, sweep, one)
    crosses = {
        mark.words: Line2D([], [], color=mark.colour, marker=mark.marker, ls="none", mew=1.8)
        for mark in failure_marks(sweep, everywhere)
    }
    legend_below(figure, grid, crosses)
    return figure


def _histogram(axes: "Axes", sweep: SweepView, one: Shown) -> None:
    chosen = sweep.independent & np.isfinite(one.values)
    values = one.values[chosen]
    log = logarithmic(values)
    count = int(np.clip(np.sqrt(values.size), *_BINS))
    low, high = float(values.min()), float(values.max())
    edges = np.histogram_bin_edges(values, count)
    if log:
        edges = np.geomspace(low, high, count + 1)
    axes.hist(np.clip(values, low, high), edges.tolist(), color=COLOURS[0], alpha=0.75,
              label="samples")  # fmt: skip
    if log:
        axes.set_xscale("log")
        plain_ticks(axes.xaxis)
    found = sample_statistics(sweep, one.worst)
    notes = [entry_words(one.worst, np.flatnonzero(chosen))]
    if not isinstance(found, str):
        centre, ranks = found
        middle, spread = (
            float(part) * one.factor for part in (centre.value, centre.standard_error)
        )
        axes.axvline(middle, color=TOTAL, linewidth=1.6, label="mean and its standard error")
        axes.axvspan(middle - spread, middle + spread, color=TOTAL, alpha=0.25, linewidth=0.0)
        axes.vlines(np.ravel(ranks.value) * one.factor, 0.0, 1.0, COLOURS[1], ":", linewidth=1.4,
                    label="5, 25, 50, 75 and 95 % quantiles",
                    transform=axes.get_xaxis_transform())  # fmt: skip
        shown = f"mean {show(middle, digits=4)} ± {show(spread, digits=2)} {one.unit}"
        notes.append(shown.rstrip())
    infinite = np.count_nonzero(np.isinf(one.values) & sweep.independent)
    notes += [f"{infinite} unbounded, not drawn"] * bool(infinite)
    notes += [_limit(axes, sweep, one, limit) for limit in one.limits]
    axes.set_title(one.title(*notes), fontsize=8)
    axes.set_xlabel(one.label)
    axes.set_ylabel("samples")
    axes.set_ylim(bottom=0.0)


def _limit(axes: "Axes", sweep: SweepView, one: Shown, limit: Limit) -> str:
    """Draw a limit where it is near; how many of the samples break it."""
    bound = limit.bound * one.factor
    done, broken, open_ = (
        int(np.count_nonzero(sweep.independent & where))
        for where in (sweep.done, limit.broken, limit.open)
    )
    left, right = axes.get_xlim()
    reach = 0.6 * (right - left)
    if left - reach <= bound <= right + reach and not (bound <= 0.0 and axes.get_xscale() == "log"):
        left, right = min(left, bound - 0.03 * reach), max(right, bound + 0.1 * reach)
        axes.axvline(bound, color=LIMIT, linestyle="--", linewidth=1.3, label="limit")
        axes.set_xlim(left, right)
    words = f", undecided by {100.0 * open_ / done:.3g} %" if open_ else ""
    return f"{limit.words}: broken by {100.0 * broken / max(done, 1):.3g} %{words}"


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
        ("first order (alone)", found.first, found.first_spread, -0.2),
        ("total (with interactions)", found.total, found.total_spread, 0.2),
    )
    for i, (words, part, spread, aside) in enumerate(parts):
        axes.barh(place + aside, part, 0.36, color=COLOURS[2 + 2 * i], label=words,
                  xerr=spread, ecolor=TOTAL, capsize=3)  # fmt: skip
    axes.set_yticks(place, names)
    axes.invert_yaxis()
    axes.set_xlim(left=min(0.0, float(np.min(found.first)) - 0.05))
    axes.axvline(0.0, color=QUIET, linewidth=0.8)
    axes.set_xlabel("Sobol index, share of the variance")
    axes.grid(visible=False, axis="y")
