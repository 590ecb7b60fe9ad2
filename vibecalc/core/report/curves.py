"""Pictures as descriptions: panels of quantities over an axis, and the engine that draws them.

A `Curves` stands as data in the `pictures.py` of a subject and is drawn from the result alone. What
a result lacks is left out; without any of its curves there is no picture.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from vibecalc.core.report.canvas import (
    COLOURS,
    LETTERS,
    LIMIT,
    QUIET,
    TOTAL,
    bars,
    bounds_of,
    canvas,
    crank_angle_axis,
    dotted,
    gaps,
    note,
    only,
    operating_line,
    palette,
    panels_of,
    plain_ticks,
    read_in,
    unit_words,
)
from vibecalc.core.report.sections import labels, magnitudes, scalar_of
from vibecalc.core.report.sources import (
    READ_IN,
    Ends,
    Look,
    Number,
    Source,
    Words,
    across,
    said,
    sourced,
)
from vibecalc.core.report.verdicts import MEASURED, judge_references
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.catalogue import deciding
from vibecalc.core.results.record import Axis, Quantity, Result
from vibecalc.core.results.verdicts import entries
from vibecalc.numerics.rounding import BoolArray
from vibecalc.units import convert, parse_quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: curves of a quantity that are drawn, the largest of many
_MOST = 6
#: what two curves differ by at most that are drawn as one
_EQUAL = 1e-6
#: up to which order an axis of them has ticks at half ones
_FEW_ORDERS = 6.0
#: of a history, what begins before begins with it
_EARLY = 0.02
#: of the largest value, bars up to which are not seen and have no name
_UNSEEN = 1e-3
#: names of equal curves that are listed
_FEW_NAMES = 3
#: of the distance of two orders, where the dots of one stand on a logarithmic axis
_DOTS = 0.2
#: letters that the line before a name takes the place of
_HANDLE = 7
#: points of a line that is level across the axes, which is no curve
_LEVEL = 2
#: height of a strip of spans at the foot
_STRIP = 0.05
#: bars end the axis where they are in its first part
_HALF = 0.5
#: the least that has a place on a logarithmic axis
_LEAST = 1e-300
#: the lowest speed of a logarithmic axis, of the highest one: below it little moves
SLOW = 0.01


# ----------------------------------------------------------------------------
# Published and measured numbers of a case as points next to the curve that they belong to.
# ----------------------------------------------------------------------------


def draw_points(
    result: Result,
    axes: "Axes",
    quantity: Quantity,
    *,
    entry: str = "",
    factor: float = 1.0,
    colour: Any = None,
    aside: float = 0.0,
    apart: float = 0.0,
) -> np.ndarray:
    """Draw the references of one curve over its last axis; gives their heights as drawn.

    Measured points are hollow circles, published ones crosses. `entry` is that of the quantity's
    other axis, "" without one; `factor` takes the quantity's unit to that of the axes. The points
    stand `aside`, measured and published ones so far `apart` from it.
    """
    *others, over = quantity.axes
    numbers, heights = over.values.dtype.kind in "biuf", list[float]()
    known = judge_references(only(result, quantity.path)) if numbers else []
    hollow = {"marker": "o", "facecolors": "none", "edgecolors": colour, "label": "measured"}
    cross = {"marker": "x", "color": colour, "label": "published"}
    for measured, look in ((True, hollow), (False, cross)):
        rows = [row for row in known if over.name in row.where and row.at != "start"
                and _named(others, row.where) == entry
                and (row.kind == MEASURED) == measured]  # fmt: skip
        if rows:
            places = [parse_quantity(row.where[over.name], over.unit) for row in rows]
            x = across(replace(over, values=np.array(places)))[0] + aside
            y = [factor * convert(row.value, row.unit, quantity.unit) for row in rows]
            x += -apart if measured else apart
            axes.scatter(x, y, s=28.0, linewidths=1.3, zorder=5, **look)
            heights += y
    return np.array(heights)


# ----------------------------------------------------------------------------
# Parts of a panel: curves, and what stands with them.
# ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Curve:
    """A quantity over its last axis, a curve for each entry of the axes before it.

    Of many entries the `most` with the largest values are drawn, and those that references or
    limits are on, equal ones as one; their names stand at `{}` of `words`, at `{each}` as
    `mounts 1, 2`.
    `part` makes numbers of complex values, their size if nothing is said. `upto` fills the band
    to another quantity, `bars` draws bars (dots on a logarithmic axis, which has no zero), with
    ranges between the two quantities `within` where these differ. References of the case on the
    quantity, so far `apart`, and limits of it are drawn with it where its values are.
    """

    of: Source
    words: Words = ""
    look: Look = field(default_factory=dict)
    most: int = _MOST
    part: Callable[[Any], Any] | None = None
    upto: Source = ""
    bars: bool = False
    within: tuple[Source, Source] | None = None
    apart: float = 0.0

    def __call__(self, plot: "Plot") -> None:
        """Draw all of it into a panel."""
        quantity = sourced(self.of, plot.result)
        if quantity is None:
            return
        x, _ = across(quantity.axes[-1])
        rank, axes = np.argsort(x, kind="stable"), plot.axes
        x = x[rank]
        upper = sourced(self.upto, plot.result) if self.upto else None
        for names, row, place in self.rows(quantity, plot.result):
            joined = together(names, quantity)
            counted = quantity.axes[0].name.replace("_", " ")
            each = f"{counted}{'s' * (len(names) > 1)} {joined}" * any(names)
            label = said(self.words, plot.result).replace("{}", joined).replace("{each}", each)
            colour, dashes = plot.colour(self.known_by(names, quantity, plot.result),
                                         self.look.get("color"))  # fmt: skip
            look = {"color": colour, **self.look, "label": label or None}
            aside, y = 0.0, plot.factor * row[rank]
            if "y" in plot.panel.log:  # what has no place on such an axis is a gap
                y = np.where(y > max(_LEAST, 1e-30 * np.nanmax(y, initial=0.0)), y, np.nan)
            plot.drawn.append((x, y))
            if upper is not None:
                top = plot.factor * gaps(magnitudes(upper))[place][rank]
                plot.drawn.append((x, top))
                if x.size > 1:
                    axes.fill_between(x, y, top, **{"linewidth": 0.0, **look})
                else:
                    axes.vlines(x, y, top, **{"linewidth": 9.0, **look})
            elif self.bars:
                if not np.any(np.abs(row) > _UNSEEN * np.nanmax(np.abs(quantity.values))):
                    look["label"] = None
                aside, colour = plot.bars(x, y, look), TOTAL
                self._ranges(plot, x + aside, y, place)
            elif not plot.named_with_its_equal(x, y, label):
                axes.plot(x, y, **{"marker": dotted(len(x)), "linestyle": dashes, **look})
            for name in names if self.part is None else ():
                plot.points += list(draw_points(
                    plot.result, axes, quantity, entry=name, factor=plot.factor, aside=aside,
                    apart=self.apart, colour=LIMIT if self.apart else colour,
                ))  # fmt: skip
        if self.part is None:
            shown = {axis.name: labels(axis) for axis in quantity.axes[:-1]}
            for text, bound in bounds_of(plot.result, quantity.path, shown):
                plot.limit(text, bound)

    def known_by(self, names: Sequence[str], quantity: Quantity, result: Result) -> str:
        """What a curve has its colour by in all panels: the names that it bears, or its words."""
        words = said(self.words, result)
        return words if words and "{" not in words else together(names, quantity) or words

    def rows(self, quantity: Quantity, result: Result) -> list[tuple[list[str], np.ndarray, Any]]:
        """What is drawn of the quantity; bars of equal height have a place each."""
        known = (*entries(result, "reference"), *entries(result, "limit"))
        paths = quantity.path, deciding(quantity.path, {}, "max")
        places = [row.get("where") or {} for row in known if row["quantity"] in paths]
        names = {_named(quantity.axes[:-1], place) for place in places}
        near = 0.0 if self.bars else _EQUAL
        return rows_of(quantity, self.most, self.part, near, names)

    def _ranges(self, plot: "Plot", x: np.ndarray, y: np.ndarray, place: Any) -> None:
        found = [sourced(one, plot.result) for one in self.within or ()]
        ends = [plot.factor * one.values[place] for one in found if one is not None]
        if len(ends) == 2:
            low, high = ends
            wide = high - low > _EQUAL * np.abs(high)
            reach = np.maximum([y - low, high - y], 0.0)[:, wide]
            plot.axes.errorbar(x[wide], y[wide], reach, fmt="none", ecolor=TOTAL, elinewidth=1.2,
                               capsize=3, zorder=3)  # fmt: skip


def rows_of(
    quantity: Quantity,
    most: int = _MOST,
    part: Callable[[Any], Any] | None = None,
    near: float = _EQUAL,
    kept: Collection[str] = (),
) -> list[tuple[list[str], np.ndarray, Any]]:
    """Names, values with gaps and place of each curve of a quantity, in the order of the entries.

    Those that differ by no more than `near` of the largest value are one, none if that is 0.
    Entries of several axes are joined: `rear, order 2`. The `most` largest are taken, and those
    that are to be `kept`.
    """
    values = gaps(magnitudes(quantity) if part is None else part(quantity.values))
    named = [labels(axis) for axis in quantity.axes[:-1]]
    apart = near * np.nanmax(np.abs(values), axis=tuple(range(len(named))), initial=0.0)
    found: list[tuple[list[str], np.ndarray, Any]] = []
    for place in np.ndindex(values.shape[:-1]):
        name = ", ".join(names[i] for names, i in zip(named, place, strict=True))
        row = np.asarray(values[place])
        for members, other, _ in found if near else ():
            if np.all((np.abs(other - row) <= apart) | (np.isnan(other) & np.isnan(row))):
                members.append(name)
                break
        else:
            found.append(([name], row, place))
    tops = [float(np.nanmax(np.abs(row), initial=0.0)) for _, row, _ in found]
    taken = set(np.argsort(-np.array(tops), kind="stable")[:most].tolist())
    taken |= {i for i, (names, *_) in enumerate(found) if not set(kept).isdisjoint(names)}
    return [found[i] for i in sorted(taken)]


def through(
    speed: np.ndarray, curve: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A curve (n,) over speeds or frequencies with points (m, 2 or more: where, height) in it.

    Gaps where it is infinite.
    """
    fresh = points[~np.isin(points[:, 0], speed)]
    x, y = np.append(speed, fresh[:, 0]), np.append(curve, fresh[:, 1])
    rising = np.argsort(x, kind="stable")
    return x[rising], gaps(y[rising])


def together(names: Sequence[str], quantity: Quantity) -> str:
    """Names of equal curves: `1, 2`, of many that follow each other `1 to 6`."""
    every = labels(quantity.axes[0])
    first = every.index(names[0]) if len(names) > _FEW_NAMES and names[0] in every else len(every)
    follow = [*names] == every[first : first + len(names)]
    return f"{names[0]} to {names[-1]}" if follow else ", ".join(names)


def _named(axes: Sequence[Axis], where: Mapping[str, Any]) -> str:
    """The entry that a reference stands on."""
    return ", ".join(str(where.get(axis.name, "")) for axis in axes)


#: what draws into a panel, other than a curve
Mark = Callable[["Plot"], None]


def level(of: Number, words: Words = "", mirrored: bool = False, **look: Any) -> Mark:
    """A line at the height of a number in SI, which stands with its unit at `{}` of `words`."""

    def draw(plot: "Plot") -> None:
        value = scalar_of(plot.result.record, of) if isinstance(of, str) else of(plot.result)
        if not isinstance(value, int | float) or not np.isfinite(value):
            return
        height = plot.factor * value
        style = {"color": QUIET, "linestyle": "--", "linewidth": 1.2, **look}
        text = said(words, plot.result).replace("{}", f"{show(height, digits=4)} {plot.unit}")
        plot.axes.axhline(height, label=text.rstrip() or None, **style)
        if mirrored:
            plot.axes.axhline(-height, **style)
        plot.points.append(height)

    return draw


def limits(path: str, words: str = "", mirrored: bool = False) -> Mark:
    """The upper limits that the case has on the quantity at `path`."""

    def draw(plot: "Plot") -> None:
        for text, bound in bounds_of(plot.result, path):
            plot.limit(f"{words} {text}".strip(), bound)
            if mirrored:
                plot.axes.axhline(-plot.factor * bound, color=LIMIT, linestyle="--", linewidth=1.3)

    return draw


def spans(path: str, words: str = "", ends: tuple[str, str] = ("low", "high"), strip: int = 99,
          only: Callable[[Result], BoolArray] | None = None, **look: Any) -> Mark:  # fmt: skip
    """Shaded intervals between the `ends` below `path`; more than `strip` of them at the foot.

    With `only`, those for which it is true.
    """

    def draw(plot: "Plot") -> None:
        low, high = (sourced(f"{path}/{end}", plot.result) for end in ends)
        if low is None or high is None:
            return
        factor = convert(1.0, low.unit, READ_IN.get(low.unit, low.unit))
        shaded = factor * np.array([low.values, high.values])
        if only is not None:
            shaded = shaded[:, only(plot.result)]
        upto = _STRIP if shaded.shape[1] > strip else 1.0
        style = {"color": "#f3c6cc", "linewidth": 1.0, "zorder": 0, **look}
        for i, (start, stop) in enumerate(shaded.T.tolist()):
            label = None if i else words or None
            plot.axes.axvspan(start, stop, 0.0, upto, label=label, **style)

    return draw


def operating(plot: "Plot") -> None:
    """The operating speed, if it lies within the curves."""
    speeds = plot.drawn[0][0]
    operating_line(plot.axes, plot.result, speeds.min() / rpm(1.0), speeds.max() / rpm(1.0))


# ----------------------------------------------------------------------------
# Ends of axes, panels and pictures.
# ----------------------------------------------------------------------------

#: of what is usual, the height from which on an axis is logarithmic
_FAR = 100.0


def usual_ends(plot: "Plot", low: float | None = None, far: float = _FAR) -> Ends:
    """All of the curves from `low` on, or decades about what is usual where a few are `far` above.

    Flanks of an undamped resonance go up without end: beside them, nothing would be left to see.
    Without `low`, magnitudes begin with zero unless all of them are far from it.
    """
    log, x = plot.panel.log, plot.drawn[0][0]
    spaced = np.geomspace if "x" in log else np.linspace
    even = spaced(max(x.min(), SLOW * x.max()), x.max(), 400)
    size = np.concatenate([np.interp(even, *one) for one in plot.drawn])
    size = size[np.isfinite(size)]
    middle = float(np.median(np.abs(size))) if size.size else 0.0
    top = max(float(np.nanmax(y, initial=0.0)) for _, y in plot.drawn)
    if np.any(size < 0.0) or middle == 0.0 or ("y" not in log and far * middle > top):
        least = float(np.min(size, initial=top))
        return 0.0 if low is None and 0.0 <= least < _HALF * top else low, None
    plot.axes.set_yscale("log")
    return middle / far, max([min(3.0 * top, far**2 * middle), *plot.points])


def decades(most: int) -> "Callable[[Plot], Ends]":
    """Ends of a logarithmic axis: all of the curves, but no more than so many decades of them."""

    def ends(plot: "Plot") -> Ends:
        size = np.concatenate([y[np.isfinite(y)] for _, y in plot.drawn])
        if not size.size:
            return None, None
        low, high = max(10.0**-most * float(size.max()), 0.5 * float(size.min())), 3.0 * size.max()
        if not plot.axes.get_autoscaley_on():  # of panels that are level with it
            before = plot.axes.get_ylim()
            low, high = min(low, before[0]), max(high, before[1])
        return low, high

    return ends


@dataclass(frozen=True)
class Panel:
    """Curves over one axis, with what stands with them, drawn in the order of `parts`.

    `label` says what is drawn; its unit, that which people read where none is given, follows or
    stands at `{}`. `log` names the logarithmic axes; `ends` are those of the upright axis. `legend`
    places the names in the panel; without it they stand below the picture. `below` are words for
    the other axis. Bars of several curves that are `stacked` stand on each other. A result without
    one of `needs` has no such panel.
    """

    label: Words
    parts: tuple[Mark, ...]
    title: Words = ""
    unit: Words = ""
    log: str = ""
    ends: "Ends | Callable[[Plot], Ends]" = (None, None)
    height: float = 1.0
    legend: Look = field(default_factory=dict)
    below: Words = ""
    stacked: bool = False
    needs: tuple[Source, ...] = ()

    def curves(self, result: Result) -> list[tuple[Curve, Quantity]]:
        """The curves that a result has, none without what the panel needs."""
        if any(sourced(one, result) is None for one in self.needs):
            return []
        found = [(one, sourced(one.of, result)) for one in self.parts if isinstance(one, Curve)]
        return [(one, quantity) for one, quantity in found if quantity is not None]


@dataclass
class Plot:
    """A panel as it is drawn: axes, unit of heights with its factor, curves, other heights."""

    axes: "Axes"
    result: Result
    panel: Panel
    axis: Axis
    largest: Mapping[str, float]
    factor: float = 1.0
    unit: str = ""
    drawn: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    points: list[float] = field(default_factory=list)
    #: places in the palette of the curves of all panels of the picture, by name and by how many
    #: curves of this panel have had that name
    places: dict[tuple[str, int], int] = field(default_factory=dict)
    looks: list[tuple[str, str]] = field(default_factory=list)
    #: points between the axes and their title, where there is more than usual
    pad: float | None = None
    _names: set[str] = field(default_factory=set)
    _own: list[str] = field(default_factory=list)
    #: places and heights
    _bars: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)

    def colour(self, name: str, given: str | None = None) -> tuple[str, str]:
        """Colour and dashes of the next curve, the same for one name in all panels."""
        key = (name, self._own.count(name))
        self._own.append(name)
        if not name and given is None and any(one for one, _ in self.places):
            given = TOTAL  # what has no name beside what has one
        if given in COLOURS:
            self.places.setdefault(key, COLOURS.index(given))
        elif given is None and key not in self.places:
            # free are colours of what has no name, and of other panels where each has its legend
            held = {place for (one, _), place in self.places.items()
                    if one in self._names or (one and not self.panel.legend)}  # fmt: skip
            self.places[key] = next(place for place in count() if place not in held)
        self.looks.append((given, "-") if given else palette(self.places[key]))
        return self.looks[-1]

    def named_with_its_equal(self, x: np.ndarray, y: np.ndarray, label: str) -> bool:
        """Whether such a curve is drawn already, which then has this name as well."""
        near = _EQUAL * np.nanmax(np.abs(y), initial=0.0)
        for line in self.axes.lines if len(x) > _LEVEL else ():
            u, v = line.get_data()
            if np.array_equal(x, u) and np.allclose(y, v, rtol=0.0, atol=near, equal_nan=True):
                names = [one for one in (str(line.get_label()), label) if one and one[0] != "_"]
                line.set_label("; ".join(names) or None)
                return True
        return False

    def limit(self, words: str, bound: float) -> None:
        """A limit in SI, with its words above it."""
        height = self.factor * bound
        self.axes.axhline(height, color=LIMIT, linestyle="--", linewidth=1.3)
        note(self.axes, words, (1.0, height), (-4, 3), ha="right", va="bottom", color=LIMIT,
             xycoords=self.axes.get_yaxis_transform())  # fmt: skip
        self.points.append(height)

    def bars(self, x: np.ndarray, y: np.ndarray, look: Look) -> float:
        """Bars next to those of the other curves of the panel, or on them; how far aside."""
        each = [
            one.rows(quantity, self.result)
            for one, quantity in self.panel.curves(self.result)
            if one.bars
        ]
        several, before = sum(map(len, each)), len(self._bars)
        self._bars.append((x, np.nan_to_num(y)))
        step = self._step(x)
        if self.panel.stacked:  # what is negative below zero
            same = [np.where(y * one > 0.0, one, 0.0) for _, one in self._bars[:-1]]
            bars(self.axes, x, self._bars[-1][1], 0.75 * step, np.sum(same, axis=0), **look)
            return 0.0
        dots = "y" in self.panel.log
        width = (_DOTS if dots else 0.8) * step / several
        aside = (before - 0.5 * (several - 1)) * width
        if dots:
            self.axes.plot(x + aside, y, "o", **look)
        else:
            bars(self.axes, x + aside, self._bars[-1][1], 0.92 * width, **look)
        return aside

    def _step(self, x: np.ndarray) -> float:
        """Least distance of two bars, 1 at most where they stand at whole numbers."""
        most = 1.0 if self.axis.values.dtype.kind != "f" else float(np.ptp(x)) or 1.0
        return float(np.min(np.diff(x), initial=most))

    def named(self) -> dict[str, Any]:
        """What stands in a legend, each name once."""
        handles, texts = self.axes.get_legend_handles_labels()
        return dict(zip(texts, handles, strict=True))

    def draw(self, curves: list[tuple[Curve, Quantity]]) -> None:
        """All of the panel, in its unit."""
        axes, panel, result = self.axes, self.panel, self.result
        first = curves[0][1]
        self.factor, self.unit = read_in(first, self.largest[first.unit])
        if panel.unit:
            unit = said(panel.unit, result)
            self.factor, self.unit = convert(1.0, first.unit, unit), unit_words(unit)[1]
        words = said(panel.label, result)
        if words and self.unit and "{}" not in words:
            words += "in {}" if words.endswith("\n") else " in {}"
        axes.set_ylabel(words.replace("{}", self.unit))
        axes.set_title(said(panel.title, result), loc="left")
        self._names = {one.known_by(names, quantity, result) for one, quantity in curves
                       for names, *_ in one.rows(quantity, result)}  # fmt: skip
        for part in panel.parts:
            part(self)
        ends = [(np.nanmin(y, initial=0.0), np.nanmax(y, initial=0.0)) for _, y in self.drawn]
        if any(low < 0.0 < high for low, high in ends) and first.unit != "dB":
            axes.axhline(0.0, color=QUIET, linewidth=0.8)
        self._ends()
        if panel.legend and self.named():
            axes.legend(self.named().values(), self.named(), **panel.legend)

    def _ends(self) -> None:
        """Scales and ends of both axes."""
        from matplotlib.ticker import MaxNLocator, MultipleLocator

        axes, panel, axis = self.axes, self.panel, self.axis
        x = np.concatenate([x for x, _ in self.drawn])
        if axis.name == "crank_angle":
            crank_angle_axis(axes, round(float(x.max()) / 360.0))
        elif axis.values.dtype.kind not in "biuf":
            axes.set_xticks(range(len(axis.values)), labels(axis))
        elif self._bars:
            step = self._step(np.unique(x))
            axes.set_xlim(float(x.min()) - 0.7 * step, float(x.max()) + 0.7 * step)
            axes.grid(visible=False, axis="x")
            if axis.name == "order":
                halves = step < 1.0 and float(np.ptp(x)) <= _FEW_ORDERS
                whole = MaxNLocator(12, integer=True, steps=[1, 2, 5, 10])
                axes.xaxis.set_major_locator(MultipleLocator(0.5) if halves else whole)
        elif np.ptp(x) > 0.0 and not dotted(len(self.drawn[0][0])):
            low, high = float(np.min(x[x > 0.0] if "x" in panel.log else x)), float(np.max(x))
            low = max(low, SLOW * high) if "x" in panel.log and axis.name == "speed" else low
            axes.set_xlim(0.0 if axis.unit == "s" and low < _EARLY * high else low, high)
        if axis.values.dtype.kind in "iu":
            axes.locator_params(axis="x", integer=True)
        for name in panel.log:
            getattr(axes, f"set_{name}scale")("log")
        axes.margins(y=0.08)
        axes.set_ylim(*(panel.ends(self) if callable(panel.ends) else panel.ends))
        if self._bars:
            self._up_to_the_last()
        for upright in (axes.xaxis, axes.yaxis):
            if upright.get_scale() == "log":
                plain_ticks(upright)

    def _up_to_the_last(self) -> None:
        """Ends the axis of orders with the last bar that is seen, and says which are not.

        On an axis that is not logarithmic only where most of it would be empty.
        """
        log = "y" in self.panel.log
        places, sizes = (np.concatenate([one[i] for one in self._bars]) for i in range(2))
        x, size = np.unique(places), np.abs(sizes)
        low = self.axes.get_ylim()[0] if log else _UNSEEN * size.max()
        if self.axis.name != "order" or not np.any(size > low):
            return
        last = int(np.searchsorted(x, places[size > low].max()))
        if last + 1 >= x.size or (not log and last > _HALF * x.size):
            return
        self.axes.set_xlim(right=float(x[last]) + 0.7 * float(x[last + 1] - x[last]))
        small = "below the axis" if log else f"below {100.0 * _UNSEEN:g} % of the largest"
        words = f"orders {x[last + 1]:g} to {x[-1]:g}: {small}"
        self.axes.set_title(words, loc="right", fontsize=8, color=QUIET)


@dataclass(frozen=True)
class Curves:
    """A picture: panels in `columns`, those that a result has curves of, each `high` in inches.

    Names of curves stand below it, up to `names` in a row, unless a panel has them. Panels that are
    `level` have one upright axis, or one in each row.
    """

    title: Words
    panels: tuple[Panel, ...] | Callable[[Result], Sequence[Panel]]
    high: float = 2.9
    columns: int = 1
    names: int = 4
    level: bool | Literal["row"] = False

    def __call__(self, result: Result) -> "Figure | None":
        """The picture, None if the result has none of its curves."""
        given = self.panels(result) if callable(self.panels) else self.panels
        found = [(panel, curves) for panel in given if (curves := panel.curves(result))]
        if not found:
            return None
        columns = min(self.columns, len(found))
        lines = -(-len(found) // columns)
        figure = canvas(result, said(self.title, result), 1.3 + self.high * lines)
        overs = [curves[0][1].axes[-1].name for _, curves in found]
        shared = len({*overs}) == 1
        places = panels_of(
            figure, len(found), columns, sharex=shared, sharey=self.level,
            height_ratios=[panel.height for panel, _ in found[::columns]],
        )  # fmt: skip
        if len(found) % columns and not shared:  # the last has a row for itself
            places[-1].set_visible(False)
            places[-1] = figure.add_subplot(places[0].get_gridspec()[-1, :])
        named: dict[str, Any] = {}
        taken: dict[tuple[str, int], int] = {}
        largest: dict[str, float] = {}  # one unit for all that is read in the same
        for one in (quantity for _, curves in found for _, quantity in curves):
            size = float(np.nanmax(gaps(np.abs(one.values)), initial=0.0))
            largest[one.unit] = max(size, largest.get(one.unit, 0.0))
        for i, (axes, (panel, curves)) in enumerate(zip(places, found, strict=True)):
            plot = Plot(axes, result, panel, curves[0][1].axes[-1], largest, places=taken)
            plot.draw(curves)
            axes.set_xlabel(said(panel.below, result) or across(plot.axis)[1])
            if columns > 1:
                title = axes.get_title(loc="left")
                axes.set_title(title, loc="left", fontsize=8, pad=plot.pad)
                axes.set_ylabel("" if self.level and i % columns else axes.get_ylabel())
            new = {} if panel.legend else plot.named()
            named |= {name: handle for name, handle in new.items() if name not in named}
        if named:
            fitting = max(LETTERS // (max(map(len, named)) + _HANDLE), 1)
            figure.legend(named.values(), named, loc="outside lower center",
                          ncols=min(self.names, fitting))  # fmt: skip
        for i, (axes, below) in enumerate(zip(places, places[columns:], strict=False)):
            if overs[i] == overs[i + columns] and axes.get_xlim() == below.get_xlim():
                axes.set_xlabel("")
        for axes in places:
            axes.tick_params(labelbottom=bool(axes.get_xlabel()))
        return figure
