"""Pictures of the piston motion over one turn, and of what its first two harmonics miss."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, TOTAL, canvas, crank_angle_axis, waves
from vibecalc.core.report.sections import along
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Motion of the piston over one turn: position, velocity, acceleration.
# ----------------------------------------------------------------------------

_NAMES = ("position", "velocity", "acceleration")


def draw_piston_motion(result: Result) -> "Figure | None":
    """A panel for each of the three that the result has; None without any."""
    found = []
    for name in _NAMES:
        hit = along(result.record, f"kinematics/{name}", "crank_angle")
        if hit is not None and hit[1].size:
            found.append((name, *hit))
    if not found:
        return None
    figure = canvas(result, "piston motion over one turn", 1.4 + 1.9 * len(found))
    panels = figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0]
    for i, (axes, (name, quantity, angle)) in enumerate(zip(panels, found, strict=True)):
        axes.plot(np.degrees(angle), quantity.values, color=COLOURS[i])
        axes.set_ylabel(f"{name}\nin {quantity.unit}")
        if name != "position":
            axes.axhline(0.0, color="#777777", linewidth=0.8)
    figure.align_ylabels(list(panels))
    crank_angle_axis(panels[-1])
    return figure


# ----------------------------------------------------------------------------
# Acceleration of the piston over one turn beside its first two harmonics, and what these miss.
# ----------------------------------------------------------------------------

_FEW = 2


def draw_piston_acceleration(result: Result) -> "Figure | None":
    """Both curves above, their difference below; None without the curve or its harmonics."""
    curve = along(result.record, "kinematics/acceleration", "crank_angle")
    series = along(result.record, "kinematics/acceleration_harmonics", "order")
    if curve is None or series is None or not curve[1].size:
        return None
    quantity, angle = curve
    harmonics, orders = series
    few = np.asarray(orders) <= _FEW
    short = np.real(np.asarray(harmonics.values)[few] @ waves(np.asarray(orders)[few], angle))
    missed = np.asarray(quantity.values) - short
    degrees = np.degrees(angle)
    figure = canvas(result, "piston acceleration and its first two harmonics", 6.4)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    above.plot(degrees, quantity.values, color=TOTAL, linewidth=2.0, label="all orders")
    above.plot(degrees, short, color=COLOURS[1], linestyle="--", label="orders 1 and 2")
    above.axhline(0.0, color=QUIET, linewidth=0.8)
    above.set_ylabel(f"acceleration in {quantity.unit}")
    above.legend(loc="lower center", fontsize=8)
    top = int(np.argmax(np.abs(missed)))
    below.plot(degrees, missed, color=COLOURS[0])
    below.axhline(0.0, color=QUIET, linewidth=0.8)
    below.set_ylabel(f"difference\nin {quantity.unit}")
    words = f"largest difference {show(abs(missed[top]), digits=3)} {quantity.unit}"
    largest = float(np.max(np.abs(quantity.values)))
    if largest > 0.0:
        words += f", {show(100.0 * abs(missed[top]) / largest, digits=2)} % of the largest"
    below.set_title(words, loc="left", fontsize=9)
    figure.align_ylabels([above, below])
    crank_angle_axis(below)
    return figure
