"""Pictures of the body on its suspension: energies by order, speed, operation; changes."""

from dataclasses import replace
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
    usual,
)
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Ends,
    Panel,
    Plot,
    Source,
    operating,
    peak,
    resonances,
    spans,
)
from vibecalc.core.report.sections import having, labels
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


def _of_orders(result: Result) -> dict[str, Quantity]:
    """Energies by order above zero, of each kind."""
    paths = {kind: f"response/{kind}_energy/peak_by_order" for kind in _KINDS}
    found = {kind: having(result.record, path, "order") for kind, path in paths.items()}
    return {
        kind: one for kind, one in found.items() if one is not None and one.values.max() >= SMALLEST
    }


def _by_order(kind: str) -> Source:
    """Energies of one kind down to a share of the largest of all."""

    def made(result: Result) -> Quantity | None:
        found = _of_orders(result)
        least = max(
            SMALLEST, 10.0**-_DECADES * max((x.values.max() for x in found.values()), default=0)
        )
        one = found.get(kind)
        return one and replace(one, values=np.where(one.values >= least, one.values, np.nan))

    return made


def _acting(plot: Plot) -> Ends:
    """Ends of both axes around what is drawn; says what is left out."""
    x, heights = plot.drawn[0][0], np.array([y for _, y in plot.drawn])
    low, top = np.nanmin(heights), np.nanmax(heights)
    last = x[np.isfinite(heights).any(axis=0)][-1]
    low *= 0.8 / max(top / low, 1e3) ** 0.06
    plot.axes.set_xlim(0.3, last + 0.7)
    if last < x[-1]:
        low = 10.0**-_DECADES * top
        words = f"orders {last + 1:.0f} to {x[-1]:.0f}: below $10^{{-{_DECADES}}}$ of the largest"
        plot.axes.set_title(words, loc="left", fontsize=8, color=QUIET)
    return low, top * max(top / low, 1e3) ** 0.08


ENERGY_BY_ORDER = Curves(
    "largest energy of each order alone",
    (
        Panel(
            "energy",
            tuple(Curve(_by_order(kind), kind, bars=True) for kind in _KINDS),
            log="y",
            ends=_acting,
            legend={"loc": "upper right"},
        ),
    ),
    high=3.9,
)


# ----------------------------------------------------------------------------
# Mean energies of the body over a range of speeds, with the speeds left out as bands.
# ----------------------------------------------------------------------------

#: decades shown around the usual energy where it has no bound at some speeds
_BELOW, _ABOVE = 1e-4, 1e6
#: the lowest speed drawn, of the highest one: below it little moves
_SPAN = 0.03


def _masked(result: Result) -> np.ndarray:
    """Ends in rad/s (bands, 2) of the speeds left out."""
    ends = [having(result.record, f"response/masked/{end}", "masked") for end in ("low", "high")]
    found = [np.asarray(one.values) for one in ends if one is not None]
    return np.transpose(found) if len(found) == 2 else np.zeros((0, 2))


def _mean(kind: str) -> Source:
    """An energy with a break in each band, and without what a logarithmic axis cannot show."""

    def made(result: Result) -> Quantity | None:
        found = having(result.record, f"response/run_up/{kind}_energy", "speed")
        if found is None or not np.any(found.axes[0].values > 0.0):
            return None
        speed, centres = found.axes[0].values, _masked(result).mean(axis=1)
        places = np.searchsorted(speed, centres)
        shown = np.where(found.values > 0.0, found.values, np.nan)
        axis = replace(found.axes[0], values=np.insert(speed, places, centres))
        return replace(found, values=np.insert(shown, places, np.nan), axes=(axis,))

    return made


def _energy_ends(plot: Plot) -> Ends:
    """Ends of the energy axis: of all that is shown, or decades around what is usual.

    Usual is the median over (logarithmically) even speeds of the larger energy.
    """
    speed = plot.drawn[0][0]
    low, high = max(float(speed[speed > 0.0].min()), _SPAN * speed.max()), float(speed.max())
    plot.axes.set_xlim(low, high)
    curves = [np.nan_to_num(y) for _, y in plot.drawn]
    shown = np.array(curves)[:, speed >= _SPAN * high]
    shown = shown[shown > 0.0]
    if not shown.size:
        return 0.1, 1.0
    if not len(_masked(plot.result)):
        return 0.5 * float(shown.min()), 4.0 * float(shown.max())
    middle = usual(speed, np.max(curves, axis=0), low, high)
    return _BELOW * middle, _ABOVE * middle


RESPONSE_RUN_UP = Curves(
    "run-up: mean energies of the body at each speed",
    (
        Panel(
            "mean energy over a turn",
            (
                Curve(_mean("kinetic"), "kinetic energy, mean", {"color": COLOURS[0]}),
                peak(colour=COLOURS[0], unless="response/masked/low"),
                Curve(_mean("potential"), "potential energy, mean", {"color": COLOURS[1]}),
                peak(colour=COLOURS[1], below=True, unless="response/masked/low"),
                spans("response/masked", "left out: no bound"),
                resonances("response/modes/natural_frequency"),
                operating,
            ),
            log="xy",
            ends=_energy_ends,
        ),
    ),
    high=3.5,
)


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
