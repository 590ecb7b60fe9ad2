"""Picture of stresses and torques of a shaft line against speed, each with its limit."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from vibecalc.core.report.canvas import LIMIT, TOTAL
from vibecalc.core.report.curves import Curve, Curves, Panel, Plot, operating
from vibecalc.core.report.sections import having, labels
from vibecalc.core.report.writing import rpm
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.pictures.excitation import torque_words
from vibecalc.torsion.report.limits import limits_of, of_torque, rule_of
from vibecalc.torsion.report.line import TORSION, every, vector

# ----------------------------------------------------------------------------
# A panel for each limit: what it is of in the section or gear of largest use, and what is allowed.
#
# Where a case has limits of stresses by tables and UR M68 alone, these stand in the picture of the
# stresses against the speed, and there is none of these panels.
# ----------------------------------------------------------------------------

#: panels of one picture
_MOST = 8
_BESIDE = {"loc": "upper left", "bbox_to_anchor": (1.005, 1.0)}


def _cross_section(record: Record, limit: int, place: int) -> float | None:
    """Stress of a section over its torque, of the cross-section that the limit counts.

    That may be another than that of the section.
    """
    here = having(record, f"{TORSION}limit/operating/stress", "limit", "section")
    whole = having(record, f"{TORSION}torque_half_range", "section")
    column = None if whole is None or here is None else np.flatnonzero(
        here.axes[1].values == whole.axes[0].values[place])  # fmt: skip
    if here is None or whole is None or column is None or not column.size:
        return None
    torque = float(whole.values[place])
    return float(here.values[limit, column[0]]) / torque if torque > 0.0 else None


def _panel(result: Result, limit: int, rule: str) -> Panel | None:
    """The load of largest use of a limit, counted from 0, and what is allowed."""
    record, torques = result.record, bool(of_torque(result.record)[limit])
    section, gear, use, at = (
        vector(record, f"limit/{name}", "limit")
        for name in ("section", "gear", "largest_use", "speed")
    )
    of_gear = gear is not None and bool(gear[limit])
    load = record.quantities.get(
        f"{TORSION}speeds/{'gear_torque' if of_gear else 'torque_half_range'}"
    )
    if section is None or load is None or use is None or at is None:
        return None
    place = int((gear if of_gear and gear is not None else section)[limit]) - 1
    factor = 1.0 if torques else _cross_section(record, limit, place)
    if factor is None:
        return None
    unit, prefix = ("N*m", "torque_") if torques else ("Pa", "")

    def allowed(name: str) -> Callable[[Result], Quantity | None]:
        found = record.quantities.get(f"{TORSION}limit/{prefix}{name}")
        if found is None or not np.any(np.isfinite(found.values[limit])):
            return lambda _: None
        one = replace(found, path="", values=found.values[limit], axes=found.axes[1:])
        return lambda _: one

    speed = np.asarray(load.axes[1].values, dtype=float)
    values = factor * np.asarray(load.values[place], dtype=float)
    lasting = allowed("allowed")(result)
    top = np.nan
    if lasting is not None:
        top = float(use[limit] * np.interp(at[limit], speed, lasting.values))
    if np.isfinite(top) and at[limit] not in speed:  # the place of largest use
        there = int(np.searchsorted(speed, at[limit]))
        speed, values = np.insert(speed, there, at[limit]), np.insert(values, there, top)
    axes = (replace(load.axes[1], values=speed),)
    curve = replace(load, path="", values=values, unit=unit, axes=axes)
    line = {"color": LIMIT, "linewidth": 1.4, "marker": ""}
    return Panel(
        "torque" if torques else "stress",
        (
            Curve(lambda _: curve, labels(load.axes[0])[place], {"color": TOTAL, "marker": ""}),
            Curve(allowed("allowed"), "allowed for lasting", line),
            Curve(allowed("transient"), "for passing through", {**line, "linestyle": "-."}),
            operating,
            partial(_exceeded, limit),
        ),
        f"limit {limit + 1}: {rule}",
        torque_words(result) if torques else "N/mm^2",
        ends=(0.0, None),
        legend=_BESIDE,
    )


def _panels(result: Result) -> list[Panel]:
    record, given = result.record, limits_of(result)
    own = any(one.get("rule") == "iacs_m53" for one in given) or np.any(of_torque(record))
    if f"{TORSION}limit/largest_use" not in record or not own:
        return []
    made = (_panel(result, i, rule_of(one).name) for i, one in enumerate(given[:_MOST]))
    return [one for one in made if one is not None]


def _exceeded(limit: int, plot: Plot) -> None:
    """Ranges in which this limit is exceeded for lasting operation."""
    found = every(plot.result.record, "exceeded", "exceeded", "from", "to", "limit")
    for start, end, which in np.transpose([one.values for one in found]).tolist():
        if which == limit + 1:
            plot.axes.axvspan(rpm(start), rpm(end), color="#E69F00", alpha=0.25, zorder=0)


TORSION_LIMITS = Curves(
    "stress and torque, half range of all orders, against their limits", _panels, high=1.9
)
