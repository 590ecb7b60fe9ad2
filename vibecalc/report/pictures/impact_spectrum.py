"""Spectrum of the joint force with the spread of single turns, beside the inertia force."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, TOTAL, canvas
from vibecalc.report.pictures.dominance import broken
from vibecalc.report.pictures.scales import clearance_names, spread_out
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/impact/"
_AXES = ("clearance", "order")
_MOST = 3
#: decades shown below the smallest of the bands
_BELOW = 0.3
#: inertia forces below this share of the largest are not drawn
_FAINT = 1e-9


def picture(result: Result) -> "Figure | None":
    """Linear above and logarithmic below, a column for each clearance; None without spectrum."""
    record = result.record
    spectrum = having(record, _STEM + "spectrum", *_AXES)
    if spectrum is None:
        return None
    names = clearance_names(spectrum.axes[0])
    chosen = spread_out(len(names), _MOST)
    figure = canvas(result, "spectrum of the joint force", 8.6 if len(chosen) < 3 else 9.4, 6.6)
    grid = figure.subplots(2, len(chosen), squeeze=False, sharex=True)
    for column, i in zip(grid.T, chosen, strict=True):
        for axes in column:
            _curves(axes, record, spectrum, i)
        column[0].set_title(names[i], loc="left", fontsize=10)
        _linear(column[0], record, spectrum, i)
        column[1].set_yscale("log")
        column[1].set_ylim(*_window(record, spectrum, i))
        column[1].set_xlabel("order")
    for axes in grid[:, 0]:
        axes.set_ylabel(f"amplitude in {spectrum.unit}")
    grid[0, 0].set_xlim(0.0, float(np.max(spectrum.axes[1].values)))
    handles, words = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=4, fontsize=9)
    return figure


def _curves(axes: "Axes", record: Record, spectrum: Quantity, i: int) -> None:
    orders = np.asarray(spectrum.axes[1].values)
    low, high = _band(record)
    if low is not None and high is not None:
        axes.fill_between(
            orders,
            np.abs(low.values[i]),
            np.abs(high.values[i]),
            color=COLOURS[5],
            alpha=0.45,
            linewidth=0.0,
            label="5 to 95 % of turns",
        )
    mean = np.abs(spectrum.values[i])
    axes.plot(orders, mean, color=COLOURS[0], linewidth=1.3, label="joint force, mean of turns")
    average = having(record, _STEM + "average_amplitude", "clearance")
    if average is not None:
        level = float(abs(average.values[i]))
        axes.axhline(
            level, color=LIMIT, linestyle="--", linewidth=1.2, label="its mean over the orders"
        )
    shaking = having(record, _STEM + "shaking", "order")
    if shaking is not None:
        values: Any = np.abs(shaking.values)
        acting = values > _FAINT * values.max()
        places, sizes = broken(np.asarray(shaking.axes[0].values), values, acting)
        axes.plot(places, sizes, "o-", color=TOTAL, linewidth=1.0, ms=4.0, label="inertia force")


def _linear(axes: "Axes", record: Record, spectrum: Quantity, i: int) -> None:
    """The joint force fills the linear axis; words say how high the inertia force goes beyond."""
    _, high = _band(record)
    top = 1.1 * float(np.max(np.abs((spectrum if high is None else high).values[i])))
    axes.set_ylim(0.0, top if top > 0.0 else 1.0)
    shaking = having(record, _STEM + "shaking", "order")
    if shaking is None or float(np.max(np.abs(shaking.values))) <= top:
        return
    axes.annotate(
        f"inertia force to {show(np.max(np.abs(shaking.values)), digits=3)} {shaking.unit}",
        (0.97, 0.97),
        xycoords="axes fraction",
        ha="right",
        va="top",
        fontsize=9,
        color=TOTAL,
    )


def _band(record: Record) -> tuple[Quantity | None, Quantity | None]:
    low, high = (having(record, f"{_STEM}spectrum_{end}", *_AXES) for end in ("low", "high"))
    return low, high


def _window(record: Record, spectrum: Quantity, i: int) -> tuple[float, float]:
    """Ends of the logarithmic axis: the joint force with its band; the inertia force leaves it."""
    low, high = _band(record)
    values = [np.abs(spectrum.values[i])]
    values += [np.abs(q.values[i]) for q in (low, high) if q is not None]
    shaking = having(record, _STEM + "shaking", "order")
    every = np.concatenate(values)
    positive = every[every > 0.0]
    bottom = float(positive.min()) if positive.size else 1e-3
    top = float(every.max()) if positive.size else 1.0
    if shaking is not None:
        top = max(top, float(np.max(np.abs(shaking.values))))
    return 10.0**-_BELOW * bottom, 3.0 * top
