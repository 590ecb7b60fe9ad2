"""The damper found for a shaft line: its values, what it brings, what proves it, what it bears."""

import numpy as np

from vibecalc.core.report.sections import (
    SCALARS,
    Section,
    by_axis,
    having,
    scalar_of,
    speed_of,
    table_of,
)
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.torsion.report.line import turns

DESIGN = "damper_design/"
#: objective -> factor, unit, name
OBJECTIVES = {
    "torque": (1.0, "N*m", "torque"),
    "twist": (1e3, "mrad", "twist"),
    "stress": (1e-6, "N/mm^2", "stress"),
}
_KINDS = {0: "section", 1: "heat", 2: "travel"}


def damper_design(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(DESIGN))
    if not shown:
        return None
    lines = paragraph(_verdict(result))
    outside = _outside(result)
    if outside:
        lines += paragraph(outside)
    for block in (
        _compared(result), _proof(result), _sensitivity(record), _rings(result), _basins(record),
    ):  # fmt: skip
        if block:
            lines += ["", *block]
    return Section("Design of the damper", lines, shown)


def objective_of(result: Result) -> str:
    """What was made small: torque, twist or stress."""
    return str(table_of(result.case, "damper_design").get("objective", "torque"))


def section_name(record: Record, number_: float | None) -> str:
    """Name of a section by its number from 1; the number where no name is known."""
    if number_ is None:
        return "-"
    for path in ("response/torsion/torque_half_range", "response/torsion/speeds/torque_half_range"):
        found = record.quantities.get(path)
        if found is not None and found.axes[0].name == "section":
            names = found.axes[0].values
            if 0 < int(number_) <= len(names):
                return str(names[int(number_) - 1])
    return f"number {int(number_)}"


def _verdict(result: Result) -> str:
    record, name = result.record, objective_of(result)
    factor, unit, words = OBJECTIVES[name]
    worst = scalar_of(record, f"{DESIGN}worst_{name}") or 0.0
    stiffness = scalar_of(record, DESIGN + "stiffness") or 0.0
    damping = scalar_of(record, DESIGN + "damping") or 0.0
    text = (
        f"Least largest half range of the {words} over the range of speeds: "
        f"{show(factor * worst, digits=5)} {unit}, with springs of {show(stiffness)} N*m/rad and a "
        f"damping of {show(damping)} N*m*s/rad."
    )
    gain = scalar_of(record, DESIGN + "table/gain")
    if gain is not None:
        text += f" With the table value it is {show(gain, digits=4)} times as high."
    pull = having(record, DESIGN + "pull", "design_value")
    if pull is not None:
        held = [str(n) for n, v in zip(pull.axes[0].values, pull.values, strict=True) if v != 0.0]
        if held:
            text += f" It stands on a bound: {', '.join(held)}."
    return text


def _outside(result: Result) -> str:
    """Said where the machine runs at a speed that the design did not look at."""
    given = table_of(result.case, "damper_design", "speeds") or table_of(
        result.case, "response", "torsion", "speeds"
    )
    speed = speed_of(result)
    if speed is None or "from" not in given or "to" not in given:
        return ""
    low, high = float(given["from"]), float(given["to"])
    if low <= speed <= high:
        return ""
    return (
        f"The damper is tuned over {turns(low)} to {turns(high)} rpm; the operating speed, "
        f"{turns(speed)} rpm, lies outside: it is no part of the design."
    )


def _compared(result: Result) -> list[str]:
    """The damper found beside the table value."""
    record, name = result.record, objective_of(result)
    factor, unit, words = OBJECTIVES[name]
    given = table_of(result.case, "damper_design", "compare")
    rows = []

    def put(title: str, key: str, scale: float, unit_: str, table_value: object = None) -> None:
        quantity = record.quantities.get(DESIGN + key)
        if quantity is None:
            return
        other = scalar_of(record, DESIGN + "table/" + key)
        if isinstance(table_value, int | float):
            other = float(table_value)
        value = show(scale * float(quantity.values), scale * quantity.error_estimate)
        beside = [] if not given else ["" if other is None else show(scale * other)]
        rows.append([title, value, *beside, unit_])

    put("inertia of the ring", "inertia", 1.0, "kg*m^2")
    put("stiffness", "stiffness", 1.0, "N*m/rad", given.get("stiffness"))
    put("damping", "damping", 1.0, "N*m*s/rad", given.get("damping"))
    put("own frequency", "own_frequency", 1.0, "rad/s")
    put("own damping ratio", "own_damping", 1.0, "")
    put(f"largest half range, {words}", f"worst_{name}", factor, unit)
    put("  at the speed", "worst_speed", rpm(1.0), "rpm")
    put("heat in the damper", "heat", 1.0, "W")
    put("  at the speed", "heat_speed", rpm(1.0), "rpm")
    put("travel of the ring", "travel", 1e3, "mrad")
    put("  at the speed", "travel_speed", rpm(1.0), "rpm")
    beside = [number("table value", 16)] if given else []
    lines = table([*SCALARS[:2], *beside, SCALARS[2]], rows)
    place = section_name(record, scalar_of(record, DESIGN + "worst_section"))
    lines += paragraph(f"The largest half range is in section {place}.")
    return lines


def _proof(result: Result) -> list[str]:
    record = result.record
    kind = having(record, DESIGN + "active/kind", "active")
    if kind is None:
        return []
    parts = {
        name: np.asarray(record[f"{DESIGN}active/{name}"].values, dtype=float)
        for name in ("section", "speed", "level", "weight")
    }
    columns = (Column("held by", 34), number("at, rpm", 12), number("level", 12),
               number("weight", 12))  # fmt: skip
    rows = []
    for i, code in enumerate(kind.values):
        what = _KINDS[int(code)]
        name = f"section {section_name(record, parts['section'][i])}" if what == "section" else what
        rows.append([name, show(rpm(parts["speed"][i])), show(parts["level"][i], digits=5),
                     show(parts["weight"][i], digits=4)])  # fmt: skip
    lines = table(columns, rows)
    left = scalar_of(record, DESIGN + "certificate")
    if left is not None:
        lines += paragraph(
            "The weighted slopes of these summits by spring and damper cancel (left over: "
            f"{show(left, digits=2)}): no small change lowers them all. That no other valley is "
            "deeper rests on a map of the whole range."
        )
    return lines


def _sensitivity(record: Record) -> list[str]:
    found = having(record, DESIGN + "sensitivity", "stiffness_factor", "damping_factor")
    if found is None:
        return []
    across = [show(float(v), digits=4) for v in found.axes[1].values]
    columns = (Column("stiffness times", 18), *(number(f"damping\ntimes {v}", 14) for v in across))
    rows = [
        [show(float(k), digits=4), *(f"{100.0 * (float(v) - 1.0):+.2f} %" for v in row)]
        for k, row in zip(found.axes[0].values, found.values, strict=True)
    ]
    return [*paragraph("What errors of spring and damper cost:"), *table(columns, rows)]


def _rings(result: Result) -> list[str]:
    name = objective_of(result)
    factor, unit, _ = OBJECTIVES[name]
    return by_axis(
        result.record, "ring_inertia", "ring, kg*m^2",
        [(f"{DESIGN}ring/{name}", f"largest half\nrange, {unit}"),
         (DESIGN + "ring/stiffness", "stiffness\nN*m/rad"),
         (DESIGN + "ring/damping", "damping\nN*m*s/rad")],
        factors=[factor, 1.0, 1.0], each=18,
    )  # fmt: skip


def _basins(record: Record) -> list[str]:
    worst = having(record, DESIGN + "basin/worst", "basin")
    if worst is None or len(worst.values) < 2:
        return []
    apart = float(np.max(worst.values)) - 1.0
    return paragraph(
        f"{len(worst.values)} descents from the valleys of the map ended within "
        f"{show(100.0 * apart, digits=2)} % of the best."
    )
