"""Levels and speed over the torque per slip of the motor, without a controller."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, scalar_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, canvas, order_name
from vibecalc.report.references import judge_references
from vibecalc.report.sections.roll_control_words import CONTROL
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PATH = CONTROL + "motor_gains/"
_ORDERS = 4


def picture(result: Result) -> "Figure | None":
    """Levels of the first orders above, mean speed below; published ones as hollow squares."""
    level = having(result.record, _PATH + "level", "motor_gain", "order")
    speed = having(result.record, _PATH + "speed", "motor_gain")
    if level is None or speed is None:
        return None
    words = "another motor and no controller (reduced model)"
    figure = canvas(result, words, 8.6, 6.4)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.2, 1.0])
    gains = np.asarray(level.axes[0].values, dtype=float)
    rank = np.argsort(gains)
    orders = np.asarray(level.axes[1].values)[:_ORDERS]
    for place, order in enumerate(orders):
        values = np.asarray(level.values, dtype=float)[rank, place]
        style = "-" if place < 2 else "--"
        above.plot(gains[rank], np.where(np.isfinite(values), values, np.nan), style, marker="o",
                   ms=4, color=COLOURS[place], label=order_name(int(order)))  # fmt: skip
    _published(above, result, _PATH + "level", orders)
    below.plot(gains[rank], rpm(1.0) * np.asarray(speed.values)[rank], marker="o", ms=4,
               color=COLOURS[0])  # fmt: skip
    _published(below, result, _PATH + "speed", None)
    own = scalar_of(result.record, CONTROL + "motor_gain")
    for axes in (above, below):
        axes.set_xscale("log")
        if own is not None:
            words = f"this motor, {show(own, digits=4)} N*m*s/rad"
            axes.axvline(own, color=LIMIT, linestyle=":", label=words if axes is above else None)
    above.set_ylabel("level in dB re 1 rad/s$^2$, zero-to-peak")
    below.set_ylabel("mean speed in rpm")
    below.set_xlabel("torque per slip in N*m*s/rad")
    above.legend(loc="lower left", fontsize=9)
    figure.align_ylabels([above, below])
    return figure


def _published(axes: "Axes", result: Result, path: str, orders: np.ndarray | None) -> None:
    first = True
    for row in judge_references(result):
        if row.quantity != path or row.at == "start":
            continue
        place = 0
        if orders is not None:
            found = np.flatnonzero(orders == row.where.get("order"))
            if not found.size:
                continue
            place = int(found[0])
        value = row.value if orders is not None else rpm(row.value)
        axes.plot(
            [float(row.where["motor_gain"])], [value], "s", color=COLOURS[place], ms=8,
            markerfacecolor="none", label="published" if first else None,
        )  # fmt: skip
        first = False
