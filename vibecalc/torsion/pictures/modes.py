"""Pictures of the modes of a shaft line: shapes along it, Campbell diagram; sketch of the line."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, QUIET, TOTAL, canvas, note, ticks
from vibecalc.core.report.sections import having, speed_of, table_of
from vibecalc.core.report.writing import hertz, rpm, short, show, turns
from vibecalc.core.results.record import Quantity, Result
from vibecalc.torsion.report.excitation import strongest_orders
from vibecalc.torsion.report.line import (
    TORSION,
    elastic_modes,
    has_pendulums,
    line_of,
    mode_names,
    order_text,
    speed_range,
    vector,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibecalc.torsion.model import ShaftLineModel


# ----------------------------------------------------------------------------
# Mode shapes along a shaft line: one row for each mode, branches next to the main line.
# ----------------------------------------------------------------------------

_MOST, _MOST_NAMES = 5, 24
#: rigid gears and elastic teeth are steps of the own angle, drawn otherwise than shafts
_GEAR = ":"
#: half the height of a mode, of the distance of two
_HALF = 0.36
_ROUNDING = 1e-9


def draw_torsion_shapes(result: Result) -> "Figure | None":
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
    figure = canvas(result, "mode shapes, actual angles of the stations", height)
    grid = figure.subplots(1, len(paths), sharey=True, squeeze=False, width_ratios=widths)[0]
    frequencies, known = np.asarray(natural.values, dtype=float), mode_names(result)
    reach = [_HALF / max(1.0, float(np.max(np.abs(values[mode])))) for mode in modes]
    for path, axes in zip(paths, grid, strict=True):
        for place, mode in enumerate(modes):
            colour = COLOURS[place % len(COLOURS)]
            _strand(axes, line, path, reach[place] * values[mode], -place, colour)
        axes.set_xlim(-0.4, len(path) - 0.6)
        _name(axes, [names[one] for one in path])
    first = grid[0]
    for place, mode in enumerate(modes):
        words = f"{known[mode]}: {show(hertz(frequencies[mode]))} Hz"
        note(first, words, (0.0, -place + _HALF), (4, 5), xycoords=first.get_yaxis_transform(),
             fontsize=9)  # fmt: skip
    marked = [(sign * _mark(_HALF / one), one) for one in reach for sign in (-1.0, 0.0, 1.0)]
    ticks(first.yaxis, [one * size - i // 3 for i, (size, one) in enumerate(marked)],
          [f"{size:g}".replace("-", "\u2212") for size, _ in marked])  # fmt: skip
    first.set_ylim(0.55 - len(modes), 0.65)
    first.set_ylabel("angle")
    for path, axes in zip(paths[1:], grid[1:], strict=True):
        axes.set_title(f"from {names[path[0]]}", loc="right", fontsize=8, color=QUIET)
    return figure


def _mark(size: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is no larger than `size`, at least 1."""
    power = 10.0 ** math.floor(math.log10(size * (1.0 + _ROUNDING)))
    return power * max(one for one in (1.0, 2.0, 5.0) if one * power <= size * (1.0 + _ROUNDING))


def strands(line: "ShaftLineModel", count: int) -> list[list[int]]:
    """The line as paths of stations (rings behind them): the longest, then what branches off it.

    Each branch begins with the place it hangs on. Loops of shafts are opened somewhere.
    """
    stations = len(line.station_names)
    # the station itself, or the one that carries the ring
    carrier = [*range(stations), *(one.station for one in line.dampers)]
    pairs = [(int(a), int(b)) for a, b in line.section_ends if b >= 0]
    pairs += [(gear.first, gear.second) for gear in line.gears if gear.element < 0]
    pairs += [(one.station, stations + place) for place, one in enumerate(line.dampers)]
    nearby: dict[int, list[int]] = {place: [] for place in range(count)}
    for first, second in pairs:
        if max(first, second) < count:
            nearby[first].append(second)
            nearby[second].append(first)
    free, found = set(range(count)), []
    path = _longest(nearby, _longest(nearby, [0], free)[-1:], free)
    path = path[::-1] if carrier[path[0]] > carrier[path[-1]] else path
    while path:
        found.append(path)
        free -= set(path)
        branches = (
            _longest(nearby, [start, next_], free)
            for start in range(count) if start not in free
            for next_ in nearby[start] if next_ in free
        )  # fmt: skip
        path = max(branches, key=len, default=[])
    return found


def _longest(nearby: dict[int, list[int]], begun: list[int], free: set[int]) -> list[int]:
    """The longest way on from the end of `begun`, breadth first through places in `free`."""
    queue, met = [begun], {*begun}
    for way in queue:
        for other in nearby[way[-1]]:
            if other in free and other not in met:
                met.add(other)
                queue.append([*way, other])
    return queue[-1]


def _strand(
    axes: "Axes", line: "ShaftLineModel", path: list[int], values: np.ndarray, level: float,
    colour: str,
) -> None:  # fmt: skip
    """The values of a mode along a path about the height `level`."""
    geared = {frozenset((gear.first, gear.second)) for gear in line.gears}
    row, x = level + values[path], np.arange(len(path))
    axes.axhline(level, color=TOTAL, linewidth=0.8)
    axes.vlines(x, level, row, color=colour, linewidth=0.8, alpha=0.5)
    teeth = np.array([frozenset(pair) in geared for pair in pairwise(path)], dtype=bool)
    for style, drawn in (("-", ~teeth), (_GEAR, teeth)):
        if drawn.any():
            # from each place to the next one where the line is drawn so, and a gap
            gapped = [np.stack([one[:-1], one[1:], np.nan * one[1:]], axis=1)[drawn].ravel()
                      for one in (1.0 * x, row)]  # fmt: skip
            axes.plot(*gapped, style, color=colour)
    ring = np.array([place >= len(line.station_names) for place in path])
    axes.plot(x[~ring], row[~ring], "o", color=colour, ms=4)
    if ring.any():
        axes.plot(x[ring], row[ring], "o", color=colour, ms=7, markerfacecolor="white")


def _name(axes: "Axes", names: list[str]) -> None:
    step = max(1, -(-len(names) // _MOST_NAMES))
    ticks(axes.xaxis, range(0, len(names), step), names[::step])
    axes.tick_params(axis="x", labelrotation=90)


# ----------------------------------------------------------------------------
# Campbell diagram: natural frequencies of a shaft line and orders against the crank speed.
# ----------------------------------------------------------------------------

#: of the height of the picture, the least distance of two words at its edge
_APART = 0.026
#: and of its width, at its upper edge
_APART_ABOVE = 0.042
_ROOM = 1.12
#: excited orders up to which all are drawn, also those that cross no mode within the range
_FEW = 5


def draw_torsion_campbell(result: Result) -> "Figure | None":
    """Hz and cpm over rpm, order lines named at their ends, crossings dotted, major ones filled."""
    natural = having(result.record, TORSION + "modes/natural_frequency", "mode")
    critical = having(result.record, TORSION + "critical/speed", "mode", "order")
    # where pendulums make natural frequencies depend on the speed
    course = having(result.record, TORSION + "campbell/natural_frequency", "mode", "speed")
    modes, (low, high) = elastic_modes(result), speed_range(result)
    if natural is None or critical is None or not modes or high <= 0.0:
        return None
    frequency = hertz(1.0) * np.asarray(natural.values, dtype=float)[modes]
    right, top = rpm(high) * 1.04, _ROOM * float(frequency[-1])
    chosen, major, lines = _chosen(result, modes)
    words = "Campbell diagram with the "
    words += "major orders and the five strongest" if major.any() else "five strongest orders"
    words += " of each mode"
    if course is None and has_pendulums(result):
        words += ", natural frequencies at the operating speed (they vary with speed: pendulums)"
    figure = canvas(result, words, 7.0)
    axes = figure.subplots()
    axes.set(xlim=(0.0, right), ylim=(0.0, top), xlabel="crank speed in rpm",
             ylabel="frequency in Hz")  # fmt: skip
    axes.grid(False)
    draw_orders(axes, critical.axes[1].values[lines], major[lines], right, top)
    colours = [COLOURS[i % len(COLOURS)] for i in range(len(modes))]
    aside, below, known = 0, -top, mode_names(result)
    for mode, value, colour in zip(modes, frequency, colours, strict=True):
        if course is None:
            axes.axhline(value, color=colour, linewidth=1.8)
        else:
            axes.axhline(value, color=colour, linewidth=0.6, alpha=0.4)
            axes.plot(rpm(1.0) * course.axes[1].values, hertz(1.0) * course.values[mode],
                      color=colour)  # fmt: skip
        # the names of modes that lie close stand side by side
        aside = aside + 1 if value - below < 1.4 * _APART * top else 0
        below = value
        note(axes, f"{known[mode]}: {show(float(value))} Hz", (0.0, value), (4 + 92 * aside, 5),
             color=colour, zorder=4, bbox=PLATE)  # fmt: skip
    _crossings(axes, critical, modes, colours, chosen & ~major, chosen & major)
    if table_of(result.case, "response", "torsion", "speeds"):
        axes.axvspan(rpm(low), rpm(high), color="#0072B2", alpha=0.07, label="speed range")
    speed = speed_of(result)
    if speed is not None:
        words = f"operating speed {turns(speed)} rpm"
        axes.axvline(rpm(speed), color=LIMIT, linestyle="--", linewidth=1.3, label=words)
    # the words of the orders stand at the right, so that cycles per minute get room beyond them
    cpm = axes.secondary_yaxis(1.09, functions=(_to_cpm, _to_hertz))
    cpm.set_ylabel("frequency in cpm")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.035), ncols=4)
    return figure


def _to_cpm(value: Any) -> Any:
    return 60.0 * value


def _to_hertz(value: Any) -> Any:
    return value / 60.0


def _chosen(result: Result, modes: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Criticals [mode, order] of the range that are drawn, major orders, orders with a line.

    Drawn are those of the major orders and, of each mode, those that the report ranks.
    """
    record = result.record
    speed = np.asarray(record[TORSION + "critical/speed"].values, dtype=float)[modes]
    found = vector(record, "excitation/major", "order")
    major = np.zeros(speed.shape[1], bool) if found is None else found > 0
    low, high = speed_range(result)
    inside = (speed >= low) & (speed <= high)
    strength = having(record, TORSION + "excitation/intensity", "mode", "order")
    if strength is None:
        return inside, major, np.asarray(inside.any(axis=0))
    size = np.abs(strength.values)[modes]
    chosen = inside & major
    for row, at, work in zip(chosen, speed, size, strict=True):
        row[strongest_orders(at, work, (low, high))] = True
    chosen &= major | (size > 0.0)
    excited = np.any(size > 0.0, axis=0)
    few = np.count_nonzero(excited) <= _FEW
    return chosen, major, chosen.any(axis=0) | (excited & few)


def draw_orders(
    axes: "Axes", order: np.ndarray, major: np.ndarray, right: float, top: float
) -> None:
    """Hz over rpm from the origin, `major` ones thick; names at the edges where there is room."""
    from matplotlib.collections import LineCollection

    lines = [[(0.0, 0.0), (right, q * right / 60.0)] for q in order]
    widths = np.where(major, 1.0, 0.5).tolist()
    axes.add_collection(
        LineCollection(lines, colors=QUIET, linewidths=widths, alpha=0.7, zorder=1), autolim=False
    )
    up, across = -1.0, 2.0  # of the edges, where the last name stands
    for q in order:
        end = q * right / 60.0 / top
        if end <= 1.0 and end - up >= _APART:
            up = end
            note(axes, order_text(q), (right, end * top), (3, 0), ha="left", va="center",
                 color=QUIET, annotation_clip=False)  # fmt: skip
        if end > 1.0 and across - 1.0 / end >= _APART_ABOVE:
            across = 1.0 / end
            note(axes, order_text(q), (across * right, top), (0, 2), ha="center", va="bottom",
                 color=QUIET, annotation_clip=False)  # fmt: skip


def _crossings(
    axes: "Axes", critical: Quantity, modes: list[int], colours: list[str], *groups: np.ndarray
) -> None:
    order = np.asarray(critical.axes[1].values, dtype=float)
    speed = np.asarray(critical.values, dtype=float)[modes]
    labels = "five strongest", "major order"
    for group, filled, words in zip(groups, (False, True), labels, strict=True):
        for row, there, colour in zip(speed, group, colours, strict=True):
            axes.plot(
                rpm(1.0) * row[there], hertz(1.0) * (order * row)[there], "o", color=colour,
                markerfacecolor=colour if filled else "white", zorder=5,
            )  # fmt: skip
        if group.any():
            axes.plot([], [], "o", color=QUIET, markerfacecolor=QUIET if filled else "white",
                      label=words)  # fmt: skip


# ----------------------------------------------------------------------------
# One row for the longest way through the line, one for each branch, below where it hangs.
# ----------------------------------------------------------------------------

#: half heights of the discs: of the largest inertia, and of the least
_HIGH, _LOW = 0.36, 0.08
_HALF_DISC = 0.11
#: discs of a row from which on names are small
_SMALL = 14
#: height of a row, in units of its discs, and in inches
_ROW, _INCHES = 2.3, 1.75

Place = tuple[float, float]


def draw_system(result: Result) -> "Figure | None":
    """Discs as high as the cube root of their inertia says; None without a shaft line."""
    line = line_of(result)
    if line is None:
        return None
    stations = len(line.station_names)
    paths = strands(line, stations + len(line.dampers))
    at = _places(paths)
    rows = 1 + round(-min(y for _, y in at.values()) / _ROW)
    words = "blue: stations with cylinders; " if line.cylinder_station.size else ""
    words += "names above: stations, below: elements between them"
    words += "; dotted: gears with their ratios" if line.gears else ""
    figure = canvas(result, f"sketch of the line; {words}", 0.6 + _INCHES * rows)
    axes = figure.subplots()
    size = 7.0 if max(map(len, paths)) <= _SMALL else 5.5
    _joints(axes, line, at, size)
    inertia = np.cbrt(np.append(line.station_values[0] / line.station_ratio**2, 0.0))
    inertia *= (_HIGH - _LOW) / max(float(np.max(inertia)), 1e-300)
    fired = set(line.cylinder_station.tolist())
    names = [*line.station_names, *(one.name for one in line.dampers)]
    for place, (x, y) in at.items():
        half = _LOW + float(inertia[min(place, stations)])
        colour = COLOURS[0] if place in fired else "#b8bec4"
        if place >= stations:
            colour, half = "white", 0.16
        corners = [(x - _HALF_DISC, y - half), (x + _HALF_DISC, y - half),
                   (x + _HALF_DISC, y + half), (x - _HALF_DISC, y + half)]  # fmt: skip
        axes.fill(*zip(*corners, strict=True), facecolor=colour, edgecolor=TOTAL, linewidth=0.8)
        axes.text(x - 0.05, y + half + 0.07, names[place], rotation=35, fontsize=size, va="bottom",
                  ha="left")  # fmt: skip
    wide = max(x for x, _ in at.values())
    axes.set_xlim(-0.5, wide + 0.9)
    axes.set_ylim(min(y for _, y in at.values()) - 1.0, 1.35)
    axes.set_axis_off()
    return figure


def _places(paths: list[list[int]]) -> dict[int, Place]:
    """Where each station and ring is drawn: a row for each path, which hangs on its first."""
    at: dict[int, Place] = {place: (float(x), 0.0) for x, place in enumerate(paths[0])}
    last = len(paths[0]) - 1
    for row, path in enumerate(paths[1:], 1):
        start = at[path[0]][0]
        step = 1.0 if start + len(path) - 2 <= last or start < last / 2.0 else -1.0
        for count, place in enumerate(path[1:]):
            at[place] = (start + step * count, -_ROW * row)
    return at


def _joints(axes: "Axes", line: "ShaftLineModel", at: dict[int, Place], size: float) -> None:
    """Shafts as lines with their names, gears dotted with their ratios, springs to the frame."""
    stations, ring = len(line.station_names), 0
    for name, kind, (first, second) in zip(
        line.section_names, line.section_kinds, line.section_ends.tolist(), strict=True
    ):
        if second < 0:
            second = stations + ring
            ring += 1
            if second not in at:
                continue
        _line(axes, at[first], at[second], name, size, geared=kind == "mesh")
    for gear in line.gears:
        if gear.element < 0:
            ratio = line.station_ratio[gear.second] / line.station_ratio[gear.first]
            words = f"{gear.name} {short(float(ratio))}"
            _line(axes, at[gear.first], at[gear.second], words, size, geared=True)


def _line(axes: "Axes", one: Place, two: Place, name: str, size: float, *, geared: bool) -> None:
    style = ":" if geared else "-"
    axes.plot(*zip(one, two, strict=True), style, color=TOTAL, linewidth=2.2 if geared else 1.4,
              zorder=0)  # fmt: skip
    x, y = 0.5 * (one[0] + two[0]), 0.5 * (one[1] + two[1])
    if one[1] == two[1]:
        axes.text(x + 0.08, y - 0.42, name, rotation=35, fontsize=size, color=QUIET, va="top",
                  ha="right")  # fmt: skip
    else:
        axes.text(x + 0.08, y - 0.2, name, fontsize=size, color=QUIET, va="center")
