"""Which force leads at which order: inertia of the piston, impacts, axial force of the motor."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.pictures.canvas import COLOURS, TOTAL, canvas
from vibecalc.report.pictures.scales import clearance_names, plain_ticks, spread_out
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/impact/"
_MOST = 4
_MOTOR = "#8A5A00"


def picture(result: Result) -> "Figure | None":
    """Amplitudes against order on a logarithmic axis; None without both kinds of force.

    Of the impacts it is what the play adds to the inertia force that shakes the body.
    """
    record = result.record
    added = having(record, _STEM + "added_force", "clearance", "order")
    shaking = having(record, _STEM + "shaking", "order")
    if added is None or shaking is None:
        return None
    figure = canvas(result, "forces against order: which one leads", 8.8, 5.8)
    axes = figure.subplots()
    axes.set_yscale("log")
    orders = np.asarray(added.axes[1].values)
    chosen = spread_out(len(added.values), _MOST)
    names = clearance_names(added.axes[0])
    impacts = np.abs(np.asarray(added.values)[chosen])
    places = np.asarray(shaking.axes[0].values)
    _points(axes, places, np.abs(shaking.values), "inertia force of the piston", TOTAL, "o-")
    for i, row in zip(chosen, impacts, strict=True):
        colour = COLOURS[chosen.index(i)]
        acting = (row > 0.0) & (orders > 0)
        axes.plot(*broken(orders, row, acting), color=colour, label=f"impacts add, {names[i]}")
    motor = having(record, _STEM + "motor", "order")
    if motor is not None:
        own = np.asarray(motor.axes[0].values)
        _points(axes, own, np.abs(motor.values), "axial force of the motor", _MOTOR, "s:")
    positive = impacts[impacts > 0.0]
    bottom = float(positive.min()) if positive.size else 1e-3
    if motor is not None and np.any(np.abs(motor.values) > 0.0):
        size = np.abs(motor.values)
        bottom = min(bottom, float(size[size > 0.0].min()))
    top = max(float(impacts.max()), float(np.max(np.abs(shaking.values))))
    axes.set_ylim(0.3 * bottom, 30.0 * top)
    axes.set_xscale("log")
    plain_ticks(axes.xaxis)
    axes.set_xlim(0.85, 1.1 * float(max(orders[-1], 2)))
    _leads(axes, record, chosen, top)
    axes.set_xlabel("order")
    axes.set_ylabel(f"amplitude in {added.unit}")
    figure.legend(loc="outside lower center", ncols=3, fontsize=9)
    return figure


def _points(
    axes: "Axes", orders: np.ndarray, values: Any, words: str, colour: str, style: str
) -> None:
    places, sizes = broken(orders, values, (np.asarray(values) > 0.0) & (orders > 0))
    axes.plot(places, sizes, style, color=colour, linewidth=1.1, ms=4.0, label=words)


def broken(
    orders: np.ndarray, values: np.ndarray, acting: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The acting orders and their values, with NaN between two that are not neighbours.

    A line does not cross an order that has no force.
    """
    kept = np.asarray(orders)[acting]
    apart = np.flatnonzero(np.diff(kept) > 1) + 1
    places = np.insert(kept.astype(float), apart, np.nan)
    return places, np.insert(np.asarray(values, dtype=float)[acting], apart, np.nan)


def _leads(axes: "Axes", record: Record, chosen: list[int], top: float) -> None:
    """A mark at the order from which impacts lead, at a height of its own for each clearance."""
    leads = having(record, _STEM + "leads_from", "clearance")
    if leads is None:
        return
    for row, i in enumerate(chosen):
        order = int(leads.values[i])
        colour = COLOURS[row]
        height = top * 30.0 ** (0.92 - 0.23 * row)
        if order > 0:
            axes.vlines(order, 0.0, height, color=colour, linestyle=":", linewidth=1.2)
        words = f"these lead from order {order}" if order > 0 else "these lead nowhere"
        axes.annotate(
            words,
            (max(order, 1), height),
            xytext=(5, 0),
            textcoords="offset points",
            color=colour,
            fontsize=9,
            va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
        )
