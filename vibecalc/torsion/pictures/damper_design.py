"""Pictures of a damper's design: worst section over its values, response with it."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    dotted,
    gaps,
    operating_line,
    plain_ticks,
    unit_words,
)
from vibecalc.core.report.sections import having, scalar_of, table_of
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Record, Result
from vibecalc.torsion.report.damper_design import DESIGN, OBJECTIVES, objective_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Worst section over stiffness and damping of a line's damper: optimum, table value, limits.
# ----------------------------------------------------------------------------

#: over the best value; the fine ones where no other is met
_LEVELS = (1.05, 1.1, 1.2, 1.5, 2.0, 3.0, 5.0, 10.0, 30.0, 100.0)
_FINE = (1.01, 1.02)
_BETTER = (0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99)


def draw_damper_map(result: Result) -> "Figure | None":
    """Contours over both on logarithmic axes; None without a map."""
    record, name = result.record, objective_of(result)
    found = having(record, f"{DESIGN}chart/{name}", "chart_stiffness", "chart_damping")
    best = scalar_of(record, f"{DESIGN}worst_{name}")
    if found is None or best is None:
        return None
    factor, unit, words = OBJECTIVES[name]
    from matplotlib.colors import BoundaryNorm

    figure = canvas(
        result, f"largest half range of the {words} over springs and damping of the damper", 6.6
    )
    axes = figure.subplots()
    k, c = (np.asarray(axis.values, dtype=float) for axis in found.axes)
    over = np.asarray(found.values, dtype=float).T / best
    over = np.where(np.isfinite(over), over, 10.0 * _LEVELS[-1])
    top = float(np.max(over))
    least = float(np.min(over))  # a limit may keep the optimum from the best of the map
    better = [level for level in _BETTER if level > least] if least < _BETTER[-1] else []
    levels = [*better, 1.0, *(level for level in (*_FINE, *_LEVELS) if level < top)]
    if top > _LEVELS[3]:
        levels = [level for level in levels if level not in _FINE]
    filled = axes.contourf(
        k, c, over, levels=[*levels, top * 1.001], extend="min", cmap="Blues",
        norm=BoundaryNorm([*levels, top * 1.001], 256, extend="min"),
    )  # fmt: skip
    axes.contour(k, c, over, levels=levels, colors="white", linewidths=0.9)
    _limits(axes, result, (k, c))
    gain = scalar_of(record, DESIGN + "table/gain")
    table = table_of(result.case, "damper_design", "compare")
    if gain is not None and (table.get("stiffness") or 0.0) > 0.0:
        axes.plot([table["stiffness"]], [table["damping"]], "D", color=COLOURS[1], ms=9, zorder=6,
                  markeredgecolor="white", clip_on=False,
                  label=f"table value, {show(gain, digits=4)} times")  # fmt: skip
    place = [scalar_of(record, DESIGN + name) or 0.0 for name in ("stiffness", "damping")]
    axes.plot(
        [place[0]], [place[1]], "*",
        color=LIMIT, ms=14, zorder=6, clip_on=False, markeredgecolor="white",
        label=f"optimum, {show(factor * best, digits=4)} {unit_words(unit)[1]}",
    )  # fmt: skip
    _basins(axes, record)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(k[0], k[-1])
    axes.set_ylim(c[0], c[-1])
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.grid(visible=False)
    bar = figure.colorbar(filled, ax=axes, ticks=levels, format="{x:g}")
    bar.set_label("times the optimum")
    axes.set_xlabel("stiffness in N m/rad")
    axes.set_ylabel("damping in N m s/rad")
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _limits(axes: "Axes", result: Result, grid: tuple[np.ndarray, np.ndarray]) -> None:
    """Borders beyond which heat or travel is above its limit."""
    given = table_of(result.case, "damper_design", "limits")
    for name, style in (("heat", "--"), ("travel", ":")):
        limit = given.get(name)
        found = having(result.record, f"{DESIGN}chart/{name}", "chart_stiffness", "chart_damping")
        if not isinstance(limit, int | float) or found is None:
            continue
        values = np.asarray(found.values, dtype=float).T
        if np.min(values) < limit < np.max(values):
            axes.contour(*grid, values, levels=[limit], colors=LIMIT, linestyles=style,
                         linewidths=1.6)  # fmt: skip
            axes.plot([], [], color=LIMIT, linestyle=style, label=f"limit of the {name}")


def _basins(axes: "Axes", record: Record) -> None:
    """Ends of descents that lie elsewhere than the optimum."""
    k, c = (having(record, f"{DESIGN}basin/{name}", "basin") for name in ("stiffness", "damping"))
    worst = having(record, DESIGN + "basin/worst", "basin")
    if k is None or c is None or worst is None:
        return
    other = np.asarray(worst.values, dtype=float) > 1.01
    if np.any(other):
        axes.plot(k.values[other], c.values[other], "o", color=TOTAL, ms=6, markerfacecolor="none",
                  label="other valleys", zorder=5)  # fmt: skip


# ----------------------------------------------------------------------------
# Largest section of a shaft line against speed: without damper, table value, optimum.
# ----------------------------------------------------------------------------

_LOOKS = {
    "none": (QUIET, "--", "no damper"),
    "table value": (COLOURS[1], "-", "table value"),
    "optimum": (COLOURS[0], "-", "optimum"),
}
#: ratio of the curves from which on the axis is logarithmic
_FAR = 6.0


def draw_damper_response(result: Result) -> "Figure | None":
    """One curve for each damper; None without a design."""
    name = objective_of(result)
    found = having(result.record, f"{DESIGN}curve/{name}", "damper_curve", "speed")
    if found is None:
        return None
    factor, unit, words = OBJECTIVES[name]
    figure = canvas(result, f"largest half range of the {words} of all sections that count", 5.4)
    axes = figure.subplots()
    speed = rpm(1.0) * np.asarray(found.axes[1].values, dtype=float)
    values = factor * np.asarray(found.values, dtype=float)
    held, worst = _held(result), scalar_of(result.record, f"{DESIGN}worst_{name}")
    for label, curve in zip(found.axes[0].values, values, strict=True):
        colour, style, text = _LOOKS[str(label)]
        x, y = speed, gaps(curve)
        if label == "optimum" and worst is not None:  # its maxima lie between the speeds
            order = np.argsort(np.append(x, held), kind="stable")
            x = np.append(x, held)[order]
            y = np.append(y, np.full(len(held), factor * worst))[order]
        axes.plot(x, y, color=colour, linestyle=style, label=text, marker=dotted(len(speed)),
                  linewidth=1.1 if label == "none" else 1.8)  # fmt: skip
    if worst is not None:
        axes.axhline(factor * worst, color=COLOURS[0], linewidth=0.9, linestyle=":",
                     label="largest of the optimum")  # fmt: skip
        axes.plot(held, np.full(len(held), factor * worst), "o", color=COLOURS[0], ms=6, zorder=5,
                  label="maxima that decide it")  # fmt: skip
        if float(np.nanmax(values)) > _FAR * factor * worst:
            known = values[np.isfinite(values) & (values > 0.0)]
            axes.set_yscale("log")
            axes.set_ylim(0.8 * float(np.min(known)), 1.3 * float(np.max(known)))
            plain_ticks(axes.yaxis)
    operating_line(axes, result, *np.asarray(found.axes[1].values, dtype=float)[[0, -1]])
    axes.set_xlim(speed[0], speed[-1])
    axes.set_xlabel("crank speed in rpm")
    axes.set_ylabel(f"{words} in {unit_words(unit)[1]}")
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _held(result: Result) -> np.ndarray:
    """Speeds in rpm of the maxima that decide the optimum."""
    kind = having(result.record, DESIGN + "active/kind", "active")
    speed = having(result.record, DESIGN + "active/speed", "active")
    if kind is None or speed is None:
        return np.zeros(0)
    return np.asarray(rpm(1.0) * speed.values[np.asarray(kind.values) == 0])
