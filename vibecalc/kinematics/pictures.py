"""Pictures of the piston motion over one turn, and of what its first two harmonics miss."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    QUIET,
    TOTAL,
    canvas,
    crank_angle_axis,
    unit_words,
    waves,
)
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
        factor, unit = (1e3, "mm") if name == "position" else unit_words(quantity.unit)
        axes.plot(np.degrees(angle), factor * np.asarray(quantity.values), color=COLOURS[i])
        axes.set_ylabel(f"{name}\nin {unit}")
        if name != "position":
            axes.axhline(0.0, color="#777777", linewidth=0.8)
    figure.align_ylabels(list(panels))
    crank_angle_axis(panels[-1])
    return figure


# ----------------------------------------------------------------------------
# Acceleration of the piston over one turn next to its first two harmonics, and what these miss.
# ----------------------------------------------------------------------------

_FEW = 2
#: of the largest acceleration, what is no difference
_ROUNDING = 1e-9


def draw_piston_acceleration(result: Result) -> "Figure | None":
    """Both curves above, their difference below, unless it is rounding; None without the two."""
    curve = along(result.record, "kinematics/acceleration", "crank_angle")
    series = along(result.record, "kinematics/acceleration_harmonics", "order")
    if curve is None or series is None or not curve[1].size:
        return None
    whole, angle = np.asarray(curve[0].values), curve[1]
    harmonics, orders = series
    few = np.asarray(orders) <= _FEW
    short = np.real(np.asarray(harmonics.values)[few] @ waves(np.asarray(orders)[few], angle))
    missed, largest = np.abs(whole - short).max(), np.abs(whole).max()
    unit, rows = unit_words(curve[0].unit)[1], 2 if missed > _ROUNDING * largest else 1
    words = "piston acceleration and its first two harmonics"
    words += "" if rows > 1 else ", which are all of it"
    figure = canvas(result, words, 2.4 + 2.0 * rows)
    panels = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=[2, 1][:rows])[:, 0]
    panels[0].plot(np.degrees(angle), whole, color=TOTAL, linewidth=2.0, label="all orders")
    panels[0].plot(np.degrees(angle), short, "--", color=COLOURS[1], label="orders 1 and 2")
    panels[0].set_ylabel(f"acceleration in {unit}")
    panels[0].legend(loc="lower center")
    if rows > 1:
        panels[1].plot(np.degrees(angle), whole - short, color=COLOURS[0])
        panels[1].set_ylabel(f"difference\nin {unit}")
        share = show(100.0 * missed / largest, digits=2)
        words = f"largest difference {show(missed, digits=3)} {unit}, {share} % of the largest"
        panels[1].set_title(words, loc="left")
        figure.align_ylabels(list(panels))
    for axes in panels:
        axes.axhline(0.0, color=QUIET, linewidth=0.8)
    crank_angle_axis(panels[-1])
    return figure
