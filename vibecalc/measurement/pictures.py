"""Pictures of a measured plate: levels at its positions, and maps of the level over it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, TOTAL, canvas, note, only
from vibecalc.core.report.sections import having, labels, scalar_of, table_of
from vibecalc.core.report.verdicts import MEASURED, judge_references
from vibecalc.core.report.writing import rpm
from vibecalc.core.results.record import Axis, Quantity, Record, Result
from vibecalc.core.results.verdicts import entries
from vibecalc.measurement.report import level_words

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# ----------------------------------------------------------------------------
# Levels at the positions of a plate: measured, published, computed, and what they consist of.
# ----------------------------------------------------------------------------

_STEM = "measurement/"
_PATH = _STEM + "level/standard"
_PARTS = (
    ("only_translation", "translation alone", COLOURS[2]),
    ("only_roll", "roll alone", COLOURS[3]),
    ("only_pitch", "pitch alone", COLOURS[4]),
)
#: level of the roll that a model of the machine gives, where the case has one next to the readings
_MODEL = "response/roll/level/shell_acceleration"
_COMPUTED = "computed; bars: its error bound"
_MOST, _WIDEST = 6, 24
#: dB below the lowest level of the whole motion that is still drawn of its parts
_DEPTH = 12.0


def draw_measured_levels(result: Result) -> "Figure | None":
    """A panel for each harmonic, and one for the roll; None without levels at positions."""
    record = result.record
    whole = having(record, _PATH, "position", "order")
    roll = having(record, _STEM + "roll_level", "order")
    if whole is None or roll is None or len(whole.axes[0].values) > _WIDEST:
        return None
    orders = _kept(result, whole.axes[1], _MOST)
    columns = min(len(orders), 3)
    rows = -(-len(orders) // columns)
    figure = canvas(
        result,
        f"levels at the positions; parts more than {_DEPTH:g} dB below are not drawn",
        3.0 * rows + 3,
    )
    grid = figure.add_gridspec(rows + 1, columns, height_ratios=[1.25] * rows + [0.8])
    first = None
    for i, place in enumerate(orders):
        first = _harmonic(figure.add_subplot(grid[i // columns, i % columns]), result, whole, place)
        first.set_title(f"harmonic {whole.axes[1].values[place]}", loc="left")
    _roll(figure.add_subplot(grid[rows, :]), result, roll)
    assert first is not None
    handles, words = first.get_legend_handles_labels()
    figure.legend(handles, words, loc="outside lower center", ncols=3)
    return figure


def _harmonic(axes: "Axes", result: Result, whole: Quantity, column: int) -> "Axes":
    names = labels(whole.axes[0])
    place = np.arange(len(names), dtype=float)
    levels = np.asarray(whole.values)[:, column]
    order = int(whole.axes[1].values[column])
    uncertainty = having(result.record, _STEM + "uncertainty/level_bound", "position", "order")
    spread = (
        np.zeros_like(levels) if uncertainty is None else np.asarray(uncertainty.values)[:, column]
    )
    open_ended = place[~np.isfinite(spread)]
    spread = np.where(np.isfinite(spread), spread, 0.0)
    finite = np.where(np.isfinite(levels), levels, np.nan)
    for path, words, colour in _PARTS:
        found = having(result.record, f"{_STEM}level/{path}", "position", "order")
        if found is not None:
            own = np.asarray(found.values)[:, column]
            kept = own > np.nanmin(finite) - _DEPTH
            drawn = np.where(kept, own, np.nan)
            axes.plot(place, drawn, "_", ms=15, mew=2.0, color=colour, label=words)
    axes.errorbar(place, finite, spread, fmt="o", color=TOTAL, ms=5, capsize=3, label=_COMPUTED)
    for x in open_ended:  # a bound without end
        axes.axvline(x, color=TOTAL, lw=1.0, ls=":")
    read = _read(result.record, order, names)
    measured = {**_printed(result, order, True), **read}
    for levels_of, mark, words, colour, shift in (
        (measured, "s", "measured", COLOURS[0], -0.22),
        (_printed(result, order, False), "x", "published", COLOURS[1], 0.22),
    ):
        known = [i for i, name in enumerate(names) if name in levels_of]
        values = [levels_of[names[i]] for i in known]
        if known:
            axes.plot(place[known] + shift, values, mark, ms=6, mfc="none", color=colour,
                      label=words)  # fmt: skip
    long = max(map(len, names)) > 3
    axes.set_xticks(place, names)
    axes.tick_params(axis="x", labelrotation=45 if long else 0)
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.set_ylabel(level_words(result.case, unit="m/s$^2$"))
    return axes


def _read(record: Record, order: int, names: list[str]) -> dict[str, float]:
    """Levels that instruments at the positions read."""
    read = having(record, _STEM + "reading/read", "reading")
    if read is None:
        return {}
    found = dict(zip(labels(read.axes[0]), np.asarray(read.values, dtype=float), strict=True))
    wanted = {name: f"{order}: {name}" for name in names}
    return {name: float(found[key]) for name, key in wanted.items() if key in found}


def _printed(result: Result, order: int, measured: bool) -> dict[str, float]:
    """Levels of the whole motion that references give, measured or published ones."""
    return {
        str(row.where["position"]): row.value
        for row in judge_references(only(result, _PATH))
        if (row.kind == MEASURED) == measured
        and set(row.where) == {"position", "order"}
        and int(row.where["order"]) == order
    }


def _roll(axes: "Axes", result: Result, roll: Quantity) -> None:
    """Roll and pitch by order, and the roll of a model of the machine where there is one."""
    orders = np.asarray(roll.axes[0].values, dtype=float)
    pitch = having(result.record, _STEM + "pitch_level", "order")
    model = having(result.record, _MODEL, "order")
    series = [(roll, "roll, from readings", COLOURS[3], "o")]
    if pitch is not None:
        series.append((pitch, "pitch, from readings", COLOURS[4], "o"))
    if model is not None:
        series.append((model, "roll, machine model", COLOURS[0], "D"))
    place = orders
    for quantity, words, colour, mark in series:
        values = np.asarray(quantity.values, dtype=float)
        drawn = np.where(np.isfinite(values), values, np.nan)
        place = np.asarray(quantity.axes[0].values, dtype=float)
        kept = place <= max(float(np.max(orders)), 10.0)
        axes.plot(place[kept], drawn[kept], mark, color=colour, label=words)
    axes.set_title("rotation", loc="left")
    axes.set_xlabel("harmonic")
    axes.set_ylabel(level_words(result.case, "angular_", "rad/s$^2$").replace(" re", "\nre"))
    axes.set_xticks(range(1, max(int(np.max(place)), 3) + 1))
    axes.legend(ncols=3)


# ----------------------------------------------------------------------------
# Map of the level over a plate, harmonic by harmonic, with positions and the quietest place.
# ----------------------------------------------------------------------------

_MOST_MAPS = 5
#: dB below the loudest place that the colours span
_RANGE = 24.0
#: share of the plate's length within which positions share a label
_APART = 0.03


def draw_plate_map(result: Result) -> "Figure | None":
    """A map for each harmonic and one for all together; None without the edges of a plate."""
    amplitudes = having(result.record, _STEM + "map/amplitude", "order", "plate_y", "plate_x")
    total = having(result.record, _STEM + "map/all_orders", "plate_y", "plate_x")
    if amplitudes is None or total is None:
        return None
    names, x, y = amplitudes.axes[0].values, total.axes[1].values, total.axes[0].values
    maps = [(f"harmonic {names[i]}", np.asarray(amplitudes.values)[i], _quiet(result.record, i))
            for i in _kept(result, amplitudes.axes[0], _MOST_MAPS)]  # fmt: skip
    if len(maps) > 1:
        maps.append(("all harmonics", np.asarray(total.values), _quiet(result.record, None)))
    columns = min(len(maps), 2)
    rows = -(-len(maps) // columns)
    height = 2.5 * float((y[-1] - y[0]) / (x[-1] - x[0])) + 0.9
    figure = canvas(result, "level over the plate", min(height, 7.0) * rows + 1.2)
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.ravel()[len(maps) :]:
        axes.set_visible(False)
    reference = _reference(result)
    for axes, (title, amplitude, place) in zip(grid.ravel(), maps, strict=False):
        _draw(axes, 1e3 * x, 1e3 * y, amplitude, reference)
        _mark(axes, result, place)
        axes.set_title(title, loc="left")
        axes.figure.axes[-1].set_ylabel(level_words(result.case, unit="m/s$^2$"), fontsize=7.5)
    if grid[0, 0].get_legend_handles_labels()[1]:
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center")
    return figure


def _reference(result: Result) -> float:
    """0-to-peak amplitude of 0 dB."""
    table = table_of(result.case, "measurement")
    given: Any = table.get("reference_level")
    peak = np.sqrt(2.0) if table.get("amplitude") == "rms" else 1.0
    return float(peak) * (float(given) if given else 1.0)


def _draw(
    axes: "Axes", x: np.ndarray, y: np.ndarray, amplitude: np.ndarray, reference: float
) -> None:
    from matplotlib.ticker import MaxNLocator

    level = 20.0 * np.log10(np.maximum(amplitude, 1e-12 * np.max(amplitude)) / reference)
    top = float(np.max(level))
    low = max(float(np.min(level)), top - _RANGE)
    shown = np.clip(level, low, top)
    # whole dB, so that the numbers of the bar are those of the contours
    whole = MaxNLocator(12, integer=True).tick_values(low, top)
    steps = np.asarray(whole) if top - low > 1e-6 else np.array([top - 1.0, top])
    filled = axes.contourf(x, y, shown, levels=steps, cmap="viridis", extend="min")
    bar = axes.figure.colorbar(filled, ax=axes, shrink=0.9)
    bar.ax.yaxis.set_major_formatter("{x:.0f}")
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlabel("x, along the crankshaft, in mm")
    axes.set_ylabel("y in mm")


def _mark(axes: "Axes", result: Result, quiet: tuple[float, float] | None) -> None:
    rows: Any = table_of(result.case, "measurement").get("positions") or ()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    reach = _APART * (right - left)
    named: list[tuple[float, float, list[str]]] = []
    for row in rows:
        x, y = 1e3 * float(row["x"]), 1e3 * float(row["y"])
        if not (left <= x <= right and low <= y <= high):
            continue
        axes.plot([x], [y], "o", ms=4, mfc="white", color=TOTAL, clip_on=False)
        nearby = [one for one in named if np.hypot(x - one[0], y - one[1]) < reach]
        if nearby:
            nearby[0][2].append(str(row["name"]))
        else:
            named.append((x, y, [str(row["name"])]))
    for x, y, names in named:
        third = min(int(3.0 * (x - left) / (right - left)), 2)
        note(axes, ", ".join(names), (x, y),
            (6 - 6 * third, 11 if y < 0.5 * (low + high) else -11),
            ha=("left", "center", "right")[third], va="center", color=TOTAL,
            bbox=PLATE)  # fmt: skip
    if quiet is not None:
        axes.plot([1e3 * quiet[0]], [1e3 * quiet[1]], "*", ms=13, color=LIMIT, mec="white",
                  clip_on=False, ls="none", label="quietest point")  # fmt: skip


def _quiet(record: Record, place: int | None) -> tuple[float, float] | None:
    """The quietest place of one harmonic, or of all."""
    if place is None:
        x, y = (scalar_of(record, f"{_STEM}quiet/all_orders_{name}") for name in ("x", "y"))
        return None if x is None or y is None else (x, y)
    found = [having(record, f"{_STEM}quiet/{name}", "order") for name in ("x", "y")]
    values = [float(one.values[place]) for one in found if one is not None]
    return (values[0], values[1]) if len(values) == 2 else None


# ----------------------------------------------------------------------------
# Spectra of orders of the channels of records; over the speed, where a record runs through one.
# ----------------------------------------------------------------------------

#: channels, and harmonics of the curves over the speed, of a picture
_CHANNELS, _ORDERS = 6, 5
#: of the mean, what a speed may change by and still count as one
_STEADY = 0.01


def draw_record_orders(result: Result) -> "Figure | None":
    """A row for each channel."""
    lines = having(result.record, _STEM + "record/spectrum", "channel", "order_line")
    speed = having(result.record, _STEM + "record/block_speed", "channel", "block")
    blocks = having(result.record, _STEM + "record/block_acceleration", "channel", "block", "order")
    if lines is None or speed is None or blocks is None:
        return None
    places, names = _kept(result, lines.axes[0], _CHANNELS), labels(lines.axes[0])
    orders, order_names = _kept(result, blocks.axes[2], _ORDERS), labels(blocks.axes[2])
    speeds = np.asarray(speed.values, dtype=float)
    runs = float(np.ptp(speeds)) > _STEADY * float(np.mean(speeds))
    words = "orders of the records: acceleration, amplitudes 0-to-peak"
    figure = canvas(result, words, 1.0 + 1.8 * len(places))
    panels = figure.subplots(len(places), 2 if runs else 1, squeeze=False, sharex="col")
    at = np.asarray(lines.axes[1].values, dtype=float)
    for place, (axes, *over_speed) in zip(places, panels, strict=True):
        axes.vlines(at[1:], 0.0, np.asarray(lines.values)[place, 1:], color=COLOURS[0], lw=1.0)
        axes.set_title(f"channel {names[place]}", loc="left")
        axes.set_ylabel("m/s$^2$")
        for other in over_speed:
            for row, j in enumerate(orders):
                values = np.abs(np.asarray(blocks.values)[place, :, j])
                other.plot(rpm(1.0) * speeds[place], values, "o-", ms=2.5,
                           color=COLOURS[row % len(COLOURS)],
                           label=f"order {order_names[j]}")  # fmt: skip
        for one in (axes, *over_speed):
            one.set_ylim(bottom=0.0)
    panels[-1, 0].set_xlabel("order")
    if runs:
        panels[-1, 1].set_xlabel("crank speed in rpm")
        handles, words = panels[0, 1].get_legend_handles_labels()
        figure.legend(handles, words, loc="outside lower center", ncols=_ORDERS)
    return figure


def _kept(result: Result, axis: Axis, most: int) -> list[int]:
    """Places of the first entries of an axis, and of those that references stand on."""
    places = [row.get("where") or {} for row in entries(result, "reference")]
    asked = {str(where.get(axis.name)) for where in places}
    return [i for i, name in enumerate(labels(axis)) if i < most or name in asked]
