"""Couple of the cylinders' torque on the body, and the load of every support, over the cycle."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels, table_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, waves
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROOT = "isolation/torque_reaction/"
_STATIC = "isolation/support_force/static"
_DASHES = ("-", "--", "-.", ":")


def picture(result: Result) -> "Figure | None":
    """Couple above, loads about their means below; None without a torque reaction."""
    record = result.record
    couple = having(record, f"{_ROOT}couple", "half_order")
    force = having(record, f"{_ROOT}support_force", "mount", "direction", "half_order")
    if couple is None or force is None:
        return None
    orders = np.asarray(couple.axes[0].values, dtype=float)
    turns = 2 if np.any(orders % 1.0) else 1
    count = max(721, int(16.0 * turns * orders.max()) + 1)
    angle = np.linspace(0.0, 2.0 * np.pi * turns, count)
    kind = table_of(result.case, "machine").get("kind") or "engine"
    title = f"torque reaction: {kind} on its mounts over the cycle"
    figure = canvas(result, title, 8.6, 7.4)
    above, below = figure.subplots(2, 1, sharex=True)
    _couple(above, record, couple, angle, orders)
    _loads(below, result, force, angle, orders)
    below.set_xlim(0.0, 360.0 * turns)
    below.set_xticks(range(0, 360 * turns + 1, 90 * turns // 2))
    below.set_xlabel("crank angle in deg")
    return figure


def _couple(
    axes: "Axes", record: Record, couple: Quantity, angle: np.ndarray, orders: np.ndarray
) -> None:
    given = having(record, f"{_ROOT}mean_couple")
    mean = 0.0 if given is None else float(given.values)
    course = mean + np.real(np.asarray(couple.values) @ waves(orders, angle))
    axes.plot(np.degrees(angle), course, color=TOTAL)
    axes.axhline(mean, color=QUIET, linestyle="--", linewidth=1.2)
    words = f"couple on the body about the crankshaft, mean {show(mean, digits=4)} N m (dashed)"
    axes.set_title(words, loc="left")
    axes.set_ylabel(f"couple in {_plain(couple.unit)}")


def _loads(
    axes: "Axes", result: Result, force: Quantity, angle: np.ndarray, orders: np.ndarray
) -> None:
    """What each support carries about its mean load, downwards; where that is zero it lifts."""
    record = result.record
    up = "xyz".index(str(table_of(result.case, "isolation").get("up") or "z"))
    weight = having(record, _STATIC, "mount")
    mean = having(record, f"{_ROOT}mean_support_force", "mount", "direction")
    courses, still = [], []
    for place, name in enumerate(labels(force.axes[0])):
        load = 0.0 if weight is None else float(weight.values[place])
        load -= 0.0 if mean is None else float(mean.values[place, up])
        course = -np.real(np.asarray(force.values)[place, up] @ waves(orders, angle))
        courses.append(course)
        still.append(load)
        axes.plot(
            np.degrees(angle),
            course,
            color=COLOURS[place % len(COLOURS)],
            linestyle=_DASHES[place // len(COLOURS) % len(_DASHES)],
            label=f"{name}: {show(load, digits=4)}",
        )
    axes.axhline(0.0, color=QUIET, linewidth=0.8)
    lowest = min((float(np.min(one)) for one in courses), default=0.0)
    for place, load in enumerate(still):
        if load + float(np.min(courses[place])) < 0.0 or -load > 1.2 * lowest:
            colour = COLOURS[place % len(COLOURS)]
            axes.axhline(-load, color=colour, linestyle=":", linewidth=1.2)
            axes.annotate(
                f"{labels(force.axes[0])[place]} carries nothing", (0.0, -load),
                xycoords=axes.get_yaxis_transform(), xytext=(4, 2), textcoords="offset points",
                fontsize=8, color=LIMIT,
            )  # fmt: skip
    axes.set_title("load on each support about its mean: torque and shaking, downwards",
                   loc="left")  # fmt: skip
    axes.set_ylabel(f"load in {_plain(force.unit)}")
    axes.legend(title=f"support: mean\nin {_plain(force.unit)}", loc="center left",
                bbox_to_anchor=(1.0, 0.5), fontsize=9)  # fmt: skip


def _plain(unit: str) -> str:
    """A unit as the other words of a picture write it."""
    return unit.replace("*", " ")
