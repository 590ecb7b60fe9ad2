"""Vector diagrams: how the torques of the cylinders add up, by order, in the lowest modes."""

import math
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import hertz, show
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.pictures.torsion_excitation import misfire_words, silent
from vibecalc.report.sections.torsion_terms import TORSION, elastic_modes, line_of, order_text
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MODES, _STARS = 3, 6
_ALIKE = 1e-6


def picture(result: Result) -> "Figure | None":
    """Stars of the phases on top, below them shape times phase laid end to end for each mode.

    A cylinder that does not fire is left out of the sums, and drawn beside those that do.
    """
    record = result.record
    firing = having(record, TORSION + "excitation/firing_angle", "cylinder")
    shape = having(record, TORSION + "modes/shape", "mode", "station")
    total = having(record, TORSION + "excitation/total", "half_order")
    natural = having(record, TORSION + "modes/natural_frequency", "mode")
    line, modes = line_of(result), elastic_modes(result)[:_MODES]
    if firing is None or shape is None or total is None or natural is None or line is None:
        return None
    angle = np.asarray(firing.values, dtype=float)
    if angle.size < 2 or not modes:
        return None
    orders = np.asarray(total.axes[0].values, dtype=float)
    stars = alike(angle, orders, mirrored=not np.iscomplexobj(shape.values))[:_STARS]
    named = labels(firing.axes[0])
    fires = np.array([name not in silent(result) for name in named])
    mirrored = "" if np.iscomplexobj(shape.values) else " (mirror images count as equal)"
    words = (
        f"phase vectors of the cylinders by order{mirrored};\n"
        "below, each times the shape of a mode, end to end, over what all in line would be"
    )
    for ill in misfire_words(result):
        are, they = ("is", "it") if fires.sum() == len(named) - 1 else ("are", "they")
        words += f"\n{ill} and {are} not in the sums (dashed); all: if {they} did"
    figure = canvas(
        result, words,
        max(1.9 * len(stars) + 0.6, 7.6), 2.0 * (len(modes) + 1) + 1.4,
    )  # fmt: skip
    grid = figure.subplots(len(modes) + 1, len(stars), squeeze=False)
    for group, column in zip(stars, grid.T, strict=True):
        turned = np.exp(-1j * group[0] * angle)
        _star(column[0], turned, named, group, fires)
        for mode, axes in zip(modes, column[1:], strict=True):
            row = np.asarray(shape.values)[mode][line.cylinder_station]
            _polygon(axes, row, turned, fires)
    values = hertz(1.0) * np.asarray(natural.values, dtype=float)
    grid[0][0].set_ylabel("phases", fontsize=9)
    for mode, row_ in zip(modes, grid[1:], strict=True):
        row_[0].set_ylabel(f"mode {mode + 1}\n{show(values[mode], digits=4)} Hz", fontsize=9)
    return figure


def alike(angle: np.ndarray, order: np.ndarray, mirrored: bool = True) -> list[list[float]]:
    """Orders in groups of equal phases of the cylinders, each group ascending.

    The mirror image of a star gives the same sums where the shapes are real: `mirrored`.
    """
    groups: list[list[float]] = []
    stars: list[np.ndarray] = []
    for q in order:
        star = np.exp(-1j * q * (angle - angle[0]))
        for group, other in zip(groups, stars, strict=True):
            away = np.abs(star - other).max()
            if mirrored:
                away = min(away, np.abs(star.conj() - other).max())
            if away < _ALIKE:
                group.append(float(q))
                break
        else:
            groups.append([float(q)])
            stars.append(star)
    return groups


def _star(
    axes: "Axes", turned: np.ndarray, named: list[str], orders: list[float], fires: np.ndarray
) -> None:
    """An arrow for each direction, with the cylinders that share it; (3) does not fire."""
    members: list[tuple[complex, list[str], list[bool]]] = []
    for one, name, well in zip(turned, named, fires, strict=True):
        word = name if well else f"({name})"
        for other, together, alive in members:
            if abs(one - other) < _ALIKE:
                together.append(word)
                alive.append(bool(well))
                break
        else:
            members.append((complex(one), [word], [bool(well)]))
    for one, together, alive in members:
        x, y = _upright(one)
        _arrow(axes, 0.0, 0.0, x, y, COLOURS[0] if any(alive) else QUIET, dashed=not any(alive))
        # several lines of names go away from the arrow
        side = "bottom" if y > 0.9 else "top" if y < -0.9 else "center"
        reach = 1.12 if side != "center" else 1.3
        axes.text(1.32 * x, reach * y, _wrapped(together), ha="center", va=side, fontsize=8)
    axes.set_xlim(-1.9, 1.9)
    axes.set_ylim(-1.9, 1.9)
    listed = ", ".join(order_text(q) for q in orders[:4]) + (" ..." if len(orders) > 4 else "")
    axes.set_title(f"order {listed}", fontsize=8)
    _bare(axes)


def _wrapped(together: list[str]) -> str:
    """At most four names in a line."""
    return "\n".join(", ".join(together[i : i + 4]) for i in range(0, len(together), 4))


def _polygon(axes: "Axes", row: np.ndarray, turned: np.ndarray, fires: np.ndarray) -> None:
    """Vectors of what fires end to end, over what all were in line, and their sum."""
    steps = row * turned / max(float(np.abs(row).sum()), 1e-300)
    way = np.concatenate([[0.0], np.cumsum(steps[fires])])
    for start, stop in pairwise(way):
        (x, y), (u, v) = _upright(start), _upright(stop)
        _arrow(axes, x, y, u, v, COLOURS[0])
    # what is left out would go on from the end to the sum of all
    rest = way[-1] + np.concatenate([[0.0], np.cumsum(steps[~fires])])
    for start, stop in pairwise(rest):
        (x, y), (u, v) = _upright(start), _upright(stop)
        _arrow(axes, x, y, u, v, QUIET, dashed=True)
    x, y = _upright(way[-1])
    if abs(way[-1]) > 1e-3:
        _arrow(axes, 0.0, 0.0, x, y, LIMIT, 2.2)
    axes.plot([0.0], [0.0], "o", color=TOTAL, ms=3)
    reach = 1.15 * max(0.35, float(np.max(np.abs([*way, *rest]))))
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    words = f"sum {abs(way[-1]):.3f}"
    if not fires.all():
        words += f"\nall {abs(rest[-1]):.3f}"
    axes.set_xlabel(words, fontsize=9)
    _bare(axes)


def _upright(one: complex) -> tuple[float, float]:
    """Phase zero points upwards, as in diagrams of cranks; angles run clockwise as the crank."""
    turned = complex(one) * 1j
    return turned.real, turned.imag


def _arrow(
    axes: "Axes", x: float, y: float, u: float, v: float, colour: str, width: float = 1.3,
    dashed: bool = False,
) -> None:  # fmt: skip
    if math.hypot(u - x, v - y) < 1e-9:
        return
    axes.annotate(
        "", (u, v), (x, y),
        arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0.0,
                    "shrinkB": 0.0, "mutation_scale": 9.0, "linestyle": "--" if dashed else "-"},
    )  # fmt: skip


def _bare(axes: "Axes") -> None:
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(QUIET)
        axes.spines[side].set_visible(False)
