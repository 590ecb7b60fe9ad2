"""Waterfall of a run: frequencies of the most loaded section's torque against crank speed."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import along, having, scalar_of
from vibecalc.report.numbers import hertz, rpm
from vibecalc.report.pictures.canvas import LIMIT, QUIET, canvas
from vibecalc.report.sections.torsion_transient import TRANSIENT
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

#: decades of amplitude that are told apart, and orders that are named at most
_DECADES, _NAMED = 3.0, 8
#: least rise of the speed, as a share of the highest, for which speed is the axis
_MOVES = 0.05


def picture(result: Result) -> "Figure | None":
    """Colours over speed (or time) and frequency, with orders and natural frequencies."""
    record = result.record
    found = having(record, TRANSIENT + "waterfall/frequency", "waterfall_time",
                   "waterfall_frequency")  # fmt: skip
    speed = along(record, TRANSIENT + "waterfall/speed", "waterfall_time")
    if found is None or speed is None:
        return None
    turning = rpm(1.0) * np.asarray(speed[0].values, dtype=float)
    steps = np.diff(turning)
    moves = bool(np.all(steps >= 0.0) or np.all(steps <= 0.0)) and float(np.ptp(turning)) > (
        _MOVES * float(np.max(turning))
    )
    figure = canvas(result, f"torque in section {_section(record)} on the way", 9.2, 6.2)
    axes = figure.subplots()
    frequency = hertz(1.0) * np.asarray(found.axes[1].values, dtype=float)
    size = np.abs(np.asarray(found.values))
    across = turning if moves else np.asarray(found.axes[0].values, dtype=float)
    if moves:
        # held speeds at the ends would be drawn on one line
        kept = np.concatenate([[True], np.abs(np.diff(across)) > 1e-6 * float(np.max(across))])
        across, size = across[kept], size[kept]
    top = float(np.max(size))
    shades = axes.pcolormesh(
        across, frequency, np.maximum(size, top * 10.0**-_DECADES).T, cmap="Blues",
        shading="gouraud", norm=_norm(top), rasterized=True,
    )  # fmt: skip
    bar = figure.colorbar(shades, ax=axes, pad=0.06 if moves else 0.02)
    bar.set_label("amplitude in N m")
    low, high = float(np.min(across)), float(np.max(across))
    axes.set_xlim(low, high)
    axes.set_ylim(0.0, float(frequency[-1]))
    if moves:
        _orders(axes, record, low, high, float(frequency[-1]))
    _natural(axes, record, float(frequency[-1]))
    axes.grid(visible=False)
    axes.set_xlabel("crank speed in rpm" if moves else "time in s")
    axes.set_ylabel("frequency in Hz")
    return figure


def _section(record: Record) -> str:
    worst = scalar_of(record, TRANSIENT + "worst_section") or 1.0
    peak = record.quantities.get(TRANSIENT + "peak")
    return str(peak.axes[0].values[int(worst) - 1]) if peak is not None else f"{worst:g}"


def _norm(top: float) -> "LogNorm":
    from matplotlib.colors import LogNorm

    return LogNorm(vmin=top * 10.0**-_DECADES, vmax=top)


def _orders(axes: "Axes", record: Record, low: float, high: float, top: float) -> None:
    """The strongest orders as rays, named where they leave the picture."""
    found = having(record, TRANSIENT + "waterfall/order", "waterfall_time", "half_order")
    if found is None:
        return
    orders = np.asarray(found.axes[1].values, dtype=float)
    size = np.abs(found.values)
    # an order that is there stands above its neighbours, what leaks from another does not
    walls = np.pad(size, ((0, 0), (1, 1)), constant_values=np.inf)
    walls[:, -1] = 0.0
    there = (size > walls[:, :-2]) & (size > walls[:, 2:])
    score = np.where(there, size, 0.0).max(axis=0)
    best = [place for place in np.argsort(-score, kind="stable")[:_NAMED] if score[place] > 0.0]
    chosen = np.sort(orders[best])
    for order in chosen:
        slope = order / 60.0
        end = min(high, top / slope)
        axes.plot([low, end], [slope * low, slope * end], color=QUIET, linewidth=0.7, alpha=0.8)
        right = end >= high
        axes.annotate(
            f"{order:g}", (end, slope * end), xytext=(3, 0) if right else (0, 2),
            textcoords="offset points", ha="left" if right else "center",
            va="center" if right else "bottom", fontsize=9, color=QUIET, annotation_clip=False,
        )  # fmt: skip


def _natural(axes: "Axes", record: Record, top: float) -> None:
    found = record.quantities.get("response/torsion/modes/natural_frequency")
    if found is None:
        return
    for mode, value in enumerate(hertz(1.0) * np.asarray(found.values, dtype=float), start=1):
        if not 0.0 < value < 0.98 * top:
            continue
        axes.axhline(value, color=LIMIT, linewidth=0.8, linestyle=":")
        axes.annotate(
            f"mode {mode}", (0.0, value), xycoords=axes.get_yaxis_transform(), xytext=(4, 2),
            textcoords="offset points", fontsize=8, color=LIMIT,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8},
        )  # fmt: skip
