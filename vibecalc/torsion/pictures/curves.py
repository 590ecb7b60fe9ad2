"""Pictures of the orders of named shafts and stations against speed, with their sums."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vibecalc.core.report.canvas import COLOURS, LIMIT, PLATE, QUIET, TOTAL, note
from vibecalc.core.report.curves import Curve, Curves, Mark, Panel, Plot, operating, spans
from vibecalc.core.report.sections import labels
from vibecalc.core.report.writing import rpm
from vibecalc.core.results.record import Quantity, Result
from vibecalc.torsion.report.curves import drawn
from vibecalc.torsion.report.line import TORSION, order_text, place_of

# ----------------------------------------------------------------------------
# Orders in thin lines with their number at the maximum, their sum thick, the sum of their
# magnitudes dashed; limits, barred ranges and measured points with them.
# ----------------------------------------------------------------------------

#: orders that are drawn at most, panels of one picture
_ORDERS, _PANELS = 8, 8
_UNITS = {
    "stress": "N/mm^2",
    "angular_speed": "rad/s",
    "angular_acceleration": "rad/s^2",
}


def _panels(result: Result) -> Sequence[Panel]:
    """One for each quantity of each shaft or station."""
    found = [
        _panel(name, one) for name, quantity in drawn(result.record) for one in
        labels(quantity.axes[0])
    ]  # fmt: skip
    return found[:_PANELS]


TORSION_CURVES = Curves("orders of named shafts and stations against speed", _panels, high=3.1)


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
        spans(f"{TORSION}barred", "barred range", ("from", "to"), color="#E69F00", alpha=0.25),
    )
    if name == "stress":
        lasting, passing = ("allowed for lasting", {}), ("for passing", {"linestyle": "-."})
        parts += tuple(
            Curve(_own(name, path, one, finite=True), words, {**limit, **look})
            for path, (words, look) in (("allowed", lasting), ("transient", passing))
        )
    words = name.replace("_", " ")
    return Panel(words, parts, f"{one}: {words}", unit=_UNITS.get(name, ""), ends=(0.0, None))


def _own(name: str, path: str, one: str, finite: bool = False):  # type: ignore[no-untyped-def]
    """The curve of one shaft or station; none where it is `finite` nowhere."""

    def made(result: Result) -> Quantity | None:
        found = result.record.quantities.get(f"{TORSION}curves/{name}/{path}")
        place = place_of(found, one)
        if found is None or place is None:
            return None
        row = np.asarray(found.values[place], dtype=float)
        if finite and not np.isfinite(row).any():
            return None
        return replace(found, values=row, axes=found.axes[-1:])

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
        for number, i in enumerate(np.sort(np.argsort(-tops, kind="stable")[:_ORDERS])):
            colour, y = COLOURS[number % len(COLOURS)], plot.factor * sizes[i]
            plot.axes.plot(x, y, color=colour, linewidth=0.8, zorder=3)
            best = int(np.nanargmax(sizes[i]))
            right = best > 0.97 * len(x)
            note(plot.axes, order_text(found.axes[1].values[i]), (float(x[best]), float(y[best])),
                 (-3 if right else 0, 2), ha="right" if right else "center", va="bottom",
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
            for part in (found.axes[0].name, "speed", "half_order")
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
