"""The front between two objectives, with the start."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibecalc.errors import ResultError
from vibecalc.report.lookup import START, along, table_of
from vibecalc.report.pictures.canvas import COLOURS, QUIET, canvas
from vibecalc.report.sections.pareto import PREFIX
from vibecalc.results.record import Result
from vibecalc.results.select import worst

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def picture(result: Result) -> "Figure | None":
    """Second objective over the first, None without a front in the result."""
    one = along(result.record, PREFIX + "objective", "front_point")
    two = along(result.record, PREFIX + "second_objective", "front_point")
    if one is None or two is None:
        return None
    study = table_of(result.case, "optimisation")
    goals = [table_of(study, name) for name in ("objective", "second_objective")]
    figure = canvas(result, "front between two objectives", 7.4, 5.4)
    axes = figure.subplots()
    across, up = (np.asarray(part[0].values, dtype=float) for part in (one, two))
    axes.plot(across, up, "-", color=COLOURS[0], linewidth=0.7, alpha=0.5)
    axes.plot(across, up, "o", color=COLOURS[0], ms=5, label="front (computed points)")
    for place in (0, len(across) - 1):
        axes.annotate(
            str(place + 1),
            (across[place], up[place]),
            xytext=(6, 6),
            textcoords="offset points",
            fontsize=9,
        )
    start = [_start(result, goal) for goal in goals]
    if start[0] is not None and start[1] is not None:
        axes.plot([start[0]], [start[1]], "s", color=QUIET, mfc="white", ms=8, label="start")
    units = (one[0].unit, two[0].unit)
    words = [_axis(goal, unit) for goal, unit in zip(goals, units, strict=True)]
    axes.set_xlabel(words[0])
    axes.set_ylabel(words[1])
    axes.legend(loc="best")
    return figure


def _axis(goal: Mapping[str, Any], unit: str) -> str:
    picks = ", ".join(f"{axis}={entry}" for axis, entry in dict(goal.get("where") or {}).items())
    sense = "smaller" if goal.get("sense", "min") == "min" else "larger"
    name = str(goal.get("quantity")) + (f" [{picks}]" if picks else "")
    return f"{name}{f' in {unit}' if unit else ''}\n({sense} is better)"


def _start(result: Result, goal: Mapping[str, Any]) -> float | None:
    quantity = result.record.quantities.get(START + str(goal.get("quantity")))
    if quantity is None:
        return None
    side: Literal["max", "min"] = "max" if goal.get("sense", "min") == "min" else "min"
    try:
        value, _ = worst(quantity, dict(goal.get("where") or {}), side)
    except ResultError:
        return None
    return value if np.isfinite(value) else None
