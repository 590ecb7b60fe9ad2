"""Levels under control over the feedback of the shell's acceleration, and what the loops bear."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having, scalar_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.sections.roll_control_words import CONTROL, in_time
from vibecalc.results.record import Quantity, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: s, a delay that any sensor and converter have
_LITTLE = 1e-4
_ORDERS = 2
#: fields with more entries than these bear no numbers
_NUMBERED = 12
_MARKS = "osD^vP"


def picture(result: Result) -> "Figure | None":
    """Above, levels of the first orders with a line for each gain; below, delay margins.

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
    words = "levels of the shell under control of the motor (reduced model), what the loop bears"
    figure = canvas(result, words, 9.8, 8.2)
    count = min(_ORDERS, level.values.shape[-1])
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
    gains, feedbacks = (np.asarray(axis.values) for axis in level.axes[:2])
    rank = np.argsort(feedbacks)
    at = feedbacks[rank]
    axes.set_xscale("symlog", linthresh=_smallest(feedbacks), linscale=0.5)
    for row, gain in enumerate(gains):
        values = np.asarray(level.values, dtype=float)[row, rank, order]
        held, weak = stable[row, rank], shaky[row, rank]
        colour = COLOURS[row % len(COLOURS)]
        mark = _MARKS[(row // len(COLOURS)) % len(_MARKS)]
        shown = np.where(held, values, np.nan)
        axes.plot(at, shown, color=colour, alpha=0.35, linewidth=1.2)
        axes.plot(at, np.where(weak, np.nan, shown), color=colour, linewidth=2.0)
        good = held & ~weak
        axes.plot(at[good], values[good], mark, color=colour, ms=5, label=f"K = {show(gain, 0, 3)}")
        poor = held & weak
        axes.plot(at[poor], values[poor], mark, color=colour, ms=5, markerfacecolor="white")
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
    if at.size <= _NUMBERED:
        axes.set_xticks(at, [f"{value:g}" for value in at], rotation=45)
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
    names += [f"bears less than {1e3 * _LITTLE:g} ms of delay", "not stable: no level"]
    figure.legend(handles, names, loc="outside lower center", ncols=5, fontsize=9)


def _map(axes: "Axes", status: Quantity, delay: Quantity, over: np.ndarray | None) -> None:
    """Delay margins as fields; hatched where the loop is not stable or bears none."""
    from matplotlib.colors import LogNorm
    from matplotlib.patches import Rectangle

    rank = np.argsort(np.asarray(status.axes[1].values))
    state = np.asarray(status.values)[:, rank]
    values = np.asarray(delay.values, dtype=float)[:, rank]
    fine = (state < 2) & (values > 0.0)
    finite = values[fine & np.isfinite(values)]
    low, high = (finite.min(), finite.max()) if finite.size else (1e-4, 1e-2)
    low, high = min(low, 1e-5), max(high, 1e-2)
    shown = np.where(fine, np.minimum(values, high), np.nan)
    image = axes.imshow(
        1e3 * shown, cmap="viridis", norm=LogNorm(1e3 * low, 1e3 * high), aspect="auto",
        origin="lower",
    )  # fmt: skip
    numbered = max(state.shape) <= _NUMBERED
    for (i, j), ok in np.ndenumerate(fine):
        if not ok:
            axes.add_patch(
                Rectangle((j - 0.5, i - 0.5), 1.0, 1.0, facecolor="#f6dede", edgecolor=LIMIT,
                          hatch="////" if state[i, j] >= 2 else "..", linewidth=0.0)
            )  # fmt: skip
        elif numbered:
            text = "any" if np.isinf(values[i, j]) else in_time(float(values[i, j]))
            text += " *" if over is not None and over[i, rank[j]] else ""
            dark = np.log(shown[i, j] / low) < 0.6 * np.log(high / low)
            axes.text(j, i, text, ha="center", va="center", fontsize=7.5,
                      color="white" if dark else "black")  # fmt: skip
    gains, feedbacks = (np.asarray(axis.values) for axis in status.axes)
    axes.set_yticks(range(len(gains)), [show(gain, 0, 3) for gain in gains])
    axes.set_xticks(range(len(rank)), [f"{value:g}" for value in feedbacks[rank]])
    axes.set_xlabel("feedback of the shell's acceleration in s")
    axes.set_ylabel("gain K")
    axes.grid(visible=False)
    words = "delay margin; hatched: not stable"
    words += ", dotted: stable only without any delay" if np.any(state == 1) else ""
    if over is not None and np.any(over):
        words += "; *: more torque than the motor has"
    axes.set_title(words, loc="left")
    axes.figure.colorbar(image, ax=axes, label="ms", pad=0.01)
