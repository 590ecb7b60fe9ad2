"""Pictures of a damper's design: worst section over its values, response with it."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    plain_ticks,
    unit_words,
)
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Ends,
    Panel,
    Plot,
    Source,
    level,
    operating,
    sourced,
)
from vibecalc.core.report.sections import having, scalar_of, table_of
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.damper_design import DESIGN, OBJECTIVES, objective_of
from vibecalc.torsion.report.line import place_of
from vibecalc.units import convert

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
    worst = record.quantities.get(f"{DESIGN}worst_{name}")
    if found is None or worst is None:
        return None
    from matplotlib.colors import BoundaryNorm

    best, unit = float(worst.values), OBJECTIVES[name]
    words = f"largest half range of the {name} over springs and damping of the damper"
    figure = canvas(result, words, 6.6)
    axes = figure.subplots()
    k, c = (np.asarray(axis.values, dtype=float) for axis in found.axes)
    over = np.asarray(found.values, dtype=float).T / best
    over = np.where(np.isfinite(over), over, 10.0 * _LEVELS[-1])
    # a limit may keep the optimum from the best of the map
    least, top = float(np.min(over)), float(np.max(over))
    above = _LEVELS if top > _LEVELS[3] else (*_FINE, *_LEVELS)
    levels = [*(one for one in _BETTER if one > least), 1.0, *(one for one in above if one < top)]
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
        label=f"optimum, {show(convert(best, worst.unit, unit))} {unit_words(unit)[1]}",
    )  # fmt: skip
    _basins(axes, record)
    axes.set(xscale="log", yscale="log", xlim=k[[0, -1]], ylim=c[[0, -1]],
             xlabel="stiffness in N m/rad", ylabel="damping in N m s/rad")  # fmt: skip
    plain_ticks(axes.xaxis)
    plain_ticks(axes.yaxis)
    axes.grid(visible=False)
    bar = figure.colorbar(filled, ax=axes, ticks=levels, format="{x:g}")
    bar.set_label("times the optimum")
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _limits(axes: "Axes", result: Result, grid: tuple[np.ndarray, np.ndarray]) -> None:
    """Borders beyond which heat or travel is above its limit."""
    given = table_of(result.case, "damper_design", "limits")
    for name, style in (("heat", "--"), ("travel", ":")):
        limit = given.get(name) or 0.0
        found = having(result.record, f"{DESIGN}chart/{name}", "chart_stiffness", "chart_damping")
        if found is not None and np.min(found.values) < limit < np.max(found.values):
            axes.contour(*grid, found.values.T, levels=[limit], colors=LIMIT, linestyles=style,
                         linewidths=1.6)  # fmt: skip
            axes.plot([], [], color=LIMIT, linestyle=style, label=f"limit of the {name}")


def _basins(axes: "Axes", record: Record) -> None:
    """Ends of descents that lie elsewhere than the optimum."""
    names = ("stiffness", "damping", "worst")
    found = [having(record, f"{DESIGN}basin/{name}", "basin") for name in names]
    ends = np.array([one.values for one in found if one is not None])
    if len(ends) == len(names) and np.any(ends[2] > 1.01):
        axes.plot(*ends[:2, ends[2] > 1.01], "o", color=TOTAL, ms=6, markerfacecolor="none",
                  label="other valleys", zorder=5)  # fmt: skip


# ----------------------------------------------------------------------------
# Largest section of a shaft line against speed: without damper, table value, optimum.
# ----------------------------------------------------------------------------

#: ratio of the curves from which on the axis is logarithmic
_FAR = 6.0
#: look of the maxima that decide the optimum
_MAXIMA = {"color": COLOURS[0], "linestyle": "", "marker": "o", "markersize": 6, "zorder": 5}


def _with(name: str) -> Source:
    """The curve with one of the dampers; that of the optimum goes through its maxima."""

    def made(result: Result) -> Quantity | None:
        found = sourced(f"{DESIGN}curve/{objective_of(result)}", result)
        place = place_of(found, name)
        if found is None or place is None:
            return None
        speed, values = found.axes[1].values, found.values[place]
        held = _held(result) if name == "optimum" else None
        if held is not None:
            speed = np.append(speed, held.axes[0].values)
            values = np.append(values, held.values)
        order = np.argsort(speed, kind="stable")
        axis = replace(found.axes[1], values=speed[order])
        return replace(found, path="", values=values[order], axes=(axis,))

    return made


def _held(result: Result) -> Quantity | None:
    """The maxima that decide the optimum, over their speeds."""
    kind, speed = (
        having(result.record, f"{DESIGN}active/{n}", "active") for n in ("kind", "speed")
    )
    worst = result.record.quantities.get(f"{DESIGN}worst_{objective_of(result)}")
    curve = sourced(f"{DESIGN}curve/{objective_of(result)}", result)
    if kind is None or speed is None or worst is None or curve is None:
        return None
    at = speed.values[kind.values == 0]
    axis = replace(curve.axes[1], values=at)
    return replace(worst, path="", values=np.full(at.shape, float(worst.values)), axes=(axis,))


def _worst(result: Result) -> float | None:
    return scalar_of(result.record, f"{DESIGN}worst_{objective_of(result)}")


def _scale(plot: Plot) -> Ends:
    """Logarithmic where a curve is far above the optimum."""
    known = np.concatenate([y for _, y in plot.drawn])
    known = known[np.isfinite(known) & (known > 0.0)]
    worst = plot.factor * (_worst(plot.result) or np.inf)
    if not known.size or float(np.max(known)) <= _FAR * worst:
        return None, None
    plot.axes.set_yscale("log")
    return 0.8 * float(np.min(known)), 1.3 * float(np.max(known))


def _response(result: Result) -> list[Panel]:
    thin = {"linewidth": 1.1, "linestyle": "--", "color": QUIET}
    parts = (
        Curve(_with("none"), "no damper", thin),
        Curve(_with("table value"), "table value", {"linewidth": 1.8, "color": COLOURS[1]}),
        Curve(_with("optimum"), "optimum", {"linewidth": 1.8, "color": COLOURS[0]}),
        level(_worst, "largest of the optimum", color=COLOURS[0], linestyle=":", linewidth=0.9),
        Curve(_held, "maxima that decide it", _MAXIMA),
        operating,
    )
    name = objective_of(result)
    return [Panel(name, parts, unit=OBJECTIVES[name], ends=_scale, needs=(_with("optimum"),))]


DAMPER_RESPONSE = Curves(
    lambda result: f"largest half range of the {objective_of(result)} of all sections that count",
    _response,
    high=4.1,
    names=3,
)
