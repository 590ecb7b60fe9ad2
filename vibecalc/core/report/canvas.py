"""What pictures share: a figure without a window, colours, marks, units."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.sections import read_as, speed_of
from vibecalc.core.report.writing import fold, read, rpm
from vibecalc.core.results.catalogue import deciding
from vibecalc.core.results.record import Quantity, Result
from vibecalc.core.results.verdicts import entries, verdicts_of
from vibecalc.units import convert

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# What the pictures share: a figure without a window, colours, and marks.
# ----------------------------------------------------------------------------

#: Okabe and Ito's colours, which readers with a colour vision deficiency can tell apart.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
TOTAL = "#222222"
LIMIT = "#B00020"
QUIET = "#777777"
#: a page 160 mm wide, in inches, and the type on it in points: pictures are read unscaled
WIDTH = 160.0 / 25.4
TYPE = 8.5
_HIGHEST = 230.0 / 25.4
#: letters of 9 pt in the width of a page
LETTERS = 92
#: what keeps words readable over lines
PLATE = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}
#: points of a curve up to which they are drawn
_SEEN = 60
#: ratio of the ends of a logarithmic axis up to which 2 and 5 have numbers as well; at least
_FEW, _FEWEST = 1e3, 3
#: and from which on not every power of ten has one
_MANY = 1e12
#: of the largest, marks of a path closer than which share their words
_CLOSE = 0.06
#: of a direction, the part along an axis from which on words stand on that side
_ASIDE = 0.35
#: the least that is written as a plain number
_LEAST = 1e-4
ORDER_NAMES: Mapping[int, str] = {1: "primary (order 1)", 2: "secondary (order 2)"}


_DASHES = ("-", "--", "-.", ":")


def palette(place: int) -> tuple[str, str]:
    """Colour and dashes of the curve of a number: dashes where all colours are used."""
    turn, place = divmod(place, len(COLOURS))
    return COLOURS[place], _DASHES[turn % len(_DASHES)]


def canvas(result: Any, subtitle: str, height: float) -> "Figure":
    """A figure for files only, as wide as a page, titled with the case and what is shown.

    `result` is one, or a sweep.

    `height` is in inches for type of 10 pt; it shrinks with the type, and ends with the page.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from vibecalc.core.report.paper import Sheet

    figure = Sheet(figsize=(WIDTH, min(TYPE / 10.0 * height, _HIGHEST)), layout="constrained")
    FigureCanvasAgg(figure)
    title = str(result.case.get("title") or result.name)
    lines = [line for words in f"{title}\n{subtitle}".split("\n") for line in _even(words)]
    figure.suptitle("\n".join(lines).rstrip(), fontsize=9)
    return figure


def _even(words: str) -> list[str]:
    """Lines no wider than the page, and as few, of even width."""
    fewest = len(fold(words, LETTERS))
    widths = range(LETTERS // 2, LETTERS) if fewest > 1 else ()
    return fold(words, next((n for n in widths if len(fold(words, n)) == fewest), LETTERS))


def panels_of(figure: "Figure", count: int, columns: int, **more: Any) -> list[Any]:
    """So many panels in columns; the last row may have fewer."""
    grid = figure.subplots(-(-count // columns), columns, squeeze=False, **more).ravel().tolist()
    for spare in grid[count:]:
        spare.set_visible(False)
    return list(grid[:count])


def ticks(axis: Any, places: Any, words: Sequence[str] | None = None) -> None:
    """Ticks at these places, with their numbers or `words`."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    axis.set_major_locator(FixedLocator(list(places)))
    if words is not None:
        axis.set_major_formatter(FixedFormatter(list(words)))


def crank_angle_axis(axes: "Axes", turns: int = 1) -> None:
    """Crank angle in degrees over one turn or two, marked at eighths of it."""
    axes.set_xlim(0.0, 360.0 * turns)
    ticks(axes.xaxis, range(0, 360 * turns + 1, 45 * turns))
    axes.set_xlabel("crank angle in deg")


def waves(orders: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """exp(i n angle), shape (orders, angles); x = Re(X @ waves) is the signal of harmonics X."""
    turned = np.multiply.outer(np.asarray(orders, dtype=float), angle)
    return np.asarray(np.exp(1j * turned))


def note(
    axes: "Axes", words: str, at: tuple[Any, Any], shift: tuple[float, float], **style: Any
) -> None:
    """Words of 8 pt, moved by some points from a place of the axes."""
    axes.annotate(words, at, xytext=shift, textcoords="offset points", **{"fontsize": 8, **style})


def mark_angles(
    axes: "Axes", path: np.ndarray, angle: np.ndarray, marks: Iterable[int], colour: str
) -> None:
    """Crank angles at places of a path (n,), across + i upwards; close ones share their words.

    Words stand outside, away from zero. All angles are in degrees.
    """
    top, named = float(np.abs(path).max()), dict[complex, list[str]]()
    for mark in marks:
        here = complex(path[np.argmin(np.abs(angle - mark))])
        near = next((one for one in named if abs(one - here) <= _CLOSE * top), here)
        named.setdefault(near, []).append(f"{mark}")
    for at, words in named.items():
        out = at / abs(at) if abs(at) > _CLOSE * top else 1.0 + 0.0j
        aside = "right" if out.real < -_ASIDE else "left" if out.real > _ASIDE else "center"
        upright = "top" if out.imag < -_ASIDE else "bottom" if out.imag > _ASIDE else "center"
        axes.plot([at.real], [at.imag], "o", color=colour, ms=3)
        note(axes, ", ".join(words), (at.real, at.imag), (4.0 * out.real, 4.0 * out.imag),
             color=colour, ha=aside, va=upright, fontsize=7, bbox=PLATE)  # fmt: skip


def bars(axes: "Axes", at: Any, heights: Any, width: float, base: Any = 0.0, **look: Any) -> None:
    """Upright bars from a `base` on, at ascending places, all of them one patch."""
    edges = np.add.outer(np.asarray(at, dtype=float), [-0.5 * width, 0.5 * width]).ravel()
    values, floor = np.full(edges.size - 1, np.nan), np.zeros(edges.size - 1)
    floor[::2], values[::2] = base, heights + np.asarray(base)
    axes.stairs(values, edges, baseline=floor, fill=True, **look)


def gaps(values: Any) -> np.ndarray:
    """Gaps where a value is infinite."""
    return np.where(np.isfinite(values), values, np.nan)


def unit_words(unit: str, largest: float = 0.0) -> tuple[float, str]:
    """Factor and words of a unit as people read it: N m, kN from 10 000 N on."""
    words = re.sub(r"\^(\d)", r"$^\1$", unit.replace("*", " ")).replace("um", "\u00b5m")
    return (1e-3, f"k{words}") if unit in ("N", "N*m") and largest >= 1e4 else (1.0, words)


def dotted(count: int) -> str:
    """Marker of a curve: its points where they are so few that the lines between them are seen."""
    return "." if count <= _SEEN else ""


def crests(time: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An extreme over a sliding window without its stairs: each step becomes its middle."""
    steps = np.flatnonzero(np.diff(value, prepend=np.nan))
    ends = np.append(steps[1:], len(value)) - 1
    at = 0.5 * (time[steps] + time[ends])
    at[0], at[-1] = time[0], time[-1]
    return at, value[steps]


def operating_line(axes: "Axes", result: Result, low: float, high: float) -> None:
    """The operating speed in rpm, if it lies between two speeds in rad/s."""
    speed = speed_of(result)
    if speed is not None and low <= speed <= high:
        axes.axvline(rpm(speed), color=LIMIT, linewidth=1.0, linestyle=":", label="operating speed")


def only(result: Result, path: str) -> Result:
    """The result with the references and limits on one quantity alone."""
    kept = {table: [row for row in entries(result, table) if row["quantity"] == path]
            for table in ("reference", "limit")}  # fmt: skip
    return replace(result, case={**result.case, **kept})


def bounds_of(
    result: Result, quantity: str, drawn: Mapping[str, Collection[str]] | None = None
) -> list[tuple[str, float]]:
    """Upper bounds that the case puts on `quantity` at the optimum, in SI, with their words.

    Of a curve over its last axis `drawn` are the entries of the other axes: without bounds on other
    entries, or at one place of the curve, and with those on its extreme over all speeds.
    """
    paths = {quantity, deciding(quantity, {}, "max")} if drawn is not None else {quantity}
    found = []
    for row in (row for path in sorted(paths) for row in verdicts_of(only(result, path))):
        own = row.quantity in paths and not row.element and row.at != "start"
        on = {axis: str(entry) for axis, entry in row.where.items()}
        there = drawn is None or all(one in drawn.get(axis, ()) for axis, one in on.items())
        if own and there and row.max is not None:
            value = convert(row.max, row.unit, result.record[quantity].unit)
            words = f"limit {row.max:g} {read(row.unit)}".rstrip()
            found.append((", ".join([words, *(on.values() if drawn else ())]), value))
    return list(dict.fromkeys(found))


# ----------------------------------------------------------------------------
# Units and choices that suit a picture: lengths that are small, orders that are many.
# ----------------------------------------------------------------------------

#: rad, an angle up to which it is read in mrad
_SMALL = 0.1
_LENGTHS = ((1.0, "m"), (1e3, "mm"), (1e6, "\u00b5m"))


def read_in(quantity: Quantity, largest: float) -> tuple[float, str]:
    """Factor and words of the unit that people read values of this size in.

    Lengths have at least one digit before the point.
    """
    if quantity.unit == "m":
        return next((one for one in _LENGTHS if one[0] * largest >= 1.0), _LENGTHS[-1])
    unit = read_as(quantity.path, quantity.unit)[1]
    unit = "mrad" if quantity.unit == "rad" and largest < _SMALL else unit
    more, words = unit_words(unit, largest)
    return more * convert(1.0, quantity.unit, unit), words


def plain_ticks(axis: Any) -> None:
    """1, 2, 5, 10, 20, 50 ... in plain numbers on a logarithmic axis; over decades 1, 10, 100.

    On an axis too short for three of these they are even. It ends where it does now, and between
    these there are no others, which cost as much and say less.
    """
    from matplotlib.ticker import FixedLocator, LogLocator, MaxNLocator, NullFormatter, NullLocator

    low, high = axis.get_view_interval()
    subs = (1.0, 2.0, 5.0) if high < _FEW * low else (1.0,)
    every = LogLocator(subs=subs, numticks=99 if high < _MANY * low else 9).tick_values(low, high)
    inside = every[(every > 0.999 * low) & (every < 1.001 * high)]
    if inside.size < _FEWEST:
        inside = MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high)
    axis.set_major_locator(FixedLocator(inside))
    if low >= _LEAST and high <= 1e2 / _LEAST:
        axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
    if len(subs) > 1:
        axis.set_minor_locator(NullLocator())


def spread_out(count: int, most: int, kept: Iterable[int] = ()) -> list[int]:
    """At most `most` of `count` places, spread out, but all that are to be `kept`."""
    if count <= most:
        return list(range(count))
    chosen = set(kept)
    first, *between, last = np.linspace(0, count - 1, most).round().astype(int).tolist()
    for place in (first, last, *between):
        if len(chosen) < most:
            chosen.add(place)
    return sorted(chosen)


def keep_apart(places: np.ndarray, apart: float) -> np.ndarray:
    """Ascending places moved as little as need be (in squares) to be so far apart."""
    # with the distances taken off, what is left need only ascend: means of pools that do not
    steps = apart * np.arange(len(places))
    pools: list[tuple[float, int]] = []
    for value in places - steps:
        mean, count = float(value), 1
        while pools and pools[-1][0] > mean:
            other, many = pools.pop()
            mean = (mean * count + other * many) / (count + many)
            count += many
        pools.append((mean, count))
    flat = [mean for mean, count in pools for _ in range(count)]
    return np.asarray(np.array(flat) + steps)
