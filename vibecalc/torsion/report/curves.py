"""Orders of named shafts and stations, cyclic irregularity and the worst condition in words."""

from collections.abc import Iterator

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, magnitudes
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.curve_results import QUANTITIES
from vibecalc.torsion.report.line import (
    DEGREES,
    MEGA,
    MILLI,
    TORSION,
    Detail,
    cell,
    entry,
    order_text,
    place_of,
    range_words,
    short,
    torque_unit,
    turns,
    vector,
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
    record = result.record
    here = having(record, f"{TORSION}irregularity/degree", "station")
    if here is None:
        return None
    top = having(record, f"{TORSION}irregularity/largest/degree", "station")
    at = vector(record, "irregularity/largest/speed", "station")
    angle = having(record, f"{TORSION}irregularity/electrical_angle", "station")
    worst = having(record, f"{TORSION}conditions/irregularity", "condition", "station")
    columns = [
        Column("station"), number("at speed"), number("1 : x"),
        number("largest"), number("1 : x"), number("at\nrpm"),
        number("el. angle at\nspeed, deg"), number("worst"),
        Column("at speed in")
    ]  # fmt: skip
    rows = []
    for i, name in enumerate(labels(here.axes[0])):
        row = [name, cell(here, i), _over(here, i)]
        row += ["", "", ""] if top is None else [
            cell(top, i), _over(top, i), "" if at is None else turns(float(at[i]))
        ]  # fmt: skip
        row.append(entry(angle, name, DEGREES))
        if worst is not None:
            condition = int(np.argmax(worst.values[:, i]))
            row += [cell(worst, (condition, i)), labels(worst.axes[0])[condition]]
        else:
            row += ["", ""]
        rows.append(row)
    words = (
        "Cyclic irregularity: highest less lowest angular speed of the station over its mean, "
        "within a cycle; turning of the whole line and vibration together. Electrical angle: half "
        "range of the vibration times the pole pairs."
    )
    return Section("Cyclic irregularity", [*table(columns, rows), *paragraph(words)], frozenset())


def _over(degree: Quantity, place: int) -> str:
    value = float(degree.values[place])
    return short(1.0 / value) if 0.0 < value < np.inf else "-"


# ----------------------------------------------------------------------------
# Conditions of the cylinders: which of them is the worst, and what it does.
# ----------------------------------------------------------------------------

_CONDITIONS = 12


def torsion_conditions(result: Result) -> Section | None:
    """The section, None if no conditions are asked for."""
    record, stem = result.record, f"{TORSION}conditions"
    here = having(record, f"{stem}/torque_half_range", "condition", "section")
    if here is None:
        return None
    conditions, sections = (labels(axis) for axis in here.axes)
    factor, unit = torque_unit(record)
    stress = having(record, f"{stem}/stress_half_range", "condition", "section")
    top = having(record, f"{stem}/largest/torque_half_range", "section")
    top_stress = having(record, f"{stem}/largest/stress_half_range", "section")
    at, which = (
        vector(record, f"conditions/largest/section_{one}", "section")
        for one in ("speed", "condition")
    )
    columns = [
        Column("section"), number(f"all fire\n{unit}"), number(f"worst\n{unit}"),
        number("stress\nN/mm^2"), Column("at speed in"), number(f"largest\n{unit}"),
        number("stress\nN/mm^2"), number("at\nrpm"), Column("condition")
    ]  # fmt: skip
    rows = []
    for i, name in enumerate(sections):
        worst = int(np.argmax(here.values[:, i]))
        own = _column(stress, name)
        row = [name, cell(here, (0, i), factor), cell(here, (worst, i), factor),
               "" if stress is None or own is None else cell(stress, (worst, own), MEGA),
               conditions[worst]]  # fmt: skip
        if top is not None and at is not None and which is not None:
            place = place_of(top_stress, name)
            row += [
                cell(top, i, factor), "" if place is None else cell(top_stress, place, MEGA),
                turns(float(at[i])), conditions[int(which[i]) - 1],
            ]  # fmt: skip
        else:
            row += [""] * 4
        rows.append(row)
    words = (
        f"Half ranges in the worst of {len(conditions)} conditions of the cylinders, at the "
        "operating speed and at any speed of the range."
    )
    uses = _uses(record, conditions)
    return Section(
        "Misfire and imbalance: the worst condition of each section",
        [*table(columns, rows), *paragraph(words), *(["", *uses] if uses else [])],
        frozenset(),
        "every condition at the operating speed",
        Detail(result, _every),
    )


def _column(quantity: Quantity | None, name: str) -> int | None:
    """Place of a section on the second axis."""
    found = [] if quantity is None else labels(quantity.axes[1])
    return found.index(name) if name in found else None


def _uses(record: Record, conditions: list[str]) -> list[str]:
    """The largest use of the limits of the stress in each condition, the worst conditions first."""
    stem = f"{TORSION}conditions/limit"
    top = having(record, f"{stem}/largest_use", "condition", "limit")
    use = top or having(record, f"{stem}/operating_use", "condition", "limit")
    if use is None:
        return []
    at = having(record, f"{stem}/speed", "condition", "limit")
    worst = np.argsort(-np.max(use.values, axis=1), kind="stable")[:_CONDITIONS]
    shown = range(min(use.values.shape[1], 4))
    columns = [Column("condition")]
    for limit in shown:
        columns.append(number(f"limit {limit + 1}\nuse, %"))
        columns += [number("at\nrpm")] * (at is not None)
    rows = []
    for i in worst:
        row = [conditions[i]]
        for limit in shown:
            row.append(cell(use, (int(i), limit), 100.0))
            row += [] if at is None else [turns(float(at.values[i, limit]))]
        rows.append(row)
    more = len(conditions) - len(worst)
    words = "Load over that allowed for lasting" + (f"; {more} lower ones left out." * (more > 0))
    return [*table(columns, rows), *paragraph(words.rstrip(".") + ".")]


def _every(result: Result) -> list[str]:
    """Largest torque, stress and angle of each condition at the operating speed."""
    record, stem = result.record, f"{TORSION}conditions"
    torque = record[f"{stem}/torque_half_range"]
    stress = record.quantities.get(f"{stem}/stress_half_range")
    mean, angle = record[f"{stem}/mean_torque"], record[f"{stem}/angle_half_range"]
    factor, unit = torque_unit(record)
    columns = [
        Column("condition"), number(f"mean torque\n{unit}"),
        number(f"torque\n{unit}"), Column("in section"),
        number("stress\nN/mm^2"), number("angle\nmrad"), Column("of station")
    ]  # fmt: skip
    rows = []
    for i, name in enumerate(labels(torque.axes[0])):
        section, station = (int(np.argmax(one.values[i])) for one in (torque, angle))
        most = None if stress is None else int(np.argmax(stress.values[i]))
        rows.append([
            name, cell(mean, i, factor), cell(torque, (i, section), factor),
            labels(torque.axes[1])[section],
            "" if stress is None or most is None else cell(stress, (i, most), MEGA),
            cell(angle, (i, station), MILLI), labels(angle.axes[1])[station],
        ])  # fmt: skip
    words = "The largest half range of each condition at the operating speed:"
    return [*paragraph(words), *table(columns, rows)]
