"""Results of a sweep over two axes as maps, of a sampling as histograms."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, panels_of, plain_ticks
from vibecalc.core.report.sweep.limits import (
    Limit,
    breaking_any,
    judge,
    keeping_all,
)
from vibecalc.core.report.sweep.picture_parts import (
    BEST,
    Picture,
    Shown,
    along,
    entry_words,
    failure_marks,
    hatch_style,
    is_map,
    legend_below,
    limit_words,
    logarithmic,
    name_axis,
    panels,
    pictured,
    short_name,
)
from vibecalc.core.report.sweep.statistics import axis_names, indices_of, sample_statistics
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import show

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


def draw_sweep_map(sweep: SweepView) -> "Figure | None":
    """A map for each result that varies, and one of the limits; None without two long axes."""
    wide = bool(sweep.grid) and is_map(sweep)
    picture = pictured(sweep, max(sweep.shape), _MOST) if wide else None
    if picture is None or len(picture.grid) < 2:
        return None
    count = len(picture.shown) + bool(picture.limits)
    columns = min(2, count)
    first, second = (axis.keys[0].words for axis in picture.grid)
    held = f"; {picture.part.held}" if picture.part.held else ""
    figure = canvas(sweep, f"over {first} and {second}{held}", 1.7 + 3.6 * -(-count // columns))
    # the names of bars of colour are wider than the layout takes them for
    figure.set_layout_engine("constrained", rect=(0.0, 0.0, 0.985, 1.0))
    grid = panels_of(figure, count, columns)
    for axes, one in zip(grid, picture.shown, strict=False):
        _map(figure, axes, picture, one)
    if picture.limits:
        _region(grid[-1], picture)
    marks, star, here = failure_marks(sweep, picture.part.points), picture.star, picture.here
    x, y = map(along, picture.grid)
    for axes in grid:
        for mark in marks:
            across, up = np.nonzero(np.isin(picture.part.points, mark.points))
            axes.plot(x[across], y[up], mark.marker, color=mark.colour, ms=6, mew=1.4, ls="none",
                      label=mark.words, zorder=6)  # fmt: skip
        if here is not None:
            axes.plot(here[:1], here[1:], "o", mfc="white", mec="black", ms=7, ls="none", zorder=7,
                      clip_on=False, label="the case as written")  # fmt: skip
        if star is not None:
            axes.plot(star[1][:1], star[1][1:], **BEST, label=star[2])
        name_axis(axes, picture.grid[0], "x")
        name_axis(axes, picture.grid[1], "y")
        axes.grid(visible=False)
    legend_below(figure, grid)
    return figure


def _map(figure: "Figure", axes: "Axes", picture: Picture, one: Shown) -> None:
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.ticker import MaxNLocator

    (x, y), own = map(along, picture.grid), picture.own(one)
    values = one.values[picture.part.points].T
    finite = values[np.isfinite(values)]
    log = logarithmic(values)
    ends = float(finite.min()), float(finite.max())
    smooth = finite.size == values.size and min(values.shape) >= _SMOOTH and ends[0] < ends[1]
    norm: Any = (LogNorm if log else Normalize)(*ends)
    if smooth:
        inner = MaxNLocator(_LEVELS).tick_values(*ends)
        levels = np.geomspace(*ends, _LEVELS) if log else inner
        drawn: Any = axes.contourf(x, y, values, levels=levels, norm=norm, cmap="viridis")
    else:
        cells = np.ma.masked_invalid(values)
        drawn = axes.pcolormesh(x, y, cells, shading="nearest", norm=norm, cmap="viridis")
    bar = figure.colorbar(drawn, ax=axes, pad=0.02)
    bar.set_label(one.label)
    if log:
        _ticks(bar, ends)
    if np.isinf(values).any():
        rows, columns = np.nonzero(np.isinf(values))
        axes.plot(x[columns], y[rows], "^", color=LIMIT, ls="none", label="unbounded")
    for limit in own:
        _boundary(axes, x, y, values, limit, limit.bound * one.factor, LIMIT, hatch=True)
    words = ", ".join(limit_words(limit) for limit in own)
    note = entry_words(one.worst, picture.part.points)
    below = "; ".join(text for text in (f"limit: {words}" if words else "", note) if text)
    axes.set_title(one.title(below), fontsize=8)


def _ticks(bar: Any, ends: tuple[float, float]) -> None:
    """1, 2, 5 in each decade, in plain numbers."""
    from matplotlib.ticker import NullFormatter

    low, high = (int(np.floor(np.log10(end))) for end in ends)
    marks = [m * 10.0**k for k in range(low, high + 1) for m in (1.0, 2.0, 5.0)]
    inside = [mark for mark in marks if ends[0] <= mark <= ends[1]]
    if len(inside) > 9:
        inside = [mark for mark in inside if np.isclose(np.log10(mark) % 1.0, 0.0)]
    bar.set_ticks(inside, labels=[f"{mark:g}" for mark in inside])
    bar.ax.yaxis.set_minor_formatter(NullFormatter())


def _boundary(
    axes: "Axes",
    x: np.ndarray,
    y: np.ndarray,
    values: np.ndarray,
    limit: Limit,
    bound: float,
    colour: str,
    hatch: bool,
) -> None:
    """The line on which a limit is just kept, its far side hatched.

    Between points that span decades it is drawn straight in the logarithm.
    """
    if bound > 0.0 and logarithmic(values):
        values, bound = np.log(values), float(np.log(bound))
    room = values - bound if limit.side == "max" else bound - values
    beyond = float(np.max(np.abs(room[np.isfinite(room)]), initial=1.0))
    room = np.ma.masked_invalid(np.where(np.isposinf(room), 2.0 * beyond, room))
    if hatch and room.max() > 0.0:
        import matplotlib

        with matplotlib.rc_context({"hatch.color": colour, "hatch.linewidth": 0.6}):
            axes.contourf(x, y, room, levels=[0.0, np.inf], colors="none", hatches=["//"])
    if room.min() < 0.0 < room.max():
        axes.contour(x, y, room, levels=[0.0], colors=[colour], linewidths=2.0)
        words = f"{short_name(limit.quantity)} {limit_words(limit)}"
        axes.plot([], [], color=colour, linewidth=2.0,
                  label="limit, broken on the hatched side" if hatch else words)  # fmt: skip


def _region(axes: "Axes", picture: Picture) -> None:
    """Green where all limits are kept, red where one is broken, yellow where that is undecided.

    A line for each limit.
    """
    from matplotlib.colors import ListedColormap

    (x, y), (sweep, limits, part, _) = map(along, picture.grid), picture
    kept, broken, done = (
        one[part.points].T
        for one in (keeping_all(sweep, limits), breaking_any(sweep, limits), sweep.done)
    )
    state = 1.0 + kept - broken
    colours = ListedColormap([_BROKEN, _UNDECIDED, _KEPT])
    shown = np.ma.masked_where(~done, state)
    axes.pcolormesh(x, y, shown, shading="nearest", cmap=colours, vmin=0.0, vmax=2.0)
    title = "limits: all are kept where it is green"
    if np.any(done & (state == 1.0)):
        title += ",\nundecided where it is yellow: the error reaches over a limit"
    for i, limit in enumerate(limits):
        values = limit.worst.values[part.points].T
        colour = COLOURS[i % len(COLOURS)]
        _boundary(axes, x, y, values, limit, limit.bound, colour, hatch=False)
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

    limits, _ = judge(sweep)
    everywhere = np.arange(sweep.count)
    chosen = panels(sweep, limits, everywhere, _MOST if sweep.indices else 2 * _MOST)
    if not chosen:
        return None
    method = sweep.sampling.replace("_", " ")
    subtitle = f"{sweep.count} points, {method} sampling of " + ", ".join(axis_names(sweep))
    columns = 1 if len(chosen) == 1 and not sweep.indices else 2
    count = len(chosen) * (1 + sweep.indices)
    figure = canvas(sweep, subtitle, 2.0 + 2.9 * -(-count // columns))
    grid = panels_of(figure, count, columns)
    for axes, one in zip(grid[:: 1 + sweep.indices], chosen, strict=True):
        _histogram(axes, sweep, one, [x for x in limits if x.quantity == one.path])
    for axes, one in zip(grid[1::2] if sweep.indices else (), chosen, strict=False):
        _bars(axes, sweep, one)
    crosses = {
        mark.words: Line2D([], [], color=mark.colour, marker=mark.marker, ls="none", mew=1.8)
        for mark in failure_marks(sweep, everywhere)
    }
    legend_below(figure, grid, crosses)
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
    axes.set_title(one.title(note), fontsize=8)
    axes.set_xlabel(one.label)
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
