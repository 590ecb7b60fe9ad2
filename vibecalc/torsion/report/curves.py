"""Orders of named shafts and stations, cyclic irregularity and the worst condition in words."""

from collections.abc import Iterator

import numpy as np

from vibecalc.core.report.rows import Cells, Found, Made, Rows, named_at, part_of, rows_of
from vibecalc.core.report.sections import Section, labels, magnitudes
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.curve_results import QUANTITIES
from vibecalc.torsion.report.line import (
    MEGA,
    MILLI,
    TORSION,
    Detail,
    cell,
    order_text,
    range_words,
    short,
    torque_unit,
    turns,
)

# ----------------------------------------------------------------------------
# Curves of orders: the largest of each order over the speeds, and what was measured.
# ----------------------------------------------------------------------------

#: orders of a shaft or station, measured points of a quantity
_MOST, _POINTS = 6, 40


def units(record: Record) -> dict[str, tuple[float, str]]:
    """Quantity -> factor from SI and the unit that people read."""
    return {
        "torque": torque_unit(record),
        "stress": (MEGA, "N/mm^2"),
        "twist": (MILLI, "mrad"),
        "angle": (MILLI, "mrad"),
        "angular_speed": (1.0, "rad/s"),
        "angular_acceleration": (1.0, "rad/s^2"),
    }


def drawn(record: Record) -> Iterator[tuple[str, Quantity]]:
    """Names and orders of the quantities that a result has curves of."""
    for name in QUANTITIES:
        found = record.quantities.get(f"{TORSION}curves/{name}/order")
        if found is not None:
            yield name, found


def torsion_curves(result: Result) -> Section | None:
    """The section, None if no curves are asked for."""
    record = result.record
    lines: list[str] = []
    for name, found in drawn(record):
        lines += ["", *_largest(record, name, found)] if lines else _largest(record, name, found)
    if not lines:
        return None
    lines += paragraph(
        "Amplitudes of single orders, the largest over the speeds; sum of orders: half range of "
        "all of them with their phases at the speeds of the curves."
    )
    points = _measured(record)
    return Section(
        f"Curves of orders, {range_words(result)}",
        [*lines, *(["", *points] if points else [])],
        frozenset(),
    )


def _largest(record: Record, name: str, found: Quantity) -> list[str]:
    """For each shaft or station of a quantity its strongest orders, and their sum."""
    factor, unit = units(record)[name]
    stem = f"{TORSION}curves/{name}"
    top, at, half = (record[f"{stem}/{one}"] for one in ("largest", "largest_speed", "half_range"))
    orders, speed = top.axes[1].values, half.axes[1].values
    columns = [
        Column(found.axes[0].name), Column("order"),
        number(f"{name.replace('_', ' ')}\n{unit}"), number("at\nrpm")
    ]  # fmt: skip
    rows = []
    for place, one in enumerate(labels(found.axes[0])):
        sizes = magnitudes(top)[place]
        strongest = np.sort(np.argsort(-sizes, kind="stable")[:_MOST])
        best = int(np.argmax(half.values[place]))
        whole = cell(half, (place, best), factor)
        if np.isinf(sizes).any():  # between the speeds of the curve
            whole = show(np.inf)
        rows.append([one, "sum of orders", whole, turns(float(speed[best]))])
        rows += [
            ["", order_text(orders[i]), cell(top, (place, int(i)), factor),
             turns(float(at.values[place, i]))]
            for i in strongest
        ]  # fmt: skip
    return table(columns, rows)


def _measured(record: Record) -> list[str]:
    """Measured points next to what is computed."""
    rows = []
    for name, found in drawn(record):
        stem = f"{TORSION}curves/{name}/measured"
        value = record.quantities.get(f"{stem}/value")
        if value is None:
            continue
        factor, unit = units(record)[name]
        axis = found.axes[0]
        own, speed, order, computed = (
            record[f"{stem}/{one}"] for one in (axis.name, "speed", "order", "computed")
        )
        named = labels(axis)
        for i in range(min(value.values.size, _POINTS)):
            ratio = value.values[i] / computed.values[i] if computed.values[i] else np.inf
            rows.append([
                named[int(own.values[i]) - 1], f"{name.replace('_', ' ')}, {unit}",
                order_text(order.values[i]) if order.values[i] else "sum",
                turns(float(speed.values[i])), cell(value, i, factor), cell(computed, i, factor),
                show(ratio, digits=3),
            ])  # fmt: skip
    if not rows:
        return []
    columns = [
        Column("measured on"), Column("quantity"), number("order"), number("rpm"),
        number("measured"), number("computed"), number("ratio")
    ]  # fmt: skip
    return table(columns, rows)


# ----------------------------------------------------------------------------
# Cyclic irregularity.
# ----------------------------------------------------------------------------


def torsion_irregularity(result: Result) -> Section | None:
    """The section, None if no station is asked for."""
    lines, _ = rows_of(result.record, _IRREGULARITY)
    return Section("Cyclic irregularity", lines, frozenset()) if lines else None


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


_ALL = f"{TORSION}conditions"
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
    digits=4,
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
    unit = torque_unit(record)[1].replace(" ", "*")
    stress, largest = f"{_ALL}/stress_half_range", f"{_ALL}/largest"
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
    lines, _ = rows_of(record, Rows("section", "section", columns, digits=4, note=words))
    uses, _ = rows_of(record, _USES)
    return Section(
        "Misfire and imbalance: the worst condition of each section",
        [*lines, *(["", *uses] if uses else [])],
        frozenset(),
        "every condition at the operating speed",
        Detail(result, _every),
    )


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
    digits=4,
    places=_highest,
    note="Load over that allowed for lasting.",
)


def _every(result: Result) -> list[str]:
    """Largest torque, stress and angle of each condition at the operating speed."""
    unit = torque_unit(result.record)[1].replace(" ", "*")
    torque, angle = (f"{_ALL}/{name}_half_range" for name in ("torque", "angle"))
    columns = (
        Cells(f"{_ALL}/mean_torque", "mean torque\n{unit}", unit),
        Cells(_worst(torque, "section"), "torque\n{unit}", unit),
        Cells(_worst(torque, "section", named=True), "in section"),
        Cells(_worst(f"{_ALL}/stress_half_range", "section"), "stress\n{unit}", "N/mm^2"),
        Cells(_worst(angle, "station"), "angle\n{unit}", "mrad"),
        Cells(_worst(angle, "station", named=True), "of station"),
    )
    lines, _ = rows_of(result.record, Rows("condition", "condition", columns, digits=4))
    words = "The largest half range of each condition at the operating speed:"
    return [*paragraph(words), *lines]
