"""Pictures of the control: levels over feedback, poles over gain, other motors."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, ORDER_NAMES, QUIET, TOTAL, canvas
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot
from vibecalc.core.report.sections import having, scalar_of, table_of
from vibecalc.core.report.sources import Look, Source
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.roll.report.control import CONTROL, status_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Levels under control over the feedback of the shell's acceleration, and what the loops bear.
# ----------------------------------------------------------------------------

#: s, a delay that any sensor and converter have
_LITTLE = 1e-4
_ORDERS_UNDER_CONTROL = 2
#: feedbacks up to which each has a tick
_FEW = 12
#: ms, borders of the fields of delay margins
_MARGINS = 10.0 ** np.arange(-2.0, 3.0)


def draw_roll_control(result: Result) -> "Figure | None":
    """Above, levels of the first orders with a line for each gain, dark to bright; below, delay
    margins in decades.

    Loops that are not stable have crosses at the top and hatches below, those that bear less than
    a tenth of a millisecond of delay hollow marks and pale lines. None without a grid.
    """
    level = having(result.record, CONTROL + "grid/level", "gain", "feedback", "order")
    status, delay, torque = (
        having(result.record, f"{CONTROL}grid/{name}", "gain", "feedback")
        for name in ("status", "delay_margin", "torque_peak")
    )
    if level is None or status is None or delay is None:
        return None
    words = "levels of the shell under control of the motor, delay margin (reduced model)"
    figure = canvas(result, words, 8.2)
    count = min(_ORDERS_UNDER_CONTROL, level.values.shape[-1])
    names: list[Any] = [[f"order {i}" for i in range(count)], ["margin"] * count]
    panels = figure.subplot_mosaic(names, height_ratios=[1.35, 1.0])
    shaky = (np.asarray(status.values) == 1) | (np.asarray(delay.values) < _LITTLE)
    stable = np.asarray(status.values) < 2
    for i in range(count):
        axes = panels[f"order {i}"]
        _lines(axes, level, i, stable, shaky)
        _without(axes, result, i)
    _legend(figure, panels["order 0"])
    over = None
    most = scalar_of(result.record, CONTROL + "breakdown_torque")
    if torque is not None and most is not None:
        over = stable & (np.asarray(torque.values, dtype=float) > most)
    _map(panels["margin"], status, delay, over)
    return figure


def _lines(
    axes: "Axes", level: Quantity, order: int, stable: np.ndarray, shaky: np.ndarray
) -> None:
    from matplotlib import colormaps

    gains, feedbacks = (np.asarray(axis.values) for axis in level.axes[:2])
    tints = colormaps["viridis"](np.linspace(0.0, 0.92, len(gains)))
    rank = np.argsort(feedbacks)
    at = feedbacks[rank]
    axes.set_xscale("symlog", linthresh=_smallest(feedbacks), linscale=0.5)
    for row, gain in enumerate(gains):
        values = np.asarray(level.values, dtype=float)[row, rank, order]
        held, weak = stable[row, rank], shaky[row, rank]
        colour, shown = tints[row], np.where(held, values, np.nan)
        axes.plot(at, shown, color=colour, alpha=0.35, linewidth=1.2)
        axes.plot(at, np.where(weak, np.nan, shown), color=colour, linewidth=2.0)
        good = held & ~weak
        axes.plot(at[good], values[good], "o", color=colour, label=f"K = {gain:g}")
        poor = held & weak
        axes.plot(at[poor], values[poor], "o", color=colour, markerfacecolor="white")
        lost = at[~held]
        if lost.size:
            top = np.full(lost.size, 1.03 + 0.025 * (row % 3))
            axes.plot(
                lost, top, "x", color=colour, ms=6, markeredgewidth=1.8, clip_on=False,
                transform=axes.get_xaxis_transform(),
            )  # fmt: skip
    number = int(level.axes[2].values[order])
    axes.set_title(f"order {number}", loc="left", pad=18)
    axes.set_xlabel("feedback of the shell's acceleration in s")
    axes.set_ylabel("level in dB re 1 rad/s$^2$, zero-to-peak")
    _across(axes, at)


def _across(axes: "Axes", at: np.ndarray) -> None:
    """Ends of the axis of feedbacks, and a tick at each of a few."""
    bend = axes.xaxis.get_transform()
    places = bend.transform(at)
    room = 0.06 * float(np.ptp(places)) or 0.5
    ends = bend.inverted().transform(np.array([places.min() - room, places.max() + room]))
    axes.set_xlim(*ends)
    if at.size <= _FEW:
        axes.set_xticks(at, [f"{value:g}" for value in at])
        axes.tick_params(axis="x", labelrotation=45)
    axes.set_xticks([], minor=True)
    if ends[0] < 0.0 < ends[1]:
        axes.axvline(0.0, color=QUIET, linewidth=0.7)


def _smallest(values: np.ndarray) -> float:
    sizes = np.abs(values[values != 0.0])
    return float(sizes.min()) if sizes.size else 1.0


def _without(axes: "Axes", result: Result, order: int) -> None:
    level = having(result.record, CONTROL + "level_without", "order")
    if level is not None and np.isfinite(level.values[order]):
        axes.axhline(float(level.values[order]), color=TOTAL, linewidth=1.0, linestyle="--",
                     label="no control")  # fmt: skip


def _legend(figure: "Figure", axes: "Axes") -> None:
    from matplotlib.lines import Line2D

    handles, names = axes.get_legend_handles_labels()
    grey: dict[str, Any] = {"color": QUIET, "linestyle": "", "ms": 6}
    handles += [
        Line2D([], [], marker="o", markerfacecolor="white", **grey),
        Line2D([], [], marker="x", markeredgewidth=1.8, **grey),
    ]
    names += [f"delay margin below {1e3 * _LITTLE:g} ms", "not stable: no level"]
    figure.legend(handles, names, loc="outside lower center", ncols=5)


def _map(axes: "Axes", status: Quantity, delay: Quantity, over: np.ndarray | None) -> None:
    """Delay margins as fields; hatched where the loop is not stable or bears none."""
    from matplotlib.colors import BoundaryNorm
    from matplotlib.patches import Rectangle

    rank = np.argsort(np.asarray(status.axes[1].values))
    state = np.asarray(status.values)[:, rank]
    margin = 1e3 * np.asarray(delay.values, dtype=float)[:, rank]
    fine = (state < 2) & (margin > 0.0)
    image = axes.imshow(
        np.where(fine, np.minimum(margin, 2.0 * _MARGINS[-1]), np.nan), cmap="viridis",
        norm=BoundaryNorm(_MARGINS, 256, extend="both"), aspect="auto", origin="lower",
    )  # fmt: skip
    for i, j in np.argwhere(~fine):
        axes.add_patch(
            Rectangle((j - 0.5, i - 0.5), 1.0, 1.0, facecolor="#f6dede", edgecolor=LIMIT,
                      hatch="////" if state[i, j] >= 2 else "..", linewidth=0.0)
        )  # fmt: skip
    gains, feedbacks = (np.asarray(axis.values) for axis in status.axes)
    axes.set_yticks(range(len(gains)), [f"{gain:g}" for gain in gains])
    axes.set_xticks(range(len(rank)), [f"{value:g}" for value in feedbacks[rank]])
    axes.set_xlabel("feedback of the shell's acceleration in s")
    axes.set_ylabel("gain K")
    axes.grid(visible=False)
    words = "delay margin; hatched: not stable"
    words += ", dotted: stable only without any delay" if np.any(state == 1) else ""
    if over is not None and np.any(over):
        axes.plot(*np.argwhere(over[:, rank]).T[::-1], "X", color="white", markeredgecolor=TOTAL,
                  ms=7)  # fmt: skip
        words += "; crosses: above the breakdown torque"
    axes.set_title(words, loc="left")
    axes.figure.colorbar(image, ax=axes, label="delay margin in ms", pad=0.01, ticks=_MARGINS,
                         format="{x:g}")  # fmt: skip


# ----------------------------------------------------------------------------
# Root locus: the poles of the controlled loop as its gain grows.
# ----------------------------------------------------------------------------

#: poles as far left as this many times the one nearest to the axis decide nothing
_FAR = 1e4


def draw_roll_locus(result: Result) -> "Figure | None":
    """Left the plane of the poles, right how fast they fade over the gain; None without poles.

    What lies to the right of the axis, or above it, grows without a bound. Poles that are all real
    would lie on one line of the plane: then it is left out.
    """
    locus = having(result.record, CONTROL + "locus/pole", "locus_gain", "branch")
    if locus is None:
        return None
    gain = np.asarray(locus.axes[0].values, dtype=float)
    pole = np.where(np.isfinite(np.abs(locus.values)), locus.values, np.nan + 0j)
    asked = table_of(result.case, "response", "control")
    own, words = asked.get("gain"), status_words(result.record, "")
    title = "poles of the loop as the gain grows (reduced model)"
    if isinstance(own, int | float):
        title += f"; with the gain of the case, {show(own, 0, 4)}: {words}"
    found = having(result.record, CONTROL + "pole", "pole")
    at = np.zeros(0, dtype=complex) if found is None else np.asarray(found.values, dtype=complex)
    at = at[np.isfinite(np.abs(at))]
    if np.any(_swings(pole)) or np.any(_swings(at)):
        figure = canvas(result, title, 5.4)
        first, fading = figure.subplots(1, 2)
        _plane(first, gain, pole, at)
    else:
        figure = canvas(result, title + ",\nall poles are real (overdamped)", 5.4)
        first = fading = figure.subplots()
    _fading(fading, gain, pole, own)
    if first is fading and isinstance(own, int | float):
        there = np.full(at.shape, float(own))
        fading.plot(there, at.real, "x", color=COLOURS[1], ms=9, markeredgewidth=2.2, zorder=5,
                    label="gain of the case")  # fmt: skip
    figure.legend(*first.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _swings(pole: np.ndarray) -> np.ndarray:
    """Which poles are not real."""
    return np.asarray(np.abs(pole.imag) > 1e-9 * np.abs(pole))


def _pairs(pole: np.ndarray) -> np.ndarray:
    """Poles with the conjugate of each that swings, (gains, branches) or (poles,)."""
    swings = _swings(pole)
    other = pole[..., np.any(swings, axis=0)] if pole.ndim > 1 else pole[swings]
    return np.concatenate([pole, np.conj(other)], axis=-1)


def _plane(axes: "Axes", gain: np.ndarray, pole: np.ndarray, at: np.ndarray) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LogNorm

    pole, at = _pairs(pole), _pairs(at)
    real, imaginary = pole.real, pole.imag
    linear = _linear(np.abs(pole))
    axes.set_xscale("symlog", linthresh=linear)
    axes.set_yscale("symlog", linthresh=linear)
    norm, lines = LogNorm(gain[0], gain[-1]), None
    for column in range(pole.shape[1]):
        points = np.stack([real[:, column], imaginary[:, column]], axis=-1)
        pieces = np.stack([points[:-1], points[1:]], axis=1)
        lines = LineCollection(list(pieces), cmap="viridis", norm=norm, linewidth=2.6)
        lines.set_array(gain[:-1])
        axes.add_collection(lines)
        axes.plot(*points[0], "o", color=TOTAL, ms=6, markerfacecolor="white",
                  label=f"K = {gain[0]:g}" if column == 0 else None)  # fmt: skip
    if at.size:
        axes.plot(at.real, at.imag, "x", color=COLOURS[1], ms=9, markeredgewidth=2.2, zorder=5,
                  label="gain of the case")  # fmt: skip
    axes.axhline(0.0, color=QUIET, linewidth=0.7)
    low = 3.0 * min(float(np.nanmin(real)), -linear)
    high = max(3.0 * float(np.nanmax(real)), 2.0 * linear)
    tall = max(3.0 * float(np.nanmax(np.abs(imaginary))), 2.0 * linear)
    axes.set_xlim(low, high)
    axes.set_ylim(-tall, tall)
    axes.axvspan(0.0, high, facecolor="#f6dede", edgecolor=LIMIT, hatch="////", linewidth=0.0,
                 zorder=0)  # fmt: skip
    axes.axvline(0.0, color=LIMIT, linewidth=1.2)
    axes.set_xlabel("real part in 1/s; hatched: unstable")
    axes.set_ylabel("imaginary part in 1/s")
    axes.tick_params(axis="x", labelrotation=45)
    if lines is not None:
        axes.figure.colorbar(lines, ax=axes, label="gain K", pad=0.02)


def _linear(sizes: np.ndarray) -> float:
    """A power of ten up to which a scale is linear: below the nearest pole, unless it is far."""
    least, most = float(np.nanmin(sizes)), float(np.nanmax(sizes))
    return float(10.0 ** np.floor(np.log10(max(least, most / _FAR, 1e-12))))


def _fading(axes: "Axes", gain: np.ndarray, pole: np.ndarray, own: object) -> None:
    axes.set_xscale("log")
    linear = _linear(np.abs(pole.real))
    axes.set_yscale("symlog", linthresh=linear)
    for column in range(pole.shape[1]):
        swings = _swings(pole[:, column])
        colour = COLOURS[column % len(COLOURS)]
        real = pole[:, column].real
        axes.plot(gain, real, color=colour, linewidth=1.4)
        axes.plot(gain, np.where(swings, real, np.nan), color=colour, linewidth=3.4, alpha=0.45)
    axes.axhline(0.0, color=LIMIT, linewidth=1.2)
    low, high = axes.get_ylim()
    high = max(high, 2.0 * linear)
    axes.set_ylim(low, high)
    axes.axhspan(0.0, high, facecolor="#f6dede", edgecolor=LIMIT, hatch="////", linewidth=0.0,
                 zorder=0)  # fmt: skip
    if isinstance(own, int | float):
        axes.axvline(float(own), color=COLOURS[1], linestyle=":")
    axes.set_xlim(gain[0], gain[-1])
    axes.set_xlabel("gain K")
    axes.set_ylabel("real part in 1/s (thick: oscillates)")


# ----------------------------------------------------------------------------
# Levels and speed over the torque per slip of the motor, without a controller.
# ----------------------------------------------------------------------------

_PATH = CONTROL + "motor_gains/"
_ORDERS_WITHOUT = 4


def _by_gain(order: int) -> Source:
    """Levels of the order at a place, over the torque per slip."""

    def made(result: Result) -> Quantity | None:
        level = having(result.record, _PATH + "level", "motor_gain", "order")
        if level is None or level.values.shape[1] <= order:
            return None
        gains, orders = level.axes
        only = replace(orders, values=orders.values[order : order + 1])
        return replace(level, values=level.values[:, order][None], axes=(only, gains))

    return made


def _name(place: int) -> Callable[[Result], str]:
    def words(result: Result) -> str:
        order = int(result.record[_PATH + "level"].axes[1].values[place])
        return ORDER_NAMES.get(order, f"order {order}")

    return words


def _this_motor(plot: Plot, named: bool) -> None:
    """The torque per slip of the motor of the case."""
    own = scalar_of(plot.result.record, CONTROL + "motor_gain")
    if own is not None:
        words = f"this motor, {show(own, digits=4)} N m s/rad" if named else None
        plot.axes.axvline(own, color=LIMIT, linestyle=":", label=words)


_MARKED: Look = {"marker": "o", "ms": 4}

ROLL_MOTOR_GAIN = Curves(
    "other motors without control (reduced model)",
    (
        Panel(
            "level in {} re 1 rad/s$^2$, zero-to-peak",
            (
                *(
                    Curve(_by_gain(i), _name(i), {**_MARKED, "linestyle": "-" if i < 2 else "--"},)
                    for i in range(_ORDERS_WITHOUT)
                ),
                partial(_this_motor, named=True),
            ),
            log="x",
            height=2.2,
            legend={"loc": "lower left"},
        ),
        Panel(
            "mean speed",
            (Curve(_PATH + "speed", "", _MARKED), partial(_this_motor, named=False)),
            unit="rpm",
            log="x",
            legend={"loc": "lower right"},
            below="motor slope in N m s/rad",
        ),
    ),
    high=2.55,
)  # fmt: skip
