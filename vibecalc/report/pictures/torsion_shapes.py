"""Mode shapes along a shaft line: one row for each mode, branches beside the main line."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.numbers import hertz, show
from vibecalc.report.pictures.canvas import COLOURS, QUIET, TOTAL, canvas
from vibecalc.report.sections.torsion_terms import TORSION, elastic_modes, line_of
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibecalc.machine.shaft_line import ShaftLine

_MOST, _MOST_NAMES = 5, 24
#: rigid gears and elastic teeth are steps of the own angle, drawn otherwise than shafts
_GEAR = ":"


def picture(result: Result) -> "Figure | None":
    """Own angles of stations and rings over the line; None without shapes."""
    shape = having(result.record, TORSION + "modes/shape", "mode", "station")
    natural = having(result.record, TORSION + "modes/natural_frequency", "mode")
    line, modes = line_of(result), elastic_modes(result)[:_MOST]
    if shape is None or natural is None or line is None or not modes:
        return None
    rings = having(result.record, TORSION + "modes/ring_shape", "mode", "damper")
    # of complex shapes what is seen where the largest station has its crest
    values = np.real(shape.values)
    if rings is not None:
        values = np.hstack([values, np.real(rings.values)])
    paths = strands(line, values.shape[1])
    names = [*line.station_names, *(one.name for one in line.dampers)]
    widths = [len(path) + 0.5 for path in paths]
    most = max(len(name) for name in names)
    height = 2.0 + 1.35 * len(modes) + 0.07 * most
    figure = canvas(result, "mode shapes, own angles of the stations", 9.6, height)
    grid = figure.subplots(
        len(modes), len(paths), sharey=True, sharex="col", squeeze=False, width_ratios=widths
    )
    frequencies = np.asarray(natural.values, dtype=float)
    for mode, row in zip(modes, grid, strict=True):
        for path, axes in zip(paths, row, strict=True):
            _strand(axes, line, path, values[mode], COLOURS[modes.index(mode) % len(COLOURS)])
        words = f"mode {mode + 1}: {show(hertz(frequencies[mode]), digits=5)} Hz"
        row[0].set_title(words, loc="left", fontsize=10)
        row[0].set_ylabel("angle")
        reach = 1.25 * max(1.0, float(np.max(np.abs(values[modes]))))
        row[0].set_ylim(-reach, reach)
    for path, axes in zip(paths, grid[-1], strict=True):
        _name(axes, [names[one] for one in path])
    for path, axes in zip(paths[1:], grid[0][1:], strict=True):
        axes.set_title(f"from {names[path[0]]}", loc="right", fontsize=9, color=QUIET)
    return figure


def strands(line: "ShaftLine", count: int) -> list[list[int]]:
    """The line as paths of stations (rings behind them): the longest, then what branches off it.

    Each branch begins with the place it hangs on. Loops of shafts are opened somewhere.
    """
    beside: dict[int, list[int]] = {place: [] for place in range(count)}
    for first, second in _joints(line, count):
        beside[first].append(second)
        beside[second].append(first)
    free, found = set(range(count)), []
    path = _longest(beside, _longest(beside, [0], free)[-1:], free)
    ends = [_station(line, place) for place in (path[0], path[-1])]
    path = path[::-1] if ends[0] > ends[1] else path
    while path:
        found.append(path)
        free -= set(path)
        starts = [one for one in range(count) if one not in free and set(beside[one]) & free]
        if not starts:
            break
        best = max(
            (_longest(beside, [start, next_], free) for start in starts
             for next_ in beside[start] if next_ in free), key=len,
        )  # fmt: skip
        path = best
    return found


def _station(line: "ShaftLine", place: int) -> int:
    """The station itself, or the one that carries the ring."""
    stations = len(line.station_names)
    return place if place < stations else line.dampers[place - stations].station


def _joints(line: "ShaftLine", count: int) -> list[tuple[int, int]]:
    stations = len(line.station_names)
    pairs = [(int(a), int(b)) for a, b in line.section_ends if b >= 0]
    pairs += [(gear.first, gear.second) for gear in line.gears if gear.element < 0]
    pairs += [(one.station, stations + place) for place, one in enumerate(line.dampers)]
    return [(a, b) for a, b in pairs if max(a, b) < count]


def _longest(beside: dict[int, list[int]], begun: list[int], free: set[int]) -> list[int]:
    """The longest way on from the end of `begun`, breadth first through places in `free`."""
    before: dict[int, int | None] = {begun[-1]: None}
    queue = [begun[-1]]
    for place in queue:
        for other in beside[place]:
            if other not in before and other in free and other not in begun:
                before[other] = place
                queue.append(other)
    way: list[int] = []
    at: int | None = queue[-1]
    while at is not None:
        way.append(at)
        at = before[at]
    return begun[:-1] + way[::-1]


def _strand(
    axes: "Axes", line: "ShaftLine", path: list[int], values: np.ndarray, colour: str
) -> None:
    geared = {frozenset((gear.first, gear.second)) for gear in line.gears}
    row, x = values[path], np.arange(len(path))
    axes.axhline(0.0, color=TOTAL, linewidth=0.8)
    axes.vlines(x, 0.0, row, color=colour, linewidth=0.8, alpha=0.5)
    for i in range(len(path) - 1):
        style = _GEAR if frozenset(path[i : i + 2]) in geared else "-"
        axes.plot(x[i : i + 2], row[i : i + 2], style, color=colour)
    ring = np.array([place >= len(line.station_names) for place in path])
    axes.plot(x[~ring], row[~ring], "o", color=colour, ms=4)
    axes.plot(x[ring], row[ring], "o", color=colour, ms=7, markerfacecolor="white")
    axes.set_xlim(-0.4, len(path) - 0.6)


def _name(axes: "Axes", names: list[str]) -> None:
    step = max(1, -(-len(names) // _MOST_NAMES))
    axes.set_xticks(range(0, len(names), step))
    axes.set_xticklabels(names[::step], rotation=90, fontsize=8)
