"""Largest section of a shaft line against speed: without damper, table value, optimum."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, scalar_of, speed_of
from vibecalc.report.numbers import rpm
from vibecalc.report.pictures.canvas import COLOURS, QUIET, TOTAL, canvas, plain_log
from vibecalc.report.sections.damper_design import DESIGN, OBJECTIVES, objective_of
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOOKS = {
    "none": (QUIET, "--", "no damper"),
    "table value": (COLOURS[1], "-", "table value"),
    "optimum": (COLOURS[0], "-", "optimum"),
}
#: ratio of the curves from which on the axis is logarithmic
_FAR = 6.0


def picture(result: Result) -> "Figure | None":
    """One curve for each damper; None without a design."""
    name = objective_of(result)
    found = having(result.record, f"{DESIGN}curve/{name}", "damper_curve", "speed")
    if found is None:
        return None
    factor, unit, words = OBJECTIVES[name]
    figure = canvas(
        result, f"largest half range of the {words} of all sections that count", 9.2, 5.4
    )
    axes = figure.subplots()
    speed = rpm(1.0) * np.asarray(found.axes[1].values, dtype=float)
    values = factor * np.asarray(found.values, dtype=float)
    values = np.where(np.isfinite(values), values, np.nan)
    for label, curve in zip(found.axes[0].values, values, strict=True):
        colour, style, text = _LOOKS[str(label)]
        axes.plot(speed, curve, color=colour, linestyle=style, label=text,
                  linewidth=1.1 if label == "none" else 1.8)  # fmt: skip
    worst = scalar_of(result.record, f"{DESIGN}worst_{name}")
    if worst is not None:
        axes.axhline(factor * worst, color=COLOURS[0], linewidth=0.9, linestyle=":",
                     label="largest of the optimum")  # fmt: skip
        _summits(axes, result, factor * worst)
        if float(np.nanmax(values)) > _FAR * factor * worst:
            known = values[np.isfinite(values) & (values > 0.0)]
            plain_log(axes, 0.8 * float(np.min(known)), 1.3 * float(np.max(known)))
    operating = speed_of(result)
    if operating is not None and speed[0] <= rpm(operating) <= speed[-1]:
        axes.axvline(rpm(operating), color=TOTAL, linewidth=0.9, linestyle="-.",
                     label="operating speed")  # fmt: skip
    axes.set_xlim(speed[0], speed[-1])
    axes.set_xlabel("crank speed in rpm")
    axes.set_ylabel(f"{words} in {unit.replace('*', ' ').replace('^2', '$^2$')}")
    figure.legend(loc="outside lower center", ncols=5, fontsize=9)
    return figure


def _summits(axes: "Axes", result: Result, level: float) -> None:
    """The summits that hold the optimum."""
    kind = having(result.record, DESIGN + "active/kind", "active")
    speed = having(result.record, DESIGN + "active/speed", "active")
    if kind is None or speed is None:
        return
    held = rpm(1.0) * np.asarray(speed.values, dtype=float)[np.asarray(kind.values) == 0]
    axes.plot(held, np.full(len(held), level), "o", color=COLOURS[0], ms=6, zorder=5,
              label="summits that hold it")  # fmt: skip
