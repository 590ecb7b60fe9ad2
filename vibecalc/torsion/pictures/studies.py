"""Pictures of studies: change in time, waterfall, variable inertia, modal route, damper design."""

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    PLATE,
    QUIET,
    TOTAL,
    canvas,
    crests,
    note,
    plain_ticks,
    unit_words,
)
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Mark,
    Panel,
    Plot,
    decades,
    level,
    operating,
    through,
)
from vibecalc.core.report.marks import first_of
from vibecalc.core.report.sections import having, labels, scalar_of, table_of
from vibecalc.core.report.sources import Ends, Look, Source, entry_of, sourced
from vibecalc.core.report.writing import hertz, rpm, show
from vibecalc.core.results.record import Axis, Quantity, Record, Result
from vibecalc.numerics.rounding import first_of_largest
from vibecalc.torsion.pictures.excitation import headroom, torque_words
from vibecalc.torsion.pictures.modes import draw_orders
from vibecalc.torsion.report.line import (
    TORSION,
    at_speed,
    mode_names,
    order_text,
    place_of,
    torque_unit,
)
from vibecalc.torsion.report.studies import (
    DESIGN,
    OBJECTIVES,
    TRANSIENT,
    change_in_words,
    objective_of,
)
from vibecalc.torsion.study_results import PASSAGES, PUBLISHED
from vibecalc.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# A change in time: envelope of the most loaded section next to the steady one, and its peak.
# ----------------------------------------------------------------------------

#: a steady half range may be this many times that of the run before the axis leaves it
_ROOM = 2.2


def _worst(result: Result) -> int | None:
    """Place of the most loaded section."""
    worst = scalar_of(result.record, TRANSIENT + "worst_section")
    return None if worst is None else int(worst) - 1


def _section(result: Result) -> str:
    return labels(result.record[TRANSIENT + "peak"].axes[0])[_worst(result) or 0]


def _crests(name: str) -> Source:
    """An extreme of the worst section from cycle to cycle, joined at the middles of its steps."""

    def made(result: Result) -> Quantity | None:
        found = sourced(entry_of(TRANSIENT + name, _worst), result)
        if found is None:
            return None
        time, values = crests(found.axes[1].values, found.values[0])
        return replace(found, values=values, axes=(replace(found.axes[1], values=time),))

    return made


def _steady(end: str, colour: str) -> Mark:
    """The steady peak of the worst section before or after the change."""

    def value(result: Result) -> float | None:
        found, place = result.record.quantities.get(f"{TRANSIENT}steady_{end}"), _worst(result)
        return None if found is None or place is None else float(found.values[place])

    return level(value, f"steady peak {end}", color=colour)


def _onset(plot: Plot) -> None:
    """When a step happens, where the case says it."""
    change = table_of(plot.result.case, "response", "torsion", "transient")
    if change.get("kind") not in PASSAGES and change.get("time_before"):
        plot.axes.axvline(float(change["time_before"]), color=TOTAL, linestyle=":", label="onset")


def _between(plot: Plot) -> None:
    """What lies between the crests, shaded, and the peak with the time that shows it."""
    (x, low), (u, high) = plot.drawn
    ends = np.interp(x, u, high)
    plot.axes.fill_between(x, low, ends, color=COLOURS[5], alpha=0.2, linewidth=0.0)
    record, place = plot.result.record, _worst(plot.result) or 0
    when, peak = (record.quantities.get(f"{TRANSIENT}{name}") for name in ("peak_time", "peak"))
    if when is None or peak is None:
        return
    at, value = float(when.values[place]), plot.factor * float(peak.values[place])
    near = (
        np.abs(x - at) <= 1.5 * np.abs(x - at)[np.argsort(np.abs(x - at))[: min(3, x.size)]].max()
    )
    sign = 1.0 if np.max(ends[near]) >= -np.min(low[near]) else -1.0
    plot.axes.plot([at], [sign * value], "o", color=LIMIT, zorder=5,
                   label=f"peak {show(value, digits=4)} {plot.unit}")  # fmt: skip
    plot.drawn.append((np.array([at]), np.array([sign * value])))


def _crank_speed(plot: Plot) -> None:
    """The crank speed on an axis of its own, if it changes."""
    speed = having(plot.result.record, TRANSIENT + "speed", "transient_time")
    if speed is None or float(np.ptp(speed.values)) <= 1e-9 * float(np.max(speed.values)):
        return
    other = plot.axes.twinx()
    other.plot(speed.axes[0].values, rpm(1.0) * speed.values, color=TOTAL, linewidth=1.0,
               linestyle="-.")  # fmt: skip
    other.set_ylabel("crank speed in rpm (dash-dotted)")
    other.grid(visible=False)
    other.set_ylim(0.0, 1.28 * rpm(float(np.max(speed.values))))
    other.spines["right"].set_visible(True)


def _half_ends(plot: Plot) -> Ends:
    own, *others = [float(np.nanmax(y)) for _, y in plot.drawn]
    return 0.0, 1.22 * max([own, *(min(one, _ROOM * own) for one in others)])


_BLUE: Look = {"color": COLOURS[0], "marker": ""}
_LOW, _HIGH = _crests("torque_low"), _crests("torque_high")
_HALF = _crests("half_range")

TORSION_TRANSIENT = Curves(
    lambda result: unit_words(change_in_words(result).rstrip(".").split(", growing")[0])[1],
    (
        Panel(
            "torque",
            (Curve(_LOW, "extremes of each cycle", _BLUE), Curve(_HIGH, "", _BLUE), _between,
             _onset, _steady("before", COLOURS[2]), _steady("after", COLOURS[1]), _crank_speed),
            lambda result: f"torque in section {_section(result)}, mean included",
            unit=torque_words,
            ends=headroom(0.36),
            legend={"loc": "upper left", "ncols": 3},
            needs=(_LOW, _HIGH),
        ),
        Panel(
            "half range",
            (
                Curve(_HALF, "half range during the change", _BLUE),
                Curve(entry_of(TRANSIENT + "quasi_steady", _worst),
                      "steady half range at these speeds",
                      {"color": COLOURS[1], "linestyle": "--", "linewidth": 1.2, "marker": ""}),
            ),
            unit=torque_words,
            ends=_half_ends,
            legend={"loc": "upper left", "ncols": 2},
            needs=(_HALF,),
        ),
        Panel(
            "torque",
            (Curve(TRANSIENT + "history/torque", "", {**_BLUE, "linewidth": 1.0}), _onset),
            "the same torque about its peak",
            unit=torque_words,
            ends=headroom(0.2),
            legend={"loc": "upper right"},
            needs=(_LOW,),
        ),
    ),
    high=2.45,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Cycles that rainflow counting finds in a change, a histogram of their ranges for each section.
# ----------------------------------------------------------------------------


def _counted(result: Result) -> list[Panel]:
    ranges = having(result.record, TRANSIENT + "counted/range", "section", "range_bin")
    number = having(result.record, TRANSIENT + "counted/number", "section", "range_bin")
    if ranges is None or number is None:
        return []
    panels = []
    (factor, unit), known = torque_unit(result.record), labels(ranges.axes[0])
    words = f"range in {unit_words(unit)[1]}"
    for name, tops, cycles in zip(known, ranges.values, number.values, strict=True):
        middles = factor * (tops - 0.5 * tops[0])  # bins of one width from 0 on
        along = Axis(name="range", values=middles, unit="", long_name=words)
        one = replace(number, path="", values=cycles, axes=(along,))
        bars = Curve(partial(_same, one), bars=True)
        panels.append(Panel("cycles", (bars,), f"section {name}"))
    return panels


def _same(one: Quantity, _: Result) -> Quantity:
    return one


COUNTED_CYCLES = Curves("rainflow cycles of the speed change by range (peak-to-peak)", _counted)


# ----------------------------------------------------------------------------
# Waterfall of a run: frequencies of the most loaded section's torque against crank speed.
# ----------------------------------------------------------------------------

#: decades of amplitude that are distinguished, and orders that are named at most
_DECADES, _NAMED = 3.0, 8
#: least rise of the speed, as a share of the highest, for which speed is the axis
_MOVES = 0.05


def draw_torsion_waterfall(result: Result) -> "Figure | None":
    """Colours over speed (or time) and frequency, with orders and natural frequencies."""
    record, stem = result.record, TRANSIENT + "waterfall"
    found = having(record, f"{stem}/frequency", "waterfall_time", "waterfall_frequency")
    speed = having(record, f"{stem}/speed", "waterfall_time")
    if found is None or speed is None:
        return None
    from matplotlib.colors import LogNorm

    factor, unit = torque_unit(record)
    size, across = factor * np.abs(found.values), rpm(1.0) * speed.values
    steps = np.diff(across)
    one_way = bool(np.all(steps >= 0.0) or np.all(steps <= 0.0))
    moves = one_way and np.ptp(across) > _MOVES * np.max(across)
    if moves:
        # held speeds at the ends would be drawn on one line
        kept = np.append(True, np.abs(steps) > 1e-6 * np.max(across))
        across, size = across[kept], size[kept]
    else:
        across = found.axes[0].values
    frequency, top = hertz(1.0) * found.axes[1].values, float(np.max(size))
    low, high, highest = float(np.min(across)), float(np.max(across)), float(frequency[-1])
    words = f"torque in section {_section(result)} during the change"
    figure = canvas(result, f"{words}; grey: orders, red: natural frequencies", 6.2)
    axes = figure.subplots()
    least = top * 10.0**-_DECADES
    shades = axes.pcolormesh(
        across, frequency, np.maximum(size, least).T, cmap="Blues", shading="gouraud",
        norm=LogNorm(vmin=least, vmax=top), rasterized=True,
    )  # fmt: skip
    bar = figure.colorbar(shades, ax=axes, pad=0.06)
    bar.set_label(f"amplitude in {unit_words(unit)[1]}")
    axes.set(xlim=(low, high), ylim=(0.0, highest), ylabel="frequency in Hz",
             xlabel="crank speed in rpm" if moves else "time in s")  # fmt: skip
    axes.grid(visible=False)
    orders = _strongest(record)
    if moves:
        draw_orders(axes, orders, np.zeros(orders.shape, bool), high, highest)
    for order in () if moves else orders:
        level_of = float(order) * hertz(float(np.mean(speed.values)))
        if level_of < highest:
            axes.axhline(level_of, color=QUIET, linewidth=0.5)
            note(axes, order_text(float(order)), (1.0, level_of), (3, 0), va="center", color=QUIET,
                 xycoords=axes.get_yaxis_transform(), annotation_clip=False)  # fmt: skip
    natural = hertz(1.0) * first_of(record, TORSION + "modes/natural_frequency")
    for name, value in zip(mode_names(result), natural, strict=True):
        if 0.0 < value < 0.98 * highest:
            axes.axhline(value, color=LIMIT, linewidth=0.8, linestyle=":")
            note(axes, name, (0.0, value), (4, 2), xycoords=axes.get_yaxis_transform(),
                 color=LIMIT, bbox=PLATE)  # fmt: skip
    return figure


def _strongest(record: Record) -> np.ndarray:
    """The orders (n,) that stand out most, ascending."""
    found = having(record, TRANSIENT + "waterfall/order", "waterfall_time", "order")
    if found is None:
        return np.zeros(0)
    size = np.abs(found.values)
    # an order that is there stands above its neighbours, what leaks from another does not
    walls = np.pad(size, ((0, 0), (1, 1)), constant_values=np.inf)
    walls[:, -1] = 0.0
    there = (size > walls[:, :-2]) & (size > walls[:, 2:])
    score = np.where(there, size, 0.0).max(axis=0)
    best = [place for place in np.argsort(-score, kind="stable")[:_NAMED] if score[place] > 0.0]
    return np.sort(np.asarray(found.axes[1].values, dtype=float)[best])


# ----------------------------------------------------------------------------
# Inertias that change over the revolution: torque by order and against speed, next to mean ones.
# ----------------------------------------------------------------------------

_ROOT = TORSION + "variable_inertia/"


def _changed(result: Result) -> str:
    """The section that changes most."""
    change = result.record.quantities.get(_ROOT + "change")
    return "" if change is None else labels(change.axes[0])[first_of_largest(np.abs(change.values))]


def _of_changed(path: str) -> Source:
    return lambda result: sourced(
        entry_of(path, place_of(result.record.quantities.get(path), _changed(result))), result
    )


VARIABLE_INERTIA = Curves(
    lambda result: (
        f"torque in section {_changed(result)}: variable inertia"
    ),
    (
        Panel(
            "torque",
            (Curve(_of_changed(TORSION + "torque"), "mean inertias", {"color": QUIET}, bars=True),
             Curve(_of_changed(_ROOT + "torque"), "variable inertias, exact motion",
                   {"color": COLOURS[0]}, bars=True)),
            lambda result: f"{at_speed(result, 'at ')}, amplitudes 0-to-peak",
            unit=torque_words,
            legend={"loc": "best"},
            needs=(_of_changed(_ROOT + "torque"),),
        ),
        Panel(
            "torque",
            (Curve(_of_changed(TORSION + "speeds/torque_half_range"), "mean inertias",
                   {"color": QUIET, "linestyle": "--"}),
             Curve(_of_changed(_ROOT + "speeds/torque_half_range"),
                   "variable inertias, linear motion", {"color": TOTAL}),
             operating),
            "half range of all orders together",
            unit=torque_words,
            ends=(0.0, None),
            legend={"loc": "best"},
            needs=(_of_changed(_ROOT + "speeds/torque_half_range"),),
            below="crank speed in rpm",
        ),
    ),
)  # fmt: skip


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
    words = f"largest half range of the {name} over stiffness and damping of the damper"
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
                  label=f"compared damper, {show(gain, digits=4)} x optimum")  # fmt: skip
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
    bar.set_label("ratio to the optimum")
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
                  label="other minima", zorder=5)  # fmt: skip


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
        held = _held(result) if name == "optimum" else None
        peaks = np.zeros((0, 2))
        if held is not None:
            peaks = np.stack([held.axes[0].values, held.values], axis=1)
        speed, values = through(found.axes[1].values, found.values[place], peaks)
        axis = replace(found.axes[1], values=speed)
        return replace(found, path="", values=values, axes=(axis,))

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


def _optimum(result: Result) -> float | None:
    return scalar_of(result.record, f"{DESIGN}worst_{objective_of(result)}")


def _scale(plot: Plot) -> Ends:
    """Logarithmic where a curve is far above the optimum."""
    known = np.concatenate([y for _, y in plot.drawn])
    known = known[np.isfinite(known) & (known > 0.0)]
    worst = plot.factor * (_optimum(plot.result) or np.inf)
    if not known.size or float(np.max(known)) <= _FAR * worst:
        return None, None
    plot.axes.set_yscale("log")
    return 0.8 * float(np.min(known)), 1.3 * float(np.max(known))


def _response(result: Result) -> list[Panel]:
    thin = {"linewidth": 1.1, "linestyle": "--", "color": QUIET}
    parts = (
        Curve(_with("none"), "no damper", thin),
        Curve(_with("table value"), "compared damper", {"linewidth": 1.8, "color": COLOURS[1]}),
        Curve(_with("optimum"), "optimum", {"linewidth": 1.8, "color": COLOURS[0]}),
        level(
            _optimum,
            "maximum of the optimum",
            color=COLOURS[0],
            linestyle=":",
            linewidth=0.9,
        ),
        Curve(_held, "decisive maxima", _MAXIMA),
        operating,
    )
    name = objective_of(result)
    return [Panel(name, parts, unit=OBJECTIVES[name], ends=_scale, needs=(_with("optimum"),))]


DAMPER_RESPONSE = Curves(
    lambda result: f"largest half range of the {objective_of(result)} of all sections considered",
    _response,
    high=4.1,
    names=3,
)


#: elastic modes that have a curve of their own; the source shows three
_MODES = 6


def _at_criticals(mode: int) -> Source:
    """The twist of one mode over the speeds at which its orders meet its frequency."""

    def made(result: Result) -> Quantity | None:
        natural = result.record.quantities.get(PUBLISHED + "natural_frequency")
        if natural is None or mode >= len(natural.values):
            return None
        found = sourced(entry_of(PUBLISHED + "twist_at_critical", mode), result)
        if found is None:
            return None
        order = np.asarray(found.axes[1].values, dtype=float)
        speeds = natural.values[mode] / order[order > 0.0]
        axis = Axis(name="speed", values=speeds, unit="rad/s", long_name="speed")
        values = np.abs(found.values[:, order > 0.0])
        return replace(found, path="", values=values, axes=(found.axes[0], axis))

    return made


def _closings(plot: Plot) -> None:
    """A dot at each natural frequency, where nothing is left."""
    natural = hertz(1.0) * first_of(plot.result.record, TORSION + "modes/natural_frequency")
    plot.axes.plot(natural, 0.0 * natural, "o", color=LIMIT, zorder=5, label="natural frequency",
                   clip_on=False)  # fmt: skip


AS_PUBLISHED = Curves(
    "modal method of the source: mode shapes with 1 at the first station, no twist of a shaft",
    (
        Panel(
            "residual",
            (Curve(PUBLISHED + "residual", look={"color": TOTAL}), _closings),
            "torque left at the last station by Holzer's table, share of all inertia torques",
            ends=headroom(0.3),
            height=0.8,
            legend={"loc": "upper right"},
        ),
        Panel(
            "twist",
            (Curve(PUBLISHED + "twist_magnitude", "mode {}"), operating),
            "modal twist at crank angle 0 against speed, magnitude",
            log="y",
        ),
        Panel(
            "vector sum",
            (Curve(PUBLISHED + "intensity", bars=True),),
            "intensity: torques weighted by the mode shape, summed over the stations",
            log="y",
            ends=decades(4),
        ),
        Panel(
            "twist",
            tuple(
                Curve(
                    _at_criticals(mode),
                    look={"color": COLOURS[mode], "marker": "v", "linestyle": ""},
                )
                for mode in range(_MODES)
            ),
            "modal twist at the critical speeds, all orders, magnitude",
            log="xy",
        ),
    ),
)
