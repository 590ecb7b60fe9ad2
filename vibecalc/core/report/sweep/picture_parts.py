"""What the pictures of a sweep share: which points and results they show, units, marks."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, read_in, unit_words
from vibecalc.core.report.sweep.limits import Limit, Limits, best, case_values, judge, nearest
from vibecalc.core.report.sweep.statistics import Worst, numeric, worst
from vibecalc.core.report.sweep.view import SweepView, causes
from vibecalc.core.report.writing import fold, many
from vibecalc.core.results.sweep_file import SweptAxis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: an axis of no more points can be a handful of lines
FEW = 6
#: ratio of the largest to the smallest value from which a scale is logarithmic
WIDE = 60.0
BEST: dict[str, Any] = {
    "marker": "*", "color": "#E69F00", "markeredgecolor": "black", "markersize": 15,
    "linestyle": "none", "zorder": 8, "clip_on": False,
}  # fmt: skip
_MARKS = (("x", COLOURS[1]), ("+", COLOURS[3]), ("1", QUIET))
_WORDS, _LINE = 100, 80
_SIDE_BY_SIDE = 45
#: letters in one line below an axis
_LABEL = 44
#: what is measured, by the unit in SI
_MEASURES = {
    "N": "force", "N*m": "torque", "J": "energy", "dB": "level", "Pa": "pressure",
    "W": "power", "rad": "angle", "s": "time", "kg": "mass", "m/s^2": "acceleration",
}  # fmt: skip


class Shown(NamedTuple):
    """One result in the unit of its picture: values and spread at all points, and its limits."""

    path: str
    words: str
    measure: str
    unit: str
    factor: float
    worst: Worst
    limits: list[Limit]

    @property
    def values(self) -> np.ndarray:
        """One value for each point, NaN where there is none."""
        return self.worst.values * self.factor

    @property
    def label(self) -> str:
        """What is measured, and its unit: `force in N`."""
        _, level, reference = self.words.partition(", dB re")
        unit = unit_words(f"dB re{reference}")[1] if level else self.unit
        return f"{self.measure} in {unit}" if self.measure else unit or "number"

    def title(self, *notes: str) -> str:
        """The quantity in words, which fit over a panel, and below them notes."""
        note = "; ".join(filter(None, notes))
        lines = fold(self.words.split(", dB re")[0], _SIDE_BY_SIDE)
        return "\n".join([*lines, *(fold(note, _SIDE_BY_SIDE) if note else ())])


class Mark(NamedTuple):
    """How the failures of one cause are drawn, and their words for the legend."""

    points: np.ndarray
    marker: str
    colour: str
    words: str


class Picture(NamedTuple):
    """What a picture of a grid shows: the places of its axes, point numbers, results.

    `points` is (x,) or (x, y); `held` says at what the other axes stand.
    """

    sweep: SweepView
    judged: Limits
    axes: tuple[int, ...]
    points: np.ndarray
    held: str
    shown: list[Shown]

    @property
    def grid(self) -> list[SweptAxis]:
        """The axes that are shown."""
        return [self.sweep.grid[i] for i in self.axes]

    @property
    def marks(self) -> list[Mark]:
        """The points without a result."""
        return failure_marks(self.sweep, self.points)

    @property
    def here(self) -> list[float] | None:
        """Where the case itself stands on the axes, None if it lies outside."""
        found = case_values(self.sweep)
        if found is None:
            return None
        places = [self.sweep.together[i][0] for i in self.axes]
        at = [float(found[place]) * self.sweep.keys[place].factor for place in places]
        spans = zip(map(along, self.grid), at, strict=True)
        return at if all(span.min() <= one <= span.max() for span, one in spans) else None

    @property
    def star(self) -> tuple[int, list[float], str] | None:
        """The best point, where it is, and its words; None where it is not shown."""
        found = best(self.sweep, self.judged)
        if found is None or found[0] not in self.points:
            return None
        place = np.argwhere(self.points == found[0])[0]
        at = [float(along(axis)[i]) for axis, i in zip(self.grid, place, strict=True)]
        return found[0], at, textwrap.fill(unit_words(found[1])[1], _LINE)


def pictured(sweep: SweepView, most_points: int, most: int) -> Picture | None:
    """What a picture shows of a grid; None if no result has a value.

    One or two axes: x is the longest of numbers, then one of `most_points` at most. The others
    stand at the best point, else at the point nearest to the case, else at their start.
    """
    judged, shape = judge(sweep), sweep.shape
    order = sorted(
        range(len(shape)), key=lambda i: (bool(sweep.grid[i].keys[0].choices), -shape[i], i)
    )
    axes = (order[0], *[i for i in order[1:] if shape[i] <= most_points][:1])
    found = best(sweep, judged)
    centre = (nearest(sweep, sweep.done) or 0) if found is None else found[0]
    places = np.unravel_index(centre, shape)
    index = tuple(slice(None) if i in axes else place for i, place in enumerate(places))
    points = np.arange(sweep.count).reshape(shape)[index]
    points = points.T if axes[0] > axes[-1] else points
    held = [
        f"{key.label} = {key.shown(value)}"
        for i, axis in enumerate(sweep.grid)
        if i not in axes
        for key, value in zip(axis.keys, axis.table[places[i]], strict=True)
    ]
    chosen = panels(sweep, judged, points, most)
    return Picture(sweep, judged, axes, points, ", ".join(held), chosen) if chosen else None


def is_map(sweep: SweepView) -> bool:
    """Whether two axes of numbers are too long for a handful of lines."""
    long = [a for a in sweep.grid if a.count > FEW and not a.keys[0].choices]
    return len(long) > 1


def panels(sweep: SweepView, judged: Limits, points: np.ndarray, most: int) -> list[Shown]:
    """The results worth a panel: those that vary over `points`, those with a limit first."""
    paths, limited = numeric(sweep), {limit.quantity for limit in judged.limits}
    if len(paths) > most:
        paths = sorted(paths, key=lambda path: path not in limited)
    found: list[Shown] = []
    still: list[Shown] = []
    for path in paths:
        one = shown(sweep, judged, path)
        values, errors = one.values[points], one.worst.errors[points]
        finite = values[np.isfinite(values)]
        if finite.size:
            slack = 2.0 * one.factor * np.max(errors[np.isfinite(errors)], initial=0.0)
            (found if np.ptp(finite) > slack or one.limits else still).append(one)
        if len(found) == most:
            break
    return found or still[:1]


def shown(sweep: SweepView, judged: Limits, path: str) -> Shown:
    """A result in the unit that people read values of its size in."""
    counted, quantity = worst(sweep, path), sweep.quantities[path]
    size = np.abs(counted.values)
    largest = float(np.max(size, initial=0.0, where=np.isfinite(size)))
    factor, unit = read_in(quantity, largest)
    measure = _MEASURES.get(quantity.unit, {"rpm": "speed", "Hz": "frequency"}.get(unit, ""))
    words = quantity.long_name or short_name(path)
    own = [limit for limit in judged.limits if limit.quantity == path]
    return Shown(path, words, measure, unit, factor, counted, own)


def short_name(path: str) -> str:
    """The last word of a path, for a legend."""
    return path.rsplit("/", 1)[-1].replace("_", " ")


def along(axis: SweptAxis) -> np.ndarray:
    """Values of the first key of an axis in its unit; places of choices."""
    if axis.keys[0].choices:
        return np.arange(axis.count, dtype=float)
    return np.asarray(axis.table[:, 0] * axis.keys[0].factor)


def axis_title(axis: SweptAxis) -> str:
    """Words of an axis with its unit, and the names of what varies along with it."""
    key = axis.keys[0]
    unit = "" if key.choices else key.written_unit.replace("um", "\u00b5m")
    title = unit_words(f"{key.label} in {unit}" if unit else key.label)[1]
    also = ", ".join(other.label for other in axis.keys[1:3])
    return textwrap.fill(title + (f" (with {also})" if also else ""), _LABEL)


def logarithmic(values: np.ndarray) -> bool:
    """Whether positive values span so much that a linear scale would hide the small ones."""
    finite = values[np.isfinite(values)]
    return bool(finite.size and finite.min() > 0.0 and finite.max() > WIDE * finite.min())


def failure_marks(sweep: SweepView, points: np.ndarray) -> list[Mark]:
    """Marks of the failed points among `points`, one for each of the most frequent causes."""
    found = [
        (inside, cause.title)
        for cause in causes(sweep)
        if (inside := cause.points[np.isin(cause.points, points)]).size
    ]
    named = len(found) if len(found) <= len(_MARKS) else len(_MARKS) - 1
    said = [(inside, f"{many(inside.size, 'point')}: {title}") for inside, title in found[:named]]
    if len(found) > named:
        rest = np.concatenate([inside for inside, _ in found[named:]])
        words = f"{many(rest.size, 'point')} of {len(found) - named} other causes"
        said.append((rest, words))
    return [
        Mark(inside, *look, textwrap.shorten(words, _WORDS, placeholder=" ..."))
        for (inside, words), look in zip(said, _MARKS, strict=False)
    ]


def entry_words(counted: Worst, points: np.ndarray) -> str:
    """Which of several entries count over some points: `largest: mount=1`."""
    if len(counted.labels) < 2:
        return ""
    places = points[~np.isnan(counted.values[points])]
    used = [counted.labels[i] for i in np.unique(counted.entry[places])]
    if len(used) > 2:
        return f"largest of {len(counted.labels)} entries"
    return "largest: " + " or ".join(used)


def legend_below(
    figure: "Figure", grid: Sequence["Axes"], more: Mapping[str, Any] | None = None
) -> None:
    """One legend for all panels, each entry once; in two columns where the words are short."""
    once: dict[str, Any] = {}
    for axes in grid:
        for handle, words in zip(*axes.get_legend_handles_labels(), strict=True):
            once.setdefault(words, handle)
    once |= more or {}
    if once:
        columns = 1 if max(map(len, once)) > _SIDE_BY_SIDE else min(3, -(-len(once) // 2))
        figure.legend(list(once.values()), list(once), loc="outside lower center", ncols=columns)
