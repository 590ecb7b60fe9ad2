"""Pictures of absorbers: response, design chart, map around the optimum, pendulum."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.absorber.asked_tables import excitation_and_response
from vibecalc.absorber.report.hardware import HARDWARE
from vibecalc.absorber.report.tuning import ABSORBER, PENDULUM
from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    PLATE,
    QUIET,
    TOTAL,
    canvas,
    gaps,
    note,
    plain_ticks,
    spread_out,
)
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot, level, through
from vibecalc.core.report.sections import having, labels, scalar_of, table_of
from vibecalc.core.report.sources import Look, Source
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Axis, Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import FuncNorm
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Response over the frequency and a ratio that varies: the surface from above, and its ridge.
# ----------------------------------------------------------------------------

#: fewer curves are distinguished as curves
FEWEST = 10
#: and of more, so many are drawn as curves
_SOME = 4
#: decades of the amplitude that are distinguished
_DECADES = (-1.0, 1.5)
#: decades of the axis from which on plain numbers would not fit below it
_WIDE = 1.5
_BELOW = "frequency / natural frequency of the primary"


def varied(curve: Quantity) -> tuple[str, np.ndarray, np.ndarray]:
    """Words of the ratio that varies, its values, and the places of these curves, ascending."""
    found = []
    for place, name in enumerate(labels(curve.axes[0])):
        words, _, number = name.rpartition(" ")
        if words and words != "as":
            found.append((float(number), place, words))
    found.sort()
    values, places = (np.array([row[i] for row in found]) for i in range(2))
    return (found[0][2] if found else ""), values, places.astype(int)


def draw_absorber_surface(result: Result) -> "Figure | None":
    """Amplitude as colour; next to it the largest one over the ratio, on the same axis."""
    curve, largest = (result.record.quantities.get(ABSORBER + x) for x in ("curve", "largest"))
    if curve is None or largest is None or len(varied(curve)[1]) < FEWEST:
        return None
    words, values, places = varied(curve)
    figure = canvas(result, f"response over frequency and {words}", 5.6)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[2.4, 1.0])
    size = np.abs(curve.values)[places]
    shown = np.log10(np.clip(np.where(np.isfinite(size), size, 1e9), 1e-9, 1e9))
    low, high = _DECADES
    look = {"cmap": "viridis", "vmin": low, "vmax": high, "shading": "nearest"}
    mesh = left.pcolormesh(curve.axes[1].values, values, shown, **look)
    bar = figure.colorbar(mesh, ax=left, location="bottom", aspect=40, extend="both")
    marks = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
    bar.set_ticks([float(np.log10(mark)) for mark in marks], labels=[f"{m:g}" for m in marks])
    bar.set_label("amplitude ratio")
    tops = gaps(largest.values[places])
    right.plot(tops, values, ".-", color=COLOURS[1])
    right.set_xscale("log")
    if np.ptp(np.log10(tops[np.isfinite(tops)])) < _WIDE:
        plain_ticks(right.xaxis)
    right.set(xlabel="largest response", ylabel=words)
    right.tick_params(labelleft=True)
    left.set(xlabel=_BELOW, ylabel=words)
    left.grid(visible=False)
    return figure


# ----------------------------------------------------------------------------
# Response of a primary with its absorber over the frequency: a family of curves.
# ----------------------------------------------------------------------------

_OWN = ("tuned", "as given")
_LIMITS = {"locked": "--", "free": ":"}
#: of the highest finite maximum, or of the fixed points, the top of the picture
_ROOM = 2.5
#: of the highest maximum of the first curve, how far up that of another counts
_FAR = 20.0
_RING: Look = {"markerfacecolor": "none", "markeredgewidth": 1.6, "linestyle": ""}


def _title(result: Result) -> str:
    asked = table_of(result.case, "response", "absorber")
    _, what = excitation_and_response(asked, table_of(result.case, "tuning"))
    return f"{what.replace('_', ' ')} of the primary over the frequency"


def _known(row: Quantity) -> Source:
    return lambda result: row


def _family(result: Result) -> tuple[Panel, ...]:
    """Magnitude on a logarithmic scale, and phase below; maxima as dots, fixed points as rings."""
    curve = having(result.record, ABSORBER + "curve", "curve", "frequency_ratio")
    if curve is None:
        return ()
    hertz = result.record.quantities.get(ABSORBER + "frequency")
    over, below, colours = curve.axes[1], _BELOW, iter(COLOURS * 12)
    if hertz is not None:
        over = replace(over, values=hertz.values / (2.0 * np.pi))
        below = "frequency in Hz"
    # a long family is a surface, with a picture of its own: here a few of it
    places = varied(curve)[2].tolist()
    some = spread_out(len(places), _SOME) if len(places) >= FEWEST else range(len(places))
    hidden = sorted({*places} - {places[i] for i in some})
    sizes, phases = list[Curve](), list[Curve]()
    for place, name in enumerate(labels(curve.axes[0])):
        if place in hidden:
            continue
        row = replace(curve, path="", values=curve.values[place], axes=(over,), unit="")
        look = {
            "color": TOTAL if name in _OWN else QUIET if name in _LIMITS else next(colours),
            "linestyle": _LIMITS.get(name, "-"),
            "linewidth": 2.4 if name in _OWN else 1.3,
            "marker": "",
        }
        sizes.append(Curve(_known(_to_its_tops(row, place, result)), name, look))
        phases.append(Curve(_known(row), "", look, part=_turned))
    scale = float(over.values[-1] / curve.axes[1].values[-1])
    return (
        Panel(
            "amplitude ratio",
            (*sizes, partial(_dots, scale=scale), partial(_rings, scale=scale)),
            log="y",
            ends=partial(_heights, hidden=hidden),
            height=2.6,
        ),
        Panel("phase in deg", (*phases, _quarters), ends=_lowest, below=below),
    )


ABSORBER_CURVES = Curves(_title, _family, high=2.85)


def _to_its_tops(row: Quantity, place: int, result: Result) -> Quantity:
    """The magnitude of a curve through its maxima, between the frequencies of the case."""
    found = [result.record.quantities.get(f"{ABSORBER}peak/{x}") for x in (
        "frequency_ratio", "magnitude")]  # fmt: skip
    where, height = (None if one is None else np.ravel(one.values[place]) for one in found)
    if where is None or height is None:
        return row
    over = row.axes[0]
    ratio = result.record[ABSORBER + "curve"].axes[1].values
    inside = np.isfinite(height) & (height > 0.0) & (where >= ratio[0]) & (where <= ratio[-1])
    scale = float(over.values[-1] / ratio[-1])
    tops = np.stack([scale * where[inside], height[inside]], axis=1)
    x, y = through(over.values, np.abs(row.values), tops)
    return replace(row, values=y, axes=(replace(over, values=x),))


def _turned(values: np.ndarray) -> np.ndarray:
    """Phases in degrees, from -360 to 0."""
    turned = np.where(np.isfinite(np.abs(values)), np.degrees(np.angle(values)), np.nan)
    return np.where(turned > 1.0, turned - 360.0, turned)


def _quarters(plot: Plot) -> None:
    plot.axes.set_yticks(range(-360, 1, 90))


def _lowest(plot: Plot) -> tuple[float, float]:
    low = min(float(np.nanmin(y)) for _, y in plot.drawn)
    return (-370.0 if low < -185.0 else -190.0), 10.0


def _dots(plot: Plot, scale: float) -> None:
    height, place = (plot.result.record.quantities.get(f"{ABSORBER}peak/{x}") for x in (
        "magnitude", "frequency_ratio"))  # fmt: skip
    if height is not None and place is not None and labels(height.axes[0])[0] in _OWN:
        tops, spots = gaps(height.values[0]), scale * place.values[0]
        there = tops > 0.0
        plot.axes.plot(spots[there], tops[there], "o", color=TOTAL, ms=6, zorder=5,
                       label="maxima")  # fmt: skip


def _rings(plot: Plot, scale: float) -> None:
    height, place = (plot.result.record.quantities.get(f"{ABSORBER}fixed_point/{x}") for x in (
        "magnitude", "frequency_ratio"))  # fmt: skip
    if height is None or place is None:
        return
    x, y = scale * place.values, height.values
    plot.axes.plot(x, y, "o", color=LIMIT, ms=9, zorder=6, label="fixed points P, Q", **_RING)
    for name, *at in zip(labels(height.axes[0]), x.tolist(), y.tolist(), strict=True):
        note(plot.axes, name, (at[0], at[1]), (0, 8), ha="center", color=LIMIT, bbox=PLATE)


def _heights(plot: Plot, hidden: Sequence[int]) -> tuple[float, float]:
    """From the lowest of the first curve to the highest maximum of what is drawn, not far above.

    Maxima of curves that are nearly undamped would leave little of the page for the others.
    """
    own = plot.drawn[0][1]
    height = plot.result.record.quantities.get(ABSORBER + "peak/magnitude")
    tops = own if height is None else np.delete(height.values, np.array(hidden, dtype=int), axis=0)
    top = float(np.nanmax(gaps(tops), initial=float(np.nanmax(own, initial=1.0))))
    low = float(np.nanmin(own, initial=1.0))
    top = min(top, _FAR * float(np.nanmax(gaps(own), initial=1.0)))
    return max(0.5 * low, 0.02 * min(1.0, top)), _ROOM * top


# ----------------------------------------------------------------------------
# Design chart: best stiffness, damping and peak over mass ratio and primary damping.
# ----------------------------------------------------------------------------

_ROOT = "tuning/chart/"
_OVER = ("primary_damping", "mass_ratio")
_MASS, _STIFF = "mass ratio $J_2 / J_1$", "optimum stiffness\nratio $K_2 / K_1$"
_DAMPING_LABEL = "optimum damping ratio\n" + r"$c_2 / (2 J_2 \omega_2)$"
_PEAK = "minimum peak"


def draw_absorber_chart(result: Result) -> "Figure | None":
    """Peak, stiffness and damping over the mass ratio, and over each other; a colour for z1."""
    found = {
        name: having(result.record, _ROOT + name, *_OVER)
        for name in ("peak", "stiffness_ratio", "absorber_damping_ratio")
    }
    peak, stiff, own = found["peak"], found["stiffness_ratio"], found["absorber_damping_ratio"]
    if peak is None or stiff is None or own is None:
        return None
    from matplotlib import colormaps

    figure = canvas(result, "optimum tuning, a colour for each damping of the primary", 8.4)
    panels = figure.subplots(2, 3)
    damping, mass = (np.asarray(axis.values, dtype=float) for axis in peak.axes)
    tints = colormaps["viridis"](np.linspace(0.0, 0.92, len(damping)))
    for row, (value, tint) in enumerate(zip(damping, tints, strict=True)):
        top, k, z = (np.asarray(part.values, dtype=float)[row] for part in (peak, stiff, own))
        helped = (k > 0.0) | (z > 0.0)
        k, z = np.where(helped, k, np.nan), np.where(z > 0.0, z, np.nan)
        label = f"{value:g}"
        pairs = ((mass, top), (mass, k), (mass, z), (z, top), (k, top), (k, z))
        for axes, (x, y) in zip(panels.flat, pairs, strict=True):
            axes.plot(x, y, color=tint, label=label if axes is panels.flat[0] else None)
    names = ((_MASS, _PEAK), (_MASS, _STIFF), (_MASS, _DAMPING_LABEL),
             (_DAMPING_LABEL, _PEAK), (_STIFF, _PEAK), (_STIFF, _DAMPING_LABEL))  # fmt: skip
    for axes, (across, up) in zip(panels.flat, names, strict=True):
        _dress(axes, across, up, mass)
    figure.legend(title="damping ratio of the primary", loc="outside lower center", ncols=8)
    return figure


def _dress(axes: "Axes", across: str, up: str, mass: np.ndarray) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    if up == _PEAK:
        axes.set_yscale("log")
        plain_ticks(axes.yaxis)
    if across == _MASS and mass[-1] > 4.0 * mass[0]:
        axes.set_xscale("log")
        plain_ticks(axes.xaxis)
        if mass[-1] > 20.0 * mass[0]:  # a third of a page has no room for 2 and 5
            from matplotlib.ticker import LogLocator

            axes.xaxis.set_major_locator(LogLocator(subs=(1.0,)))


# ----------------------------------------------------------------------------
# Largest response over stiffness and damping of the absorber, around the optimum.
# ----------------------------------------------------------------------------

_SHARES = (0.01, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5)
_MARKS = ("s", "D", "^", "v")


def draw_absorber_map(result: Result) -> "Figure | None":
    """Contours by how far the peak is above the best one; optimum, other methods, stock pairs."""
    record = result.record
    found = having(record, "tuning/map/peak", "stiffness_ratio", "damping_over_primary_critical")
    best = scalar_of(record, "tuning/peak")
    if found is None or best is None or not np.isfinite(best):
        return None
    free = scalar_of(record, "tuning/unbounded/peak")
    figure = canvas(result, "largest response over spring and damper", 6.2)
    axes = figure.subplots()
    k, z2 = (np.asarray(axis.values, dtype=float) for axis in found.axes)
    above = np.asarray(found.values, dtype=float).T / best - 1.0
    # beyond the bounds of a case there may be better ones
    above = np.where(np.isfinite(above), np.maximum(above, 0.0), 10.0 * _SHARES[-1])
    levels = [0.0, *_SHARES]
    filled = axes.contourf(k, z2, above, levels=levels, extend="max", cmap="Blues", norm=_norm())
    axes.contour(k, z2, above, levels=_SHARES, colors="white", linewidths=0.9)
    bar = figure.colorbar(filled, ax=axes, ticks=levels)
    bar.ax.set_yticklabels([f"{100.0 * level:g}" for level in levels])
    bar.set_label("peak above the optimum in %")
    for place, (name, *at) in enumerate(_methods(record)):
        look: Look = {"color": COLOURS[(place + 1) % 6], "ms": 7 + 3 * place, "zorder": 5, **_RING}
        axes.plot(*at, _MARKS[place % 4], label=name.replace("_", " ").title(), **look)
    stock = (record.quantities.get(HARDWARE + x) for x in (
        "spring/stiffness_ratio", "oil/damping_over_primary_critical"))  # fmt: skip
    sides = [one.values[(low < one.values) & (one.values < high)] for one, (low, high) in zip(
        stock, ((k[0], k[-1]), (z2[0], z2[-1])), strict=True) if one is not None]  # fmt: skip
    if len(sides) == 2 and all(map(len, sides)):
        edge: Look = {"markeredgecolor": TOTAL, "markeredgewidth": 0.5}
        x, y = (part.ravel() for part in np.meshgrid(*sides))
        axes.plot(x, y, ".", color=COLOURS[4], ms=10, label="pairs in stock", **edge)
    within = "" if free is None else " within the bounds"
    words = f"optimum{within}, peak {show(best, digits=4)}"
    axes.plot(*_place(record, "tuning"), "*", color=LIMIT, ms=15, zorder=6, label=words)
    if free is not None:
        hollow: Look = {"markerfacecolor": "none", "zorder": 6, "label": "without the bounds"}
        axes.plot(*_place(record, "tuning/unbounded"), "*", color=LIMIT, ms=12, **hollow)
    axes.set_yscale("log")
    plain_ticks(axes.yaxis)
    axes.set(xlim=(k[0], k[-1]), ylim=(z2[0], z2[-1]), xlabel="stiffness ratio $K_2 / K_1$",
             ylabel=r"damping $c_2 / (2 \sqrt{K_1 J_1})$")  # fmt: skip
    axes.grid(visible=False)
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _norm() -> "FuncNorm":
    from matplotlib.colors import FuncNorm

    return FuncNorm((np.sqrt, np.square), vmin=0.0, vmax=4.0)


def _place(record: Record, root: str) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping ratio of tunings."""
    names = ("stiffness_ratio", "damping_over_primary_critical")
    stiffness, damping = (record[f"{root}/{name}"].values for name in names)
    return stiffness, damping


def _methods(record: Record) -> list[tuple[str, float, float]]:
    """Other methods and their tunings."""
    if "tuning/method/stiffness_ratio" not in record:
        return []
    names = labels(record["tuning/method/stiffness_ratio"].axes[0])
    both = zip(names, *_place(record, "tuning/method"), strict=True)
    return [row for row in both if row[0] != "numerical"]


# ----------------------------------------------------------------------------
# What a tuned absorber becomes while its oil warms.
# ----------------------------------------------------------------------------


_PLAIN: Look = {"color": COLOURS[0], "marker": ""}
_WARM = HARDWARE + "warming/"

ABSORBER_WARMING = Curves(
    "peak and damping over the oil temperature",
    (
        Panel(
            "largest response",
            (
                Curve(_WARM + "peak", "same springs", _PLAIN),
                Curve(_WARM + "best_peak", "optimum springs at each temperature",
                      {"color": COLOURS[2], "linestyle": "--", "marker": ""}),
                level("tuning/peak", "as tuned, {}", color=LIMIT, linestyle=":"),
            ),
            ends=(0.0, None),
            height=1.7,
            legend={"loc": "best"},
        ),
        Panel(
            r"damping $c_2 / (2 \sqrt{K_1 J_1})$",
            (
                Curve(_WARM + "damping_over_primary_critical", "", {**_PLAIN, "color": COLOURS[1]}),
                level("tuning/damping_over_primary_critical", "required", linestyle=":"),
            ),
            log="y",
            legend={"loc": "lower left"},
            below="temperature of the oil in $\\degree$C",
        ),
    ),
    high=2.35,
)  # fmt: skip


# ----------------------------------------------------------------------------
# Order of a pendulum over its swing, the torque that it carries, and the rotor's motion.
# ----------------------------------------------------------------------------


def _given(name: str) -> Callable[[Result], Any]:
    return lambda result: table_of(result.case, "machine", "pendulum").get(name)


def _steady(result: Result) -> Quantity | None:
    """Torque over the largest swing, from rest on and upwards."""
    torque = having(result.record, PENDULUM + "steady/torque", "steady_swing")
    swing = having(result.record, PENDULUM + "steady/largest_swing", "steady_swing")
    if torque is None or swing is None:
        return None
    size = np.asarray(torque.values) * np.sign(torque.values[0])
    axis = Axis(name="swing", values=np.append(0.0, swing.values), unit="rad")
    return replace(torque, values=np.append(0.0, size), axes=(axis,))


def _jump(plot: Plot) -> None:
    record = plot.result.record
    limit, place = (scalar_of(record, PENDULUM + f"jump/{x}") for x in ("torque", "swing"))
    if limit is not None and place is not None and np.isfinite(limit):
        words = f"jump, {show(plot.factor * limit, digits=4)} {plot.unit}"
        plot.axes.plot([np.degrees(place)], [plot.factor * limit], "o", color=LIMIT, label=words)


def _path(result: Result) -> str:
    return str(_given("path")(result) or "circular")


SWINGING = Curves(
    "order, torque and motion of the rotor",
    (
        Panel(
            "order of the pendulum",
            (
                Curve(PENDULUM + "order_of_swing", _path, _PLAIN),
                level(_given("order"), "required", linestyle=":"),
            ),
            legend={"loc": "best"},
            below="swing in deg",
        ),
        Panel(
            "torque",
            (
                Curve(_steady, "undamped, exact", _PLAIN),
                _jump,
                level(_given("torque"), "torque of the case"),
            ),
            unit="N*m",
            legend={"loc": "best"},
            below="largest angle of swing in deg",
        ),
        Panel(
            "motion of the rotor, zero-to-peak,",
            (
                Curve(PENDULUM + "response/rotor", "small swings of the pendulums", _PLAIN),
                Curve(PENDULUM + "response/without", "pendulums locked",
                      {**_PLAIN, "color": COLOURS[1]}),
            ),
            unit="deg",
            log="y",
            legend={"loc": "best"},
            below="order of the torque / required order",
        ),
    ),
    high=3.25,
    columns=2,
)  # fmt: skip
