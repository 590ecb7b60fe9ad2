"""Inertias that change over the revolution: torque by order and against speed, beside mean ones."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import having, labels, speed_of
from vibecalc.report.numbers import rpm
from vibecalc.report.pictures.canvas import COLOURS, LIMIT, QUIET, TOTAL, canvas
from vibecalc.report.sections.torsion_terms import TORSION, place_of, turns
from vibecalc.results.record import Record, Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROOT = TORSION + "variable_inertia/"
_KILO = 1e-3


def picture(result: Result) -> "Figure | None":
    """The section that changes most; None if no inertia changes."""
    record = result.record
    change = having(record, _ROOT + "change", "section")
    torque = having(record, _ROOT + "torque", "section", "half_order")
    if change is None or torque is None:
        return None
    place = int(np.argmax(np.abs(change.values)))
    name = labels(change.axes[0])[place]
    speeds = having(record, _ROOT + "speeds/torque_half_range", "section", "variable_speed")
    figure = canvas(result, f"torque in section {name}: inertias that change over the revolution",
                    9.2, 4.0 if speeds is None else 7.0)  # fmt: skip
    panels = figure.subplots(1 if speeds is None else 2, 1, squeeze=False)[:, 0]
    _orders(result, panels[0], name)
    if speeds is not None:
        _speeds(record, panels[1], name)
        operating = speed_of(result)
        if operating is not None:
            panels[1].axvline(rpm(operating), color=LIMIT, linewidth=1.0, linestyle=":",
                              label="operating speed")  # fmt: skip
        panels[1].legend(fontsize=9)
    return figure


def _orders(result: Result, axes: "Axes", name: str) -> None:
    """Bars of the exact motion beside those with mean inertias."""
    for path, words, colour, shift in (
        (TORSION + "torque", "mean inertias", QUIET, -0.21),
        (_ROOT + "torque", "inertias that change, exact motion", COLOURS[0], 0.21),
    ):
        found = having(result.record, path, "section", "half_order")
        place = place_of(found, name)
        if found is None or place is None:
            continue
        order = np.asarray(found.axes[1].values, dtype=float)
        step = float(np.min(np.diff(order))) if order.size > 1 else 1.0
        size = _KILO * np.abs(np.asarray(found.values)[place])
        axes.bar(order + shift * step, size, 0.4 * step, color=colour, label=words)
    at = speed_of(result)
    axes.set_title(f"at {turns(at)} rpm, amplitudes 0-to-peak" if at is not None else "",
                   loc="left", fontsize=10)  # fmt: skip
    axes.set_xlabel("order (multiple of crank speed)")
    axes.set_ylabel("torque in kN m")
    axes.legend(fontsize=9)


def _speeds(record: Record, axes: "Axes", name: str) -> None:
    """Half ranges of all orders against speed."""
    for path, axis, words, colour, style in (
        (TORSION + "speeds/torque_half_range", "speed", "mean inertias", QUIET, "--"),
        (_ROOT + "speeds/torque_half_range", "variable_speed",
         "inertias that change, linear motion", TOTAL, "-o"),
    ):  # fmt: skip
        found = having(record, path, "section", axis)
        place = place_of(found, name)
        if found is None or place is None:
            continue
        speed = rpm(1.0) * np.asarray(found.axes[1].values, dtype=float)
        row = _KILO * np.asarray(found.values, dtype=float)[place]
        axes.plot(speed, np.where(np.isfinite(row), row, np.nan), style, color=colour, label=words,
                  ms=4, linewidth=1.4)  # fmt: skip
    axes.set_title("half range of all orders together", loc="left", fontsize=10)
    axes.set_xlabel("crank speed in rpm")
    axes.set_ylabel("torque in kN m")
    axes.set_ylim(bottom=0.0)
