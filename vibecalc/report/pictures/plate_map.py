"""Map of the level over a plate, harmonic by harmonic, with positions and the quietest place."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import having, scalar_of, table_of
from vibecalc.report.pictures.canvas import LIMIT, TOTAL, canvas
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STEM = "measurement/"
_MOST = 5
#: dB below the loudest place that the colours span
_RANGE = 24.0
#: share of the plate's length within which positions share a label
_APART = 0.03


def picture(result: Result) -> "Figure | None":
    """A map for each harmonic and one for all together; None without the edges of a plate."""
    amplitudes = having(result.record, _STEM + "map/amplitude", "order", "plate_y", "plate_x")
    total = having(result.record, _STEM + "map/all_orders", "plate_y", "plate_x")
    if amplitudes is None or total is None:
        return None
    orders = [int(order) for order in amplitudes.axes[0].values][:_MOST]
    x, y = (np.asarray(total.axes[place].values, dtype=float) for place in (1, 0))
    maps = [np.asarray(amplitudes.values)[i] for i in range(len(orders))]
    titles = [f"harmonic {order}" for order in orders]
    if len(orders) > 1:
        maps.append(np.asarray(total.values))
        titles.append("all harmonics")
    columns = min(len(maps), 2)
    rows = -(-len(maps) // columns)
    height = 5.2 * float((y[-1] - y[0]) / (x[-1] - x[0])) + 0.9
    figure = canvas(result, "level over the plate", 6.6 * columns, min(height, 7.0) * rows + 0.8)
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.ravel()[len(maps) :]:
        axes.set_visible(False)
    reference = _reference(result)
    for i, (title, amplitude) in enumerate(zip(titles, maps, strict=True)):
        axes = grid.ravel()[i]
        place = _quiet(result.record, i if i < len(orders) else None)
        _draw(axes, x, y, amplitude, reference)
        _mark(axes, result, place)
        axes.set_title(title, loc="left")
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
    level = 20.0 * np.log10(np.maximum(amplitude, 1e-12 * np.max(amplitude)) / reference)
    top = float(np.max(level))
    low = max(float(np.min(level)), top - _RANGE)
    shown = np.clip(level, low, top)
    steps = np.linspace(low, top, 13) if top - low > 1e-6 else np.array([top - 1.0, top])
    filled = axes.contourf(x, y, shown, levels=steps, cmap="viridis", extend="min")
    bar = axes.figure.colorbar(filled, ax=axes, shrink=0.75)
    bar.set_label("level in dB")
    bar.ax.yaxis.set_major_formatter("{x:.1f}")
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlabel("x, along the crankshaft, in m")
    axes.set_ylabel("y in m")


def _mark(axes: "Axes", result: Result, quiet: tuple[float, float] | None) -> None:
    rows: Any = table_of(result.case, "measurement").get("positions") or ()
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    reach = _APART * (right - left)
    named: list[tuple[float, float, list[str]]] = []
    for row in rows:
        x, y = float(row["x"]), float(row["y"])
        if not (left <= x <= right and low <= y <= high):
            continue
        axes.plot([x], [y], "o", ms=4, mfc="white", color=TOTAL, clip_on=False)
        beside = [one for one in named if np.hypot(x - one[0], y - one[1]) < reach]
        if beside:
            beside[0][2].append(str(row["name"]))
        else:
            named.append((x, y, [str(row["name"])]))
    for x, y, names in named:
        axes.annotate(
            ", ".join(names),
            (x, y),
            xytext=(6 if x < 0.5 * (left + right) else -6, 9 if y < 0.5 * (low + high) else -9),
            textcoords="offset points",
            ha="left" if x < 0.5 * (left + right) else "right",
            va="center",
            color=TOTAL,
            fontsize=9,
            bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.75},
        )
    if quiet is not None:
        axes.plot([quiet[0]], [quiet[1]], "*", ms=13, color=LIMIT, mec="white", clip_on=False)


def _quiet(record: Record, place: int | None) -> tuple[float, float] | None:
    """The quietest place of one harmonic, or of all."""
    if place is None:
        x, y = (scalar_of(record, f"{_STEM}quiet/all_orders_{name}") for name in ("x", "y"))
        return None if x is None or y is None else (x, y)
    found = [having(record, f"{_STEM}quiet/{name}", "order") for name in ("x", "y")]
    values = [float(one.values[place]) for one in found if one is not None]
    return (values[0], values[1]) if len(values) == 2 else None
