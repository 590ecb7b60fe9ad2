"""Where an order meets a natural frequency on a picture over the crank speed."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.pictures.canvas import QUIET
from vibecalc.report.pictures.sweep_parts import Plane, along
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.sweep.worst import entries

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SPEED = "machine.speed"
_MODES = "modes/natural_frequency"
_ORDERS = (1, 2)
_PLATE = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.85}


def resonances(axes: "Axes", sweep: SweepView, part: Plane) -> None:
    """Dotted lines, if x is the crank speed and the sweep keeps the natural frequencies."""
    axis = sweep.grid[part.axes[0]]
    path = next((path for path in sweep.kept if path.endswith(_MODES)), None)
    if path is None or axis.keys[0].key != _SPEED:
        return
    natural, _ = entries(sweep, path)
    known = natural[np.ravel(part.points)]
    known = known[~np.isnan(known).any(axis=1)]
    # a suspension that changes with what else is swept has no one place to mark
    if not len(known) or np.any(np.ptp(known, axis=0) > 1e-6 * np.abs(known[0])):
        return
    x, factor = along(axis), axis.keys[0].factor
    for order in _ORDERS:
        at = np.sort(known[0]) / order * factor
        inside = at[(at > x.min()) & (at < x.max())]
        for place in inside:
            axes.axvline(place, color=QUIET, linestyle=":", linewidth=0.9, zorder=0)
        if inside.size:
            count = "" if inside.size == 1 else f", {inside.size} modes"
            axes.annotate(f"order {order}{count}", (inside[0], 0.98),
                          xycoords=axes.get_xaxis_transform(), xytext=(-2, 0),
                          textcoords="offset points", rotation=90, ha="right", va="top",
                          fontsize=8, color=QUIET, bbox=_PLATE)  # fmt: skip
