"""Levels of the shell's acceleration by order: computed, published and measured."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.levels import ROLL, ZERO, oscillating, shell_acts
from vibecalc.report.lookup import having
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.references import MEASURED, ReferenceRow, judge_references
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PATH = ROLL + "level/shell_acceleration"
#: how far the marks of published and measured levels stand beside an order
_ASIDE = 0.22
#: more orders than these get no mark of their own on the axis
_MARKED = 24


def picture(result: Result) -> "Figure | None":
    """One mark for each order and origin; None without levels.

    Whiskers reach over the levels with other interpolations of the gas tables. What is zero by
    symmetry stands as such at the foot.
    """
    level = having(result.record, _PATH, "order")
    if level is None or not oscillating(level).size:
        return None
    chosen = oscillating(level)
    orders = np.asarray(level.axes[0].values)[chosen]
    values = np.asarray(level.values, dtype=float)[chosen]
    acts = shell_acts(result.record, orders) & np.isfinite(values)
    rows = _references(result)
    figure = canvas(result, "angular acceleration of the shell by order", 8.6, 5.4)
    axes = figure.subplots()
    drawn = [*values[acts], *(row.value for row in rows)]
    low, high = (min(drawn), max(drawn)) if drawn else (-1.0, 1.0)
    room = max(0.1 * (high - low), 2.0)
    foot = low - room
    axes.vlines(orders[acts], foot, values[acts], color=COLOURS[0], alpha=0.35, linewidth=5.0)
    axes.plot(orders[acts], values[acts], "o", color=COLOURS[0], ms=7, label="computed", zorder=4)
    _whiskers(axes, result.record, orders, acts)
    _marks(axes, rows)
    for order in orders[~acts]:
        axes.annotate(
            ZERO, (order, foot), xytext=(0, 4), textcoords="offset points", ha="center", color=QUIET
        )
    axes.set_ylim(foot, high + room)
    axes.set_xlim(orders[0] - 0.6, orders[-1] + 0.6)
    if len(orders) <= _MARKED:
        axes.set_xticks(orders)
    axes.grid(visible=False, axis="x")
    axes.set_xlabel("order, multiple of the crank speed")
    axes.set_ylabel("level in dB re 1 rad/s$^2$, zero-to-peak")
    figure.legend(loc="outside lower center", ncols=4, fontsize=9)
    return figure


def _references(result: Result) -> list[ReferenceRow]:
    return [
        row
        for row in judge_references(result)
        if row.quantity == _PATH and "order" in row.where and row.at != "start"
    ]


def _whiskers(axes: "Axes", record: Record, orders: np.ndarray, acts: np.ndarray) -> None:
    """From the lowest to the highest level with any way to read the gas tables."""
    level = having(record, ROLL + "interpolation/level", "interpolant", "order")
    if level is None:
        return
    known = np.asarray(level.axes[1].values)
    places = np.flatnonzero(np.isin(known, orders[acts]))
    if not places.size:
        return
    found = np.asarray(level.values, dtype=float)[:, places]
    low, high = found.min(axis=0), found.max(axis=0)
    axes.errorbar(
        known[places],
        0.5 * (low + high),
        yerr=0.5 * (high - low),
        fmt="none",
        ecolor=TOTAL,
        elinewidth=1.3,
        capsize=5,
        zorder=5,
        label="other ways to read the gas tables",
    )


def _marks(axes: "Axes", rows: list[ReferenceRow]) -> None:
    published = [row for row in rows if row.verdict != MEASURED]
    measured = [row for row in rows if row.verdict == MEASURED]
    for some, words, style, colour, aside in (
        (published, "published", "s", COLOURS[1], _ASIDE),
        (measured, "measured", "D", LIMIT, -_ASIDE),
    ):
        if some:
            places = [float(row.where["order"]) + aside for row in some]
            values = [row.value for row in some]
            face = "white" if words == "published" else colour
            axes.plot(
                places,
                values,
                style,
                color=colour,
                ms=6,
                markeredgewidth=1.5,
                markerfacecolor=face,
                label=words,
            )
