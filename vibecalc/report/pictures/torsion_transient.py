"""A change in time: envelope of the most loaded section beside the steady one, and its peak."""

from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import along, having, scalar_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, TOTAL, canvas
from vibecalc.report.sections.torsion_transient import TRANSIENT, change_in_words
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KILO = 1e-3
#: a steady half range may be this many times that of the run before the axis leaves it
_ROOM = 2.2
#: letters of a line of the title
_WIDE = 90


def picture(result: Result) -> "Figure | None":
    """Speed and envelope over time, half ranges beside the steady ones, the course at the peak."""
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
    words = "\n".join(wrap(change_in_words(result).rstrip("."), _WIDE))
    figure = canvas(result, words, 9.2, 8.6 if half else 6.4)
    rows = 3 if half is not None else 2
    panels = list(figure.subplots(rows, 1, squeeze=False)[:, 0])
    name = str(low.axes[0].values[place])
    time = speed[1]
    _envelope(panels[0], record, (low, high), place, time)
    panels[0].set_title(f"torque in section {name}, mean in it", loc="left", fontsize=10)
    _speed(panels[0], time, rpm(1.0) * np.asarray(speed[0].values, dtype=float))
    if half is not None:
        _half_ranges(panels[1], record, half, place, time)
    _course(panels[-1], record, place)
    return figure


def _envelope(
    axes: "Axes", record: Record, ends: tuple[Quantity, Quantity], place: int, time: np.ndarray
) -> None:
    below, above = (_KILO * np.asarray(one.values, dtype=float)[place] for one in ends)
    axes.fill_between(time, below, above, color=COLOURS[5], alpha=0.8, linewidth=0.5,
                      label="envelope over a cycle")  # fmt: skip
    for end, colour in (("before", COLOURS[2]), ("after", COLOURS[1])):
        found = having(record, f"{TRANSIENT}steady_{end}", "section")
        if found is not None:
            value = _KILO * float(found.values[place])
            axes.axhline(value, color=colour, linestyle="--", linewidth=1.2,
                         label=f"steady peak {end}")  # fmt: skip
    when = having(record, TRANSIENT + "peak_time", "section")
    peak = having(record, TRANSIENT + "peak", "section")
    if when is not None and peak is not None:
        at, value = float(when.values[place]), _KILO * float(peak.values[place])
        row = int(np.argmin(np.abs(time - at)))
        near = slice(max(row - 1, 0), row + 2)
        sign = 1.0 if np.max(above[near]) >= -np.min(below[near]) else -1.0
        axes.plot([at], [sign * value], "o", color=LIMIT, ms=5, zorder=5,
                  label=f"peak {show(value, digits=4)} kN m")  # fmt: skip
    axes.set_xlim(*_span(axes, time))
    axes.set_ylabel("torque in kN m")
    axes.set_xlabel("time in s")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, top + 0.28 * (top - bottom))
    axes.legend(loc="upper left", ncols=4, fontsize=9)


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
    own = _KILO * np.asarray(half.values, dtype=float)[place]
    axes.plot(time, own, color=COLOURS[0], label="half range on the way")
    steady = having(record, TRANSIENT + "quasi_steady", "section", "transient_time")
    top = float(np.max(own))
    if steady is not None:
        beside = _KILO * np.asarray(steady.values, dtype=float)[place]
        beside = np.where(np.isfinite(beside), beside, np.nan)
        axes.plot(time, beside, color=COLOURS[1], linestyle="--", linewidth=1.2,
                  label="steady half range at these speeds")  # fmt: skip
        top = max(top, min(float(np.nanmax(beside)), _ROOM * top))
    axes.set_ylim(0.0, 1.22 * top)
    axes.set_xlim(float(time[0]), float(time[-1]))
    axes.set_ylabel("half range in kN m")
    axes.set_xlabel("time in s")
    axes.legend(loc="upper left", ncols=2, fontsize=9)


def _course(axes: "Axes", record: Record, place: int) -> None:
    found = along(record, TRANSIENT + "course/torque", "course_time")
    if found is None:
        return
    value = _KILO * np.asarray(found[0].values, dtype=float)
    axes.plot(found[1], value, color=COLOURS[0], linewidth=1.0)
    axes.set_xlim(float(found[1][0]), float(found[1][-1]))
    axes.set_title("the same torque about its peak", loc="left", fontsize=10)
    axes.set_ylabel("torque in kN m")
    axes.set_xlabel("time in s")
