"""Motion of the piston over one turn: position, velocity, acceleration."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import along
from vibecalc.report.pictures.canvas import COLOURS, canvas, crank_angle_axis
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMES = ("position", "velocity", "acceleration")


def picture(result: Result) -> "Figure | None":
    """A panel for each of the three that the result has; None without any."""
    found = []
    for name in _NAMES:
        hit = along(result.record, f"kinematics/{name}", "crank_angle")
        if hit is not None and hit[1].size:
            found.append((name, *hit))
    if not found:
        return None
    figure = canvas(result, "piston motion over one turn", 7.6, 1.4 + 1.9 * len(found))
    panels = figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0]
    for i, (axes, (name, quantity, angle)) in enumerate(zip(panels, found, strict=True)):
        axes.plot(np.degrees(angle), quantity.values, color=COLOURS[i])
        axes.set_ylabel(f"{name}\nin {quantity.unit}")
        if name != "position":
            axes.axhline(0.0, color="#777777", linewidth=0.8)
    figure.align_ylabels(list(panels))
    crank_angle_axis(panels[-1])
    return figure
