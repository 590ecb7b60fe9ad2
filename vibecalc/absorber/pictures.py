"""Pictures of absorbers: response, design chart, map around the optimum, pendulum."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.absorber.report.hardware import HARDWARE
from vibecalc.absorber.report.tuning import ABSORBER, PENDULUM
from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, note, plain_ticks
from vibecalc.core.report.curves import Curve, Curves, Look, Panel, Plot, level
from vibecalc.core.report.sections import having, labels, scalar_of, table_of
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
#: decades of the amplitude that are distinguished
_DECADES = (-1.0, 1.5)
#: decades of the axis from which on plain numbers would not fit below it
_WIDE = 1.5


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
    curve = having(result.record, ABSORBER + "curve", "curve", "frequency_ratio")
    largest = having(result.record, ABSORBER + "largest", "curve")
    if curve is None or largest is None:
        return None
    words, values, places = varied(curve)
    if len(values) < FEWEST:
        return None
    figure = canvas(result, f"response over frequency and {words}", 5.6)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[2.4, 1.0])
    x = np.asarray(curve.axes[1].values, dtype=float)
    size = np.abs(np.asarray(curve.values))[places]
    shown = np.log10(np.clip(np.where(np.isfinite(size), size, 1e9), 1e-9, 1e9))
    mesh = left.pcolormesh(
        x, values, shown, cmap="viridis", vmin=_DECADES[0], vmax=_DECADES[1], shading="nearest"
    )
    bar = figure.colorbar(mesh, ax=left, location="bottom", aspect=40, extend="both")
    marks = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
    bar.set_ticks([float(np.log10(mark)) for mark in marks], labels=[f"{m:g}" for m in marks])
    bar.set_label("amplitude ratio")
    tops = np.asarray(largest.values, dtype=float)[places]
    right.plot(np.where(np.isfinite(tops), tops, np.nan), values, ".-", color=COLOURS[1])
    right.set_xscale("log")
    if np.ptp(np.log10(tops[np.isfinite(tops)])) < _WIDE:
        plain_ticks(right.xaxis)
    right.set_xlabel("largest response")
    right.set_ylabel(words)
    right.tick_params(labelleft=True)
    left.set_xlabel("frequency / natural frequency of the primary")
    left.set_ylabel(words)
    left.grid(visible=False)
    return figure


# ----------------------------------------------------------------------------
# Response of a primary with its absorber over the frequency: a family of curves.
# ----------------------------------------------------------------------------

_OWN = ("tuned", "as given")
_LIMITS = {"locked": "--", "free": ":"}
#: of the highest finite maximum, or of the fixed points, the top of the picture
_ROOM = 2.5


def draw_absorber_curves(result: Result) -> "Figure | None":
    """Magnitude on a logarithmic scale, and phase below; maxima as dots, fixed points as rings."""
    record = result.record
    curve = having(record, ABSORBER + "curve", "curve", "frequency_ratio")
    if curve is None:
        return None
    options = table_of(result.case, "response", "absorber")
    what = str(options.get("response") or "displacement").replace("_", " ")
    figure = canvas(result, f"{what} of the primary over the frequency", 7.0)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.6, 1.0])
    hertz = having(record, ABSORBER + "frequency", "frequency_ratio")
    x = np.asarray(curve.axes[1].values, dtype=float)
    if hertz is not None:
        x = np.asarray(hertz.values) / (2.0 * np.pi)
    names, colours = labels(curve.axes[0]), iter(COLOURS * 12)
    # a long family is a surface, with a picture of its own
    hidden = set(varied(curve)[2]) if len(varied(curve)[1]) >= FEWEST else set()
    for place, (name, row) in enumerate(zip(names, np.asarray(curve.values), strict=True)):
        if place in hidden:
            continue
        colour = TOTAL if name in _OWN else QUIET if name in _LIMITS else next(colours)
        style = _LIMITS.get(name, "-")
        width = 2.4 if name in _OWN else 1.3
        size = np.abs(row)
        seen = np.where(np.isfinite(size) & (size > 0.0), size, np.nan)
        above.plot(x, seen, style, color=colour, linewidth=width, label=name)
        turned = np.where(np.isfinite(size), np.degrees(np.angle(row)), np.nan)
        turned = np.where(turned > 1.0, turned - 360.0, turned)
        below.plot(x, turned, style, color=colour, linewidth=width)
    scale = _scale(record, curve, x)
    _dots(above, record, names, scale)
    _rings(above, record, scale)
    above.set_yscale("log")
    above.set_ylim(*_limits(record, curve, hidden))
    plain_ticks(above.yaxis)
    above.set_ylabel("amplitude ratio")
    below.set_ylabel("phase in deg")
    below.set_yticks(range(-360, 1, 90))
    below.set_ylim(*_phase_limits(below))
    below.set_xlabel(
        "frequency in Hz" if hertz is not None else "frequency / natural frequency of the primary"
    )
    below.set_xlim(x[0], x[-1])
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def _scale(record: Record, curve: Quantity, x: np.ndarray) -> float:
    """What a frequency ratio is on the axis: itself, or Hz."""
    ratios = np.asarray(curve.axes[1].values, dtype=float)
    return float(x[-1] / ratios[-1]) if ratios[-1] else 1.0


def _dots(axes: "Axes", record: Record, names: list[str], scale: float) -> None:
    height = having(record, ABSORBER + "peak/magnitude", "curve", "peak")
    place = having(record, ABSORBER + "peak/frequency_ratio", "curve", "peak")
    if height is None or place is None:
        return
    first = True
    for name, tops, spots in zip(names, height.values, place.values, strict=True):
        there = np.isfinite(tops) & (tops > 0.0)
        if name in _OWN and np.any(there):
            axes.plot(
                scale * spots[there],
                tops[there],
                "o",
                color=TOTAL,
                ms=6,
                zorder=5,
                label="its maxima" if first else None,
            )
            first = False


def _rings(axes: "Axes", record: Record, scale: float) -> None:
    height = having(record, ABSORBER + "fixed_point/magnitude", "fixed_point")
    place = having(record, ABSORBER + "fixed_point/frequency_ratio", "fixed_point")
    if height is None or place is None:
        return
    axes.plot(
        scale * np.asarray(place.values),
        np.asarray(height.values),
        "o",
        color=LIMIT,
        ms=9,
        markerfacecolor="none",
        markeredgewidth=1.6,
        zorder=6,
        label="fixed points P, Q",
    )
    for name, x, y in zip(labels(height.axes[0]), place.values, height.values, strict=True):
        note(axes, name, (scale * float(x), float(y)), (0, 9), ha="center", color=LIMIT)


def _limits(record: Record, curve: Quantity, hidden: set[int]) -> tuple[float, float]:
    size = np.abs(np.asarray(curve.values))
    own = size[0][np.isfinite(size[0]) & (size[0] > 0.0)]
    height = having(record, ABSORBER + "peak/magnitude", "curve", "peak")
    tops = np.asarray(height.values, dtype=float) if height is not None else own
    if hidden and height is not None:  # the highest of what is drawn
        tops = np.delete(tops, sorted(hidden), axis=0)
    tops = tops[np.isfinite(tops) & (tops > 0.0)]
    top = float(np.max(tops, initial=float(np.max(own, initial=1.0))))
    low = float(np.min(own, initial=1.0))
    return max(0.5 * low, 0.02 * min(1.0, top)), _ROOM * top


def _phase_limits(axes: "Axes") -> tuple[float, float]:
    low = min(float(np.nanmin(line.get_ydata())) for line in axes.get_lines())
    return (-370.0 if low < -185.0 else -190.0), 10.0


# ----------------------------------------------------------------------------
# Design chart: best stiffness, damping and peak over mass ratio and primary damping.
# ----------------------------------------------------------------------------

_ROOT = "tuning/chart/"
_OVER = ("primary_damping", "mass_ratio")
_MASS, _STIFF = "mass ratio $J_2 / J_1$", "best stiffness ratio $K_2 / K_1$"
_DAMPING_LABEL = r"best damping $\varepsilon_2 = c_2 / (2 J_2 \omega_2)$"
_PEAK = "least peak"


def draw_absorber_chart(result: Result) -> "Figure | None":
    """Peak, stiffness and damping over the mass ratio, and over each other; a colour for z1."""
    found = {
        name: having(result.record, _ROOT + name, *_OVER)
        for name in ("peak", "stiffness_ratio", "own_damping")
    }
    peak, stiff, own = found["peak"], found["stiffness_ratio"], found["own_damping"]
    if peak is None or stiff is None or own is None:
        return None
    from matplotlib import colormaps

    figure = canvas(result, "best tuning, one colour for each damping of the primary", 8.4)
    panels = figure.subplots(2, 3)
    damping, mass = (np.asarray(axis.values, dtype=float) for axis in peak.axes)
    tints = colormaps["viridis"](np.linspace(0.0, 0.92, len(damping)))
    for row, (value, tint) in enumerate(zip(damping, tints, strict=True)):
        top, k, z = (np.asarray(part.values, dtype=float)[row] for part in (peak, stiff, own))
        helped = (k > 0.0) | (z > 0.0)
        k, z = np.where(helped, k, np.nan), np.where(z > 0.0, z, np.nan)
        label = show(float(value), digits=2)
        pairs = ((mass, top), (mass, k), (mass, z), (z, top), (k, top), (k, z))
        for axes, (x, y) in zip(panels.flat, pairs, strict=True):
            axes.plot(x, y, color=tint, label=label if axes is panels.flat[0] else None)
    names = (
        (_MASS, _PEAK),
        (_MASS, _STIFF),
        (_MASS, _DAMPING_LABEL),
        (_DAMPING_LABEL, _PEAK),
        (_STIFF, _PEAK),
        (_STIFF, _DAMPING_LABEL),
    )
    for axes, (across, up) in zip(panels.flat, names, strict=True):
        _dress(axes, across, up, mass)
    figure.legend(title="damping of the primary", loc="outside lower center", ncols=8)
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
    found = having(record, "tuning/map/peak", "stiffness_ratio", "secondary_damping")
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
    _methods(axes, record)
    _stock(axes, record, (k[0], k[-1]), (z2[0], z2[-1]))
    axes.plot(
        [float(record["tuning/stiffness_ratio"].values)],
        [float(record["tuning/secondary_damping"].values)],
        "*",
        color=LIMIT,
        ms=15,
        zorder=6,
        label=f"optimum{'' if free is None else ' within the bounds'}, peak {show(best, digits=4)}",
    )
    if free is not None:
        axes.plot(
            [float(record["tuning/unbounded/stiffness_ratio"].values)],
            [float(record["tuning/unbounded/secondary_damping"].values)],
            "*",
            color=LIMIT,
            ms=12,
            markerfacecolor="none",
            zorder=6,
            label="without the bounds",
        )
    axes.set_yscale("log")
    plain_ticks(axes.yaxis)
    axes.set_xlim(k[0], k[-1])
    axes.set_ylim(z2[0], z2[-1])
    axes.grid(visible=False)
    axes.set_xlabel("stiffness ratio $K_2 / K_1$")
    axes.set_ylabel(r"damping $c_2 / (2 \sqrt{K_1 J_1})$")
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _norm() -> "FuncNorm":
    from matplotlib.colors import FuncNorm

    return FuncNorm((np.sqrt, np.square), vmin=0.0, vmax=4.0)


def _methods(axes: "Axes", record: Record) -> None:
    k = having(record, "tuning/method/stiffness_ratio", "method")
    z2 = having(record, "tuning/method/secondary_damping", "method")
    if k is None or z2 is None:
        return
    others = [
        (n, x, y)
        for n, x, y in zip(k.axes[0].values, k.values, z2.values, strict=True)
        if n != "numerical"
    ]
    for place, (name, x, y) in enumerate(others):
        axes.plot(
            [x],
            [y],
            _MARKS[place % 4],
            color=COLOURS[(place + 1) % 6],
            ms=7 + 3 * place,
            label=str(name).replace("_", " ").title(),
            zorder=5,
            markerfacecolor="none",
            markeredgewidth=1.6,
        )


def _stock(
    axes: "Axes", record: Record, across: tuple[float, float], along: tuple[float, float]
) -> None:
    """Pairs of stock parts that lie on the map."""
    k = having(record, "hardware/spring/stiffness_ratio", "stock_spring")
    z2 = having(record, "hardware/oil/secondary_damping", "stock_oil")
    if k is None or z2 is None:
        return
    x, y = (part.ravel() for part in np.meshgrid(k.values, z2.values))
    there = (across[0] < x) & (x < across[1]) & (along[0] < y) & (y < along[1])
    if np.any(there):
        axes.plot(
            x[there],
            y[there],
            ".",
            color=COLOURS[4],
            ms=10,
            label="pairs in stock",
            markeredgecolor=TOTAL,
            markeredgewidth=0.5,
        )


# ----------------------------------------------------------------------------
# What a tuned absorber becomes while its oil warms.
# ----------------------------------------------------------------------------


_PLAIN: Look = {"color": COLOURS[0], "marker": ""}
_WARM = HARDWARE + "warming/"

ABSORBER_WARMING = Curves(
    "peak and damping as the oil warms",
    (
        Panel(
            "largest response",
            (
                Curve(_WARM + "peak", "springs kept", _PLAIN),
                Curve(_WARM + "best_peak", "springs that suit the damping of each temperature",
                      {"color": COLOURS[2], "linestyle": "--", "marker": ""}),
                level("tuning/peak", "tuning, {}", color=LIMIT, linestyle=":"),
            ),
            ends=(0.0, None),
            height=1.7,
            legend={"loc": "best"},
        ),
        Panel(
            r"damping $c_2 / (2 \sqrt{K_1 J_1})$",
            (
                Curve(_WARM + "secondary_damping", "", {**_PLAIN, "color": COLOURS[1]}),
                level("tuning/secondary_damping", "wanted", linestyle=":"),
            ),
            log="y",
            legend={"loc": "upper right"},
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
            "order that the pendulum keeps",
            (
                Curve(PENDULUM + "order_of_swing", _path, _PLAIN),
                level(_given("order"), "wanted", linestyle=":"),
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
                Curve(PENDULUM + "response/rotor", "pendulums swing a little", _PLAIN),
                Curve(PENDULUM + "response/without", "pendulums locked",
                      {**_PLAIN, "color": COLOURS[1]}),
            ),
            unit="deg",
            log="y",
            legend={"loc": "best"},
            below="order of the torque over the wanted one",
        ),
    ),
    high=3.25,
    columns=2,
)  # fmt: skip
