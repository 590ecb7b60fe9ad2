"""Orders at the operating speed: torque of one cylinder, and torque in the most loaded section."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, speed_of
from vibecalc.report.pictures.canvas import COLOURS, QUIET, TOTAL, canvas
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    entry,
    order_text,
    place_of,
    turns,
    vector,
    worst_section,
)
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST, _NAMED = 40, 5
_PARTS = (("gas", "gas", COLOURS[0]), ("inertia", "inertia", COLOURS[1]), ("total", "both", TOTAL))


def picture(result: Result) -> "Figure | None":
    """Bars by order, 0-to-peak; None if the line was not driven."""
    record = result.record
    total = having(record, TORSION + "excitation/total", "half_order")
    torque = having(record, TORSION + "torque", "section", "half_order")
    section = worst_section(record)
    place = None if section is None else place_of(torque, section)
    if total is None or torque is None or section is None or place is None:
        return None
    speed = speed_of(result)
    at = f" at {turns(speed)} rpm" if speed is not None else ""
    figure = canvas(result, f"order spectrum{at}, amplitudes 0-to-peak", 9.6, 7.0)
    above, below = figure.subplots(2, 1, sharex=True)
    order = np.asarray(total.axes[0].values, dtype=float)[:_MOST]
    step = float(order[1] - order[0]) if order.size > 1 else 1.0
    for number, (name, words, colour) in enumerate(_PARTS):
        part = having(record, f"{TORSION}excitation/{name}", "half_order")
        if part is not None:
            size = np.abs(np.asarray(part.values))[:_MOST]
            shift = (number - 1) * 0.27 * step
            above.bar(order + shift, size, 0.25 * step, color=colour, label=words)
    above.set_ylabel("torque of one cylinder\nin N m")
    above.legend(loc="upper right", fontsize=9)
    row = np.abs(np.asarray(torque.values)[place])[:_MOST]
    major = vector(record, "excitation/major", "half_order")
    strong = np.zeros(row.size, bool) if major is None else major[:_MOST] > 0
    for chosen, colour, words in (
        (strong, COLOURS[1], "major order"),
        (~strong, COLOURS[0], "other order"),
    ):
        if np.any(chosen):
            below.bar(order[chosen], row[chosen], 0.6 * step, color=colour, label=words)
    _name(below, order, row)
    below.set_ylabel(f"torque in section\n{section} in N m")
    below.set_xlabel("order (multiple of crank speed)")
    half = entry(having(record, TORSION + "torque_half_range", "section"), section)
    if half:
        words = f"half range of all orders together: {half} N m"
        below.set_title(words, loc="left", fontsize=9, color=QUIET)
    below.legend(loc="upper right", fontsize=9)
    below.set_xlim(order[0] - step, order[-1] + step)
    below.set_xticks(np.arange(1.0, order[-1] + 0.5, max(1.0, round(order[-1] / 20.0))))
    return figure


def _name(axes: "Axes", order: np.ndarray, row: np.ndarray) -> None:
    for i in np.argsort(-row, kind="stable")[:_NAMED]:
        if row[i] > 0.0:
            axes.annotate(
                order_text(order[i]), (order[i], row[i]), xytext=(0, 2),
                textcoords="offset points", ha="center", va="bottom", fontsize=8,
            )  # fmt: skip
    axes.set_ylim(0.0, 1.15 * float(np.max(row, initial=1e-300)))
