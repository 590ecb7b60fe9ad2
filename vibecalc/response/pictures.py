"""Pictures of the body on its suspension: energies by order, speed, operation; changes."""

from dataclasses import replace
from functools import partial

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, TOTAL, crests, note, usual
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Ends,
    Mark,
    Panel,
    Plot,
    Source,
    entry_of,
    first_of,
    level,
    operating,
    peak,
    resonances,
    sourced,
    spans,
)
from vibecalc.core.report.sections import having, labels, speed_of
from vibecalc.core.report.writing import show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.response.report import SMALLEST

# ----------------------------------------------------------------------------
# Kinetic and potential energy of each order alone, over as many decades as there are.
# ----------------------------------------------------------------------------

_KINDS = ("kinetic", "potential")
#: powers of ten below the largest that are drawn
_DECADES = 6


def _by_order(kind: str) -> Source:
    """Energies of one kind without what is far too small for a picture."""

    def made(result: Result) -> Quantity | None:
        found = having(result.record, f"response/{kind}_energy/peak_by_order", "order")
        if found is None or found.values.max() < SMALLEST:
            return None
        seen = found.values >= max(SMALLEST, 1e-12 * found.values.max())
        return replace(found, values=np.where(seen, found.values, np.nan))

    return made


def _acting(plot: Plot) -> Ends:
    """Ends of both axes around what is large enough; says what is left out."""
    x, heights = plot.drawn[0][0], np.array([y for _, y in plot.drawn])
    top = float(np.nanmax(heights))
    large = heights >= 10.0**-_DECADES * top
    last = x[np.flatnonzero(large.any(axis=0))[-1]]
    plot.axes.set_xlim(0.3, last + 0.7)
    if last == x[-1]:
        return 0.5 * float(np.min(heights[large])), 3.0 * top
    words = f"orders {last + 1:.0f} to {x[-1]:.0f}: below $10^{{-{_DECADES}}}$ of the largest"
    plot.axes.set_title(words, loc="left", fontsize=8, color=QUIET)
    return 10.0**-_DECADES * top, 3.0 * top


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


def _mean(kind: str) -> Source:
    """An energy with a break in each band, and without what a logarithmic axis cannot show."""

    def made(result: Result) -> Quantity | None:
        found = having(result.record, f"response/run_up/{kind}_energy", "speed")
        if found is None:
            return None
        low, high = (first_of(result.record, f"response/masked/{end}") for end in ("low", "high"))
        speed, centre = found.axes[0].values, 0.5 * (low + high)
        places = np.searchsorted(speed, centre)
        shown = np.where(found.values > 0.0, found.values, np.nan)
        axis = replace(found.axes[0], values=np.insert(speed, places, centre))
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
    if not sourced("response/masked/low", plot.result):
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
#: width of the bars of a balance together
_GROUP = 0.8
#: of a quantity, from the middle of a bar in widths, and the dashes of its range
_PLACES = {"mean": (-0.2, "-"), "peak": (0.37, (0, (2, 1.5)))}
#: a range below this share of the energy is none
_NARROW = 1e-6


def _bars_of(result: Result) -> list[Panel]:
    """A panel for each kind of energy: a bar for each operation, with what it may reach."""
    panels = []
    for kind in _KINDS:
        path = f"{_OPERATIONS}{kind}_energy/mean"
        mean = having(result.record, path, "operation", "balance")
        if mean is not None:
            each = [
                Curve(entry_of(path, i), f"{name}: mean", {"color": COLOURS[i % len(COLOURS)]},
                      bars=True)
                for i, name in enumerate(labels(mean.axes[0]))
            ]  # fmt: skip
            marks = (_ranges(kind, mean), _together(kind, mean))
            panels.append(Panel(f"{kind} energy", (*each, *marks), ends=(0.0, None)))
    return panels


def _ranges(kind: str, mean: Quantity) -> Mark:
    """Peaks as diamonds; the range of means in full lines, that of peaks in dashes."""

    def draw(plot: Plot) -> None:
        found = plot.result.record.quantities.get
        stem, (count, groups) = f"{_OPERATIONS}{kind}_energy/", mean.values.shape
        width = _GROUP / count
        for i, name in enumerate(labels(mean.axes[0])):
            middle = np.arange(groups) + (i - 0.5 * (count - 1)) * width
            peak = found(stem + "peak")
            if peak is not None:
                plot.axes.plot(
                    middle + 0.12 * width, plot.factor * peak.values[i], "D", markersize=7,
                    color=COLOURS[i % len(COLOURS)], markeredgecolor="white",
                    label=f"{name}: peak", zorder=4,
                )  # fmt: skip
            for what, (aside, dashes) in _PLACES.items():
                low, high = (found(f"{stem}{what}_{end}") for end in ("low", "high"))
                if low is None or high is None:
                    continue
                half = 0.5 * plot.factor * (high.values[i] - low.values[i])
                wide = half > 0.5 * _NARROW * plot.factor * np.abs(high.values[i])
                drawn = plot.axes.errorbar(
                    middle[wide] + aside * width, plot.factor * low.values[i][wide] + half[wide],
                    yerr=half[wide], fmt="none", ecolor=TOTAL, elinewidth=1.2, capsize=4, zorder=3,
                    label=f"range of the {what} over the angle of the weights" if any(wide) else "",
                )  # fmt: skip
                drawn[2][0].set_linestyle(dashes)

    return draw


def _together(kind: str, mean: Quantity) -> Mark:
    """The weighted mean as a line across a group, and how far the operations are apart."""

    def draw(plot: Plot) -> None:
        plot.axes.grid(visible=False, axis="x")
        stem, ends = f"{_OPERATIONS}{kind}_energy/", plot.factor * np.asarray(mean.values)
        weighted, apart = (
            plot.result.record.quantities.get(stem + name) for name in ("weighted", "difference")
        )
        for j, (low, high) in enumerate(zip(ends.min(axis=0), ends.max(axis=0), strict=True)):
            right = j + 0.5 * _GROUP
            if weighted is not None:
                height, words = plot.factor * weighted.values[j], None if j else "weighted mean"
                plot.axes.plot(
                    [j - 0.5 * _GROUP, right],
                    [height] * 2,
                    "--",
                    color=TOTAL,
                    label=words,
                    zorder=5,
                )
            if apart is not None:
                arrow = {"arrowstyle": "<->", "color": QUIET, "shrinkA": 0, "shrinkB": 0}
                plot.axes.annotate("", (right + 0.04, high), (right + 0.04, low), arrowprops=arrow)
                words = f"{show(float(plot.factor * apart.values[j]), digits=3)} {plot.unit} apart"
                note(plot.axes, words, (right + 0.04, low), (3, 2), rotation=90, color=QUIET)

    return draw


OPERATIONS = Curves("energies of the operations with each balance", _bars_of, high=3.4, names=2)


# ----------------------------------------------------------------------------
# The change between two operations in time: displacement, energy, and the speed of the crank.
# ----------------------------------------------------------------------------

_SWITCHING = "response/switching/"
_WAYS = {"reversal": "change through rest", "instant": "change at once"}
#: the energy is drawn as the largest of so many intervals: single ones follow every swing
_INTERVALS = 24


def _course(result: Result) -> list[Panel]:
    """A column for each way of changing, with histories of the energy.

    Rows: the displacement of the direction that moves most, one for each change; the kinetic
    energy of all changes; the crank speed.
    """
    found = result.record.quantities.get
    ways = [way for way in _WAYS if f"{_SWITCHING}{way}/kinetic_energy_high" in result.record]
    panels, steady = [], found(_SWITCHING + "steady_energy")
    ends = [found(f"{_SWITCHING}{way}/translation_{end}") for way in ways[:1]
            for end in ("low", "high")]  # fmt: skip
    moved = [end for end in ends if end is not None]
    for i, change in enumerate(labels(moved[0].axes[0]) if len(moved) == 2 else []):
        reach = np.max([np.abs(end.values[i]).max(axis=-1) for end in moved], axis=0)
        place, colour = int(np.argmax(reach)), COLOURS[i % len(COLOURS)]
        label = f"{change}\n{labels(moved[0].axes[1])[place]}"
        for way in ways:
            low, high = (_history(f"{way}/translation_{end}", i, place) for end in ("low", "high"))
            band = Curve(low, look={"color": colour, "linewidth": 0.6}, upto=high)
            panels.append(Panel(label, (band,)))
    levels = [] if steady is None else [
        level(partial(_height, float(height)), f"steady {name}", linestyle=style)
        for name, height, style in zip(labels(steady.axes[0]), steady.values, ("--", ":"),
                                       strict=False)
    ]  # fmt: skip
    panels += [
        Panel("largest kinetic\nenergy", (Curve(_crests(way), "{}"), *levels, _dots(way)),
              log="y", ends=_window, height=1.2)
        for way in ways
    ]  # fmt: skip
    panels += [
        Panel("crank speed\n", (Curve(_speed(way), look={"color": QUIET}, most=1),), unit="rpm",
              height=0.8)
        for way in ways
    ]  # fmt: skip
    titled = [replace(one, title=_WAYS[way]) for one, way in zip(panels, ways, strict=False)]
    return [*titled, *panels[len(titled) :]]


def _height(height: float, _: Result) -> float:
    """A height that is known."""
    return height


def _history(name: str, *place: int) -> Source:
    """A history of one change and direction."""

    def made(result: Result) -> Quantity | None:
        found = result.record.quantities.get(_SWITCHING + name)
        return found and replace(found, values=found.values[place], axes=found.axes[-1:])

    return made


def _crests(way: str) -> Source:
    """The largest energies of intervals of time about each."""

    def made(result: Result) -> Quantity | None:
        found = result.record.quantities.get(f"{_SWITCHING}{way}/kinetic_energy_high")
        if found is None:
            return None
        time = np.asarray(found.axes[-1].values)
        rows = [np.interp(time, *crests(time, envelope(row))) for row in found.values]
        return replace(found, path="", values=np.where(np.array(rows) > 0.0, rows, np.nan))

    return made


def envelope(values: np.ndarray) -> np.ndarray:
    """Largest of each entry and its neighbours; near an end there are fewer of these."""
    reach = min(_INTERVALS // 2, len(values) - 1)
    padded = np.pad(values, reach, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    return np.asarray(windows.max(axis=1))


def _dots(way: str) -> Mark:
    """The largest energy of each change."""

    def draw(plot: Plot) -> None:
        height, time = (
            first_of(plot.result.record, f"{_SWITCHING}{way}/{name}")
            for name in ("kinetic_energy_peak", "peak_time")
        )
        for x, y, colour in zip(time, height, COLOURS, strict=False):
            plot.axes.plot([x], [plot.factor * y], "o", color=colour)

    return draw


def _window(plot: Plot) -> Ends:
    """Ends of a logarithmic axis for the energies of all ways, not too many decades of it."""
    found = [sourced(_crests(way), plot.result) for way in _WAYS]
    every = [one.values.ravel() for one in found if one is not None]
    every.append(first_of(plot.result.record, _SWITCHING + "steady_energy"))
    energy = plot.factor * np.concatenate(every)
    energy = energy[energy > 0.0]
    top = float(np.max(energy, initial=0.0))
    return max(0.5 * float(np.min(energy, initial=top)), top * 10.0**-_DECADES), 2.5 * top


def _speed(way: str) -> Source:
    """The crank speed, which a change at once leaves as it is."""

    def made(result: Result) -> Quantity | None:
        found = result.record.quantities.get(f"{_SWITCHING}{way}/speed")
        energy, speed = result.record[f"{_SWITCHING}{way}/kinetic_energy_high"], speed_of(result)
        if found is not None or speed is None:
            return found
        same = np.full(len(energy.axes[-1].values), speed)
        return replace(energy, path="", values=same, axes=energy.axes[-1:], unit="rad/s")

    return made


SWITCHING = Curves("change between operations", _course, high=1.9, columns=2, level="row")
