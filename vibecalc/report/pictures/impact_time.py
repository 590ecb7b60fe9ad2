"""Force in the joint over the first turn from rest, with the contacts that can be reproduced."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, canvas, crank_angle_axis
from vibecalc.report.pictures.scales import clearance_names, spread_out
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST = 3


def picture(result: Result) -> "Figure | None":
    """A panel for each clearance, three at most; None without the first turn."""
    stem = "response/impact/"
    force = having(result.record, stem + "first_turn_force", "clearance", "crank_angle")
    if force is None:
        return None
    contacts = having(result.record, stem + "first_contacts", "clearance", "contact")
    names = clearance_names(force.axes[0])
    chosen = spread_out(len(names), _MOST)
    angle = np.asarray(force.axes[1].values)
    subtitle = "joint force over the first turn, from rest in the joint"
    figure = canvas(result, subtitle, 8.4, 1.6 + 2.1 * len(chosen))
    panels = list(figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0])
    for axes, i in zip(panels, chosen, strict=True):
        axes.plot(np.degrees(angle), force.values[i], color=COLOURS[0], linewidth=1.0)
        axes.axhline(0.0, color=QUIET, linewidth=0.6)
        axes.set_ylabel(f"force in {force.unit}")
        title = names[i]
        if contacts is not None:
            starts = np.asarray(contacts.values[i], dtype=float)
            starts = starts[np.isfinite(starts) & (starts <= angle[-1])]
            axes.plot(
                np.degrees(starts),
                np.full(starts.size, 0.015),
                "^",
                transform=axes.get_xaxis_transform(),
                color=LIMIT,
                markersize=6,
                clip_on=False,
            )
            count = "contact" if starts.size == 1 else "contacts"
            title += f", triangles: the first {starts.size} {count}"
        axes.set_title(title, loc="left", fontsize=10)
    crank_angle_axis(panels[-1])
    return figure
