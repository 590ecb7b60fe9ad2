"""The couple over the lever during one turn, body held still and on its mounts."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import along, scalar_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import (
    COLOURS,
    LIMIT,
    TOTAL,
    bounds_of,
    canvas,
    crank_angle_axis,
    limit_line,
    order_name,
    waves,
)
from vibecalc.results.record import Quantity, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PANELS = (("rigid", "without isolation: body held still"), ("steady", "through the mounts"))
_DRAWN = 2


def picture(result: Result) -> "Figure | None":
    """Two panels with primary, secondary and total force; None without lever force."""
    found = []
    for name, words in _PANELS:
        hit = along(result.record, f"isolation/lever_force/{name}_harmonics", "order")
        if hit is not None and hit[1].size:
            found.append((name, words, *hit))
    if not found:
        return None
    figure = canvas(result, "couple over the lever during one turn", 8.0, 1.2 + 2.9 * len(found))
    panels = figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (name, words, quantity, orders) in zip(panels, found, strict=True):
        _curves(axes, quantity, orders)
        path = f"isolation/lever_force/{name}_peak"
        peak = scalar_of(result.record, path)
        title = words if peak is None else f"{words}, peak {show(peak, digits=4)} {quantity.unit}"
        axes.set_title(title, loc="left")
        axes.set_ylabel(f"force in {quantity.unit}")
        for text, bound in bounds_of(result, path):
            limit_line(axes, bound, text)
            axes.axhline(-bound, color=LIMIT, linestyle="--", linewidth=1.3)
    panels[0].legend(loc="upper center", ncols=4, bbox_to_anchor=(0.5, -0.02), fontsize=9)
    crank_angle_axis(panels[-1])
    return figure


def _curves(axes: "Axes", quantity: Quantity, orders: np.ndarray) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    parts = np.real(np.asarray(quantity.values)[:, None] * waves(orders, angle))
    degrees = np.degrees(angle)
    for order, colour in zip((1, 2), COLOURS, strict=False):
        for part in parts[np.asarray(orders) == order]:
            axes.plot(degrees, part, color=colour, linewidth=1.3, label=order_name(order))
    words = "total" if len(orders) <= _DRAWN else f"total of {len(orders)} orders"
    axes.plot(degrees, parts.sum(axis=0), color=TOTAL, linewidth=2.0, label=words)
