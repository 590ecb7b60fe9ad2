"""Axial force of the motor: amplitude by order, and the force over one turn."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    TOTAL,
    canvas,
    crank_angle_axis,
    limit_line,
    waves,
)
from vibecalc.core.report.sections import along, scalar_of
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FOLDER = "excitation/motor/"
_LEVELS = (
    ("sum_of_amplitudes", "sum of amplitudes (bound)", LIMIT),
    ("peak", "peak", COLOURS[1]),
    ("rms", "rms", COLOURS[2]),
)


def draw_motor_force(result: Result) -> "Figure | None":
    """Bars above, signal below; None without an axial force."""
    hit = along(result.record, _FOLDER + "axial_force", "order")
    if hit is None or not hit[1].size:
        return None
    quantity, orders = hit
    figure = canvas(result, "axial force of the motor's skewed conductors", 6.6)
    bars, signal = figure.subplots(2, 1)
    bars.bar(orders, np.abs(np.asarray(quantity.values)), color=COLOURS[0], width=0.7)
    bars.set_xlim(0.0, float(np.max(orders)) + 1.0)
    bars.set_xlabel("order, multiple of the crank speed")
    bars.set_ylabel(f"amplitude in {quantity.unit}")
    bars.xaxis.get_major_locator().set_params(integer=True)
    _over_a_turn(signal, result.record, quantity, orders)
    return figure


def _over_a_turn(axes: "Axes", record: Record, quantity: Quantity, orders: np.ndarray) -> None:
    samples = max(721, 16 * int(np.max(orders)) + 1)
    angle = np.linspace(0.0, 2.0 * np.pi, samples)
    force = np.real(np.asarray(quantity.values) @ waves(orders, angle))
    axes.plot(np.degrees(angle), force, color=TOTAL, label="force, mean apart")
    for name, words, colour in _LEVELS:
        level = scalar_of(record, _FOLDER + name)
        if level is None:
            continue
        if name == "sum_of_amplitudes":
            limit_line(axes, level, f"{words} {show(level, digits=4)} {quantity.unit}")
        else:
            label = f"{words} {show(level, digits=4)} {quantity.unit}"
            axes.axhline(level, color=colour, linestyle="--", linewidth=1.3, label=label)
        axes.axhline(-level, color=colour, linestyle="--", linewidth=1.3)
    axes.axhline(0.0, color="#777777", linewidth=0.8)
    axes.margins(y=0.12)
    axes.set_ylabel(f"force in {quantity.unit}")
    axes.legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, -0.2), fontsize=8)
    crank_angle_axis(axes)
