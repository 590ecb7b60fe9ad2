"""Pictures of vibration at points: by order at the speed, r.m.s. over the run-up with its zones."""

import numpy as np

from vibecalc.core.report.canvas import LIMIT, QUIET
from vibecalc.core.report.curves import Curve, Curves, Mark, Panel, Plot, limits, operating, spans
from vibecalc.core.report.marks import peak
from vibecalc.core.report.sections import having, speed_of
from vibecalc.core.report.sources import entry_of
from vibecalc.core.report.writing import hertz
from vibecalc.core.results.record import Result
from vibecalc.points.report import band_in_hertz, band_words, boundaries, standard_of
from vibecalc.points.results import ROOT, RUN_UP, UNITS
from vibecalc.points.severity import zone_names

_RIGHT = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)}
#: points of which spectra are drawn, the worst of many
_MOST = 4

# ----------------------------------------------------------------------------
# Velocity by order at each point, with the orders that do not count.
# ----------------------------------------------------------------------------


def _outside(plot: Plot) -> None:
    """Orders outside the band, shaded."""
    speed = speed_of(plot.result)
    if not speed:
        return
    low, high = (one / hertz(speed) for one in band_in_hertz(plot.result))
    orders = np.asarray(plot.axis.values, dtype=float)
    for start, stop in ((0.0, low), (high, orders.max() + 1.0)):
        if np.any((orders > start) & (orders < stop)):
            plot.axes.axvspan(start, min(stop, orders.max() + 1.0), color=QUIET, alpha=0.15,
                              linewidth=0.0, zorder=0, label="outside the band")  # fmt: skip


def _spectra(result: Result) -> list[Panel]:
    path = f"{ROOT}/velocity"
    found = having(result.record, path, "sensor", "order")
    if found is None:
        return []
    size, last, panels = np.linalg.norm(found.values, axis=1), 0, []
    for one in result.case["point"]:  # type: ignore[attr-defined]
        first, last = last, last + (3 if one.get("direction") is None else 1)
        bars = (Curve(entry_of(path, i), "{}", bars=True) for i in range(first, last))
        parts: tuple[Mark, ...] = (*bars, _outside)
        panel = Panel("velocity, 0 to peak", parts, one["name"], unit="mm/s", legend=_RIGHT)
        panels.append((max(size[first:last], default=0.0), panel))
    largest = sorted((top for top, _ in panels), reverse=True)[:_MOST]
    return [panel for top, panel in panels if top >= largest[-1]][:_MOST]


BY_ORDER = Curves(
    lambda result: f"vibration at points by order; r.m.s. band {band_words(result)}", _spectra
)

# ----------------------------------------------------------------------------
# R.m.s. values over speed, between the boundaries of the zones.
# ----------------------------------------------------------------------------


def _zones(name: str) -> Mark:
    """A line for each boundary, with the names of the zones that it parts."""

    def draw(plot: Plot) -> None:
        found = boundaries(plot.result.record).get(name)
        if found is None:
            return
        zones = zone_names(found.values.size)
        top = max(float(np.nanmax(y, initial=0.0)) for _, y in plot.drawn)
        for number, value in enumerate(found.values):
            height = plot.factor * float(value)
            if number and plot.factor * float(found.values[number - 1]) > 1.2 * top:
                break  # far above all curves
            plot.axes.axhline(height, color=LIMIT, linestyle="--", linewidth=1.1)
            plot.axes.annotate(
                f"{zones[number]} | {zones[number + 1]}", (0.004, height),
                xycoords=plot.axes.get_yaxis_transform(), fontsize=7, color=LIMIT,
                xytext=(0, 2), textcoords="offset points",
            )  # fmt: skip
            plot.points.append(height)

    return draw


def _title(result: Result) -> str:
    title = f"r.m.s. of {band_words(result)} at points over the run-up"
    zones = bool(boundaries(result.record))
    return title + f"; zones of {standard_of(result)}, informative" * zones


def _over_speed(name: str, unit: str) -> Panel:
    path = f"{RUN_UP}/{name}_rms"
    left_out = spans("isolation/resonances_skipped", "left out: unbounded")
    top = peak(f"{path}_largest", f"{path}_largest_speed")
    parts = (left_out, Curve(path, "{}"), limits(f"{path}_largest"), _zones(name), operating, top)
    return Panel(f"{name}, r.m.s.", parts, unit=unit, log="y", legend=_RIGHT)


OVER_SPEED = Curves(_title, tuple(_over_speed(name, read) for name, (_, read) in UNITS.items()))
