"""The change between two operations in time: displacement, energy, and the speed of the crank."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import rpm
from vibecalc.report.pictures.canvas import COLOURS, QUIET, canvas
from vibecalc.report.pictures.scales import factor_of, length_scale
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "response/switching/"
_WAYS = (("reversal", "through rest"), ("instant", "at once"))
#: decades of the energy axis below its largest value
_DECADES = 6
_MOST = 3
#: the energy is drawn as the largest of so many intervals: single ones follow every swing
_INTERVALS = 24


def picture(result: Result) -> "Figure | None":
    """A column for each way of changing; None without histories of the energy.

    Rows: the displacement of the direction that moves most, one for each change; the kinetic
    energy of all changes; the crank speed.
    """
    record = result.record
    ways = [(way, words) for way, words in _WAYS if _energy(record, way) is not None]
    if not ways:
        return None
    first = _energy(record, ways[0][0])
    assert first is not None
    changes = labels(first.axes[0])[:_MOST]
    moved = having(record, f"{_STEM}{ways[0][0]}/translation_high", *_axes(ways[0][0])) is not None
    count = len(changes) if moved else 0
    figure = canvas(result, "change between operations", 9.2, 2.0 + 1.75 * (count + 2))
    heights = [1.0] * count + [1.2, 0.8]
    widths = [1.5, 1.0][: len(ways)]
    grid = figure.subplots(
        count + 2,
        len(ways),
        squeeze=False,
        sharex="col",
        sharey="row",
        height_ratios=heights,
        width_ratios=widths,
    )
    for column, (way, words) in zip(grid.T, ways, strict=True):
        column[0].set_title(f"change {words}", loc="left")
        for i in range(count):
            _displacement(column[i], record, way, i, ways)
        _energies(column[count], record, way, changes)
        for axes in column[:count]:
            axes.axhline(0.0, color=QUIET, linewidth=0.6)
        _speed(column[-1], record, way)
        time = _energy(record, way)
        assert time is not None
        column[-1].set_xlim(0.0, float(time.axes[-1].values[-1]))
        column[-1].set_xlabel("time in s")
    _window(grid[count, 0], record, ways)
    for i, change in enumerate(changes[:count]):
        direction, _, unit = _direction(record, i, ways)
        grid[i, 0].set_ylabel(f"{change}\n{direction} in {unit}")
    _name_rows(grid, count, first.unit)
    if not any(f"{_STEM}{way}/speed" in record for way, _ in ways):
        grid[-1, 0].set_yticks([])
    engine: Any = figure.get_layout_engine()
    engine.set(wspace=0.06)
    figure.align_ylabels(list(grid[:, 0]))
    handles, words_ = grid[count, 0].get_legend_handles_labels()
    figure.legend(handles, words_, loc="outside lower center", ncols=4, fontsize=9)
    return figure


def _axes(way: str) -> tuple[str, str, str]:
    return ("change", "direction", f"{way}_time")


def _energy(record: Record, way: str) -> Quantity | None:
    return having(record, f"{_STEM}{way}/kinetic_energy_high", "change", f"{way}_time")


def _ends(record: Record, way: str) -> tuple[Quantity, Quantity] | None:
    low = having(record, f"{_STEM}{way}/translation_low", *_axes(way))
    high = having(record, f"{_STEM}{way}/translation_high", *_axes(way))
    return None if low is None or high is None else (low, high)


def _direction(record: Record, change: int, ways: list[tuple[str, str]]) -> tuple[str, int, str]:
    """Name and place of the direction that moves most in the first way, and a unit that suits."""
    ends = _ends(record, ways[0][0])
    if ends is None:
        return "", 0, "m"
    reach = np.max(np.maximum(np.abs(ends[0].values), np.abs(ends[1].values)), axis=-1)
    place = int(np.argmax(reach[change]))
    return labels(ends[0].axes[1])[place], place, length_scale(float(np.max(reach)))[1]


def _displacement(
    axes: "Axes", record: Record, way: str, change: int, ways: list[tuple[str, str]]
) -> None:
    """Envelope of one direction, the same in every column."""
    own = _ends(record, way)
    if own is None:
        return
    _, place, unit = _direction(record, change, ways)
    low, high = (factor_of(unit) * np.asarray(end.values[change, place]) for end in own)
    colour = COLOURS[change % len(COLOURS)]
    axes.fill_between(np.asarray(own[0].axes[-1].values), low, high, color=colour, linewidth=0.6)


def _energies(axes: "Axes", record: Record, way: str, changes: list[str]) -> None:
    quantity = _energy(record, way)
    if quantity is None:
        return
    time = np.asarray(quantity.axes[-1].values)
    for i, change in enumerate(changes):
        values = envelope(np.asarray(quantity.values[i], dtype=float))
        drawn = np.where(values > 0.0, values, np.nan)
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(time, drawn, color=colour, label=change)
        peak, when = (
            having(record, f"{_STEM}{way}/{name}", "change")
            for name in ("kinetic_energy_peak", "peak_time")
        )
        if peak is not None and when is not None and peak.values[i] > 0.0:
            axes.plot([float(when.values[i])], [float(peak.values[i])], "o", color=colour, ms=5.0)
    steady = having(record, _STEM + "steady_energy", "operation")
    if steady is not None:
        styles = ("--", ":", "-.")
        for i, name in enumerate(labels(steady.axes[0])):
            axes.axhline(
                float(steady.values[i]),
                color=QUIET,
                linestyle=styles[i % len(styles)],
                linewidth=1.2,
                label=f"steady {name}",
            )


def envelope(values: np.ndarray) -> np.ndarray:
    """Largest of each entry and its neighbours; near an end there are fewer of these."""
    reach = min(_INTERVALS // 2, len(values) - 1)
    padded = np.pad(values, reach, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    return np.asarray(windows.max(axis=1))


def _window(axes: "Axes", record: Record, ways: list[tuple[str, str]]) -> None:
    """A logarithmic axis for the energies of all ways, not too many decades of it."""
    found = [quantity for way, _ in ways if (quantity := _energy(record, way)) is not None]
    every = np.concatenate([envelope(row) for quantity in found for row in quantity.values])
    steady = having(record, _STEM + "steady_energy", "operation")
    if steady is not None:
        every = np.concatenate([every, steady.values])
    every = every[every > 0.0]
    if every.size:
        axes.set_yscale("log")
        top = float(every.max())
        axes.set_ylim(max(0.5 * float(every.min()), top * 10.0**-_DECADES), 2.5 * top)


def _speed(axes: "Axes", record: Record, way: str) -> None:
    quantity = having(record, f"{_STEM}{way}/speed", "change", f"{way}_time")
    if quantity is not None:
        turns = [rpm(float(value)) for value in quantity.values[0]]
        axes.plot(quantity.axes[-1].values, turns, color=QUIET)
        axes.axhline(0.0, color=QUIET, linewidth=0.6)
        return
    axes.annotate(
        "at operating speed", (0.5, 0.5), xycoords="axes fraction", ha="center", color=QUIET
    )


def _name_rows(grid: np.ndarray, count: int, unit: str) -> None:
    grid[count, 0].set_ylabel(f"largest kinetic\nenergy in {unit}")
    grid[count + 1, 0].set_ylabel("crank speed\nin rpm")
