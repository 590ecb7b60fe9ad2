"""The modes of the body as a box seen in perspective: where it goes and how it turns."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having
from vibecalc.report.numbers import hertz, show
from vibecalc.report.pictures.canvas import COLOURS, QUIET, canvas
from vibecalc.report.pictures.perspective import EDGES, TRIAD, arc_about, corners, project
from vibecalc.report.sections.response import main_coordinates
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
_MOVES, _TURNS = COLOURS[0], COLOURS[1]
#: parts of a mode shorter than this share of its longest arrow are left out
_SHORT = 0.06
_ARROW = 1.25
#: behind the letters of the axes
_PLATE = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8}
#: how far the box is drawn aside, and by what angle, at an arrow of length 1
_ASIDE, _ANGLE = 0.45, 0.35


def picture(result: Result) -> "Figure | None":
    """A panel for each mode; None without shapes and their shares of energy.

    Metres and radians have no common scale: each component is drawn as long as the square root of
    its share of the kinetic energy, with the sign of the shape.
    """
    record = result.record
    stem = "response/modes/"
    shape = having(record, stem + "shape", "mode", "coordinate")
    share = having(record, stem + "energy_fraction", "mode", "coordinate")
    natural = having(record, stem + "natural_frequency", "mode")
    if shape is None or share is None or natural is None:
        return None
    if tuple(str(name) for name in shape.axes[1].values) != _COORDINATES:
        return None
    length = np.sign(np.real(shape.values)) * np.sqrt(np.abs(np.asarray(share.values, dtype=float)))
    modes = len(length)
    columns = min(3, modes)
    rows = -(-modes // columns)
    subtitle = "modes of the body; arrows by their share of the energy"
    figure = canvas(result, subtitle, 3.1 * columns, 1.2 + 3.0 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
        axes.set_aspect("equal")
    for i, vector in enumerate(length):
        _panel(panels[i], vector)
        frequency = show(hertz(float(natural.values[i])), digits=4)
        words = main_coordinates(share, i)
        panels[i].set_title(f"mode {i + 1}: {frequency} Hz\n{words}", fontsize=10)
    _legend(figure)
    return figure


def _panel(axes: "Axes", vector: np.ndarray) -> None:
    """The box at rest, the box displaced, and the two arrows from its centre."""
    largest = float(np.max(np.abs(vector), initial=0.0))
    kept = np.where(np.abs(vector) >= _SHORT * largest, vector, 0.0)
    along, about = kept[:3], kept[3:]
    _box(axes, corners(), "#b0b0b0", 0.9)
    _box(axes, corners(_ASIDE * along, _ANGLE * about), "#444444", 1.4)
    for name, end in TRIAD:
        tip = project(end)
        axes.plot(*np.transpose([project(0.0 * end), tip]), color=QUIET, linewidth=0.8, ls=":")
        x, y = (float(value) for value in project(1.1 * end))
        text = axes.text(x, y, name, color=QUIET, ha="center", va="center", zorder=6)
        text.set_bbox(_PLATE)
    if np.linalg.norm(along) > 0.0:
        _arrow(axes, np.zeros(3), _ARROW * along, _MOVES)
    size = float(np.linalg.norm(about))
    if size > 0.0:
        tip = _ARROW * about
        _arrow(axes, np.zeros(3), tip, _TURNS)
        path = np.array([project(point) for point in arc_about(tip, 0.2 + 0.35 * size)])
        axes.plot(path[:, 0], path[:, 1], color=_TURNS, linewidth=1.8)
        _head(axes, path[-4], path[-1], _TURNS)
    axes.set_xlim(-1.55, 1.55)
    axes.set_ylim(-1.4, 1.6)


def _box(axes: "Axes", points: np.ndarray, colour: str, width: float) -> None:
    flat = np.array([project(point) for point in points])
    for start, end in EDGES:
        axes.plot(flat[[start, end], 0], flat[[start, end], 1], color=colour, linewidth=width)


def _arrow(axes: "Axes", start: np.ndarray, end: np.ndarray, colour: str) -> None:
    first, last = project(start), project(end)
    axes.plot(*np.transpose([first, last]), color=colour, linewidth=2.2, zorder=4)
    _head(axes, first, last, colour)


def _head(axes: "Axes", first: np.ndarray, last: np.ndarray, colour: str) -> None:
    style = {"arrowstyle": "-|>", "color": colour, "lw": 0.0, "shrinkA": 0, "shrinkB": 0}
    tip, tail = ((float(point[0]), float(point[1])) for point in (last, first))
    axes.annotate("", tip, tail, arrowprops={**style, "mutation_scale": 15}, zorder=5)


def _legend(figure: "Figure") -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=_MOVES, linewidth=2.2, label="moves along"),
        Line2D([], [], color=_TURNS, linewidth=2.2, label="turns about (right-handed)"),
        Line2D([], [], color="#b0b0b0", label="at rest"),
        Line2D([], [], color="#444444", label="displaced, exaggerated"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=9)
