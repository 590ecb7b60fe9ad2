"""Marks of a picture that name places: the highest point, resonances, names above the axes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vibecalc.core.report.canvas import LIMIT, PLATE, QUIET, TOTAL, bounds_of, keep_apart, note
from vibecalc.core.report.curves import SLOW, Mark, Plot
from vibecalc.core.report.sources import across, sourced
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Record

#: ratio of places below which two marks have no room for words of their own
_CLOSE = 1.18
#: of the axis, beyond which words stand at the left of their dot
_RIGHT = 0.7
#: of the width of a picture, the least distance of two names above axes
_APART = 0.03
#: points of room for such names between the axes and their title
_ROOM = 70.0
#: of the height of a curve, how near a limit leaves no room for words between them
_TIGHT = 0.1


def peak(
    of: str = "", at: str = "", colour: str = TOTAL, below: bool = False, unless: str = ""
) -> Mark:
    """A dot at the largest of the last curve, or of the values at `of` and `at`, with its words.

    It is red beyond a limit of the case on `of`. Where there is anything at `unless` it has none.
    """

    def draw(plot: Plot) -> None:
        top, place = (plot.result.record.quantities.get(path) for path in (of, at))
        x, y = plot.drawn[-1]
        if top is not None and place is not None:
            x, _ = across(replace(plot.axis, values=np.ravel(place.values)))
            y = plot.factor * np.ravel(top.values)
        i = int(np.argmax(np.nan_to_num(y)))
        here, height = float(x[i]), float(y[i])
        if not np.isfinite(height) or height <= 0.0 or sourced(unless, plot.result):
            return
        bounds = [plot.factor * bound for _, bound in bounds_of(plot.result, of)]
        over = any(height > bound for bound in bounds)
        # the words of a limit stand above its line
        under = below or any(abs(bound - height) < _TIGHT * height for bound in bounds)
        plot.axes.plot([here], [height], "o", color=LIMIT if over else colour, zorder=5)
        ends = plot.drawn[0][0][[0, -1]]
        if "x" in plot.panel.log:
            ends, spot = np.log(np.maximum(ends, SLOW * ends[1])), np.log(here)
        else:
            spot = here
        left = spot - ends[0] > _RIGHT * (ends[1] - ends[0])
        unit = across(plot.axis)[1].rpartition(" in ")[2]
        words = f"{show(height, digits=4)} {plot.unit} at {show(here, digits=4)} {unit}"
        note(plot.axes, words, (here, height), (-8 if left else 8, -3 if under else 3), zorder=6,
             ha="right" if left else "left", va="top" if under else "bottom", color=colour,
             bbox=PLATE)  # fmt: skip

    return draw


def first_of(record: Record, *paths: str) -> np.ndarray:
    """Values (n,) at the first of the paths that a result has; none without any."""
    values = next((record[path].values for path in paths if path in record), np.zeros(0))
    return np.atleast_1d(np.asarray(values, dtype=float))


def resonances(*paths: str) -> Mark:
    """Lines where order 1 or 2 meets a natural frequency, of the first of `paths` that is there.

    Close ones of an order share their words, which stand above the axes.
    """

    def draw(plot: Plot) -> None:
        modes, speed = rpm(1.0) * first_of(plot.result.record, *paths), plot.drawn[0][0]
        named: list[tuple[float, str]] = []
        label: str | None = "resonance, mode / order" if len(modes) > 1 else "resonance"
        for order in (1, 2):
            groups: list[list[int]] = []
            inside = (speed.min() < modes / order) & (modes / order < speed.max())
            for i in np.flatnonzero(inside).tolist():
                plot.axes.axvline(modes[i] / order, color=QUIET, ls=":", lw=1.0, zorder=0,
                                  label=label)  # fmt: skip
                label = None
                if groups and modes[i] < _CLOSE * modes[groups[-1][0]]:
                    groups[-1].append(i)
                else:
                    groups.append([i])
            for first, *_, last in ([*group, group[-1]] for group in groups):
                which = f"mode{'s' * (last > first)} {first + 1}"
                which += f"{' to ' if last > first + 1 else ', '}{last + 1}" * (last > first)
                words = f"{which} / {order}" if len(modes) > 1 else f"order {order}"
                named.append((float(modes[first] / order), words))
        if named:
            at, every = zip(*sorted(named), strict=True)
            name_above(plot, np.array(at), every, QUIET)

    return draw


def name_above(
    plot: Plot, at: np.ndarray, words: Sequence[str], colour: str, tops: np.ndarray | None = None
) -> None:
    """Names of ascending places above the axes, each with a line to its top, or to the edge."""
    axes, (x, _), log = plot.axes, plot.drawn[0], "x" in plot.panel.log
    edge, low = axes.get_xaxis_transform(), max(x[0], SLOW * x[-1]) if log else x[0]
    grid = axes.get_subplotspec()
    room = _APART * (1 if grid is None else grid.get_gridspec().ncols)
    straight, back = (np.log, np.exp) if log else (np.asarray, np.asarray)
    places = back(spread(straight(at), (float(straight(low)), float(straight(x[-1]))), room))
    plot.pad = _ROOM
    axes.set_title(axes.get_title(loc="left"), loc="left", pad=plot.pad)
    for where, top, place, one in zip(
        at, np.ones(len(at)) if tops is None else tops, places, words, strict=True
    ):
        axes.annotate(
            one, (where, top), xycoords=edge if tops is None else "data", xytext=(place, 1.02),
            textcoords=edge, rotation=90, ha="center", va="bottom", fontsize=8, color=colour,
            annotation_clip=False, arrowprops={
                "arrowstyle": "-", "linewidth": 0.6, "linestyle": ":", "shrinkA": 1.5,
                "shrinkB": 3.0, "relpos": (0.5, 0.0), "color": colour,
            },
        )  # fmt: skip


def spread(at: np.ndarray, ends: tuple[float, float], apart: float = _APART) -> np.ndarray:
    """Places near `at` (ascending) within the ends that leave room for a name each."""
    room = min(apart, 1.0 / max(len(at) - 1, 1)) * (ends[1] - ends[0])
    steps = room * np.arange(len(at))
    return np.asarray(np.clip(keep_apart(at, room), ends[0] + steps, ends[1] - steps[::-1]))
