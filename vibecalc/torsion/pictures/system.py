"""Sketch of a shaft line: its stations, what joins them, gears and branches."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.core.report.canvas import COLOURS, QUIET, TOTAL, canvas
from vibecalc.core.results.record import Result
from vibecalc.torsion.pictures.modes import strands
from vibecalc.torsion.report.line import line_of, short

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from vibecalc.torsion.model import ShaftLineModel

# ----------------------------------------------------------------------------
# One row for the longest way through the line, one for each branch, below where it hangs.
# ----------------------------------------------------------------------------

#: half heights of the discs: of the largest inertia, and of the least
_HIGH, _LOW = 0.36, 0.08
_HALF = 0.11
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
    words += "names above: stations, below: what joins them"
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
        corners = [(x - _HALF, y - half), (x + _HALF, y - half),
                   (x + _HALF, y + half), (x - _HALF, y + half)]  # fmt: skip
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
