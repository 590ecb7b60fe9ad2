"""Levels at the positions of a plate: measured, published, computed, and what they consist of."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import entries, having, labels
from vibecalc.report.pictures.canvas import COLOURS, TOTAL, canvas
from vibecalc.results.record import Quantity, Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "measurement/"
_PATH = _STEM + "level/standard"
_PARTS = (
    ("only_translation", "translation alone", COLOURS[2]),
    ("only_roll", "roll alone", COLOURS[3]),
    ("only_pitch", "pitch alone", COLOURS[4]),
)
#: level of the roll that a model of the machine gives, where the case has one beside the readings
_MODEL = "response/roll/level/shell_acceleration"
_COMPUTED = "computed; bars: its bound (+- of the report: its standard uncertainty)"
_MOST, _WIDEST = 6, 24
#: dB below the lowest level of the whole motion that is still drawn of its parts
_DEPTH = 12.0


def picture(result: Result) -> "Figure | None":
    """A panel for each harmonic, and one for the roll; None without levels at positions."""
    record = result.record
    whole = having(record, _PATH, "position", "order")
    roll = having(record, _STEM + "roll_level", "order")
    if whole is None or roll is None or len(whole.axes[0].values) > _WIDEST:
        return None
    orders = list(whole.axes[1].values)[:_MOST]
    columns = min(len(orders), 3)
    rows = -(-len(orders) // columns)
    figure = canvas(
        result, "levels measured, published and computed", 4.4 * columns, 3.0 * rows + 3
    )
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[1.25] * rows + [0.8])
    first = None
    for i, order in enumerate(orders):
        first = _harmonic(figure.add_subplot(grid[i // columns, i % columns]), result, whole, i)
        first.set_title(f"harmonic {order}", loc="left")
    _roll(figure.add_subplot(grid[rows, :]), result, roll)
    assert first is not None
    handles, words = first.get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=4, fontsize=9)
    return figure


def _harmonic(axes: "Axes", result: Result, whole: Quantity, column: int) -> "Axes":
    names = labels(whole.axes[0])
    place = np.arange(len(names), dtype=float)
    levels = np.asarray(whole.values)[:, column]
    order = int(whole.axes[1].values[column])
    doubt = having(result.record, _STEM + "uncertainty/level_bound", "position", "order")
    spread = np.zeros_like(levels) if doubt is None else np.asarray(doubt.values)[:, column]
    open_ended = place[~np.isfinite(spread)]
    spread = np.where(np.isfinite(spread), spread, 0.0)
    finite = np.where(np.isfinite(levels), levels, np.nan)
    for part, (path, words, colour) in enumerate(_PARTS):
        found = having(result.record, f"{_STEM}level/{path}", "position", "order")
        if found is not None:
            own = np.asarray(found.values)[:, column]
            kept = own > np.nanmin(finite) - _DEPTH
            drawn = np.where(kept, own, np.nan)
            axes.plot(place, drawn, "_", ms=15, mew=2.0, color=colour, label=words)
            _below(axes, place[~kept], own[~kept], colour, 0.3 * (part - 1))
    axes.errorbar(place, finite, spread, fmt="o", color=TOTAL, ms=5, capsize=3, label=_COMPUTED)
    for x in open_ended:  # a bound without end
        axes.axvline(x, color=TOTAL, lw=1.0, ls=":")
    read = _read(result.record, order, names)
    measured = {**_printed(result, order, "measured"), **read}
    for levels_of, mark, words, colour, shift in (
        (measured, "s", "measured", COLOURS[0], -0.22),
        (_printed(result, order, "published"), "x", "published", COLOURS[1], 0.22),
    ):
        known = [i for i, name in enumerate(names) if name in levels_of]
        values = [levels_of[names[i]] for i in known]
        axes.plot(place[known] + shift, values, mark, ms=6, mfc="none", color=colour, label=words)
    axes.set_xticks(place, names, rotation=35 if max(map(len, names)) > 3 else 0, ha="center")
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.set_ylabel(f"level in {whole.unit}")
    return axes


def _below(axes: "Axes", place: np.ndarray, levels: np.ndarray, colour: str, aside: float) -> None:
    """Parts too low to be drawn: an arrow at the lower edge, with the level in dB beside it."""
    for x, level in zip(place, levels, strict=True):
        words = f"{level:.0f}" if np.isfinite(level) else "none"
        axes.annotate(
            f"\u2193{words}",
            (x + aside, 0.02),
            xycoords=axes.get_xaxis_transform(),
            ha="center",
            color=colour,
            fontsize=8,
        )


def _read(record: Record, order: int, names: list[str]) -> dict[str, float]:
    """Levels that instruments at the positions read."""
    read = having(record, _STEM + "reading/read", "reading")
    if read is None:
        return {}
    found = dict(zip(labels(read.axes[0]), np.asarray(read.values, dtype=float), strict=True))
    wanted = {name: f"{order}: {name}" for name in names}
    return {name: float(found[key]) for name, key in wanted.items() if key in found}


def _printed(result: Result, order: int, kind: str) -> dict[str, float]:
    """Levels of the whole motion that references of one kind give."""
    found = {}
    for row in entries(result, "reference"):
        where: Mapping[str, Any] = row.get("where") or {}
        own = str(row.get("kind") or "published")
        if row["quantity"] != _PATH or own != kind or set(where) != {"position", "order"}:
            continue
        if int(where["order"]) == order:
            found[str(where["position"])] = _number(row["value"])
    return found


def _number(value: Any) -> float:
    from vibecalc.units import split_number

    return float(split_number(value)[0]) if isinstance(value, str) else float(value)


def _roll(axes: "Axes", result: Result, roll: Quantity) -> None:
    """Roll and pitch by order, and the roll of a model of the machine where there is one."""
    orders = np.asarray(roll.axes[0].values, dtype=float)
    pitch = having(result.record, _STEM + "pitch_level", "order")
    model = having(result.record, _MODEL, "order")
    series = [(roll, "roll, from readings", COLOURS[3], "o")]
    if pitch is not None:
        series.append((pitch, "pitch, from readings", COLOURS[4], "o"))
    if model is not None:
        series.append((model, "roll, of the machine's model", COLOURS[0], "D"))
    place = orders
    for quantity, words, colour, mark in series:
        values = np.asarray(quantity.values, dtype=float)
        drawn = np.where(np.isfinite(values), values, np.nan)
        place = np.asarray(quantity.axes[0].values, dtype=float)
        kept = place <= max(float(np.max(orders)), 10.0)
        axes.plot(place[kept], drawn[kept], mark + "-", color=colour, lw=0.8, label=words)
    axes.set_title("rotation", loc="left")
    axes.set_xlabel("harmonic")
    axes.set_ylabel(f"level in {roll.unit}")
    axes.set_xticks(range(1, max(int(np.max(place)), 3) + 1))
    axes.legend(fontsize=9, ncols=3)
