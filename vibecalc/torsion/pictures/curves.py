"""Pictures of the orders of named shafts and stations against speed, with their sums."""

from collections.abc import Collection, Sequence
from functools import partial

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, QUIET, TOTAL, note
from vibecalc.core.report.curves import (
    Curve,
    Curves,
    Ends,
    Mark,
    Panel,
    Plot,
    Source,
    operating,
    spans,
)
from vibecalc.core.report.sections import labels
from vibecalc.core.report.writing import rpm, show
from vibecalc.core.results.record import Quantity, Result
from vibecalc.torsion.report.curves import drawn
from vibecalc.torsion.report.line import TORSION, order_text, place_of, row_of
from vibecalc.torsion.results import QUANTITIES

# ----------------------------------------------------------------------------
# Orders in thin lines with their number at the maximum, their sum thick, the sum of their
# magnitudes dashed; limits, barred ranges and measured points with them.
# ----------------------------------------------------------------------------

#: orders that are drawn at most, and of the largest one what they have at least
_ORDERS, _FAINT = 8, 0.03
#: panels of one picture; times the curves, from which on a limit is told and not drawn
_PANELS, _FAR = 8, 3.0
#: of the axis, how near to its ends a number stands inside
_EDGE = 0.03
_OF_SECTIONS, _OF_STATIONS = (
    [name for name, (axis, *_) in QUANTITIES.items() if axis == one]
    for one in ("section", "station")
)
_UNITS = {
    "stress": "N/mm^2",
    "angular_speed": "rad/s",
    "angular_acceleration": "rad/s^2",
}


def _panels(of: Collection[str], result: Result) -> Sequence[Panel]:
    """One for each of some quantities of each shaft or station."""
    found = [
        _panel(name, one)
        for name, quantity in drawn(result.record)
        if name in of
        for one in labels(quantity.axes[0])
    ]
    return found[:_PANELS]


TORSION_CURVES, TORSION_STATION_CURVES = (
    Curves(f"orders of named {what} against speed", partial(_panels, of), high=2.7, columns=2)
    for what, of in (("shafts", _OF_SECTIONS), ("stations", _OF_STATIONS))
)


def _panel(name: str, one: str) -> Panel:
    of_all = {"color": TOTAL, "linewidth": 2.0, "marker": ""}
    dashed = {"color": QUIET, "linestyle": "--", "linewidth": 1.1, "marker": ""}
    limit = {"color": LIMIT, "linewidth": 1.4, "marker": ""}
    parts: tuple[Mark, ...] = (
        Curve(_own(name, "sum", one), "sum of magnitudes", dashed),
        Curve(_own(name, "half_range", one), "half range of all orders", of_all),
        _orders(name, one),
        _measured(name, one),
        operating,
        spans(
            f"{TORSION}barred", "no lasting operation", ("from", "to"), color="#E69F00", alpha=0.25
        ),
    )
    if name == "stress":
        lasting, passing = (_own(name, path, one, finite=True) for path in ("allowed", "transient"))
        parts += (
            Curve(lasting, "allowed for lasting", limit),
            Curve(passing, "for passing through", {**limit, "linestyle": "-."}),
        )
    words = name.replace("_", " ")
    return Panel("{}", parts, f"{one}: {words}", unit=_UNITS.get(name, ""), ends=_heights)


def _heights(plot: Plot) -> Ends:
    """From zero to above the sums, and above the limits where these are not far away."""
    sums, *others = (float(np.nanmax(y, initial=0.0)) for _, y in plot.drawn[:1] + plot.drawn[2:])
    top = max([sums, *plot.points])
    beyond = [one for one in others if one > _FAR * top]
    for one in beyond[:1]:
        words = f"allowed: {show(one, digits=3)} {plot.unit}"
        note(plot.axes, words, (0.98, 0.97), (0, 0), ha="right", va="top", color=LIMIT, bbox=PLATE,
             xycoords="axes fraction", fontsize=8, zorder=8)  # fmt: skip
    return 0.0, 1.12 * max([top, *(one for one in others if one not in beyond)]) or None


def _own(name: str, path: str, one: str, finite: bool = False) -> Source:
    """The curve of one shaft or station; none where it is `finite` nowhere."""

    row = row_of(f"{TORSION}curves/{name}/{path}", one)

    def made(result: Result) -> Quantity | None:
        found = row(result.record)
        known = found is not None and (not finite or np.isfinite(found.values).any())
        return found if known else None

    return made


def _orders(name: str, one: str) -> Mark:
    """The largest orders, each with its number at its maximum."""

    def draw(plot: Plot) -> None:
        found = plot.result.record.quantities.get(f"{TORSION}curves/{name}/order")
        place = place_of(found, one)
        if found is None or place is None:
            return
        sizes = np.abs(found.values[place])
        sizes = np.where(np.isfinite(sizes), sizes, np.nan)
        tops = np.nan_to_num(sizes).max(axis=1)
        x = rpm(1.0) * np.asarray(found.axes[-1].values, dtype=float)
        strong = np.argsort(-tops, kind="stable")[:_ORDERS]
        strong = strong[tops[strong] >= _FAINT * tops.max(initial=0.0)]
        for number, i in enumerate(np.sort(strong)):
            colour, y = COLOURS[number % len(COLOURS)], plot.factor * sizes[i]
            plot.axes.plot(x, y, color=colour, linewidth=0.8, zorder=3)
            best = int(np.nanargmax(sizes[i]))
            side = "left" if best < _EDGE * len(x) else "center"
            side = "right" if best > (1.0 - _EDGE) * len(x) else side
            aside = {"left": 3, "center": 0, "right": -3}[side]
            note(plot.axes, order_text(found.axes[1].values[i]), (float(x[best]), float(y[best])),
                 (aside, 2), ha=side, va="bottom",
                 color=colour, bbox=PLATE, zorder=6, fontsize=8)  # fmt: skip

    return draw


def _measured(name: str, one: str) -> Mark:
    """Measured half ranges as hollow circles, measured orders as small squares."""

    def draw(plot: Plot) -> None:
        record, stem = plot.result.record, f"{TORSION}curves/{name}"
        value = record.quantities.get(f"{stem}/measured/value")
        found = record.quantities.get(f"{stem}/order")
        place = place_of(found, one)
        if value is None or found is None or place is None:
            return
        own, speed, order = (
            np.asarray(record[f"{stem}/measured/{part}"].values, dtype=float)
            for part in (found.axes[0].name, "speed", "order")
        )
        mine = own == place + 1
        for some, marker, words in (
            (mine & (order == 0.0), "o", "measured"),
            (mine & (order > 0.0), "s", "measured, one order"),
        ):
            height = plot.factor * np.asarray(value.values, dtype=float)[some]
            if height.size:
                plot.axes.scatter(
                    rpm(1.0) * speed[some], height, s=28.0, linewidths=1.3, zorder=7, label=words,
                    marker=marker, facecolors="none", edgecolors=TOTAL,
                )  # fmt: skip
                plot.points += list(height)

    return draw
