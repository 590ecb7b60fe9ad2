"""What the pictures of a sweep share: which points and results they show, units, marks."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, length_scale, plain_ticks, unit_words
from vibecalc.core.report.sweep.limits import Limit, best, case_values, judge, nearest
from vibecalc.core.report.sweep.statistics import Worst, numeric, worst
from vibecalc.core.report.sweep.view import Cause, GridAxis, SweepView, causes
from vibecalc.core.report.writing import fold, is_speed, many, show
from vibecalc.units import convert

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
_WORDS = 100
_SIDE_BY_SIDE = 45
#: letters in one line below an axis
_LABEL = 44
#: relative distance of lines that are one
_ALIKE = 1e-6
_MEASURES = {
    "N": "force", "N*m": "torque", "J": "energy", "mJ": "energy", "dB": "level", "rpm": "speed",
    "Hz": "frequency", "m": "length", "mm": "length", "\u00b5m": "length", "Pa": "pressure",
    "W": "power", "rad": "angle", "s": "time", "kg": "mass", "m/s^2": "acceleration",
}  # fmt: skip


class Plane(NamedTuple):
    """The part of a grid that a picture shows: places of its axes, and point numbers.

    `points` is (x,) or (x, y); `held` says at what the other axes stand.
    """

    axes: tuple[int, ...]
    points: np.ndarray
    held: str


class Shown(NamedTuple):
    """One result in the unit of its picture: values and spread at all points."""

    path: str
    words: str
    unit: str
    factor: float
    worst: Worst

    @property
    def values(self) -> np.ndarray:
        """One value for each point, NaN where there is none."""
        return self.worst.values * self.factor

    @property
    def label(self) -> str:
        """What is measured, and its unit: `force in N`."""
        measure = _MEASURES.get(self.unit, "")
        _, level, reference = self.words.partition(", dB re")
        unit = unit_words(f"dB re{reference}" if level else self.unit)[1]
        return f"{measure} in {unit}" if measure else unit or "number"

    def title(self, note: str) -> str:
        """The quantity in words, which fit over a panel, and below them a note."""
        lines = fold(self.words.split(", dB re")[0], _SIDE_BY_SIDE)
        return "\n".join([*lines, *(fold(note, _SIDE_BY_SIDE) if note else ())])


class Mark(NamedTuple):
    """How the failures of one cause are drawn, and their words for the legend."""

    points: np.ndarray
    marker: str
    colour: str
    words: str


class Picture(NamedTuple):
    """What a picture of a grid shows: which points and results, with which limits and marks."""

    sweep: SweepView
    limits: Sequence[Limit]
    part: Plane
    shown: list[Shown]

    @property
    def grid(self) -> list[GridAxis]:
        """The axes that are shown."""
        return [self.sweep.grid[i] for i in self.part.axes]

    @property
    def here(self) -> list[float] | None:
        """Where the case itself stands on these, None if it lies outside."""
        found = case_values(self.sweep)
        if found is None:
            return None
        places = [self.sweep.together[i][0] for i in self.part.axes]
        at = [float(found[place]) * self.sweep.keys[place].factor for place in places]
        spans = zip(map(along, self.grid), at, strict=True)
        return at if all(span.min() <= one <= span.max() for span, one in spans) else None

    @property
    def star(self) -> tuple[int, list[float], str] | None:
        """The best point, where it is, and its words; None where it is not shown."""
        found = best(self.sweep, self.limits)
        if found is None or found[0] not in self.part.points:
            return None
        place = np.argwhere(self.part.points == found[0])[0]
        at = [float(along(axis)[i]) for axis, i in zip(self.grid, place, strict=True)]
        return found[0], at, best_words(self.sweep, found[1], found[0])

    def own(self, one: Shown) -> list[Limit]:
        """The limits on a result."""
        return [limit for limit in self.limits if limit.quantity == one.path]


def pictured(sweep: SweepView, most_points: int, most: int) -> Picture | None:
    """What a picture shows of a grid; None if no result has a value."""
    limits, _ = judge(sweep)
    part = plane(sweep, limits, most_points)
    chosen = panels(sweep, limits, part.points, most)
    return Picture(sweep, limits, part, chosen) if chosen else None


def plane(sweep: SweepView, limits: Sequence[Limit], most: int) -> Plane:
    """The one or two axes to show: x the longest of numbers, then one of `most` points at most.

    The others stand at the best point, else at the point nearest to the case, else at their start.
    """
    lengths = [len(axis.values) for axis in sweep.grid]
    order = sorted(
        range(len(lengths)), key=lambda i: (bool(sweep.grid[i].keys[0].names), -lengths[i], i)
    )
    others = [i for i in order[1:] if lengths[i] <= most]
    shown = (order[0], *others[:1])
    found = best(sweep, limits)
    near = nearest(sweep, sweep.done)
    centre = found[0] if found is not None else (near or 0)
    places = list(np.unravel_index(centre, sweep.shape))
    index = [np.array([place]) for place in places]
    for axis in shown:
        index[axis] = np.arange(lengths[axis])
    mesh = np.meshgrid(*index, indexing="ij")
    numbers = np.asarray(np.ravel_multi_index(mesh, sweep.shape))
    points = np.squeeze(numbers, tuple(i for i in range(len(lengths)) if i not in shown))
    if len(shown) == 2 and shown[0] > shown[1]:
        points = points.T
    held = [
        f"{key.words} = {key.shown(value)}"
        for i, axis in enumerate(sweep.grid)
        if i not in shown
        for key, value in zip(axis.keys, axis.values[places[i]], strict=True)
    ]
    return Plane(shown, points, ", ".join(held))


def is_map(sweep: SweepView) -> bool:
    """Whether two axes of numbers are too long for a handful of lines."""
    long = [a for a in sweep.grid if len(a.values) > FEW and not a.keys[0].names]
    return len(long) > 1


def panels(sweep: SweepView, limits: Sequence[Limit], points: np.ndarray, most: int) -> list[Shown]:
    """The results worth a panel: those that vary over `points`, those with a limit first."""
    paths = numeric(sweep)
    limited = [path for path in paths if any(limit.quantity == path for limit in limits)]
    if len(paths) > most:
        paths = [*limited, *(path for path in paths if path not in limited)]
    found: list[Shown] = []
    still: list[Shown] = []
    for path in paths:
        one = shown(sweep, path)
        values = one.values[np.ravel(points)]
        finite = values[np.isfinite(values)]
        if not finite.size:
            continue
        errors = one.worst.errors[np.ravel(points)]
        slack = 2.0 * one.factor * float(np.max(errors[np.isfinite(errors)], initial=0.0))
        (found if np.ptp(finite) > slack or path in limited else still).append(one)
        if len(found) == most:
            break
    return found or still[:1]


def shown(sweep: SweepView, path: str) -> Shown:
    """A result in a unit that suits its size: rpm, Hz, mm, mJ, else as it is."""
    counted = worst(sweep, path)
    factor, unit = shown_unit(path, sweep.quantities[path].unit, counted.values)
    return Shown(path, sweep.quantities[path].long_name or short_name(path), unit, factor, counted)


def short_name(path: str) -> str:
    """The last word of a path, for a legend."""
    return path.rsplit("/", 1)[-1].replace("_", " ")


def together(drawn: np.ndarray) -> list[list[int]]:
    """Numbers of lines (points, lines) in groups that lie on each other."""
    found: list[list[int]] = []
    for i, line in enumerate(drawn.T):
        for group in found:
            if np.allclose(line, drawn[:, group[0]], rtol=_ALIKE, atol=0.0, equal_nan=True):
                group.append(i)
                break
        else:
            found.append([i])
    return found


def shown_unit(path: str, unit: str, values: np.ndarray) -> tuple[float, str]:
    """Factor and unit for a picture; `values` are in SI."""
    finite = np.abs(values[np.isfinite(values)])
    largest = float(np.max(finite, initial=0.0))
    if unit == "m" and largest > 0.0:
        return length_scale(largest)
    if unit == "J" and 0.0 < largest < 0.1:
        return 1e3, "mJ"
    if unit == "rad/s":
        other = "rpm" if is_speed(path) else "Hz"
        return convert(1.0, unit, other), other
    return 1.0, unit


def along(axis: GridAxis) -> np.ndarray:
    """Values of the first key of an axis in its unit; places of choices."""
    return np.asarray(axis.values[:, 0] * axis.keys[0].factor)


def name_axis(axes: "Axes", axis: GridAxis, direction: str) -> None:
    """Title, scale and, for choices, names of the x or y axis of a picture."""
    key = axis.keys[0]
    also = "".join(f", {other.words}" for other in axis.keys[1:3])
    title = unit_words(key.title.replace(" in um", " in \u00b5m"))[1]
    words = title + (f" (with{also[1:]})" if also else "")
    getattr(axes, f"set_{direction}label")(textwrap.fill(words, _LABEL))
    if key.names:
        places = axis.values[:, 0]
        names = [key.names[round(float(place))] for place in places]
        getattr(axes, f"set_{direction}ticks")(places, names)
    elif axis.logarithmic:
        getattr(axes, f"set_{direction}scale")("log")
        plain_ticks(getattr(axes, f"{direction}axis"))


def logarithmic(values: np.ndarray) -> bool:
    """Whether positive values span so much that a linear scale would hide the small ones."""
    finite = values[np.isfinite(values)]
    return bool(finite.size and finite.min() > 0.0 and finite.max() > WIDE * finite.min())


def failure_marks(sweep: SweepView, points: np.ndarray) -> list[Mark]:
    """Marks of the failed points among `points`, one for each of the most frequent causes."""
    shown_points = np.ravel(points)
    found = []
    for cause in causes(sweep):
        inside = cause.points[np.isin(cause.points, shown_points)]
        if inside.size:
            found.append((cause, inside))
    named = len(found) if len(found) <= len(_MARKS) else len(_MARKS) - 1
    marks = [_mark(place, cause, inside) for place, (cause, inside) in enumerate(found[:named])]
    if len(found) > named:
        rest = np.concatenate([inside for _, inside in found[named:]])
        words = f"{many(rest.size, 'point')} of {len(found) - named} other causes"
        marks.append(Mark(rest, *_MARKS[2], words))
    return marks


def entry_words(counted: Worst, points: np.ndarray) -> str:
    """Which of several entries count over some points: `largest: mount=1`."""
    if len(counted.labels) < 2:
        return ""
    places = np.ravel(points)
    places = places[~np.isnan(counted.values[places])]
    used = [counted.labels[i] for i in np.unique(counted.entry[places])]
    if len(used) > 2:
        return f"largest of {len(counted.labels)} entries"
    return "largest: " + " or ".join(used)


def limit_words(limit: Limit) -> str:
    """`max 100 N`."""
    return f"{limit.side} {limit.shown}"


def best_words(sweep: SweepView, limit: Limit, point: int) -> str:
    """What the star is: the point and its value."""
    sense = "smallest" if limit.side == "max" else "largest"
    factor, unit = shown_unit(limit.quantity, limit.unit, limit.worst.values)
    value = show(factor * limit.worst.values[point], digits=4)
    text = f"{sense} {short_name(limit.quantity)} within all limits, {value} {unit}"
    return textwrap.fill(unit_words(f"{text}: {sweep.words_of(point)}")[1], 95)


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


def hatch_style() -> dict[str, Any]:
    """The infeasible side of a limit."""
    return {"facecolor": "none", "edgecolor": LIMIT, "hatch": "//", "linewidth": 0.0, "alpha": 0.35}


def _mark(place: int, cause: Cause, inside: np.ndarray) -> Mark:
    words = f"{many(inside.size, 'point')}: {cause.title}"
    return Mark(inside, *_MARKS[place], textwrap.shorten(words, _WORDS, placeholder=" ..."))
