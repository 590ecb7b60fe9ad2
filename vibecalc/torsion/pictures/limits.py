"""Picture of stresses and torques of a shaft line against speed, each with its limit."""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from vibecalc.core.report.canvas import LIMIT, TOTAL
from vibecalc.core.report.curves import Curve, Curves, Mark, Panel, Plot, operating
from vibecalc.core.report.sections import having
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.pictures.excitation import torque_words
from vibecalc.torsion.report.limits import limits_of, of_torque, rule_of
from vibecalc.torsion.report.line import TORSION, names, vector

# ----------------------------------------------------------------------------
# A panel for each limit: what it is of in the section or gear of largest use, and what is allowed.
#
# Where a case has limits of stresses by tables and UR M68 alone, these stand in the picture of the
# stresses against the speed, and there is none of these panels.
# ----------------------------------------------------------------------------

#: panels of one picture
_MOST = 8
_BESIDE = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)}


class Held(NamedTuple):
    """What a limit is held against: name of the load, curve, place in it, factor, unit, results."""

    name: str
    path: str
    place: int
    factor: float
    unit: str
    prefix: str


def _held(record: Record, limit: int) -> Held | None:
    """The load of largest use of a limit, counted from 0."""
    section, gear = (vector(record, f"limit/{name}", "limit") for name in ("section", "gear"))
    if section is None:
        return None
    torques = bool(of_torque(record)[limit])
    known = names(record, "torque_half_range", "section")
    if gear is not None and gear[limit]:
        place = int(gear[limit]) - 1
        name = names(record, "gear/hammers", "gear")[place]
        return Held(name, "speeds/gear_torque", place, 1.0, "N*m", "torque_")
    place = int(section[limit]) - 1
    path = "speeds/torque_half_range"
    if torques:
        return Held(known[place], path, place, 1.0, "N*m", "torque_")
    here = having(record, f"{TORSION}limit/operating/stress", "limit", "section")
    whole = vector(record, "torque_half_range", "section")
    columns = names(record, "limit/operating/stress", "section")
    if here is None or whole is None or known[place] not in columns or not whole[place] > 0.0:
        return None
    # of the cross-section that the limit counts, which may be another than that of the section
    factor = float(here.values[limit, columns.index(known[place])] / whole[place])
    return Held(known[place], path, place, factor, "Pa", "")


def _load(held: Held, limit: int, result: Result) -> Quantity | None:
    """Over the speeds of the sweep, with the place of largest use."""
    found = result.record.quantities.get(TORSION + held.path)
    use, at = (vector(result.record, f"limit/{name}", "limit") for name in ("largest_use", "speed"))
    allowed = result.record.quantities.get(f"{TORSION}limit/{held.prefix}allowed")
    if found is None or use is None or at is None or allowed is None:
        return None
    speed = np.asarray(found.axes[1].values, dtype=float)
    values = held.factor * np.asarray(found.values[held.place], dtype=float)
    level = np.interp(at[limit], speed, np.asarray(allowed.values[limit], dtype=float))
    if np.isfinite(use[limit] * level) and at[limit] not in speed:
        there = int(np.searchsorted(speed, at[limit]))
        speed = np.insert(speed, there, at[limit])
        values = np.insert(values, there, use[limit] * level)
    axis = replace(found.axes[1], values=speed)
    return replace(found, path="", values=values, unit=held.unit, axes=(axis,))


def _level(held: Held, limit: int, name: str, result: Result) -> Quantity | None:
    found = result.record.quantities.get(f"{TORSION}limit/{held.prefix}{name}")
    if found is None or not np.any(np.isfinite(found.values[limit])):
        return None
    return replace(found, path="", values=found.values[limit], axes=found.axes[1:])


def _panels(result: Result) -> list[Panel]:
    record, given = result.record, limits_of(result)
    if f"{TORSION}limit/largest_use" not in record:
        return []
    own = [one.get("rule") == "iacs_m53" for one in given]
    if not any(own) and not np.any(of_torque(record)):
        return []
    panels = []
    for limit, one in enumerate(given[:_MOST]):
        held = _held(record, limit)
        if held is None:
            continue
        line = {"color": LIMIT, "linewidth": 1.4, "marker": ""}
        parts: list[Mark] = [
            Curve(partial(_load, held, limit), held.name, {"color": TOTAL, "marker": ""}),
            Curve(partial(_level, held, limit, "allowed"), "allowed for lasting", line),
            Curve(
                partial(_level, held, limit, "transient"),
                "for passing through",
                {**line, "linestyle": "-."},
            ),
            operating,
            partial(_exceeded, limit),
        ]
        label = "stress" if held.unit == "Pa" else "torque"
        words = f"limit {limit + 1}: {rule_of(one).name}"
        unit = "N/mm^2" if held.unit == "Pa" else torque_words(result)
        panel = Panel(label, tuple(parts), words, unit, ends=(0.0, None), legend=_BESIDE)
        panels.append(panel)
    return panels


def _exceeded(limit: int, plot: Plot) -> None:
    """Ranges in which this limit is exceeded for lasting operation."""
    low, high, which = (
        vector(plot.result.record, f"exceeded/{name}", "exceeded")
        for name in ("from", "to", "limit")
    )
    if low is None or high is None or which is None:
        return
    for start, end in zip(low[which == limit + 1], high[which == limit + 1], strict=True):
        to_rpm = 30.0 / np.pi
        plot.axes.axvspan(to_rpm * start, to_rpm * end, color="#E69F00", alpha=0.25, zorder=0)


TORSION_LIMITS = Curves(
    "stress and torque, half range of all orders, against their limits", _panels, high=1.9
)
