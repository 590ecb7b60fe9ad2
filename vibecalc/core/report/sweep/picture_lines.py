"""Results of a sweep along one axis, a line for each value of a short second one."""

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import LIMIT, QUIET, keep_apart, note, unit_words
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot, rows_of, usual_ends
from vibecalc.core.report.marks import resonances
from vibecalc.core.report.sources import Ends
from vibecalc.core.report.sweep.picture_parts import (
    BEST,
    FEW,
    Picture,
    Shown,
    along,
    axis_title,
    entry_words,
    is_map,
    logarithmic,
    pictured,
)
from vibecalc.core.report.sweep.statistics import entries
from vibecalc.core.report.sweep.view import SweepView
from vibecalc.core.report.writing import rpm
from vibecalc.core.results.record import Axis, Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST = 6
#: a limit further beyond the data than this is said, not drawn
_FAR = 4.0
#: ratio of the ends of an axis to what is usual, where results are unbounded at resonances
_FAR_FLANK = 30.0
#: entries of these axes are alike; those of others get a line each if they are few
_ALIKE = ("order", "direction", "mount", "cylinder", "coordinate", "crank_angle", "mode")
_ENTRIES = 4
#: levels are not alike: one may fall by 10 dB below another; their names stand at the end
_LEVELS = 12
#: least distance of two names, as a share of the height of a panel
_APART = 0.042
#: standard errors of more points than these are a band; points up to which they are drawn
_DENSE, _SEEN = 30, 40
_SPEED, _MODES = "machine.speed", "modes/natural_frequency"


def draw_sweep_line(sweep: SweepView) -> "Figure | None":
    """A panel for each result that varies; None for samplings and for two long axes."""
    picture = pictured(sweep, FEW, _MOST) if sweep.grid and not is_map(sweep) else None
    if picture is None:
        return None
    # a case that is a sweep says it in its title already
    title = str(sweep.case.get("title") or "")
    over = "" if {"over", "against"} & {*title.split()} else f"over {picture.grid[0].keys[0].label}"
    panels = tuple(_panel(picture, one) for one in picture.shown)
    below = 1 if picture.star or picture.marks else 3
    words = "; ".join(filter(None, (over, picture.held)))
    return Curves(words, panels, high=3.3, columns=2, names=below)(_constant(picture))


def _constant(picture: Picture) -> Result:
    """What does not vary along a picture: its title and, over the speed, natural frequencies.

    A suspension that changes with what else is swept has no one place to mark.
    """
    sweep, key, record = picture.sweep, picture.grid[0].keys[0], Record()
    path = next((path for path in sweep.quantities if path.endswith(_MODES)), None)
    if path is not None and key.key == _SPEED:
        known = entries(sweep, path)[0][np.ravel(picture.points)]
        known = known[~np.isnan(known).any(axis=1)]
        if len(known) and np.all(np.ptp(known, axis=0) <= 1e-6 * np.abs(known[0])):
            # in the unit of the axis, whatever that is
            modes = np.sort(known[0]) * key.factor / rpm(1.0)
            axes = sweep.quantities[path].axes
            record.add(Quantity(path=_MODES, values=modes, unit="rad/s", long_name="", axes=axes))
    return Result(
        name=sweep.name, case={"title": sweep.case.get("title")}, record=record, version="",
        case_toml="", case_toml_resolved="", case_sha256="",
    )  # fmt: skip


def _panel(picture: Picture, one: Shown) -> Panel:
    sweep, axis = picture.sweep, picture.grid[0]
    key, x = axis.keys[0], along(axis)
    numbers = picture.points.reshape(len(x), -1).T
    values, names, words, notes = one.values[numbers], [""], "", [entry_words(one.worst, numbers)]
    separate = _separate(picture, one)
    if separate is not None:
        values, names = separate
        words, notes = "{}", []
    elif len(picture.grid) > 1:
        second = picture.grid[1].keys[0]
        names = [unit_words(second.shown(value))[1] for value in picture.grid[1].table[:, 0]]
        words = f"{second.label} = {{}}"
    if at_end := separate is not None and len(names) > _ENTRIES:
        words, notes = "", [f"{sweep.quantities[one.path].axes[0].name} at the right"]
    if one.worst.spread is not None:
        notes.append(f"{'bars' if x.size <= _DENSE else 'band'}: standard error")
    places, values = _with_gaps(sweep, x, numbers, values)
    choices = np.array([key.shown(value) for value in axis.table[:, 0]], dtype=object)
    along_x = Axis(
        name=key.key, values=choices if key.choices else places, unit="", long_name=key.label
    )
    lines = Axis(name="line", values=np.array(names, dtype=object))
    drawn = Quantity(path="", values=values, unit="", long_name="", axes=(lines, along_x))
    look = {"marker": "o" if x.size <= _SEEN else "", "ms": 4}
    look |= {"linestyle": "none"} if key.choices else {}

    def marks(plot: Plot) -> None:
        axes = plot.axes
        if one.worst.spread is not None:
            for i, (_, row, (line,)) in enumerate(rows_of(drawn, _LEVELS, np.real)):
                spread = one.factor * one.worst.spread[numbers[line]]
                _spread(axes, x, row, spread, plot.looks[i][0])
        unbounded = places[np.isinf(values).any(axis=0)]
        foot = axes.get_xaxis_transform()
        if unbounded.size:
            axes.plot(unbounded, np.full(unbounded.size, 0.97), "^", color=LIMIT, transform=foot,
                      label="unbounded", clip_on=False, zorder=5)  # fmt: skip
        for mark in picture.marks:
            up, across = np.nonzero(np.isin(numbers, mark.points))
            # one row of crosses for each line
            axes.plot(x[across], 0.04 + 0.05 * up, mark.marker, color=mark.colour, ms=8, mew=1.8,
                      transform=foot, label=mark.words, zorder=6)  # fmt: skip
        if picture.star is not None:
            point, at, label = picture.star
            axes.plot(at[:1], [one.values[point]], **BEST, label=label)
        if picture.here is not None and len(picture.axes) == 1:
            axes.axvline(picture.here[0], color="black", ls="--", lw=1.0,
                         label="the case as written")  # fmt: skip
        _limits(plot, x, one, numbers, values)
        if at_end:
            _name_ends(plot, drawn)

    curve = Curve(lambda _: drawn, words, look, most=_LEVELS, part=np.real)
    return Panel(
        one.label, (curve, marks, resonances(_MODES)), one.title(*notes),
        log="x" if axis.logarithmic else "", below=axis_title(axis),
        ends=_flanks if np.isinf(values).any() else (None, None),
    )  # fmt: skip


def _flanks(plot: Plot) -> Ends:
    """On a logarithmic axis, decades about what is usual: flanks of a resonance have no end."""
    return usual_ends(plot, far=_FAR_FLANK) if plot.axes.get_yscale() == "log" else (None, None)


def _with_gaps(
    sweep: SweepView, x: np.ndarray, numbers: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places and values (lines, x), infinite also between two points where a line is unbounded."""
    without = np.zeros(values.shape, dtype=bool)  # a bound after this point
    everywhere = np.broadcast_to(numbers, values.shape)
    for gap, points, row in zip(without, everywhere, values, strict=True):
        whole = np.full(sweep.count, np.nan)
        whole[points] = row
        pairs = [one.pair for one in sweep.crossings if one.bare and one.peaks(whole)]
        gap[:-1] = [pair in pairs for pair in pairwise(points.tolist())]
    after = np.flatnonzero(without.any(axis=0))
    middle = 0.5 * (values[:, after] + values[:, after + 1])
    middle[without[:, after]] = np.inf
    return (
        np.insert(x, after + 1, 0.5 * (x[after] + x[after + 1])),
        np.insert(values, after + 1, middle, axis=1),
    )


def _spread(axes: "Axes", x: np.ndarray, y: np.ndarray, spread: np.ndarray, colour: str) -> None:
    if x.size <= _DENSE:
        axes.errorbar(x, y, spread, fmt="none", ecolor=colour, capsize=4)
    else:
        axes.fill_between(x, y - spread, y + spread, color=colour, alpha=0.2, linewidth=0.0)


def _separate(picture: Picture, one: Shown) -> tuple[np.ndarray, list[str]] | None:
    """Entries (lines, x) that are unlike each other and few, where nothing else has lines."""
    quantity = picture.sweep.quantities[one.path]
    own, levels = quantity.axes, quantity.unit == "dB"
    if len(picture.axes) > 1 or len(own) != 1 or (own[0].name in _ALIKE and not levels):
        return None
    if not 2 <= len(own[0].values) <= (_LEVELS if levels else _ENTRIES):
        return None
    values, names = entries(picture.sweep, one.path)
    return values[picture.points].T * one.factor, list(names)


def _limits(plot: Plot, x: np.ndarray, one: Shown, numbers: np.ndarray, values: np.ndarray) -> None:
    """Limits, unless they are so far beyond all values that they are only said; a scale with room
    for both; error bars where they reach over a limit."""
    axes, finite = plot.axes, values[np.isfinite(values)]
    reach = _FAR * float(np.max(np.abs(finite)))
    bounds, far = [], list[str]()
    for limit in one.limits:
        bound = limit.bound * one.factor
        if abs(bound) <= reach or np.any(limit.broken | limit.open):
            bounds.append(bound)
            plot.limit(limit.words, bound)
        else:
            far.append(limit.words)
        rows, columns = np.nonzero(limit.open[numbers])
        if rows.size:
            points = numbers[rows, columns]
            value, error = (one.factor * part[points] for part in limit.worst[:2])
            axes.errorbar(x[columns], value, error, fmt="none", ecolor=QUIET, capsize=3,
                          label="error where it reaches over a limit: undecided")  # fmt: skip
    if far:
        axes.annotate(f"limit {', '.join(far)}: kept everywhere", (0.02, 0.97),
                      xycoords="axes fraction", va="top", color=LIMIT, fontsize=8)  # fmt: skip
    if logarithmic(finite) and min(bounds, default=1.0) > 0.0:
        axes.set_yscale("log")


def _name_ends(plot: Plot, lines: Quantity) -> None:
    """Names behind the last finite value of each line, shifted apart where these come close."""
    axes, x = plot.axes, plot.drawn[0][0]
    found: list[tuple[float, float, str, str]] = []
    for i, (names, y, _) in enumerate(rows_of(lines, _LEVELS, np.real)):
        words = ", ".join(name.split("=")[-1] for name in names)
        for end in np.flatnonzero(np.isfinite(y))[-1:]:
            pixel = axes.transData.transform((x[end], y[end]))
            height = float(axes.transAxes.inverted().transform(pixel)[1])
            found.append((height, float(x[end]), words, plot.looks[i][0]))
    found.sort()
    heights = keep_apart(np.array([height for height, *_ in found]), _APART)
    for height, (_, end, words, colour) in zip(heights, found, strict=True):
        note(axes, words, (end, height), (5, 0), xycoords=("data", "axes fraction"), va="center",
             color=colour, annotation_clip=False)  # fmt: skip
