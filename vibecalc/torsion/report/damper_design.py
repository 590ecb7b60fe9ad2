"""The optimal damper of a shaft line: its values, its effect, the proof, what deviations cost."""

from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import Cells, Rows, by_axis, part_of, rows_of
from vibecalc.core.report.sections import Section, having, scalar_of, stacked, table_of
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import Detail, cell, joined, names, torque_unit, turns
from vibecalc.torsion.report.vibration import in_turns
from vibecalc.units import convert

DESIGN = "damper_design/"
#: objective -> unit that people read
OBJECTIVES = {"torque": "N*m", "twist": "mrad", "stress": "N/mm^2"}
_KINDS = {0: "section", 1: "heat", 2: "travel"}
_CERTIFIED = (
    "The weighted slopes of these peaks by spring and damper cancel (residual {}): no small change "
    "lowers them all. That no other minimum is lower rests on a map of the whole range."
)


def damper_design(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(DESIGN))
    if not shown:
        return None
    lines = stacked(_compared(result), _sensitivity(record), _rings(result))
    proof = Detail(result, _proof, _basins)
    return Section("Design of the damper", lines, shown, "proof of the optimum", proof)


def objective_of(result: Result) -> str:
    """What was made small: torque, twist or stress."""
    return str(table_of(result.case, "damper_design").get("objective", "torque"))


def _unit(record: Record, name: str) -> str:
    """As in `OBJECTIVES`, torques in the unit of the report."""
    return torque_unit(record)[1] if name == "torque" else OBJECTIVES[name]


def _section_name(record: Record, number_: float) -> str:
    """Name of a section by its number from 1; the number where no name is known."""
    known = names(record, "torque_half_range", "section")
    known = known or names(record, "speeds/torque_half_range", "section")
    place = int(number_)
    return known[place - 1] if 0 < place <= len(known) else f"number {place}"


def _compared(result: Result) -> list[str]:
    """The optimal damper and the one to compare it with."""
    record, name = result.record, objective_of(result)
    given = table_of(result.case, "damper_design", "compare")
    rows = []
    for title, key, unit in (
        ("inertia of the ring", "inertia", "kg*m^2"),
        ("stiffness", "stiffness", "kN*m/rad"),
        ("damping", "damping", "N*m*s/rad"),
        ("natural frequency of the ring, station held", "natural_frequency", "Hz"),
        ("damping ratio of the ring, station held", "damping_ratio", ""),
        (f"largest {name}, half range", f"worst_{name}", _unit(record, name)),
        ("  at", "worst_speed", "rpm"),
        ("  times the optimum", "gain", ""),
        ("heat in the damper, mean", "heat", "W"),
        ("  at", "heat_speed", "rpm"),
        ("travel of the ring, peak", "travel", "mrad"),
        ("  at", "travel_speed", "rpm"),
    ):
        quantity = record.quantities.get(DESIGN + key)
        known = quantity or record.quantities.get(f"{DESIGN}table/{key}")
        if known is None:
            continue
        scale = convert(1.0, known.unit, unit) if unit else 1.0
        other = scalar_of(record, f"{DESIGN}table/{key}")
        other = given.get(key) if other is None else other
        compared = "" if other is None else show(scale * other)
        rows.append([title, cell(quantity, (), scale), compared, unit])
    columns = (Column("quantity"), number("optimum"), number("compared"), Column("unit"))
    held, speed = _held(record), having(record, DESIGN + "active/speed", "active")
    if held is not None and speed is not None:
        both = zip(held.values, speed.values, strict=True)
        words = f"The optimum is held by {joined(f'{of} at {turns(w)} rpm' for of, w in both)}."
    else:
        place = scalar_of(record, DESIGN + "worst_section")
        section = "-" if place is None else _section_name(record, place)
        words = f"The largest half range is in section {section}."
    pull = having(record, DESIGN + "bound_sensitivity", "design_value")
    if pull is not None and np.any(pull.values):
        bounds = ", ".join(str(name) for name in pull.axes[0].values[pull.values != 0.0])
        words += f" It stands on a bound: {bounds}."
    return [*table(columns, rows), *paragraph(words)]


def _held(record: Record) -> Quantity | None:
    """What holds the optimum: a section, heat or travel."""
    kind, section = (having(record, f"{DESIGN}active/{n}", "active") for n in ("kind", "section"))
    if kind is None or section is None:
        return None
    words = [
        _KINDS[int(code)] + (f" {_section_name(record, place)}" if code == 0 else "")
        for code, place in zip(kind.values, section.values, strict=True)
    ]
    return part_of(kind, np.array(words), *kind.axes)


_ACTIVE = Rows("active", "", (
    Cells(_held, "held by"),
    Cells("speed", "at, rpm", in_turns),
    Cells("level", "level"),
    Cells("weight", "weight"),
), f"{DESIGN}active")  # fmt: skip


def _proof(result: Result) -> list[str]:
    """What carries the optimum, and that no small change lowers it."""
    lines, _ = rows_of(result.record, _ACTIVE)
    left = scalar_of(result.record, DESIGN + "certificate")
    if lines and left is not None:
        lines += paragraph(_CERTIFIED.format(show(left, digits=2)))
    return lines


def _sensitivity(record: Record) -> list[str]:
    above = "Largest half range with other springs and damping, against the optimum:"
    cells = Cells(_increases, "damping\ntimes {}", right=True)
    rows = Rows("stiffness_factor", "stiffness times", [cells], label="{:g}", above=above)
    return rows_of(record, rows)[0]


def _increases(record: Record) -> Quantity | None:
    """In percent, below the factors on the damping in words."""
    found = having(record, f"{DESIGN}sensitivity", "stiffness_factor", "damping_factor")
    if found is None:
        return None
    share = found.values - 1.0
    words = [[f"{100.0 * one:+.2f} %" if abs(one) > 5e-5 else "0" for one in row] for row in share]
    times = replace(found.axes[1], values=np.array([f"{one:g}" for one in found.axes[1].values]))
    return part_of(found, np.array(words), found.axes[0], times)


def _rings(result: Result) -> list[str]:
    name = objective_of(result)
    return by_axis(
        result.record, "ring_inertia", "ring, kg m^2",
        [(f"{DESIGN}ring/{name}", "largest half\nrange,", _unit(result.record, name)),
         (DESIGN + "ring/stiffness", "stiffness\n", "kN*m/rad"),
         (DESIGN + "ring/damping", "damping\n", "N*m*s/rad")],
    )  # fmt: skip


def _basins(result: Result) -> list[str]:
    worst = having(result.record, DESIGN + "basin/worst", "basin")
    if worst is None or len(worst.values) < 2:
        return []
    apart = show(100.0 * (float(np.max(worst.values)) - 1.0), digits=2)
    words = f"{len(worst.values)} descents from the minima of the map ended within {apart} % of "
    return paragraph(words + "the best.")
