"""Published and measured numbers of a case as points beside the curve that they belong to."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.references import MEASURED, ReferenceRow
from vibecalc.results.record import Quantity
from vibecalc.units import convert, parse_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_points(
    rows: Sequence[ReferenceRow],
    axes: "Axes",
    quantity: Quantity,
    *,
    entry: str = "",
    turning: float = 1.0,
    factor: float = 1.0,
    colour: Any = None,
) -> np.ndarray:
    """Draw the references of one curve over the crank speed; gives their heights as drawn.

    Measured points are hollow circles, published ones crosses. `entry` is that of the quantity's
    other axis, "" without one; `turning` and `factor` take rad/s and the quantity's unit to those
    of the axes.
    """
    others = [axis.name for axis in quantity.axes if axis.name != "speed"]
    points: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    for row in rows:
        own = [str(row.where.get(name, "")) for name in others]
        if row.quantity != quantity.path or "speed" not in row.where or own != [entry][: len(own)]:
            continue
        speed = parse_quantity(row.where["speed"], "rad/s")
        height = convert(row.value, row.unit, quantity.unit)
        points[row.kind == MEASURED].append((turning * speed, factor * height))
    for measured, found in points.items():
        if found:
            x, y = np.array(found).T
            look: dict[str, Any] = {"marker": "x", "color": colour}
            if measured:
                look = {"marker": "o", "facecolors": "none", "edgecolors": colour}
            label = f"{entry + ', ' if entry else ''}{'measured' if measured else 'published'}"
            axes.scatter(x, y, s=28.0, linewidths=1.3, zorder=5, label=label, **look)
    return np.array([y for found in points.values() for _, y in found])
