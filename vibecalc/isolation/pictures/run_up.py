"""Picture of a run-up: largest force over the cycle by speed, with limits and resonances."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    bounds_of,
    canvas,
    draw_points,
    limit_line,
    natural_frequencies,
    plain_ticks,
)
from vibecalc.core.report.sections import along, labels, speed_of
from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Marks of a run-up: orders on natural frequencies, speeds left out, where the axis begins.
# ----------------------------------------------------------------------------

_ORDERS = (1, 2)
#: Ratio of frequencies below which two marks have no room for words of their own.
_CLOSE = 1.18


def resonances(record: Record, axes: "Axes", speed: np.ndarray) -> None:
    """Dotted lines where an order meets a mode; lines of one order that lie close share words."""
    frequencies = natural_frequencies(record)
    for order in _ORDERS:
        groups: list[list[int]] = []
        for mode, natural in enumerate(frequencies):
            at = natural / order
            if not speed.min() < at < speed.max():
                continue
            axes.axvline(at, color=QUIET, linestyle=":", linewidth=1.0, zorder=0)
            if groups and natural < _CLOSE * frequencies[groups[-1][0]]:
                groups[-1].append(mode)
            else:
                groups.append([mode])
        for group in groups:
            axes.annotate(
                f"order {order}" + (_modes(group) if len(frequencies) > 1 else ""),
                (frequencies[group[0]] / order, 0.98),
                xycoords=axes.get_xaxis_transform(),
                xytext=(-2, 0),
                textcoords="offset points",
                rotation=90,
                ha="right",
                va="top",
                fontsize=8,
                color=QUIET,
                zorder=1,
            )


def _modes(group: list[int]) -> str:
    first, last = group[0] + 1, group[-1] + 1
    if first == last:
        return f", mode {first}"
    return f", modes {first}" + (f", {last}" if last == first + 1 else f" to {last}")


def lowest(record: Record, speed: np.ndarray) -> float:
    """Where the logarithmic axis begins: well below the first order resonance."""
    first = min(natural_frequencies(record), default=float(speed.max())) / max(_ORDERS)
    return max(float(speed.min()), 0.25 * min(float(first), float(speed.max())))


def unbounded(record: Record) -> bool:
    """Whether speeds were left out because the forces have no bound there."""
    low = record.quantities.get("isolation/masked/low")
    return low is not None and low.values.size > 0


def window(
    speed: np.ndarray, values: np.ndarray, shown: tuple[float, float], bounds: list[float]
) -> tuple[float, float]:
    """Ends of a logarithmic force axis: decades around what is usual between the resonances.

    The samples crowd at the resonances, so the usual force is the median over evenly spaced
    (logarithmic) speeds within `shown`, of the largest curve.
    """
    largest = np.atleast_2d(values).max(axis=0)
    places = np.geomspace(*shown, 400)
    usual = np.interp(places, speed, np.where(np.isfinite(largest), largest, 0.0))
    middle = float(np.median(usual[usual > 0.0])) if np.any(usual > 0.0) else 1.0
    return 1e-2 * middle, max([1e3 * middle, *(3.0 * bound for bound in bounds)])


def masked(record: Record, axes: "Axes") -> None:
    """Shade the intervals of speed that were left out."""
    low, high = (record.quantities.get(f"isolation/masked/{end}") for end in ("low", "high"))
    if low is None or high is None:
        return
    for start, stop in zip(np.atleast_1d(low.values), np.atleast_1d(high.values), strict=True):
        axes.axvspan(float(start), float(stop), color="#f3c6cc", linewidth=1.0)


# ----------------------------------------------------------------------------
# The run-up: at each speed the largest force over the cycle, with limits and resonances.
# ----------------------------------------------------------------------------

#: Room above the curves for those words, as a factor, for one mode and for several.
_ROOM = (1.2, 1.9)
_LEVER = "isolation/lever_force/run_up"
_SUPPORT = "isolation/support_force/run_up"


def draw_run_up(result: Result) -> "Figure | None":
    """One panel for the couple over the lever, one for the supports; None without a run-up."""
    record = result.record
    lever = along(record, _LEVER, "speed")
    support = record.quantities.get(_SUPPORT)
    count = (lever is not None) + (support is not None)
    if count == 0:
        return None
    figure = canvas(result, "run-up: largest force over the cycle", 8.6, 1.5 + 3.0 * count)
    rows = judge_references(result)
    panels = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    if lever is not None:
        axes = panels[0]
        quantity, speed = lever
        axes.plot(speed, _drawable(quantity.values), color=TOTAL)
        draw_points(rows, axes, quantity, colour=LIMIT)
        _finish(result, axes, quantity, speed, "couple over the lever")
    if support is not None:
        axes = panels[-1]
        speed = np.asarray(support.axes[-1].values)
        _supports(axes, support, speed)
        for name in labels(support.axes[0]):
            draw_points(rows, axes, support, entry=name, colour=LIMIT)
        _finish(result, axes, support, speed, "one support on the ground")
    _rpm_axis(panels[0])
    panels[-1].set_xlabel("crank speed in rad/s")
    plain_ticks(panels[-1].xaxis)
    return figure


def _supports(axes: "Axes", quantity: Quantity, speed: np.ndarray) -> None:
    rows = np.asarray(quantity.values)
    names = labels(quantity.axes[0])
    drawn: list[tuple[np.ndarray, list[str]]] = []
    # Beside a resonance without damping the force is a million times that of other speeds.
    largest = np.max(np.where(np.isfinite(rows), rows, 0.0), axis=0, initial=0.0)
    for name, row in zip(names, rows, strict=True):
        # Mounts that carry the same are one curve with several names.
        for other, members in drawn:
            if np.all(np.isclose(other, row, rtol=1e-6, atol=1e-9 * largest)):
                members.append(name)
                break
        else:
            drawn.append((row, [name]))
    for i, (row, members) in enumerate(drawn):
        words = ("mounts " if len(members) > 1 else "mount ") + ", ".join(members)
        axes.plot(speed, _drawable(row), color=COLOURS[i % len(COLOURS)], label=words)
    # Forces are small at low speeds, and limits are named on the right.
    axes.legend(loc="center left", fontsize=9, frameon=True, framealpha=0.9, edgecolor="none")


def _finish(
    result: Result, axes: "Axes", quantity: Quantity, speed: np.ndarray, words: str
) -> None:
    axes.set_ylabel(f"{words}\nforce in {quantity.unit}")
    values = np.asarray(quantity.values)
    finite = values[np.isfinite(values)]
    top = float(np.max(finite)) if finite.size else 1.0
    limits = bounds_of(result, quantity.path + "_peak")
    steady = bounds_of(result, quantity.path.removesuffix("run_up") + "steady_peak")
    for text, bound in limits:
        limit_line(axes, bound, f"run-up {text}")
    for text, bound in steady:
        _steady(result, axes, bound, text)
    highest = max([top, *(bound for _, bound in limits), *(bound for _, bound in steady)])
    several = natural_frequencies(result.record).size > 1
    axes.set_ylim(0.0, _ROOM[several] * highest)
    axes.set_xscale("log")
    axes.set_xlim(lowest(result.record, speed), float(speed.max()))
    if unbounded(result.record):
        # The flanks go up without end: in between, nothing would be left to see.
        bounds = [bound for _, bound in (*limits, *steady)]
        axes.set_yscale("log")
        axes.set_ylim(*window(speed, values, axes.get_xlim(), bounds))
    resonances(result.record, axes, speed)
    masked(result.record, axes)
    _peak(result.record, axes, quantity, speed, limits)


def _peak(
    record: Record,
    axes: "Axes",
    quantity: Quantity,
    speed: np.ndarray,
    limits: list[tuple[str, float]],
) -> None:
    """Mark the largest force, as refined between the speeds drawn, else as drawn."""
    values = np.asarray(quantity.values)
    peaks = record.quantities.get(quantity.path + "_peak")
    places = record.quantities.get(quantity.path + "_peak_speed")
    if peaks is not None and places is not None:
        top = int(np.argmax(peaks.values))
        peak, at = float(np.ravel(peaks.values)[top]), float(np.ravel(places.values)[top])
    else:
        peak = float(np.max(values, initial=0.0))
        at = float(speed[int(np.argmax(values)) % speed.size])
    if not np.isfinite(peak) or peak <= 0.0:
        return
    axes.plot([at], [peak], "o", color=LIMIT if _beyond(peak, limits) else TOTAL, markersize=5)
    left = at > 0.7 * float(speed.max())
    axes.annotate(
        f"{show(peak, digits=4)} {quantity.unit} at {show(rpm(at), digits=4)} rpm",
        (at, peak),
        xytext=(-8 if left else 8, 3),
        textcoords="offset points",
        ha="right" if left else "left",
        fontsize=9,
    )


def _steady(result: Result, axes: "Axes", bound: float, words: str) -> None:
    speed = speed_of(result)
    if speed is None:
        return
    axes.plot([speed], [bound], marker="v", color=LIMIT, markersize=9, clip_on=False)
    axes.annotate(
        f"steady {words}",
        (speed, bound),
        xytext=(-4, 7),
        textcoords="offset points",
        ha="right",
        color=LIMIT,
        fontsize=9,
    )


def _rpm_axis(axes: "Axes") -> None:
    def to_rpm(speed: Any) -> Any:
        return speed * rpm(1.0)

    def from_rpm(turns: Any) -> Any:
        return turns / rpm(1.0)

    turns = axes.secondary_xaxis("top", functions=(to_rpm, from_rpm))
    turns.set_xlabel("crank speed in rpm")
    plain_ticks(turns.xaxis)


def _drawable(values: np.ndarray) -> np.ndarray:
    """Gaps where a value is infinite."""
    return np.where(np.isfinite(values), values, np.nan)


def _beyond(peak: float, limits: list[tuple[str, float]]) -> bool:
    return any(peak > bound for _, bound in limits)
