"""Results of a sweep over two axes as maps, and the region where all limits are kept."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.pictures.canvas import COLOURS, LIMIT, canvas
from vibecalc.report.pictures.sweep_parts import (
    BEST,
    Mark,
    Plane,
    Shown,
    along,
    best_words,
    entry_words,
    failure_marks,
    is_map,
    legend_below,
    limit_words,
    logarithmic,
    name_axis,
    panels,
    plane,
)
from vibecalc.report.sweep.limits import Limit, best, breaking_any, judge, keeping_all
from vibecalc.report.sweep.nearest import case_values
from vibecalc.report.sweep.view import SweepView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 5
_LEVELS = 14
#: axes from which on filled contours say more than cells
_SMOOTH = 9
_BROKEN, _UNDECIDED, _KEPT = "#f4d9dc", "#f2e6b8", "#cfe8cf"


def picture(sweep: SweepView) -> "Figure | None":
    """A map for each result that varies, and one of the limits; None without two long axes."""
    if not sweep.grid or not is_map(sweep):
        return None
    limits, _ = judge(sweep)
    part = plane(sweep, limits, max(sweep.shape))
    chosen = panels(sweep, limits, part.points, _MOST)
    if not chosen or len(part.axes) < 2:
        return None
    count = len(chosen) + bool(limits)
    columns = min(2, count)
    rows = -(-count // columns)
    first, second = (sweep.grid[i].keys[0].words for i in part.axes)
    subtitle = f"over {first} and {second}" + (f"; {part.held}" if part.held else "")
    figure = canvas(sweep, subtitle, 5.0 * columns, 1.7 + 3.6 * rows)
    grid = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for axes, one in zip(grid, chosen, strict=False):
        _map(figure, axes, sweep, part, one, [x for x in limits if x.quantity == one.path])
    if limits:
        _region(grid[len(chosen)], sweep, part, limits)
    marks = failure_marks(sweep, part.points)
    found = best(sweep, limits)
    for axes in grid[:count]:
        _points(axes, sweep, part, marks)
        _here(axes, sweep, part)
        if found is not None and found[0] in part.points:
            x, y = _place(sweep, part, found[0])
            axes.plot([x], [y], **BEST, label=best_words(sweep, found[1], found[0]))
        name_axis(axes, sweep.grid[part.axes[0]], "x")
        name_axis(axes, sweep.grid[part.axes[1]], "y")
        axes.grid(visible=False)
    for axes in grid[count:]:
        axes.set_visible(False)
    legend_below(figure, grid[:count])
    return figure


def _map(
    figure: "Figure", axes: "Axes", sweep: SweepView, part: Plane, one: Shown, own: Sequence[Limit]
) -> None:
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.ticker import MaxNLocator

    x, y = (along(sweep.grid[i]) for i in part.axes)
    values = one.values[part.points].T
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
    bar.set_label(one.unit)
    if log:
        _ticks(bar, ends)
    if np.isinf(values).any():
        rows, columns = np.nonzero(np.isinf(values))
        axes.plot(x[columns], y[rows], "^", color=LIMIT, ms=5, ls="none", label="unbounded")
    for limit in own:
        _boundary(axes, x, y, values, limit, limit.bound * one.factor, LIMIT, hatch=True)
    words = ", ".join(limit_words(limit) for limit in own)
    note = entry_words(one.worst, part.points)
    below = "; ".join(text for text in (f"limit: {words}" if words else "", note) if text)
    axes.set_title(one.path + (f"\n{below}" if below else ""), fontsize=9.5)


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
        axes.plot([], [], color=colour, linewidth=2.0, label=_line_words(limit, hatch))


def _line_words(limit: Limit, hatch: bool) -> str:
    return (
        "limit, broken on the hatched side" if hatch else f"{limit.quantity} {limit_words(limit)}"
    )


def _region(axes: "Axes", sweep: SweepView, part: Plane, limits: Sequence[Limit]) -> None:
    """Green where all limits are kept, red where one is broken, yellow where that is undecided.

    A line for each limit.
    """
    from matplotlib.colors import ListedColormap

    x, y = (along(sweep.grid[i]) for i in part.axes)
    kept = keeping_all(sweep, limits)[part.points].T
    broken = breaking_any(sweep, limits)[part.points].T
    done = sweep.done[part.points].T
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
    axes.set_title(title, fontsize=9.5)


def _points(axes: "Axes", sweep: SweepView, part: Plane, marks: Sequence[Mark]) -> None:
    x, y = (along(sweep.grid[i]) for i in part.axes)
    for mark in marks:
        columns, rows = np.nonzero(np.isin(part.points, mark.points))
        axes.plot(x[columns], y[rows], mark.marker, color=mark.colour, ms=6, mew=1.4, ls="none",
                  label=mark.words, zorder=6)  # fmt: skip


def _here(axes: "Axes", sweep: SweepView, part: Plane) -> None:
    """The case itself, where it lies inside."""
    found = case_values(sweep)
    if found is None:
        return
    places = [sweep.together[i][0] for i in part.axes]
    x, y = (float(found[place]) * sweep.keys[place].factor for place in places)
    spans = [along(sweep.grid[i]) for i in part.axes]
    inside = all(s.min() <= value <= s.max() for s, value in zip(spans, (x, y), strict=True))
    if inside:
        axes.plot([x], [y], "o", mfc="white", mec="black", ms=7, ls="none", zorder=7,
                  clip_on=False, label="the case as written")  # fmt: skip


def _place(sweep: SweepView, part: Plane, point: int) -> tuple[float, float]:
    column, row = (int(place) for place in np.argwhere(part.points == point)[0])
    x, y = (along(sweep.grid[i]) for i in part.axes)
    return float(x[column]), float(y[row])
