"""Pictures of the body on its suspension: energies by order, speed, operation; changes."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    QUIET,
    TOTAL,
    canvas,
    crests,
    length_scale,
    note,
    operating_line,
    plain_ticks,
    usual,
)
from vibecalc.core.report.curves import draw_points
from vibecalc.core.report.sections import along, having, labels
from vibecalc.core.report.verdicts import judge_references
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.response.report import SMALLEST

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Kinetic and potential energy of each order alone, over as many decades as there are.
# ----------------------------------------------------------------------------

_KINDS = ("kinetic", "potential")
#: powers of ten below the largest that are drawn
_DECADES = 6


def draw_energy_by_order(result: Result) -> "Figure | None":
    """Bars of the largest energy against order, down to a share of the largest of all.

    None without energies by order above zero. The axis is in powers of ten by hand: bars of a
    logarithmic axis stop before 1e-308.
    """
    found: list[tuple[str, np.ndarray, np.ndarray, str]] = []
    for kind in _KINDS:
        quantity = having(result.record, f"response/{kind}_energy/peak_by_order", "order")
        if quantity is not None and np.any(quantity.values >= SMALLEST):
            orders = np.asarray(quantity.axes[0].values)
            found.append((kind, orders, np.asarray(quantity.values, dtype=float), quantity.unit))
    if not found:
        return None
    figure = canvas(result, "largest energy of each order alone", 5.2)
    axes = figure.subplots()
    lowest = min(float(np.log10(values[values >= SMALLEST]).min()) for _, _, values, _ in found)
    highest = max(float(np.log10(values.max())) for _, _, values, _ in found)
    floor = max(lowest - 0.06 * max(highest - lowest, 3.0), highest - _DECADES)
    width = 0.8 / len(found)
    for i, (kind, orders, values, _) in enumerate(found):
        acting = values >= max(10.0**floor, SMALLEST)
        heights = np.log10(values[acting]) - floor
        place = orders[acting] + (i - 0.5 * (len(found) - 1)) * width
        axes.bar(place, heights, width, bottom=floor, color=COLOURS[i], label=kind)
    every = max(int(orders[-1]) for _, orders, _, _ in found)
    least = max(10.0**floor, SMALLEST)
    last = max(int(np.max(orders[values >= least], initial=0)) for _, orders, values, _ in found)
    axes.set_xlim(0.3, last + 0.7)
    axes.set_ylim(floor, highest + 0.08 * (highest - floor))
    _ticks(axes)
    axes.set_xlabel("order")
    axes.set_ylabel(f"energy in {found[0][3]}")
    axes.grid(visible=False, axis="x")
    axes.legend(loc="upper right")
    if every > last:
        axes.set_title(
            f"orders {last + 1} to {every}: below $10^{{-{_DECADES}}}$ of the largest",
            loc="left", fontsize=8, color=QUIET,
        )  # fmt: skip
    return figure


def _ticks(axes: "Axes") -> None:
    """Whole orders below; next to them powers of ten, written as a logarithmic axis has them."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(nbins=10, integer=True))

    def power(value: Any, _: Any) -> str:
        return f"$10^{{{value:.0f}}}$"

    axes.yaxis.set_major_locator(MaxNLocator(nbins=9, integer=True))
    axes.yaxis.set_major_formatter(FuncFormatter(power))


# ----------------------------------------------------------------------------
# Mean energies of the body over a range of speeds, with the speeds left out as bands.
# ----------------------------------------------------------------------------

_BAND = "#f3c6cc"
#: decades shown around the usual energy where it has no bound at some speeds
_BELOW, _ABOVE = 1e-4, 1e6
#: the lowest speed drawn, of the highest one: below it little moves
_SPAN = 0.03
#: ratio of the speeds of two bands that leaves room for the words of each
_APART = 1.09


def draw_response_run_up(result: Result) -> "Figure | None":
    """Both energies on one logarithmic axis; None without a run-up of [response]."""
    record = result.record
    hits = [(kind, along(record, f"response/run_up/{kind}_energy", "speed")) for kind in _KINDS]
    curves = [(kind, *hit) for kind, hit in hits if hit is not None and np.any(hit[1] > 0.0)]
    if not curves:
        return None
    figure = canvas(result, "run-up: mean energies of the body at each speed", 4.8)
    axes = figure.subplots()
    curves = [(kind, one, rpm(1.0) * places) for kind, one, places in curves]
    speed, unit = curves[0][2], curves[0][1].unit
    axes.set_xscale("log")
    axes.set_xlim(max(float(speed[speed > 0.0].min()), _SPAN * float(speed.max())), speed.max())
    axes.set_yscale("log")
    gaps = _masked(record, axes)
    drawn, rows = [], judge_references(result)
    for (kind, quantity, places), colour in zip(curves, COLOURS, strict=False):
        values = np.asarray(quantity.values, dtype=float)
        drawn.append(np.interp(speed, places, values))
        axes.plot(*_broken(places, values, gaps), color=colour, label=f"{kind} energy, mean")
        draw_points(rows, axes, quantity, colour=colour)
        if not gaps:
            _largest(axes, places, values, colour, unit, above=kind == "kinetic")
    axes.set_ylim(*_run_up_window(speed, np.array(drawn), bool(gaps)))
    operating_line(axes, result, speed[0] / rpm(1.0), speed[-1] / rpm(1.0))
    axes.set_ylabel(f"mean energy over a turn in {unit}")
    axes.set_xlabel("crank speed in rpm")
    plain_ticks(axes.xaxis)
    figure.legend(loc="outside lower center", ncols=4)
    return figure


def _masked(record: Record, axes: "Axes") -> list[tuple[float, float]]:
    """Shade what is left out next to undamped resonances; says which order meets which mode."""
    low, high, order, mode = (
        having(record, f"response/masked/{name}", "masked")
        for name in ("low", "high", "order", "mode")
    )
    if low is None or high is None:
        return []
    gaps = [(rpm(a), rpm(b)) for a, b in zip(low.values, high.values, strict=True)]
    left, _ = axes.get_xlim()
    named, words = left, "left out: no bound"
    for i in np.argsort([start for start, _ in gaps]):
        start, stop = gaps[i]
        # the edge keeps an interval visible that is narrower than a dot
        axes.axvspan(start, stop, color=_BAND, linewidth=1.5, zorder=0, label=words)
        words = ""
        if order is None or mode is None or start < _APART * named:
            continue
        named = start
        note(axes, f"order {int(order.values[i])}, mode {int(mode.values[i])}", (start, 0.98),
            (-3, 0), xycoords=axes.get_xaxis_transform(), rotation=90, ha="right", va="top",
            color=QUIET)  # fmt: skip
    return gaps


def _broken(
    speed: np.ndarray, values: np.ndarray, gaps: list[tuple[float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """The curve with a break in each gap, and without what a logarithmic axis cannot show."""
    centres = np.array([0.5 * (low + high) for low, high in gaps])
    places = np.searchsorted(speed, centres)
    shown = np.where(np.isfinite(values) & (values > 0.0), values, np.nan)
    return np.insert(speed, places, centres), np.insert(shown, places, np.nan)


def _run_up_window(speed: np.ndarray, values: np.ndarray, unbounded: bool) -> tuple[float, float]:
    """Ends of the energy axis: of all that is shown, or decades around what is usual.

    Usual is the median over (logarithmically) even speeds of the larger energy.
    """
    shown = values[:, speed >= _SPAN * speed[-1]]
    shown = shown[np.isfinite(shown) & (shown > 0.0)]
    if not shown.size:
        return 0.1, 1.0
    if not unbounded:
        return 0.5 * float(shown.min()), 4.0 * float(shown.max())
    middle = usual(speed, np.max(values, axis=0), _SPAN * speed[-1], speed[-1])
    return _BELOW * middle, _ABOVE * middle


def _largest(
    axes: "Axes", speed: np.ndarray, values: np.ndarray, colour: str, unit: str, above: bool
) -> None:
    """Mark the largest energy, as sampled."""
    top = int(np.argmax(values))
    at, energy = float(speed[top]), float(values[top])
    if not np.isfinite(energy) or energy <= 0.0:
        return
    axes.plot([at], [energy], "o", color=colour, markersize=5)
    left = at > 0.2 * float(speed.max())
    note(axes, f"{show(energy, digits=4)} {unit} at {show(at, digits=4)} rpm",
        (at, energy), (-8 if left else 8, 4 if above else -3), ha="right" if left else "left",
        va="bottom" if above else "top", color=colour)  # fmt: skip


# ----------------------------------------------------------------------------
# Energies of the operations with each balance: mean, peak, what the weights' angle can do.
# ----------------------------------------------------------------------------

_OPERATIONS = "response/operations/"
_AXES = ("operation", "balance")
_GROUP = 0.68
#: places of a peak's diamond and, next to it, of its range, in widths of a bar from the middle
_PEAK, _NEARBY = 0.12, 0.37
#: a range below this share of the energy is none
_NARROW = 1e-6


def draw_operations(result: Result) -> "Figure | None":
    """A panel for each kind of energy; None without combinations."""
    record = result.record
    found = [
        (kind, mean)
        for kind in _KINDS
        if (mean := having(record, f"{_OPERATIONS}{kind}_energy/mean", *_AXES)) is not None
    ]
    if not found:
        return None
    subtitle = "energies of the operations with each balance"
    figure = canvas(result, subtitle, 1.5 + 3.4 * len(found))
    panels = list(figure.subplots(len(found), 1, sharex=True, squeeze=False)[:, 0])
    for axes, (kind, mean) in zip(panels, found, strict=True):
        _bars(axes, record, kind, mean)
        _together(axes, record, kind, mean)
        axes.set_ylabel(f"{kind} energy in {mean.unit}")
        axes.set_ylim(bottom=0.0)
        axes.margins(y=0.12)
        axes.grid(visible=False, axis="x")
    balances = labels(found[0][1].axes[1])
    panels[-1].set_xticks(range(len(balances)), [f"balance {name}" for name in balances])
    # A few groups keep to the middle: bars as broad as the page are hard to compare.
    aside = max(0.5, 0.5 * (3.2 - len(balances)))
    panels[-1].set_xlim(-aside, len(balances) - 1.0 + aside + 0.12)
    _legend(figure, panels[0])
    return figure


def _legend(figure: "Figure", axes: "Axes") -> None:
    """Each entry once: bars, then diamonds, then lines."""
    once = {words: handle for handle, words in zip(*axes.get_legend_handles_labels(), strict=True)}
    ends = (": mean", ": peak", "of the weights", "weighted mean")
    ordered = [words for end in ends for words in once if words.endswith(end)]
    handles = [once[words] for words in ordered]
    figure.legend(handles, ordered, loc="outside lower center", ncols=2)


def _bars(axes: "Axes", record: Record, kind: str, mean: Quantity) -> None:
    """One bar for each operation, its peak as a diamond, both with their range."""
    operations, balances = (labels(axis) for axis in mean.axes)
    stem = f"{_OPERATIONS}{kind}_energy/"
    peak = having(record, stem + "peak", *_AXES)
    width = _GROUP / len(operations)
    for i, name in enumerate(operations):
        place = np.arange(len(balances)) + (i - 0.5 * (len(operations) - 1)) * width - 0.06
        colour = COLOURS[i % len(COLOURS)]
        axes.bar(place, mean.values[i], 0.86 * width, color=colour, label=f"{name}: mean")
        _range(axes, record, stem + "mean", i, place - 0.2 * width, "mean")
        if peak is not None:
            axes.plot(
                place + _PEAK * width,
                peak.values[i],
                "D",
                color=colour,
                markeredgecolor="white",
                markersize=7,
                label=f"{name}: peak",
                zorder=4,
            )
            _range(axes, record, stem + "peak", i, place + _NEARBY * width, "peak")


def _range(axes: "Axes", record: Record, path: str, i: int, place: np.ndarray, what: str) -> None:
    """The range of means in full lines, that of peaks in dashes, so that the legend parts them."""
    low, high = (having(record, f"{path}_{end}", *_AXES) for end in ("low", "high"))
    if low is None or high is None:
        return
    least, most = np.asarray(low.values[i]), np.asarray(high.values[i])
    wide = most - least > _NARROW * np.abs(most)
    if not wide.any():
        return
    half = 0.5 * (most - least)[wide]
    drawn = axes.errorbar(
        place[wide],
        least[wide] + half,
        yerr=half,
        fmt="none",
        ecolor=TOTAL,
        elinewidth=1.2,
        capsize=4,
        label=f"range of the {what} over the angle of the weights",
        zorder=3,
    )
    if what == "peak":
        for bar in drawn[2]:
            bar.set_linestyle((0, (2, 1.5)))


def _together(axes: "Axes", record: Record, kind: str, mean: Quantity) -> None:
    """The weighted mean as a line across a group, and how far the operations are apart."""
    weighted = having(record, f"{_OPERATIONS}{kind}_energy/weighted", "balance")
    apart = having(record, f"{_OPERATIONS}{kind}_energy/difference", "balance")
    for j in range(mean.values.shape[1]):
        left, right = j - 0.5 * _GROUP - 0.06, j + 0.5 * _GROUP - 0.06
        if weighted is not None:
            height = float(weighted.values[j])
            words = "weighted mean" if j == 0 else None
            axes.plot([left, right], [height] * 2, "--", color=TOTAL, label=words, zorder=5)
        if apart is None:
            continue
        low, high = float(np.min(mean.values[:, j])), float(np.max(mean.values[:, j]))
        axes.annotate(
            "",
            (right + 0.05, high),
            (right + 0.05, low),
            arrowprops={"arrowstyle": "<->", "color": QUIET, "shrinkA": 0, "shrinkB": 0},
        )
        note(axes, f"{show(float(apart.values[j]), digits=3)} {apart.unit}\napart",
            (right + 0.05, 0.5 * (low + high)), (4, 0), va="center", color=QUIET)  # fmt: skip


# ----------------------------------------------------------------------------
# The change between two operations in time: displacement, energy, and the speed of the crank.
# ----------------------------------------------------------------------------

_SWITCHING = "response/switching/"
_WAYS = (("reversal", "through rest"), ("instant", "at once"))
#: decades of the energy axis below its largest value
_DECADES = 6
_MOST = 3
#: the energy is drawn as the largest of so many intervals: single ones follow every swing
_INTERVALS = 24


def draw_switching(result: Result) -> "Figure | None":
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
    moved = (
        having(record, f"{_SWITCHING}{ways[0][0]}/translation_high", *_axes(ways[0][0])) is not None
    )
    count = len(changes) if moved else 0
    figure = canvas(result, "change between operations", 2.0 + 1.75 * (count + 2))
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
    _energy_window(grid[count, 0], record, ways)
    for i, change in enumerate(changes[:count]):
        direction, _, (_, unit) = _direction(record, i, ways)
        grid[i, 0].set_ylabel(f"{change}\n{direction} in {unit}")
    _name_rows(grid, count, first.unit)
    if not any(f"{_SWITCHING}{way}/speed" in record for way, _ in ways):
        grid[-1, 0].set_yticks([])
    engine: Any = figure.get_layout_engine()
    engine.set(wspace=0.06)
    figure.align_ylabels(list(grid[:, 0]))
    handles, words_ = grid[count, 0].get_legend_handles_labels()
    figure.legend(handles, words_, loc="outside lower center", ncols=4)
    return figure


def _axes(way: str) -> tuple[str, str, str]:
    return ("change", "direction", f"{way}_time")


def _energy(record: Record, way: str) -> Quantity | None:
    return having(record, f"{_SWITCHING}{way}/kinetic_energy_high", "change", f"{way}_time")


def _ends(record: Record, way: str) -> tuple[Quantity, Quantity] | None:
    low = having(record, f"{_SWITCHING}{way}/translation_low", *_axes(way))
    high = having(record, f"{_SWITCHING}{way}/translation_high", *_axes(way))
    return None if low is None or high is None else (low, high)


def _direction(
    record: Record, change: int, ways: list[tuple[str, str]]
) -> tuple[str, int, tuple[float, str]]:
    """Name and place of the direction that moves most in the first way, and the unit of all."""
    ends = _ends(record, ways[0][0])
    if ends is None:
        return "", 0, (1.0, "m")
    reach = np.max(np.maximum(np.abs(ends[0].values), np.abs(ends[1].values)), axis=-1)
    place = int(np.argmax(reach[change]))
    return labels(ends[0].axes[1])[place], place, length_scale(float(np.max(reach)))


def _displacement(
    axes: "Axes", record: Record, way: str, change: int, ways: list[tuple[str, str]]
) -> None:
    """Envelope of one direction, the same in every column."""
    own = _ends(record, way)
    if own is None:
        return
    _, place, (factor, _) = _direction(record, change, ways)
    low, high = (factor * np.asarray(end.values[change, place]) for end in own)
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
        axes.plot(*crests(time, drawn), color=colour, label=change)
        peak, when = (
            having(record, f"{_SWITCHING}{way}/{name}", "change")
            for name in ("kinetic_energy_peak", "peak_time")
        )
        if peak is not None and when is not None and peak.values[i] > 0.0:
            axes.plot([float(when.values[i])], [float(peak.values[i])], "o", color=colour)
    steady = having(record, _SWITCHING + "steady_energy", "operation")
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


def _energy_window(axes: "Axes", record: Record, ways: list[tuple[str, str]]) -> None:
    """A logarithmic axis for the energies of all ways, not too many decades of it."""
    found = [quantity for way, _ in ways if (quantity := _energy(record, way)) is not None]
    every = np.concatenate([envelope(row) for quantity in found for row in quantity.values])
    steady = having(record, _SWITCHING + "steady_energy", "operation")
    if steady is not None:
        every = np.concatenate([every, steady.values])
    every = every[every > 0.0]
    if every.size:
        axes.set_yscale("log")
        top = float(every.max())
        axes.set_ylim(max(0.5 * float(every.min()), top * 10.0**-_DECADES), 2.5 * top)


def _speed(axes: "Axes", record: Record, way: str) -> None:
    quantity = having(record, f"{_SWITCHING}{way}/speed", "change", f"{way}_time")
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
