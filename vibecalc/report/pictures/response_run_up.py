"""Mean energies of the body over a range of speeds, with the speeds left out as bands."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibecalc.report.lookup import along, having, speed_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.pictures.canvas import COLOURS, QUIET, canvas
from vibecalc.report.pictures.reference_points import draw_points
from vibecalc.report.pictures.scales import plain_ticks
from vibecalc.report.references import judge_references
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_KINDS = ("kinetic", "potential")
_BAND = "#f3c6cc"
#: decades shown around the usual energy where it has no bound at some speeds
_BELOW, _ABOVE = 1e-4, 1e6
#: the lowest speed drawn, of the highest one: below it little moves
_SPAN = 0.03
#: ratio of the speeds of two bands that leaves room for the words of each
_APART = 1.09


def picture(result: Result) -> "Figure | None":
    """Both energies on one logarithmic axis; None without a run-up of [response]."""
    record = result.record
    hits = [(kind, along(record, f"response/run_up/{kind}_energy", "speed")) for kind in _KINDS]
    curves = [(kind, *hit) for kind, hit in hits if hit is not None and np.any(hit[1] > 0.0)]
    if not curves:
        return None
    figure = canvas(result, "run-up: mean energies of the body at each speed", 8.6, 4.8)
    axes = figure.subplots()
    speed, unit = curves[0][2], curves[0][1].unit
    axes.set_xscale("log")
    axes.set_xlim(max(float(speed[speed > 0.0].min()), _SPAN * float(speed.max())), speed.max())
    axes.set_yscale("log")
    gaps = _masked(record, axes)
    drawn, rows = [], judge_references(result)
    for (kind, quantity, places), colour in zip(curves, COLOURS, strict=False):
        values = np.asarray(quantity.values, dtype=float)
        drawn.append(np.interp(speed, places, values))
        axes.plot(*_broken(places, values, gaps), color=colour, label=f"{kind} energy, mean")
        draw_points(rows, axes, quantity, colour=colour)
        if not gaps:
            _largest(axes, places, values, colour, unit, above=kind == "kinetic")
    axes.set_ylim(*_window(speed, np.array(drawn), bool(gaps)))
    _operating(result, axes, speed)
    axes.set_ylabel(f"mean energy over a turn in {unit}")
    axes.set_xlabel("crank speed in rad/s")
    turns = axes.secondary_xaxis("top", functions=(_to_rpm, _from_rpm))
    turns.set_xlabel("crank speed in rpm")
    for axis in (axes.xaxis, turns.xaxis):
        plain_ticks(axis)
    figure.legend(loc="outside lower center", ncols=4, fontsize=9)
    return figure


def _masked(record: Record, axes: "Axes") -> list[tuple[float, float]]:
    """Shade what is left out beside undamped resonances; says which order meets which mode."""
    low, high, order, mode = (
        having(record, f"response/masked/{name}", "masked")
        for name in ("low", "high", "order", "mode")
    )
    if low is None or high is None:
        return []
    gaps = [(float(a), float(b)) for a, b in zip(low.values, high.values, strict=True)]
    left, _ = axes.get_xlim()
    named, words = left, "left out: no bound"
    for i in np.argsort([start for start, _ in gaps]):
        start, stop = gaps[i]
        # the edge keeps an interval visible that is narrower than a dot
        axes.axvspan(start, stop, color=_BAND, linewidth=1.5, zorder=0, label=words)
        words = ""
        if order is None or mode is None or start < _APART * named:
            continue
        named = start
        axes.annotate(
            f"order {int(order.values[i])}, mode {int(mode.values[i])}",
            (start, 0.98),
            xycoords=axes.get_xaxis_transform(),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=8,
            color=QUIET,
        )
    return gaps


def _broken(
    speed: np.ndarray, values: np.ndarray, gaps: list[tuple[float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """The curve with a break in each gap, and without what a logarithmic axis cannot show."""
    centres = np.array([0.5 * (low + high) for low, high in gaps])
    places = np.searchsorted(speed, centres)
    shown = np.where(np.isfinite(values) & (values > 0.0), values, np.nan)
    return np.insert(speed, places, centres), np.insert(shown, places, np.nan)


def _window(speed: np.ndarray, values: np.ndarray, unbounded: bool) -> tuple[float, float]:
    """Ends of the energy axis: of all that is shown, or decades around what is usual.

    Usual is the median over (logarithmically) even speeds of the larger energy.
    """
    shown = values[:, speed >= _SPAN * speed[-1]]
    shown = shown[np.isfinite(shown) & (shown > 0.0)]
    if not shown.size:
        return 0.1, 1.0
    if not unbounded:
        return 0.5 * float(shown.min()), 4.0 * float(shown.max())
    even = np.geomspace(_SPAN * speed[-1], speed[-1], 400)
    usual = np.interp(even, speed, np.max(values, axis=0))
    usual = usual[np.isfinite(usual) & (usual > 0.0)]
    middle = float(np.median(usual)) if usual.size else float(np.median(shown))
    return _BELOW * middle, _ABOVE * middle


def _largest(
    axes: "Axes", speed: np.ndarray, values: np.ndarray, colour: str, unit: str, above: bool
) -> None:
    """Mark the largest energy, as sampled."""
    top = int(np.argmax(values))
    at, energy = float(speed[top]), float(values[top])
    if not np.isfinite(energy) or energy <= 0.0:
        return
    axes.plot([at], [energy], "o", color=colour, markersize=5)
    left = at > 0.2 * float(speed.max())
    axes.annotate(
        f"{show(energy, digits=4)} {unit} at {show(rpm(at), digits=4)} rpm",
        (at, energy),
        xytext=(-8 if left else 8, 4 if above else -3),
        textcoords="offset points",
        ha="right" if left else "left",
        va="bottom" if above else "top",
        fontsize=9,
        color=colour,
    )


def _operating(result: Result, axes: "Axes", speed: np.ndarray) -> None:
    at = speed_of(result)
    if at is not None and speed.min() < at < speed.max():
        axes.axvline(at, color=QUIET, linestyle=":", linewidth=1.2, label="operating speed")


def _to_rpm(speed: Any) -> Any:
    return speed * rpm(1.0)


def _from_rpm(turns: Any) -> Any:
    return turns / rpm(1.0)
