"""The optimal damper of a shaft line: its values, its effect, the proof, what deviations cost."""

import numpy as np

from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    Section,
    having,
    scalar_of,
    table_of,
)
from vibecalc.core.report.writing import Column, hertz, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Record, Result
from vibecalc.torsion.report.line import Detail, cell, joined, torque_unit, turns

DESIGN = "damper_design/"
#: objective -> factor, unit, name
OBJECTIVES = {
    "torque": (1.0, "N m", "torque"),
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
    lines = _compared(result)
    for block in (_sensitivity(record), _rings(result)):
        lines += ["", *block] if block else []
    proof = Detail(result, _proof, lambda one: _basins(one.record))
    return Section("Design of the damper", lines, shown, "proof of the optimum", proof)


def objective_of(result: Result) -> str:
    """What was made small: torque, twist or stress."""
    return str(table_of(result.case, "damper_design").get("objective", "torque"))


def _objective(record: Record, name: str) -> tuple[float, str, str]:
    """As in `OBJECTIVES`, torques in the unit of the report."""
    return (*torque_unit(record), name) if name == "torque" else OBJECTIVES[name]


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


def _compared(result: Result) -> list[str]:
    """The optimal damper and the one to compare it with."""
    record, name = result.record, objective_of(result)
    factor, unit, words = _objective(record, name)
    given = table_of(result.case, "damper_design", "compare")
    rows = []
    for title, key, scale, unit_ in (
        ("inertia of the ring", "inertia", 1.0, "kg m^2"),
        ("stiffness", "stiffness", 1e-3, "kN m/rad"),
        ("damping", "damping", 1.0, "N m s/rad"),
        ("natural frequency of the ring, station held", "natural_frequency", hertz(1.0), "Hz"),
        ("damping ratio of the ring, station held", "damping_ratio", 1.0, ""),
        (f"largest {words}, half range", f"worst_{name}", factor, unit),
        ("  at", "worst_speed", rpm(1.0), "rpm"),
        ("  times the optimum", "gain", 1.0, ""),
        ("heat in the damper, mean", "heat", 1.0, "W"),
        ("  at", "heat_speed", rpm(1.0), "rpm"),
        ("travel of the ring, peak", "travel", 1e3, "mrad"),
        ("  at", "travel_speed", rpm(1.0), "rpm"),
    ):
        quantity = record.quantities.get(DESIGN + key)
        other = scalar_of(record, DESIGN + "table/" + key)
        if other is None and isinstance(given.get(key), int | float):
            other = float(given[key])
        if quantity is None and other is None:
            continue
        rows.append([
            title, cell(quantity, (), scale),
            "" if other is None else show(scale * other, digits=4), unit_,
        ])  # fmt: skip
    columns = (Column("quantity"), number("optimum"), number("compared"),
               Column("unit"))  # fmt: skip
    held = joined(f"{name} at {turns(speed)} rpm" for name, speed in _active(record))
    place = section_name(record, scalar_of(record, DESIGN + "worst_section"))
    words = (
        f"The optimum is held by {held}."
        if held
        else f"The largest half range is in section {place}."
    )
    pull = having(record, DESIGN + "bound_sensitivity", "design_value")
    if pull is not None and np.any(pull.values):
        bounds = ", ".join(str(name) for name in pull.axes[0].values[pull.values != 0.0])
        words += f" It stands on a bound: {bounds}."
    return [*table(columns, rows), *paragraph(words)]


def _active(record: Record) -> list[tuple[str, float]]:
    """What holds the optimum, and at which speed in rad/s."""
    kind, section, speed = (
        having(record, f"{DESIGN}active/{name}", "active") for name in ("kind", "section", "speed")
    )
    if kind is None or section is None or speed is None:
        return []
    names = [
        _KINDS[int(code)] + (f" {section_name(record, place)}" if code == 0 else "")
        for code, place in zip(kind.values, section.values, strict=True)
    ]
    return list(zip(names, map(float, speed.values), strict=True))


def _proof(result: Result) -> list[str]:
    """What carries the optimum, and that no small change lowers it."""
    record = result.record
    held = _active(record)
    level, weight = (having(record, f"{DESIGN}active/{n}", "active") for n in ("level", "weight"))
    if not held or level is None or weight is None:
        return []
    columns = (Column("held by"), number("at, rpm"), number("level"),
               number("weight"))  # fmt: skip
    rows = [
        [name, turns(speed), cell(level, i), cell(weight, i)]
        for i, (name, speed) in enumerate(held)
    ]
    lines = table(columns, rows)
    left = scalar_of(record, DESIGN + "certificate")
    if left is not None:
        lines += paragraph(
            "The weighted slopes of these peaks by spring and damper cancel (residual "
            f"{show(left, digits=2)}): no small change lowers them all. That no other minimum is "
            "lower rests on a map of the whole range."
        )
    return lines


def _sensitivity(record: Record) -> list[str]:
    quantity = having(record, DESIGN + "sensitivity", "stiffness_factor", "damping_factor")
    if quantity is None:
        return []
    across = [f"{float(v):g}" for v in quantity.axes[1].values]
    columns = (Column("stiffness times"), *(number(f"damping\ntimes {v}") for v in across))
    rows = [
        [f"{float(k):g}", *(_increase(float(v) - 1.0) for v in row)]
        for k, row in zip(quantity.axes[0].values, quantity.values, strict=True)
    ]
    words = "Largest half range with other springs and damping, against the optimum:"
    return [*paragraph(words), *table(columns, rows)]


def _increase(share: float) -> str:
    return f"{100.0 * share:+.2f} %" if abs(share) > 5e-5 else "0"


def _rings(result: Result) -> list[str]:
    name = objective_of(result)
    _, unit, _ = _objective(result.record, name)
    return by_axis(
        result.record, "ring_inertia", "ring, kg m^2",
        [(f"{DESIGN}ring/{name}", "largest half\nrange,", unit.replace(" ", "*")),
         (DESIGN + "ring/stiffness", "stiffness\n", "kN*m/rad"),
         (DESIGN + "ring/damping", "damping\n", "N*m*s/rad")], digits=4,
    )  # fmt: skip


def _basins(record: Record) -> list[str]:
    worst = having(record, DESIGN + "basin/worst", "basin")
    if worst is None or len(worst.values) < 2:
        return []
    apart = float(np.max(worst.values)) - 1.0
    return paragraph(
        f"{len(worst.values)} descents from the minima of the map ended within "
        f"{show(100.0 * apart, digits=2)} % of the best."
    )
