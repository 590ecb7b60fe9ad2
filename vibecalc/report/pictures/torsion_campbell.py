"""Campbell diagram: natural frequencies of a shaft line and orders against the crank speed."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having, speed_of, table_of
from vibecalc.report.numbers import hertz, rpm
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, canvas
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    elastic_modes,
    has_pendulums,
    order_text,
    speed_range,
    turns,
    vector,
)
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: of the height of the picture, the least distance of two words at its edge
_APART = 0.026
#: and of its width, at its upper edge
_APART_ABOVE = 0.042
_ROOM = 1.12


def picture(result: Result) -> "Figure | None":
    """Hz and cpm over rpm, order lines named at their ends, crossings dotted, major ones filled."""
    natural = having(result.record, TORSION + "modes/natural_frequency", "mode")
    critical = having(result.record, TORSION + "critical/speed", "mode", "half_order")
    modes = elastic_modes(result)
    low, high = speed_range(result)
    if natural is None or critical is None or not modes or high <= 0.0:
        return None
    frequency = hertz(1.0) * np.asarray(natural.values, dtype=float)[modes]
    order = np.asarray(critical.axes[1].values, dtype=float)
    right, top = rpm(high) * 1.04, _ROOM * float(frequency[-1])
    words, course = "Campbell diagram", _course(result)
    if course is None and has_pendulums(result):
        words += ", natural frequencies as they are at the operating speed (pendulums change them)"
    figure = canvas(result, words, 9.6, 7.0)
    axes = figure.subplots()
    axes.set_xlim(0.0, right)
    axes.set_ylim(0.0, top)
    _orders(axes, order, right, top)
    colours = [COLOURS[i % len(COLOURS)] for i in range(len(modes))]
    aside, below = 0, -top
    for mode, value, colour in zip(modes, frequency, colours, strict=True):
        if course is None:
            axes.axhline(value, color=colour, linewidth=1.8)
        else:
            axes.plot(rpm(1.0) * course[0], hertz(1.0) * course[1][mode], color=colour)
            axes.axhline(value, color=colour, linewidth=0.6, alpha=0.4)
        # the names of modes that lie close stand side by side
        aside = aside + 1 if value - below < 1.2 * _APART * top else 0
        below = value
        axes.annotate(
            f"mode {mode + 1}: {value:.4g} Hz", (0.0, value), xytext=(5 + 110 * aside, 3),
            textcoords="offset points", fontsize=9, color=colour, zorder=4,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.0},
        )  # fmt: skip
    _crossings(result, axes, modes, colours)
    _speeds(result, axes, low, high)
    axes.set_xlabel("crank speed in rpm")
    axes.set_ylabel("frequency in Hz")
    axes.grid(False)

    def to_cpm(value: Any) -> Any:
        return 60.0 * value

    def to_hertz(value: Any) -> Any:
        return value / 60.0

    # the words of the orders stand at the right, so that cycles per minute get room beyond them
    axes.secondary_yaxis(1.075, functions=(to_cpm, to_hertz)).set_ylabel("frequency in cpm")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.035), ncols=4, fontsize=9)
    return figure


def _course(result: Result) -> tuple[np.ndarray, np.ndarray] | None:
    """Speeds and natural frequencies [mode, speed] where pendulums make them depend on it."""
    found = having(result.record, TORSION + "campbell/natural_frequency", "mode", "speed")
    if found is None:
        return None
    return np.asarray(found.axes[1].values, dtype=float), np.asarray(found.values, dtype=float)


def _orders(axes: "Axes", order: np.ndarray, right: float, top: float) -> None:
    """Lines from the origin; names at the right or upper edge, where there is room for them."""
    last_y, last_x = -1.0, 2.0
    for q in order:
        end = q * right / 60.0
        axes.plot([0.0, right], [0.0, end], color=QUIET, linewidth=0.6, alpha=0.7, zorder=1)
        if end <= top:
            if end / top - last_y < _APART:
                continue
            last_y = end / top
            place, align, shift = (right, end), ("left", "center"), (3, 0)
        else:
            across = 60.0 * top / q / right
            if last_x - across < _APART_ABOVE:
                continue
            last_x = across
            place, align, shift = (across * right, top), ("center", "bottom"), (0, 2)
        axes.annotate(
            order_text(q), place, xytext=shift, textcoords="offset points", ha=align[0],
            va=align[1], fontsize=8, color=QUIET, annotation_clip=False,
        )  # fmt: skip


def _crossings(result: Result, axes: "Axes", modes: list[int], colours: list[str]) -> None:
    critical = result.record[TORSION + "critical/speed"]
    order = np.asarray(critical.axes[1].values, dtype=float)
    major = vector(result.record, "excitation/major", "half_order")
    low, high = speed_range(result)
    values = np.asarray(critical.values, dtype=float)
    filled = np.zeros(values.shape[1], bool) if major is None else major > 0
    for mode, colour in zip(modes, colours, strict=True):
        inside = (values[mode] >= low) & (values[mode] <= high)
        for chosen, face in ((inside & filled, colour), (inside & ~filled, "white")):
            axes.plot(
                rpm(1.0) * values[mode][chosen],
                hertz(1.0) * (order * values[mode])[chosen], "o", color=colour, ms=5,
                markerfacecolor=face, zorder=5,
            )  # fmt: skip
    for face, words in ((QUIET, "major order"), ("white", "other order")):
        axes.plot([], [], "o", color=QUIET, markerfacecolor=face, ms=5, label=words)


def _speeds(result: Result, axes: "Axes", low: float, high: float) -> None:
    if table_of(result.case, "response", "torsion", "speeds"):
        axes.axvspan(rpm(low), rpm(high), color="#0072B2", alpha=0.07, label="speeds looked at")
    speed = speed_of(result)
    if speed is not None:
        words = f"operating speed {turns(speed)} rpm"
        axes.axvline(rpm(speed), color=LIMIT, linestyle="--", linewidth=1.3, label=words)
