"""Polar diagrams of main bearings and crank pins; their loads over the crank angle."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.bearings.results import CrankPin, MainLoad, WristPin
from vibecalc.core.report.canvas import (
    COLOURS,
    LIMIT,
    QUIET,
    TOTAL,
    canvas,
    mark_angles,
    unit_words,
)
from vibecalc.core.report.curves import Curve, Curves, Panel, rows_of
from vibecalc.core.report.sections import labels
from vibecalc.core.report.sources import sourced
from vibecalc.core.results.record import Quantity, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Magnitudes over the crank angle.
# ----------------------------------------------------------------------------


def _size(path: str) -> Callable[[Result], Quantity | None]:
    """The magnitude of a force, whose last but one axis is that of its components."""

    def made(result: Result) -> Quantity | None:
        found = sourced(path, result)
        if found is None:
            return None
        axes = (*found.axes[:-2], found.axes[-1])
        return replace(found, path="", values=np.linalg.norm(found.values, axis=-2), axes=axes)

    return made


def _sizes(group: type[MainLoad]) -> Panel:
    name, beside = group.WORDS["bearing"].replace("_", " "), (1.005, 1.0)
    curve = Curve(_size(f"{group.ROOT}/force"), f"{name} {{}}")
    legend = {"loc": "upper left", "bbox_to_anchor": beside}
    return Panel(f"{group.WORDS['load']}s", (curve,), legend=legend)


FORCES = Curves("loads on bearings over a cycle",
                tuple(map(_sizes, (MainLoad, CrankPin, WristPin))), high=2.2)  # fmt: skip

# ----------------------------------------------------------------------------
# Polar diagrams: the path of the force over a cycle, one for each bearing.
# ----------------------------------------------------------------------------

#: diagrams of one picture at most, and in a row
_MOST, _ROW = 9, 3
#: crank angles between marks, in degrees, of a cycle of one turn
_MARK = 90


def draw_main_bearings(result: Result) -> "Figure | None":
    """The force on each main bearing, stroke upwards where it is an axis of the machine."""
    return _polar(result, f"{MainLoad.ROOT}/force", "main bearing", "machine", (1, 0))


def draw_crank_pins(result: Result) -> "Figure | None":
    """The force on each crank pin in axes that turn with its throw, which points upwards."""
    return _polar(result, f"{CrankPin.ROOT}/force_of_throw", "crank pin", "throw", (0, 1))


def _polar(
    result: Result, path: str, what: str, axes_of: str, places: tuple[int, int]
) -> "Figure | None":
    """Paths in axes of the machine or the throw, of which the first of the `places` is upright."""
    found = sourced(path, result)
    if found is None:
        return None
    upright, flat = places
    bearing, directions, angle = found.axes
    of = labels(directions)
    force = found.values[:, flat] + 1j * found.values[:, upright]
    shown = rows_of(replace(found, values=force, axes=(bearing, angle)), _MOST, part=np.asarray)
    factor, unit = unit_words(found.unit, float(np.abs(found.values).max()))
    columns = min(_ROW, len(shown))
    rows = -(-len(shown) // columns)
    figure = canvas(
        result, f"polar diagrams: {what}s over a cycle, in axes of the {axes_of}; crank angle "
        "in deg",
        1.0 + (7.8 if columns == 1 else 9.0 / columns) * rows,
    )  # fmt: skip
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in grid.ravel()[len(shown) :]:
        axes.set_visible(False)
    for axes, (names, row, _) in zip(grid.ravel(), shown, strict=False):
        _path(axes, factor * row, np.degrees(angle.values))
        axes.set_title(f"{what} {', '.join(names)}", loc="left", fontsize=8)
    handles, texts = grid[0, 0].get_legend_handles_labels()
    if texts:
        figure.legend(handles, texts, loc="outside lower center", ncols=len(texts))
    for axes in grid.ravel()[len(shown) - columns : len(shown)]:  # the lowest of each column
        axes.set_xlabel(f"{of[flat]} in {unit}")
        axes.tick_params(labelbottom=True)
    for axes in grid[:, 0]:
        axes.set_ylabel(f"{of[upright]} in {unit}")
    return figure


def _path(axes: "Axes", force: np.ndarray, angle: np.ndarray) -> None:
    """One path (n,), flat + i upright, over crank angles (n,) in degrees."""
    turns = max(round(float(angle[-1]) / 360.0), 1)
    top = force[np.argmax(np.abs(force))]
    for turn in range(turns):
        of = (angle >= 360.0 * turn - 1e-9) & (angle <= 360.0 * (turn + 1) + 1e-9)
        label = f"turn {turn + 1}" if turns > 1 else None
        axes.plot(force[of].real, force[of].imag, color=COLOURS[turn], linewidth=1.1, label=label)
    axes.plot([0.0], [0.0], "+", color=QUIET, ms=9)
    mark_angles(axes, force, angle, range(0, round(float(angle[-1])), _MARK * turns), TOTAL)
    axes.plot([0.0, top.real], [0.0, top.imag], color=LIMIT, linewidth=0.9)
    axes.plot([top.real], [top.imag], "o", color=LIMIT, ms=4, label="largest")
    axes.set_aspect("equal", adjustable="box")
    axes.margins(0.12)
