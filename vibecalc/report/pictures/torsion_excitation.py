"""Pressure in one cylinder and torques on its throw over a cycle, and those of all cylinders."""

from typing import TYPE_CHECKING

import numpy as np

from vibecalc.report.lookup import along, having, scalar_of, speed_of, table_of
from vibecalc.report.numbers import show
from vibecalc.report.pictures.canvas import COLOURS, QUIET, TOTAL, canvas, waves
from vibecalc.report.sections.torsion_line import firing_words
from vibecalc.report.sections.torsion_terms import (
    TORSION,
    asked,
    joined,
    order_text,
    speed_range,
    turns,
)
from vibecalc.results.record import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EXCITATION = TORSION + "excitation/"
_TORQUES = (("gas_torque", "gas", COLOURS[0]), ("inertia_torque", "inertia", COLOURS[1]),
            ("total_torque", "both", TOTAL))  # fmt: skip
#: the second speed is so many times the operating one, if the range goes as far; at least the other
_TWICE, _LEAST = 2.0, 1.3


def picture(result: Result) -> "Figure | None":
    """Panels over the crank angle; None without a torque over the cycle.

    The orders of the case are drawn over the card and the torque that they come from. A second
    speed shows how the inertia torque grows: twice the operating one, or where the range ends.
    """
    record = result.record
    total = along(record, EXCITATION + "total_torque", "crank_angle")
    if total is None:
        return None
    speed, second = speed_of(result), _second(result)
    at = f" at {turns(speed)} rpm" if speed is not None else ""
    words = ", ".join([f"gas pressure and torques over one cycle{at}", *misfire_words(result)])
    rows = 3 if second is None else 4
    figure = canvas(result, words, 9.4, 2.6 + 2.0 * rows)
    panels = list(figure.subplots(rows, 1, sharex=True))
    above, below = panels[0], panels[-1]
    _curve(result, above, "pressure", 1e-5, "card", COLOURS[3])
    _approximated(result, above, "pressure", 1e-5, "bar")
    above.set_ylabel("gauge pressure\nin bar")
    above.legend(loc="upper center", fontsize=9, ncols=3)
    for axes, times, rpm_words in (
        (panels[1], 1.0, at),
        (panels[-2], second, f" at {turns((second or 0.0) * (speed or 0.0))} rpm"),
    ):
        if times is None:
            continue
        for name, label, colour in _TORQUES:
            _curve(result, axes, name, 1e-3, label, colour, times)
        _approximated(result, axes, "total_torque", 1e-3, "kN m", times)
        axes.set_ylabel("torque of one cyl-\ninder in kN m")
        axes.legend(loc="upper right", fontsize=9, ncols=4)
        axes.set_title(f"one cylinder from its firing on{rpm_words}", loc="left", fontsize=9)
        axes.axhline(0.0, color=QUIET, linewidth=0.8)
        _headroom(axes)
    _curve(result, below, "engine_torque", 1e-3, "all cylinders", TOTAL)
    below.set_ylabel("torque of all cyl-\ninders in kN m")
    mean = scalar_of(record, EXCITATION + "mean_torque")
    if mean is not None:
        signed = float(record[EXCITATION + "mean_torque"].values)
        below.axhline(1e-3 * signed, color=QUIET, linestyle="--", linewidth=1.2)
        below.set_title(f"mean {show(1e-3 * signed, digits=4)} kN m", loc="right", fontsize=9)
    cycle = str(table_of(result.case, "machine").get("cycle") or "").replace("_", "-")
    order = firing_words(record, cycle)
    if order:
        ill = "".join(f"; {words}" for words in misfire_words(result))
        below.set_title(f"all cylinders{at}, {order}{ill}", loc="left", fontsize=9)
    below.axhline(0.0, color=QUIET, linewidth=0.8)
    top = float(np.degrees(total[1][-1]))
    below.set_xlim(0.0, top)
    below.set_xticks(np.arange(0.0, top + 1.0, 90.0 if top > 400.0 else 45.0))
    below.set_xlabel("crank angle in deg")
    return figure


def silent(result: Result) -> list[str]:
    """Names of the cylinders that do not fire in this case."""
    given = asked(result).get("misfire")
    return [str(name) for name in given] if isinstance(given, list | tuple) else []


def misfire_words(result: Result) -> list[str]:
    """`cylinder 3 does not fire`, nothing for an engine that fires as it should."""
    found = silent(result)
    if not found:
        return []
    many = len(found) > 1
    return [f"cylinder{'s' if many else ''} {joined(found)} do{'' if many else 'es'} not fire"]


def _second(result: Result) -> float | None:
    """The second speed over the operating one; None without a range or with cards by speed."""
    speed, train = speed_of(result), table_of(result.case, "machine", "crank_train")
    if not speed or train.get("gas_cards"):
        return None
    if not table_of(result.case, "response", "torsion", "speeds"):
        return None
    times = min(_TWICE, speed_range(result)[1] / speed)
    return times if times >= _LEAST else None


def _values(result: Result, name: str, times: float = 1.0) -> tuple[np.ndarray, np.ndarray] | None:
    """A curve of the result and its angle; inertia goes with the square of the speed."""
    found = along(result.record, EXCITATION + name, "crank_angle")
    if found is None:
        return None
    drawn = np.asarray(found[0].values, dtype=float)
    if times != 1.0:
        inertia = along(result.record, EXCITATION + "inertia_torque", "crank_angle")
        part = 0.0 if inertia is None else np.asarray(inertia[0].values, dtype=float)
        share = {"inertia_torque": 1.0, "total_torque": 1.0}.get(name, 0.0)
        drawn = drawn + share * (times**2 - 1.0) * part
    return drawn, np.asarray(found[1], dtype=float)


def _curve(
    result: Result, axes: "Axes", name: str, factor: float, words: str, colour: str,
    times: float = 1.0,
) -> None:  # fmt: skip
    found = _values(result, name, times)
    if found is not None:
        axes.plot(np.degrees(found[1]), factor * found[0], color=colour, label=words)


def _approximated(
    result: Result, axes: "Axes", name: str, factor: float, unit: str, times: float = 1.0
) -> None:
    """What the orders of the case make of a curve, and by how much that misses it."""
    found = _values(result, name, times)
    total = having(result.record, EXCITATION + "total", "half_order")
    if found is None or total is None:
        return
    curve, angle = found
    order = np.asarray(total.axes[0].values, dtype=float)
    if name == "total_torque":
        amplitude = np.asarray(total.values)
        inertia = having(result.record, EXCITATION + "inertia", "half_order")
        if times != 1.0 and inertia is not None:
            amplitude = amplitude + (times**2 - 1.0) * np.asarray(inertia.values)
    else:
        # the card has no orders in the result: sums over its points, evenly over the cycle
        amplitude = 2.0 * np.mean(curve[:-1] * np.conj(waves(order, angle[:-1])), axis=1)
    made = float(np.mean(curve[:-1])) + np.real(amplitude @ waves(order, angle))
    label = f"of orders {order_text(order[0])} to {order_text(order[-1])}"
    axes.plot(np.degrees(angle), factor * made, color=COLOURS[4], linestyle="--", linewidth=1.3,
              label=label)  # fmt: skip
    missed = factor * float(np.max(np.abs(made - curve)))
    axes.set_title(f"the orders miss it by {show(missed, digits=2)} {unit} at most", loc="right",
                   fontsize=9)  # fmt: skip


def _headroom(axes: "Axes") -> None:
    """Room for the legend above the curves."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.22 * (high - low))
