"""Twist of every section of a shaft line against speed beside that of the same line otherwise."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels, speed_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, plain_log
from vibecalc.report.pictures.torsion_excitation import misfire_words
from vibecalc.report.pictures.torsion_summits import through, top_of
from vibecalc.report.sections.torsion_terms import MILLI, TORSION, names, place_of
from vibecalc.results.record import Quantity, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LOAD = "twist_half_range"
_COLUMNS, _MOST = 3, 9
#: letters of a name beside which there is room for two values
_SHORT = 16
#: ratio of the curves from which on the axes are logarithmic
_FAR = 6.0
#: where the other line stands, its look, and how it is named
_OTHERS = (
    ("bare/", QUIET, "--", "without dampers"),
    ("healthy/", COLOURS[2], "-", "all cylinders fire"),
)


def picture(result: Result) -> "Figure | None":
    """A panel for each section, at most nine; None where there is nothing to compare with."""
    record = result.record
    own = having(record, f"{TORSION}speeds/{_LOAD}", "section", "speed")
    beside: list[tuple[Quantity, str, str, str, str]] = []
    for root, *look in _OTHERS:
        other = having(record, f"{TORSION}{root}speeds/{_LOAD}", "section", "speed")
        if other is not None:
            beside.append((other, root, look[0], look[1], look[2]))
    if own is None or not beside:
        return None
    known = {name for one in beside for name in labels(one[0].axes[0])}
    hung = names(record, "damper/travel", "damper")
    sections = [name for name in labels(own.axes[0]) if name in known and name not in hung]
    values = np.asarray(own.values, dtype=float)
    tops = {name: _finite(values[place_of(own, name) or 0]) for name in sections}
    most = sorted(sections, key=lambda name: -tops[name])[:_MOST]
    shown = [name for name in sections if name in most]
    if not shown:
        return None
    speed = np.asarray(own.axes[1].values, dtype=float)
    rows = -(-len(shown) // _COLUMNS)
    words = ["twist of the sections against speed, half range of all orders",
             *misfire_words(result)]  # fmt: skip
    figure = canvas(result, ", ".join(words), 10.4, 1.4 + 2.5 * rows)
    grid = figure.subplots(rows, min(_COLUMNS, len(shown)), sharex=True, sharey=True, squeeze=False)
    damped = "with dampers" if any(one[1] == "bare/" for one in beside) else "as it is"
    if misfire_words(result) and damped == "as it is":
        damped = misfire_words(result)[0]
    own_curves, highest = [], []
    for axes, name in zip(grid.ravel(), shown, strict=False):
        curves = [np.zeros(1)]
        for quantity, root, colour, style, label in beside:
            place = place_of(quantity, name)
            if place is not None:
                curve = np.asarray(quantity.values, dtype=float)[place]
                x, y = through(speed, curve, top_of(record, name, _LOAD, root))
                axes.plot(rpm(1.0) * x, MILLI * y, style, color=colour, linewidth=1.2, label=label)
                curves.append(MILLI * y)
        x, y = through(speed, values[place_of(own, name) or 0], top_of(record, name, _LOAD))
        axes.plot(rpm(1.0) * x, MILLI * y, color=TOTAL, linewidth=1.6, label=damped)
        told = f"{name}: largest {show(_finite(MILLI * y), digits=3)} mrad"
        bare = top_of(record, name, _LOAD, "bare/").height
        if bare.size and len(name) <= _SHORT:
            told += f", without {show(MILLI * float(bare[0]), digits=3)}"
        axes.set_title(told, loc="left", fontsize=8.5)
        own_curves.append(MILLI * y)
        highest.append(np.concatenate(curves))
        operating = speed_of(result)
        if operating is not None and speed[0] <= operating <= speed[-1]:
            axes.axvline(rpm(operating), color=LIMIT, linewidth=0.9, linestyle=":",
                         label="operating speed")  # fmt: skip
        axes.set_xlim(rpm(speed[0]), rpm(speed[-1]))
    _height(grid[0, 0], own_curves, highest)
    for place, axes in enumerate(grid.ravel()):
        axes.set_visible(place < len(shown))
        if place + grid.shape[1] >= len(shown):
            axes.set_xlabel("crank speed in rpm")
            axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel("twist in mrad")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4,
                  fontsize=9)  # fmt: skip
    return figure


def _height(axes: "Axes", own: list[np.ndarray], others: list[np.ndarray]) -> None:
    """One height for all panels, logarithmic where curves or sections are far apart."""
    highs, fars = [_finite(one) for one in own], [_finite(one) for one in others]
    far = max([*highs, *fars]) or 1.0
    low = min(float(np.min(one[one > 0.0], initial=np.inf)) for one in [*own, *others])
    apart = any(b > _FAR * a > 0.0 for a, b in zip(highs, fars, strict=True))
    if (apart or max(highs) > _FAR * min(highs) > 0.0) and low < far:
        plain_log(axes, max(0.7 * low, 1e-4 * far), 1.5 * far)
    else:
        axes.set_ylim(0.0, 1.06 * far)


def _finite(values: np.ndarray) -> float:
    return float(np.max(values[np.isfinite(values)], initial=0.0))
