"""Pictures of studies next to the steady vibration: change in time, waterfall, variable inertia."""

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
    dotted,
    gaps,
    note,
    operating_line,
)
from vibecalc.core.report.sections import along, having, labels, scalar_of, speed_of, table_of
from vibecalc.core.report.writing import hertz, rpm, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.pictures.excitation import torque_unit
from vibecalc.torsion.report.line import TORSION, mode_names, place_of, turns
from vibecalc.torsion.report.studies import TRANSIENT, change_in_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# A change in time: envelope of the most loaded section next to the steady one, and its peak.
# ----------------------------------------------------------------------------

#: a steady half range may be this many times that of the run before the axis leaves it
_ROOM = 2.2


def draw_torsion_transient(result: Result) -> "Figure | None":
    """Speed and envelope over time, half ranges with the steady ones, the time about the peak."""
    record = result.record
    low, high = (
        having(record, f"{TRANSIENT}torque_{end}", "section", "transient_time")
        for end in ("low", "high")
    )
    speed = along(record, TRANSIENT + "speed", "transient_time")
    worst = scalar_of(record, TRANSIENT + "worst_section")
    if low is None or high is None or speed is None or worst is None:
        return None
    place = int(worst) - 1
    half = having(record, TRANSIENT + "half_range", "section", "transient_time")
    words = change_in_words(result).rstrip(".").split(", growing")[0]
    figure = canvas(result, words, 8.6 if half else 6.4)
    rows = 3 if half is not None else 2
    panels = list(figure.subplots(rows, 1, squeeze=False)[:, 0])
    name = str(low.axes[0].values[place])
    time = speed[1]
    _envelope(panels[0], result, (low, high), place, time)
    panels[0].set_title(f"torque in section {name}, mean included", loc="left")
    _speed(panels[0], time, rpm(1.0) * np.asarray(speed[0].values, dtype=float))
    if half is not None:
        _half_ranges(panels[1], record, half, place, time)
    _course(panels[-1], result)
    return figure


def _envelope(
    axes: "Axes", result: Result, ends: tuple[Quantity, Quantity], place: int, time: np.ndarray
) -> None:
    record = result.record
    factor, unit = torque_unit(record)
    curves = [crests(time, factor * np.asarray(one.values, dtype=float)[place]) for one in ends]
    for curve, label in zip(curves, ("crests, cycle by cycle", None), strict=True):
        axes.plot(*curve, color=COLOURS[0], label=label)
    below, above = (np.interp(time, *curve) for curve in curves)
    axes.fill_between(time, below, above, color=COLOURS[5], alpha=0.2, linewidth=0.0)
    _onset(axes, result)
    for end, colour in (("before", COLOURS[2]), ("after", COLOURS[1])):
        found = having(record, f"{TRANSIENT}steady_{end}", "section")
        if found is not None:
            value = factor * float(found.values[place])
            axes.axhline(value, color=colour, linestyle="--", linewidth=1.2,
                         label=f"steady peak {end}")  # fmt: skip
    when = having(record, TRANSIENT + "peak_time", "section")
    peak = having(record, TRANSIENT + "peak", "section")
    if when is not None and peak is not None:
        at, value = float(when.values[place]), factor * float(peak.values[place])
        row = int(np.argmin(np.abs(time - at)))
        near = slice(max(row - 1, 0), row + 2)
        sign = 1.0 if np.max(above[near]) >= -np.min(below[near]) else -1.0
        axes.plot([at], [sign * value], "o", color=LIMIT, zorder=5,
                  label=f"peak {show(value, digits=4)} {unit}")  # fmt: skip
    axes.set_xlim(*_span(axes, time))
    axes.set_ylabel(f"torque in {unit}")
    axes.set_xlabel("time in s")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.36 * (top - bottom))
    axes.legend(loc="upper left", ncols=3)


def _onset(axes: "Axes", result: Result) -> None:
    """When a step happens, where the case says it."""
    change = table_of(result.case, "response", "torsion", "transient")
    if change.get("kind") in ("misfire_onset", "load_step") and change.get("before"):
        axes.axvline(float(change["before"]), color=TOTAL, linestyle=":", label="onset")


def _span(axes: "Axes", time: np.ndarray) -> tuple[float, float]:
    """The times of the envelope, and that of a peak in the half cycle before or after them."""
    peaks = [float(x) for line in axes.get_lines() if line.get_marker() == "o"
             for x in np.asarray(line.get_xdata(), dtype=float)]  # fmt: skip
    return min(float(time[0]), *peaks, np.inf), max(float(time[-1]), *peaks, -np.inf)


def _speed(axes: "Axes", time: np.ndarray, turning: np.ndarray) -> None:
    """The crank speed on an axis of its own."""
    if float(np.ptp(turning)) <= 1e-9 * float(np.max(turning)):
        return
    other = axes.twinx()
    other.plot(time, turning, color=TOTAL, linewidth=1.0, linestyle="-.")
    other.set_ylabel("crank speed in rpm (dash-dotted)")
    other.grid(visible=False)
    other.set_ylim(0.0, 1.28 * float(np.max(turning)))
    other.spines["right"].set_visible(True)


def _half_ranges(
    axes: "Axes", record: Record, half: Quantity, place: int, time: np.ndarray
) -> None:
    factor, unit = torque_unit(record)
    own = factor * np.asarray(half.values, dtype=float)[place]
    axes.plot(*crests(time, own), color=COLOURS[0], label="half range during the change")
    steady = having(record, TRANSIENT + "quasi_steady", "section", "transient_time")
    top = float(np.max(own))
    if steady is not None:
        nearby = gaps(factor * np.asarray(steady.values, dtype=float)[place])
        axes.plot(time, nearby, color=COLOURS[1], linestyle="--", linewidth=1.2,
                  label="steady half range at these speeds")  # fmt: skip
        top = max(top, min(float(np.nanmax(nearby)), _ROOM * top))
    axes.set_ylim(0.0, 1.22 * top)
    axes.set_xlim(float(time[0]), float(time[-1]))
    axes.set_ylabel(f"half range in {unit}")
    axes.set_xlabel("time in s")
    axes.legend(loc="upper left", ncols=2)


def _course(axes: "Axes", result: Result) -> None:
    found = along(result.record, TRANSIENT + "history/torque", "history_time")
    if found is None:
        return
    factor, unit = torque_unit(result.record)
    _onset(axes, result)
    axes.plot(found[1], factor * np.asarray(found[0].values), color=COLOURS[0], linewidth=1.0)
    axes.set_xlim(float(found[1][0]), float(found[1][-1]))
    axes.set_title("the same torque about its peak", loc="left")
    axes.set_ylabel(f"torque in {unit}")
    axes.set_xlabel("time in s")


# ----------------------------------------------------------------------------
# Waterfall of a run: frequencies of the most loaded section's torque against crank speed.
# ----------------------------------------------------------------------------

#: decades of amplitude that are distinguished, and orders that are named at most
_DECADES, _NAMED = 3.0, 8
#: least rise of the speed, as a share of the highest, for which speed is the axis
_MOVES = 0.05


def draw_torsion_waterfall(result: Result) -> "Figure | None":
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
    figure = canvas(result, f"torque in section {_section(record)} during the change", 6.2)
    axes = figure.subplots()
    frequency = hertz(1.0) * np.asarray(found.axes[1].values, dtype=float)
    factor, unit = torque_unit(record)
    size = factor * np.abs(np.asarray(found.values))
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
    bar.set_label(f"amplitude in {unit}")
    low, high = float(np.min(across)), float(np.max(across))
    axes.set_xlim(low, high)
    axes.set_ylim(0.0, float(frequency[-1]))
    if moves:
        _orders(axes, record, low, high, float(frequency[-1]))
    _natural(axes, result, float(frequency[-1]))
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
        note(axes, f"{order:g}", (end, slope * end), (3, 0) if right else (0, 2),
            ha="left" if right else "center", va="center" if right else "bottom", color=QUIET,
            annotation_clip=False)  # fmt: skip


def _natural(axes: "Axes", result: Result, top: float) -> None:
    found = result.record.quantities.get("response/torsion/modes/natural_frequency")
    if found is None:
        return
    for name, value in zip(mode_names(result), hertz(1.0) * np.asarray(found.values), strict=True):
        if not 0.0 < value < 0.98 * top:
            continue
        axes.axhline(value, color=LIMIT, linewidth=0.8, linestyle=":")
        note(axes, name, (0.0, value), (4, 2), xycoords=axes.get_yaxis_transform(),
            color=LIMIT,
            bbox=PLATE)  # fmt: skip


# ----------------------------------------------------------------------------
# Inertias that change over the revolution: torque by order and against speed, next to mean ones.
# ----------------------------------------------------------------------------

_ROOT = TORSION + "variable_inertia/"


def draw_variable_inertia(result: Result) -> "Figure | None":
    """The section that changes most; None if no inertia changes."""
    record = result.record
    change = having(record, _ROOT + "change", "section")
    torque = having(record, _ROOT + "torque", "section", "half_order")
    if change is None or torque is None:
        return None
    place = int(np.argmax(np.abs(change.values)))
    name = labels(change.axes[0])[place]
    speeds = having(record, _ROOT + "speeds/torque_half_range", "section", "variable_speed")
    words = f"torque in section {name}: inertias that change over the revolution"
    figure = canvas(result, words, 4.0 if speeds is None else 7.0)
    panels = figure.subplots(1 if speeds is None else 2, 1, squeeze=False)[:, 0]
    _inertia_orders(result, panels[0], name)
    if speeds is not None:
        _inertia_speeds(record, panels[1], name)
        operating_line(panels[1], result, 0.0, np.inf)
        panels[1].legend()
    return figure


def _inertia_orders(result: Result, axes: "Axes", name: str) -> None:
    """Bars of the exact motion next to those with mean inertias."""
    factor, unit = torque_unit(result.record)
    for path, words, colour, shift in (
        (TORSION + "torque", "mean inertias", QUIET, -0.21),
        (_ROOT + "torque", "inertias that change, exact motion", COLOURS[0], 0.21),
    ):
        found = having(result.record, path, "section", "half_order")
        place = place_of(found, name)
        if found is None or place is None:
            continue
        order = np.asarray(found.axes[1].values, dtype=float)
        step = float(np.min(np.diff(order))) if order.size > 1 else 1.0
        size = factor * np.abs(np.asarray(found.values)[place])
        axes.bar(order + shift * step, size, 0.4 * step, color=colour, label=words)
    at = speed_of(result)
    axes.set_title(f"at {turns(at)} rpm, amplitudes 0-to-peak" if at is not None else "",
                   loc="left")  # fmt: skip
    axes.set_xlabel("order (multiple of crank speed)")
    axes.set_ylabel(f"torque in {unit}")
    axes.legend()


def _inertia_speeds(record: Record, axes: "Axes", name: str) -> None:
    """Half ranges of all orders against speed."""
    factor, unit = torque_unit(record)
    for path, axis, words, colour, style in (
        (TORSION + "speeds/torque_half_range", "speed", "mean inertias", QUIET, "--"),
        (_ROOT + "speeds/torque_half_range", "variable_speed",
         "inertias that change, linear motion", TOTAL, "-"),
    ):  # fmt: skip
        found = having(record, path, "section", axis)
        place = place_of(found, name)
        if found is None or place is None:
            continue
        speed = rpm(1.0) * np.asarray(found.axes[1].values, dtype=float)
        row = gaps(factor * np.asarray(found.values, dtype=float)[place])
        axes.plot(speed, row, style, color=colour, label=words, marker=dotted(len(speed)))
    axes.set_title("half range of all orders together", loc="left")
    axes.set_xlabel("crank speed in rpm")
    axes.set_ylabel(f"torque in {unit}")
    axes.set_ylim(bottom=0.0)
