"""Polar diagrams of main bearings and crank pins; their loads over the crank angle."""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.bearings.results import CrankPin, MainLoad, WristPin
from vibecalc.core.report.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas, note, unit_words
from vibecalc.core.report.curves import Curve, Curves, Panel, sourced
from vibecalc.core.report.sections import labels
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


FORCES = Curves(
    "loads on bearings over a cycle",
    tuple(
        Panel(
            f"{what}s",
            (Curve(_size(f"{group.ROOT}/force"), f"{of} {{}}"),),
            legend={"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)},
        )
        for what, group, of in (
            ("main bearing", MainLoad, "main bearing"),
            ("crank pin", CrankPin, "cylinder"),
            ("wrist pin", WristPin, "cylinder"),
        )
    ),
    high=2.2,
)

# ----------------------------------------------------------------------------
# Polar diagrams: the path of the force over a cycle, one for each bearing.
# ----------------------------------------------------------------------------

#: diagrams of one picture at most, and in a row
_MOST, _ROW = 9, 3
#: crank angles between marks, in degrees, of a cycle of one turn
_MARK = 90
#: of the highest, marks closer than which share their words
_CLOSE = 0.06


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
    found = result.record.quantities.get(path)
    if found is None or len(found.axes) != 3:
        return None
    values, angle = np.asarray(found.values), np.degrees(found.axes[-1].values)
    kept = _different(values, 1e-9 * float(np.abs(values).max(initial=0.0)))[:_MOST]
    names, of = labels(found.axes[0]), labels(found.axes[1])
    factor, unit = unit_words(found.unit, float(np.abs(values).max()))
    upright, flat = places
    columns = min(_ROW, len(kept))
    rows = -(-len(kept) // columns)
    figure = canvas(
        result, f"polar diagrams: {what}s over a cycle, in axes of the {axes_of}; crank angle "
        "in deg",
        1.0 + (7.8 if columns == 1 else 9.0 / columns) * rows,
    )  # fmt: skip
    grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for axes in grid.ravel()[len(kept) :]:
        axes.set_visible(False)
    for axes, (i, alike) in zip(grid.ravel(), kept, strict=False):
        x, y = factor * values[i, flat], factor * values[i, upright]
        _path(axes, x, y, angle)
        axes.set_title(f"{what} {', '.join(names[k] for k in alike)}", loc="left", fontsize=8)
    handles, texts = grid[0, 0].get_legend_handles_labels()
    if texts:
        figure.legend(handles, texts, loc="outside lower center", ncols=len(texts))
    for axes in grid[-1]:
        axes.set_xlabel(f"{of[flat]} in {unit}")
    for axes in grid[:, 0]:
        axes.set_ylabel(f"{of[upright]} in {unit}")
    return figure


def _different(values: np.ndarray, near: float) -> list[tuple[int, list[int]]]:
    """Rows that differ by more than `near`, each with those that do not."""
    found = list[tuple[int, list[int]]]()
    for i, row in enumerate(values):
        same = next((k for k in found if np.all(np.abs(values[k[0]] - row) <= near)), None)
        if same is None:
            found.append((i, [i]))
        else:
            same[1].append(i)
    return found


def _path(axes: "Axes", x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> None:
    size, turns = np.hypot(x, y), round(float(angle[-1]) / 360.0)
    top = int(np.argmax(size))
    for turn in range(max(turns, 1)):
        of = (angle >= 360.0 * turn - 1e-9) & (angle <= 360.0 * (turn + 1) + 1e-9)
        label = f"turn {turn + 1}" if turns > 1 else None
        axes.plot(x[of], y[of], color=COLOURS[turn], linewidth=1.1, label=label)
    axes.plot([0.0], [0.0], "+", color=QUIET, ms=9)
    marks = np.arange(0, round(float(angle[-1])), _MARK * max(turns, 1))
    there = [int(np.argmin(np.abs(angle - mark))) for mark in marks]
    points = np.stack([x[there], y[there]], axis=-1)
    for i, alike in _different(points, _CLOSE * float(size[top])):
        axes.plot(*points[i], ".", color=TOTAL, ms=5)
        words = ", ".join(f"{marks[k]}" for k in alike)
        note(axes, words, tuple(points[i]), (3, 2), color=TOTAL, fontsize=7)
    axes.plot([0.0, x[top]], [0.0, y[top]], color=LIMIT, linewidth=0.9)
    axes.plot([x[top]], [y[top]], "o", color=LIMIT, ms=4)
    axes.set_aspect("equal", adjustable="box")
    axes.margins(0.12)
