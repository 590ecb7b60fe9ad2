"""The picture of mounts: load over deflection with the rest and the motion, stiffness by order."""

import numpy as np

from vibecalc.core.report.canvas import TOTAL
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot
from vibecalc.isolation.mount_results import AT_REST, BY_ORDER, MOVING


def _rests(plot: Plot) -> None:
    """A dot where each mount is at rest, with the range of its motion at speed."""
    record = plot.result.record
    load, deflection = (record[path].values for path in AT_REST[:2])
    travel = record[MOVING[0]].values if MOVING[0] in record else np.zeros(len(load))
    plot.axes.errorbar(
        1e3 * deflection, plot.factor * load, xerr=1e3 * travel, fmt="o", color=TOTAL,
        markersize=4.5, elinewidth=1.2, capsize=2.5, zorder=5, label="at rest",
    )  # fmt: skip
    plot.points += (plot.factor * load).tolist()


MOUNTS = Curves(
    "mounts: load at rest, stiffness in use",
    (
        Panel(
            "load",
            (Curve(AT_REST[4], "{each}"), _rests),
            "static load over compression along the axis, dots: at rest",
        ),
        Panel(
            "stiffness",
            (Curve(BY_ORDER[0], "{each}", look={"marker": "o", "markersize": 3.5}),),
            "dynamic stiffness at the frequency of each order",
            unit="kN/mm",
        ),
        Panel(
            "loss factor",
            (Curve(BY_ORDER[1], look={"marker": "o", "markersize": 3.5}),),
            "loss factor at the frequency of each order",
        ),
    ),
)
