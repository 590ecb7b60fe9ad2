"""Order of a pendulum over its swing, the torque that it carries, and the rotor's motion."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, scalar_of, table_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, canvas
from vibecalc.report.sections.pendulum import PENDULUM
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def picture(result: Result) -> "Figure | None":
    """Detuning, torque of steady swings, and response over the order; what the result has."""
    record = result.record
    order = having(record, PENDULUM + "order_of_swing", "swing")
    torque = having(record, PENDULUM + "steady/torque", "steady_swing")
    if PENDULUM + "steady/largest_swing" not in record.quantities:
        torque = None  # of a file from before this result
    rotor = having(record, PENDULUM + "response/rotor", "order_ratio")
    drawn = [quantity for quantity in (order, torque, rotor) if quantity is not None]
    if not drawn:
        return None
    figure = canvas(result, "order, torque and motion of the rotor", 4.4 * len(drawn) + 0.6, 4.6)
    panels = iter(np.atleast_1d(figure.subplots(1, len(drawn))))
    given = table_of(result.case, "machine", "pendulum")
    if order is not None:
        axes = next(panels)
        swing = np.degrees(np.asarray(order.axes[0].values, dtype=float))
        axes.plot(swing, order.values, color=COLOURS[0], label=str(given.get("path", "circular")))
        wanted = given.get("order")
        if isinstance(wanted, int | float):
            axes.axhline(wanted, color=QUIET, linestyle=":", label="wanted")
        axes.set_ylabel("order that the pendulum keeps")
        axes.legend(fontsize=9)
        axes.set_xlabel("swing in deg")
        axes.set_xlim(0.0, swing[-1])
        axes.ticklabel_format(axis="y", useOffset=False)
    if torque is not None:
        _torque(next(panels), record, given.get("torque"))
    if rotor is not None:
        _rotor(next(panels), record)
    return figure


def _torque(axes: "Axes", record: Record, applied: object) -> None:
    torque = record[PENDULUM + "steady/torque"]
    swing = np.degrees(np.asarray(record[PENDULUM + "steady/largest_swing"].values, dtype=float))
    size = np.asarray(torque.values, dtype=float)
    size = size * (np.sign(size[0]) if size.size else 1.0)
    axes.plot(np.concatenate([[0.0], swing]), np.concatenate([[0.0], size]), color=COLOURS[0],
              label="undamped, exact")  # fmt: skip
    limit, place = (scalar_of(record, PENDULUM + f"jump/{x}") for x in ("torque", "swing"))
    if limit is not None and place is not None and np.isfinite(limit):
        axes.plot([np.degrees(place)], [limit], "o", color=LIMIT,
                  label=f"jump, {show(limit, digits=4)} N m")  # fmt: skip
    if isinstance(applied, int | float):
        axes.axhline(applied, color=QUIET, linestyle="--", label="torque of the case")
    axes.set_xlabel("largest angle of swing in deg")
    axes.set_ylabel("torque in N m")
    axes.set_xlim(0.0, None)
    axes.axhline(0.0, color=QUIET, linewidth=0.8)
    axes.legend(fontsize=9)


def _rotor(axes: "Axes", record: Record) -> None:
    for name, words, colour in (
        ("rotor", "pendulums swing a little", COLOURS[0]),
        ("without", "pendulums locked", COLOURS[1]),
    ):
        found = having(record, PENDULUM + f"response/{name}", "order_ratio")
        if found is not None:
            ratio = np.asarray(found.axes[0].values, dtype=float)
            size = np.degrees(np.abs(np.asarray(found.values)))
            axes.semilogy(ratio, np.where(np.isfinite(size), size, np.nan), color=colour,
                          label=words)  # fmt: skip
    axes.set_xlabel("order of the torque over the wanted one")
    axes.set_ylabel("motion of the rotor in deg, zero-to-peak")
    axes.legend(fontsize=9)
