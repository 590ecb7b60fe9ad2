"""Orders of named shafts and stations, cyclic irregularity and the worst condition in words."""

from collections.abc import Iterator

import numpy as np

from vibecalc.core.report.rows import Cells, Found, Made, Rows, named_at, part_of, rows_of
from vibecalc.core.report.sections import Section, labels, magnitudes
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    TORSION,
    cell,
    order_text,
    range_words,
    short,
    titled,
    torque_unit,
    turns,
)
from vibecalc.torsion.results import QUANTITIES
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# Curves of orders: the largest of each order over the speeds, and what was measured.
# ----------------------------------------------------------------------------

#: orders of a shaft or station, measured points of a quantity
_MOST, _POINTS = 6, 40
#: what is read in other units than those of results
_READ = {"stress": "N/mm^2", "twist": "mrad", "angle": "mrad"}
_AMPLITUDES = (
    "Amplitudes of single orders, the largest over the speeds; sum of orders: half range of "
    "all of them with their phases at the speeds of the curves."
)


def drawn(record: Record) -> Iterator[tuple[str, Quantity]]:
    """Names and orders of the quantities that a result has curves of."""
    for name in QUANTITIES:
        found = record.quantities.get(f"{TORSION}curves/{name}/order")
        if found is not None:
            yield name, found


def _unit(record: Record, name: str, of: Quantity) -> tuple[float, str]:
    """Factor from SI and the unit that people read."""
    unit = torque_unit(record)[1] if name == "torque" else _READ.get(name, of.unit)
    return convert(1.0, of.unit, unit), unit


def torsion_curves(result: Result) -> Section | None:
    """The section, None if no curves are asked for."""
    record = result.record
    tables = [_largest(record, name, found) for name, found in drawn(record)]
    if not tables:
        return None
    tables[-1] += paragraph(_AMPLITUDES)
    title = f"Curves of orders, {range_words(result)}"
    return titled(result, title, *tables, _measured(record))


def _largest(record: Record, name: str, found: Quantity) -> list[str]:
    """For each shaft or station of a quantity its strongest orders, and their sum."""
    factor, unit = _unit(record, name, found)
    stem = f"{TORSION}curves/{name}"
    top, at, half = (record[f"{stem}/{one}"] for one in ("largest", "largest_speed", "half_range"))
    speed, rows = half.axes[1].values, list[list[str]]()
    for place, one in enumerate(labels(found.axes[0])):
        sizes = magnitudes(top)[place]
        best = int(np.argmax(half.values[place]))
        # between the speeds of the curve
        endless = np.isinf(sizes).any()
        whole = show(np.inf) if endless else cell(half, (place, best), factor)
        rows.append([one, "sum of orders", whole, turns(speed[best])])
        rows += [
            ["", order_text(top.axes[1].values[i]), cell(top, (place, i), factor),
             turns(at.values[place, i])]
            for i in np.sort(np.argsort(-sizes, kind="stable")[:_MOST]).tolist()
        ]  # fmt: skip
    heads = [Column(found.axes[0].name), Column("order")]
    return table([*heads, number(f"{name.replace('_', ' ')}\n{unit}"), number("at\nrpm")], rows)


def _measured(record: Record) -> list[str]:
    """Measured points next to what is computed."""
    rows = []
    for name, found in drawn(record):
        stem = f"{TORSION}curves/{name}/measured"
        if f"{stem}/value" not in record:
            continue
        (factor, unit), axis = _unit(record, name, found), found.axes[0]
        value, own, speed, order, computed = (
            record[f"{stem}/{one}"] for one in ("value", axis.name, "speed", "order", "computed")
        )
        for i in range(min(value.values.size, _POINTS)):
            ratio = value.values[i] / computed.values[i] if computed.values[i] else np.inf
            rows.append([
                labels(axis)[int(own.values[i]) - 1], f"{name.replace('_', ' ')}, {unit}",
                order_text(order.values[i]) if order.values[i] else "sum",
                turns(speed.values[i]), cell(value, i, factor), cell(computed, i, factor),
                show(ratio, digits=3),
            ])  # fmt: skip
    heads = ("order", "rpm", "measured", "computed", "ratio")
    return table([Column("measured on"), Column("quantity"), *map(number, heads)], rows)


# ----------------------------------------------------------------------------
# Cyclic irregularity.
# ----------------------------------------------------------------------------

_ALL = f"{TORSION}conditions"


def torsion_irregularity(result: Result) -> Section | None:
    """The section, None if no station is asked for."""
    return titled(result, "Cyclic irregularity", rows_of(result.record, _IRREGULARITY)[0])


def _over(degree: float, _error: float) -> str:
    return short(1.0 / degree) if 0.0 < degree < np.inf else "-"


def _worst(path: str, along: str, named: bool = False) -> Made:
    """The largest of each entry along another axis, or the name of where it is."""

    def made(record: Record) -> Quantity | None:
        found = record.quantities.get(path)
        if found is None:
            return None
        over = [axis.name for axis in found.axes].index(along)
        place, other = np.argmax(found.values, axis=over), found.axes[1 - over]
        names = np.array(labels(found.axes[over]), dtype=object)
        values = names[place].astype(str) if named else np.max(found.values, axis=over)
        return part_of(found, values, other)

    return made


_IRREGULARITY = Rows(
    "station",
    "station",
    (
        Cells("degree", "at speed"),
        Cells("degree", "1 : x", _over),
        Cells("largest/degree", "largest"),
        Cells("largest/degree", "1 : x", _over),
        Cells("largest/speed", "at\nrpm", "rpm"),
        Cells("electrical_angle", "el. angle at\nspeed, deg", "deg"),
        Cells(_worst(f"{_ALL}/irregularity", "condition"), "worst"),
        Cells(_worst(f"{_ALL}/irregularity", "condition", named=True), "at speed in"),
    ),
    root=f"{TORSION}irregularity",
    note="Cyclic irregularity: highest less lowest angular speed of the station over its mean, "
    "within a cycle; turning of the whole line and vibration together. Electrical angle: half "
    "range of the vibration times the pole pairs.",
)


# ----------------------------------------------------------------------------
# Conditions of the cylinders: which of them is the worst, and what it does.
# ----------------------------------------------------------------------------

_CONDITIONS = 12


def torsion_conditions(result: Result) -> Section | None:
    """The section, None if no conditions are asked for."""
    record, torque = result.record, f"{_ALL}/torque_half_range"
    if torque not in record:
        return None
    unit, stress, largest = torque_unit(record)[1], f"{_ALL}/stress_half_range", f"{_ALL}/largest"
    columns = (
        Cells(_all_fire, "all fire\n{unit}", unit),
        Cells(_worst(torque, "condition"), "worst\n{unit}", unit),
        Cells(_worst(stress, "condition"), "stress\n{unit}", "N/mm^2"),
        Cells(_worst(torque, "condition", named=True), "at speed in"),
        Cells(f"{largest}/torque_half_range", "largest\n{unit}", unit),
        Cells(f"{largest}/stress_half_range", "stress\n{unit}", "N/mm^2"),
        Cells(f"{largest}/section_speed", "at\n{unit}", "rpm"),
        Cells(named_at(f"{largest}/section_condition", torque), "condition"),
    )
    words = (
        f"Half ranges in the worst of {len(record[torque].axes[0].values)} conditions of the "
        "cylinders, at the operating speed and at any speed of the range."
    )
    title = "Misfire and imbalance: the worst condition of each section"
    blocks = [rows_of(record, one)[0]
              for one in (Rows("section", "section", columns, note=words), _USES)]  # fmt: skip
    details = {"every condition at the operating speed": [_every]}
    return titled(result, title, *blocks, details=details)


def _all_fire(record: Record) -> Quantity | None:
    """Torques of the first condition."""
    found = record[f"{_ALL}/torque_half_range"]
    return part_of(found, found.values[0], found.axes[1])


def _highest(found: Found) -> np.ndarray:
    """Conditions of the largest uses of limits, the worst first."""
    most = found[0].values.max(axis=1)
    return np.argsort(-most, kind="stable")[:_CONDITIONS]


_USES = Rows(
    "condition",
    "condition",
    (
        Cells("largest_use", "limit {}\nuse, %", "%"),
        Cells("speed", "{} at\nrpm", "rpm"),
        Cells("operating_use", "{} at\nspeed, %", "%"),
    ),
    root=f"{_ALL}/limit",
    places=_highest,
    note="Load over that allowed for lasting.",
)


def _every(result: Result) -> list[str]:
    """Largest torque, stress and angle of each condition at the operating speed."""
    unit = torque_unit(result.record)[1]
    torque, angle = (f"{_ALL}/{name}_half_range" for name in ("torque", "angle"))
    columns = (
        Cells(f"{_ALL}/mean_torque", "mean torque\n{unit}", unit),
        Cells(_worst(torque, "section"), "torque\n{unit}", unit),
        Cells(_worst(torque, "section", named=True), "in section"),
        Cells(_worst(f"{_ALL}/stress_half_range", "section"), "stress\n{unit}", "N/mm^2"),
        Cells(_worst(angle, "station"), "angle\n{unit}", "mrad"),
        Cells(_worst(angle, "station", named=True), "of station"),
    )
    words = "The largest half range of each condition at the operating speed:"
    return rows_of(result.record, Rows("condition", "condition", columns, above=words))[0]
