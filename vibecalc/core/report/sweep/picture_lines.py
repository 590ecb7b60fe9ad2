"""Results of a sweep along one axis, a line for each value of a short second one."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    PLATE,
    QUIET,
    canvas,
    gaps,
    keep_apart,
    note,
    panels_of,
    plain_ticks,
    unit_words,
)
from vibecalc.core.report.sweep.limits import Limit
from vibecalc.core.report.sweep.picture_parts import (
    BEST,
    FEW,
    Mark,
    Picture,
    Plane,
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
    pictured,
    together,
)
from vibecalc.core.report.sweep.statistics import entries
from vibecalc.core.report.sweep.view import SweepView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Names of many lines at their right ends, shifted apart where the lines come close.
# ----------------------------------------------------------------------------

#: least distance of two names, as a share of the height of a panel
_APART = 0.042
#: after each round of colours another line
_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.4)))


def line_style(place: int) -> dict[str, Any]:
    """Colour and dashes of the line with this number; 18 lines differ."""
    return {
        "color": COLOURS[place % len(COLOURS)],
        "ls": _STYLES[place // len(COLOURS) % len(_STYLES)],
    }


def name_ends(axes: "Axes", x: np.ndarray, drawn: np.ndarray, names: tuple[str, ...]) -> None:
    """Names behind the last finite value of each line (points, lines), in the order of these.

    The scale of the panel must be final.
    """
    found: list[tuple[float, int, float]] = []
    for i in range(drawn.shape[1]):
        finite = np.flatnonzero(np.isfinite(drawn[:, i]))
        if finite.size:
            end = finite[-1]
            pixel = axes.transData.transform((x[end], drawn[end, i]))
            found.append((float(axes.transAxes.inverted().transform(pixel)[1]), i, x[end]))
    found.sort()
    heights = keep_apart(np.array([height for height, _, _ in found]), _APART)
    for height, (_, i, end) in zip(heights, found, strict=True):
        note(axes, names[i].split("=")[-1], (end, height), (5, 0),
            xycoords=("data", "axes fraction"), va="center", color=line_style(i)["color"],
            annotation_clip=False)  # fmt: skip


# ----------------------------------------------------------------------------
# Where an order meets a natural frequency on a picture over the crank speed.
# ----------------------------------------------------------------------------

_SPEED = "machine.speed"
_MODES = "modes/natural_frequency"
_ORDERS = (1, 2)


def resonances(axes: "Axes", sweep: SweepView, part: Plane) -> None:
    """Dotted lines, if x is the crank speed and the sweep keeps the natural frequencies."""
    axis = sweep.grid[part.axes[0]]
    path = next((path for path in sweep.quantities if path.endswith(_MODES)), None)
    if path is None or axis.keys[0].key != _SPEED:
        return
    natural, _ = entries(sweep, path)
    known = natural[np.ravel(part.points)]
    known = known[~np.isnan(known).any(axis=1)]
    # a suspension that changes with what else is swept has no one place to mark
    if not len(known) or np.any(np.ptp(known, axis=0) > 1e-6 * np.abs(known[0])):
        return
    x, factor = along(axis), axis.keys[0].factor
    for order in _ORDERS:
        at = np.sort(known[0]) / order * factor
        inside = at[(at > x.min()) & (at < x.max())]
        for place in inside:
            axes.axvline(place, color=QUIET, linestyle=":", linewidth=0.9, zorder=0)
        if inside.size:
            count = "" if inside.size == 1 else f", {inside.size} modes"
            note(axes, f"order {order}{count}", (inside[0], 0.98), (-2, 0),
                xycoords=axes.get_xaxis_transform(), rotation=90, ha="right", va="top",
                color=QUIET, bbox=PLATE)  # fmt: skip


# ----------------------------------------------------------------------------
# Results of a sweep along one axis, a line for each value of a short second one.
# ----------------------------------------------------------------------------

_MOST = 6
#: a limit further beyond the data than this is said, not drawn
_FAR = 4.0
#: entries of these axes are alike; those of others get a line each if they are few
_ALIKE = ("order", "direction", "mount", "cylinder", "coordinate", "crank_angle", "mode")
_ENTRIES = 4
#: levels are not alike: one may fall by 10 dB below another; their names stand at the end
_LEVELS = 12
#: standard errors of more points than these are a band
_DENSE = 30


def draw_sweep_line(sweep: SweepView) -> "Figure | None":
    """A panel for each result that varies; None for samplings and for two long axes."""
    picture = pictured(sweep, FEW, _MOST) if sweep.grid and not is_map(sweep) else None
    if picture is None:
        return None
    axis, shown, star = picture.grid[0], picture.shown, picture.star
    # a case that is a sweep says it in its title already
    over = "" if " over " in str(sweep.case.get("title") or "") else f"over {axis.keys[0].words}"
    subtitle = "; ".join(words for words in (over, picture.part.held) if words)
    columns = 1 if len(shown) == 1 else 2
    figure = canvas(sweep, subtitle, 1.9 + 3.1 * -(-len(shown) // columns))
    grid = panels_of(figure, len(shown), columns, sharex=True)
    marks = failure_marks(sweep, picture.part.points)
    for axes, one in zip(grid, shown, strict=True):
        _panel(axes, picture, one)
        _failures(axes, picture, marks)
        name_axis(axes, axis, "x")
        axes.xaxis.set_tick_params(labelbottom=True)
        if star is not None:
            axes.plot(star[1][:1], [one.values[star[0]]], **BEST, label=star[2])
    legend_below(figure, grid)
    return figure


def _numbers(part: Plane) -> np.ndarray:
    """Points (x, lines)."""
    return part.points if part.points.ndim == 2 else part.points[:, None]


def _panel(axes: "Axes", picture: Picture, one: Shown) -> None:
    sweep, part, own = picture.sweep, picture.part, picture.own(one)
    x, numbers = along(picture.grid[0]), _numbers(part)
    separate = _separate(sweep, part, one)
    line = "none" if picture.grid[0].keys[0].names else "-"
    style: dict[str, Any] = {"ls": line, "marker": "o" if x.size <= 40 else None, "ms": 4}
    at_end = False
    if separate is None:
        drawn, spread = one.values[numbers], one.worst.spread
        for i, *others in together(drawn):
            colour = COLOURS[i % len(COLOURS)]
            if spread is not None:
                _spread(axes, x, gaps(drawn[:, i]), spread[numbers[:, i]] * one.factor, colour)
            label = _series(picture, [i, *others])
            axes.plot(x, gaps(drawn[:, i]), color=colour, label=label, **style)
        words = [entry_words(one.worst, part.points)]
    else:
        drawn, names = separate
        at_end = len(names) > _ENTRIES
        for i, name in enumerate(names):
            look = style | line_style(i) | ({"ls": "none"} if line == "none" else {})
            axes.plot(x, gaps(drawn[:, i]), label=None if at_end else name, **look)
        words = [f"{sweep.quantities[one.path].axes[0].name} at the right"] * at_end
    unbounded = np.isinf(drawn).any(axis=1)
    if unbounded.any():
        places = np.full(np.count_nonzero(unbounded), 0.97)
        axes.plot(x[unbounded], places, "^", color=LIMIT, transform=axes.get_xaxis_transform(),
                  label="unbounded", clip_on=False)  # fmt: skip
    if one.worst.spread is not None:
        words.append(f"{'bars' if x.size <= _DENSE else 'band'}: standard error")
    axes.set_title(one.title("; ".join(filter(None, words))), fontsize=8)
    axes.set_ylabel(one.label)
    _scale(axes, drawn, own, one)
    _undecided(axes, x, one, own, numbers)
    resonances(axes, sweep, part)
    if separate is not None:
        if at_end:
            name_ends(axes, x, drawn, names)
        if picture.here is not None:
            axes.axvline(
                picture.here[0], color="black", ls="--", lw=1.0, label="the case as written"
            )


def _undecided(
    axes: "Axes", x: np.ndarray, one: Shown, own: Sequence[Limit], numbers: np.ndarray
) -> None:
    """Error bars where they reach over a limit."""
    for limit in own:
        rows, columns = np.nonzero(~(limit.kept | limit.broken | np.isnan(limit.margin))[numbers])
        if rows.size:
            points = numbers[rows, columns]
            value, error = (one.factor * part[points] for part in limit.worst[:2])
            axes.errorbar(x[rows], value, error, fmt="none", ecolor=QUIET, capsize=3,
                          label="error where it reaches over a limit: undecided")  # fmt: skip
            return


def _spread(axes: "Axes", x: np.ndarray, y: np.ndarray, spread: np.ndarray, colour: str) -> None:
    if x.size <= _DENSE:
        axes.errorbar(x, y, spread, fmt="none", ecolor=colour, capsize=4)
    else:
        axes.fill_between(x, y - spread, y + spread, color=colour, alpha=0.2, linewidth=0.0)


def _series(picture: Picture, places: list[int]) -> str | None:
    if len(picture.grid) < 2:
        return None
    axis, key = picture.grid[1], picture.grid[1].keys[0]
    values = ", ".join(key.shown(axis.values[place, 0]) for place in places)
    return f"{key.words} = {unit_words(values)[1]}"


def _separate(
    sweep: SweepView, part: Plane, one: Shown
) -> tuple[np.ndarray, tuple[str, ...]] | None:
    """Entries that are unlike each other and few, where nothing else asks for several lines."""
    own, levels = sweep.quantities[one.path].axes, sweep.quantities[one.path].unit == "dB"
    if len(part.axes) > 1 or len(own) != 1 or (own[0].name in _ALIKE and not levels):
        return None
    if not 2 <= len(own[0].values) <= (_LEVELS if levels else _ENTRIES):
        return None
    values, names = entries(sweep, one.path)
    return values[part.points] * one.factor, names


def _scale(axes: "Axes", drawn: np.ndarray, own: Sequence[Limit], one: Shown) -> None:
    finite = drawn[np.isfinite(drawn)]
    low, high = float(finite.min()), float(finite.max())
    reach = _FAR * max(abs(low), abs(high))
    placed = [(limit, limit.bound * one.factor) for limit in own]
    near = [(limit, bound) for limit, bound in placed
            if abs(bound) <= reach or np.any(np.isfinite(limit.margin) & ~limit.kept)]  # fmt: skip
    bounds = [bound for _, bound in near]
    low, high = min([low, *bounds]), max([high, *bounds])
    if logarithmic(drawn) and all(bound > 0.0 for bound in bounds):
        axes.set_yscale("log")
        axes.set_ylim(low / 1.5, 1.8 * high)
        if high < 1e4 * low:
            plain_ticks(axes.yaxis)
    elif bounds:
        room = 0.12 * (high - low or abs(high) or 1.0)
        axes.set_ylim(0.0 if 0.0 <= low < 0.5 * high else low - room, high + room)
    else:
        axes.margins(y=0.1)
    bottom, top = axes.get_ylim()
    for limit, bound in near:
        upper, end = limit.side == "max", _freer_end(drawn, bound)
        axes.axhline(bound, color=LIMIT, linewidth=1.4)
        axes.axhspan(*((bound, top) if upper else (bottom, bound)), zorder=0.5, **hatch_style())
        note(axes, limit_words(limit), (end, bound), (4 - 8 * end, -3 if upper else 3),
            xycoords=axes.get_yaxis_transform(), ha="right" if end else "left",
            va="top" if upper else "bottom", color=LIMIT, zorder=7)  # fmt: skip
    axes.set_ylim(bottom, top)
    far = ", ".join(limit_words(limit) for limit, bound in placed if bound not in bounds)
    if far:
        axes.annotate(f"limit {far}: kept everywhere", (0.02, 0.97), xycoords="axes fraction",
                      va="top", color=LIMIT, fontsize=8)  # fmt: skip


def _freer_end(drawn: np.ndarray, bound: float) -> int:
    """0 for the left and 1 for the right, where lines leave more room at the height of a limit."""
    away = np.abs(np.where(np.isfinite(drawn), drawn, np.inf) - bound)
    third = max(1, len(away) // 3)
    return int(away[-third:].min() >= away[:third].min())


def _failures(axes: "Axes", picture: Picture, marks: Sequence[Mark]) -> None:
    x, numbers = along(picture.grid[0]), _numbers(picture.part)
    for mark in marks:
        rows, columns = np.nonzero(np.isin(numbers, mark.points))
        # one row of crosses for each line
        height = 0.04 + 0.05 * columns
        axes.plot(x[rows], height, mark.marker, color=mark.colour, ms=8, mew=1.8,
                  transform=axes.get_xaxis_transform(), label=mark.words, zorder=6)  # fmt: skip
