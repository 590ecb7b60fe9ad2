"""Excitation in the report: forces and couples by order, balance table, rod, motor, pump."""

import math

import numpy as np

from vibecalc.core.report.rows import by_axis
from vibecalc.core.report.sections import (
    FAINT,
    Section,
    along,
    having,
    labels,
    magnitudes,
    scalar_of,
    scalars,
    section,
    stacked,
    together,
)
from vibecalc.core.report.writing import (
    Column,
    height,
    number,
    paragraph,
    show,
    show_phase,
    table,
)
from vibecalc.core.results.record import AT_START, Quantity, Record, Result

# ----------------------------------------------------------------------------
# The balance table, as an engineer lays it out: a line for each cylinder and a total.
# ----------------------------------------------------------------------------

_ENTRIES = ("sine", "cosine", "position_sine", "position_cosine")
_HEADS = ("sin", "cos", "z sin m", "z cos m")
_PREFIX = "excitation/balance/"
_NOTHING = 1e-12
_OF_MASS = ("excitation/mass/reciprocating", "excitation/mass/rotating")
_BANKS = (
    *("sum", "position_sum", "rotating", "counter_rotating"),
    *("position_rotating", "position_counter_rotating"),
)
_KINDS = ("force", "couple m")
_WORDS_OF_BANKS = (
    "force: 1 is that of one cylinder at the order, 0-pk; couple: the same times z; rotating with "
    "the crank, counter-rotating against it, both the order times as fast: the largest is their sum"
)


def balance(result: Result) -> tuple[list[str], set[str]]:
    """Lines and the paths shown; nothing if the result has no balance table.

    At an optimum the table of the start follows: how they differ is what was asked.
    """
    notes = "z along the crankshaft, angles of the order"
    lines, shown = _table(result.record, _PREFIX, f"Balance table of equal cylinders ({notes})")
    if lines and _masses_differ(result.record):
        lines += paragraph(
            "the masses of these cylinders differ: what is left of each order is under forces and "
            "couples by order"
        )
    before, begun = _table(result.record, AT_START + _PREFIX, "Balance table at the start")
    return stacked(lines, before), shown | begun


def _masses_differ(record: Record) -> bool:
    masses = (record.quantities.get(path) for path in _OF_MASS)
    return any(one is not None and np.ptp(one.values) > 0.0 for one in masses)


def _table(record: Record, prefix: str, title: str) -> tuple[list[str], set[str]]:
    entries_of = [quantity for name in _ENTRIES if (quantity := _entry(record, prefix + name))]
    if len(entries_of) != len(_ENTRIES):
        return [], set()
    order_axis, cylinder_axis = entries_of[0].axes
    totals = [along(record, f"{prefix}total_{name}", "order") for name in _ENTRIES]
    shown = {quantity.path for quantity in entries_of}
    shown |= {total[0].path for total in totals if total}
    lines = [f"  {title}"]
    for row, order in enumerate(order_axis.values):
        columns = [Column(f"order {int(order)}", 14), number("angle deg", 11), number("z m")]
        columns += [number(head) for head in _HEADS]
        cells = []
        for i, name in enumerate(labels(cylinder_axis)):
            entries = [float(quantity.values[row, i]) for quantity in entries_of]
            errors = [_uncertainty(quantity) for quantity in entries_of]
            cells.append(
                [
                    name,
                    f"{_angle(entries):.2f}",
                    show(_position(entries), errors[2] + errors[3]),
                    *(show(entry, error) for entry, error in zip(entries, errors, strict=True)),
                ]
            )
        sums = [
            show(total[0].values[row], _uncertainty(total[0])) if total else "" for total in totals
        ]
        below = [["total", "", "", *sums]] if any(totals) else []
        lines += ["", *table(columns, cells, below)]
    sums_of_banks, more = _banks(record, prefix)
    return lines + sums_of_banks, shown | more


def _banks(record: Record, prefix: str) -> tuple[list[str], set[str]]:
    """Sums of several banks: along two directions, and turning with the crank and against it."""
    quantities = [record.quantities.get(f"{prefix}banks/{name}") for name in _BANKS]
    vectors = [quantity for quantity in quantities[:2] if quantity is not None]
    circles = [quantity for quantity in quantities[2:] if quantity is not None]
    if len(vectors) != 2 or len(circles) != 4:
        return [], set()
    names = labels(vectors[0].axes[1])
    size = np.max([np.abs(one.values).max(0) for one in vectors], axis=0)
    shown = [place for place in range(len(names)) if size[place] > 0.0]
    heads = [f"along {names[place]}" for place in shown]
    columns = [number("order", 8), Column("of", 10)]
    columns += [number(head, 16) for head in (*heads, "rotating", "counter-rotating")]
    rows = []
    for row, order in enumerate(vectors[0].axes[0].values):
        for of, vector, pair in zip(_KINDS, vectors, (circles[:2], circles[2:]), strict=True):
            lengths = [abs(complex(vector.values[row, place])) for place in shown]
            cells = [show(one, vector.error_estimate) for one in lengths]
            cells += [show(float(one.values[row]), one.error_estimate) for one in pair]
            rows.append([str(int(order)), of, *cells])
    title = "Sums over the banks: vectors, each cylinder along its own axis"
    lines = ["", f"  {title}", "", *table(columns, rows), *paragraph(_WORDS_OF_BANKS)]
    return lines, {quantity.path for quantity in (*vectors, *circles)}


def _entry(record: Record, path: str) -> Quantity | None:
    quantity = record.quantities.get(path)
    if quantity is None or [axis.name for axis in quantity.axes] != ["order", "cylinder"]:
        return None
    return quantity


def _uncertainty(quantity: Quantity) -> float:
    """What prints as 0: a search leaves the last digits of an angle open, which no table wants."""
    largest = float(np.max(np.abs(quantity.values), initial=0.0))
    return max(quantity.error_estimate, _NOTHING * largest)


def _angle(entries: list[float]) -> float:
    """Degrees in [0, 360) from sine and cosine, so that they belong together at an optimum too."""
    turned = round(math.degrees(math.atan2(entries[0], entries[1])) % 360.0, 2)
    return 0.0 if turned == 360.0 else turned


def _position(entries: list[float]) -> float:
    """z from z sin and z cos."""
    sine, cosine, position_sine, position_cosine = entries
    return position_sine * sine + position_cosine * cosine


# ----------------------------------------------------------------------------
# Forces and couples of the crank train on the body, order by order.
# ----------------------------------------------------------------------------

_ROWS = 12
#: lines of forces and couples by order that a brief report has room for
_BRIEF = 10
_EXCITATION_KINDS = ("force", "couple")


def excitation(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    orders = _excitation_orders(record)
    blocks = [_peaks(record), scalars(record, ["excitation/residual"]), _turning(record)]
    details = {"balance table": balance(result), "counterweights": _counterweights(record)}
    if height(orders[0]) <= _BRIEF:
        blocks.insert(0, orders)
    else:
        details["forces and couples by order"] = orders
    return section("Excitation: crank train on the body", blocks, details)


def _excitation_orders(record: Record) -> tuple[list[str], set[str]]:
    rows, silent, shown, left_out = [], [], set(), 0
    for kind in _EXCITATION_KINDS:
        quantity = record.quantities.get(f"excitation/{kind}")
        if quantity is None or [axis.name for axis in quantity.axes] != ["order", "direction"]:
            continue
        shown.add(quantity.path)
        orders, directions = (labels(axis) for axis in quantity.axes)
        error = quantity.error_estimate
        for j, direction in enumerate(directions):
            column, acting = quantity.values[:, j], np.flatnonzero(~quantity.zero[:, j]).tolist()
            if not acting:
                silent.append(f"{kind} {direction}")
                continue
            left_out += max(len(acting) - _ROWS, 0)
            rows += [
                [
                    f"{kind} {direction}",
                    orders[i],
                    show(abs(column[i]), error),
                    quantity.unit,
                    show_phase(complex(column[i]), error),
                ]
                for i in acting[:_ROWS]
            ]
    if not shown:
        return [], shown
    columns = (
        Column("component", 14),
        number("order", 6),
        number("amplitude", 14),
        Column("unit", 8),
        number("phase deg", 10),
    )
    lines = table(columns, rows) if rows else []
    if silent:
        lines += paragraph("zero at every order: " + ", ".join(silent))
    if left_out:
        lines += paragraph(f"{left_out} further entries of higher order are in the result file")
    return lines, shown


def _peaks(record: Record) -> tuple[list[str], set[str]]:
    rows, shown = [], set()
    for kind in _EXCITATION_KINDS:
        quantity = record.quantities.get(f"excitation/{kind}_peak")
        if quantity is None or [axis.name for axis in quantity.axes] != ["direction"]:
            continue
        shown.add(quantity.path)
        values = magnitudes(quantity)
        cells = [show(value, quantity.error_estimate) for value in values]
        rows.append([kind, *[*cells, "", "", ""][:3], quantity.unit])
    if not rows:
        return [], shown
    columns = (
        Column("largest over a turn", 20),
        number("x", 14),
        number("y", 14),
        number("z", 14),
        Column("unit", 8),
    )
    return table(columns, rows), shown


_WEIGHTS = (
    ("excitation/counterweight/force", "force N"),
    ("excitation/counterweight/couple", "couple N*m"),
)


_TURNING = (
    ("excitation/turning/with_crank", "force with the crank N"),
    ("excitation/turning/against_crank", "force against it N"),
)
_KNUCKLE = "excitation/mass/knuckle"


def _turning(record: Record) -> tuple[list[str], set[str]]:
    """With slave rods: the parts of the force that turn at the order times the crank's speed."""
    found = [having(record, path, "order") for path, _ in _TURNING]
    both = [one for one in found if one is not None]
    if len(both) != len(found):
        return [], set()
    sizes = np.array([np.abs(one.values) for one in both])
    loud = np.flatnonzero(np.any(sizes > FAINT * sizes.max(initial=0.0), axis=0))[:_ROWS]
    names, pairs = labels(both[0].axes[0]), list(zip(sizes, both, strict=True))
    rows = [[names[i], *(show(float(size[i]), one.estimate) for size, one in pairs)] for i in loud]
    heads = [Column("order, times as fast", 22), *(number(words, 24) for _, words in _TURNING)]
    return table(heads, rows), {path for path, _ in _TURNING}


def _counterweights(record: Record) -> tuple[list[str], set[str]]:
    lines = by_axis(record, "counterweight", "counterweight, alone", _WEIGHTS)
    return lines, {path for path, _ in _WEIGHTS}


# ----------------------------------------------------------------------------
# What of the rod and the piston moves how: masses, and the rod's inertia beyond two points.
# ----------------------------------------------------------------------------

_STEM = "excitation/rod/"
_MASSES = (
    ("excitation/mass/reciprocating", "moves with the piston kg"),
    ("excitation/mass/rotating", "turns with the pin kg"),
)


def rod(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    details = {"running gear": together(_masses(record), _inertia(record), _orders(record))}
    return section("Running gear: masses and rod inertia", (), details)


def _masses(record: Record) -> tuple[list[str], set[str]]:
    lines = by_axis(record, "cylinder", "cylinder", _MASSES, 20, 27)
    slaves = by_axis(record, "slave_rod", "slave rod of", ((_KNUCKLE, "with its pin kg"),), 20, 27)
    return stacked(lines, slaves), {*dict(_MASSES), _KNUCKLE}


def _inertia(record: Record) -> tuple[list[str], set[str]]:
    names = ("split_inertia", "couple_peak", "couple_bound")
    lines, shown = scalars(record, [_STEM + name for name in names], "excitation/")
    if not lines:
        return [], set()
    if scalar_of(record, _STEM + "couple_peak") is not None:
        words = "couple: of one rod about the crankshaft, beyond that of its two point masses"
    else:
        words = (
            "the case does not give the rod's moment of inertia; a rod whose material lies between "
            "its bearings cannot add more than the bound to the couple about the crankshaft"
        )
    return lines + paragraph(words), shown


def _orders(record: Record) -> tuple[list[str], set[str]]:
    quantity = having(record, _STEM + "couple", "order")
    if quantity is None:
        return [], set()
    error = quantity.error_estimate
    sizes = np.abs(quantity.values)
    acting = np.flatnonzero(~quantity.zero)
    loud = [int(i) for i in acting if sizes[i] > FAINT * sizes.max()][:_ROWS]
    names = labels(quantity.axes[0])
    columns = (
        Column("couple of the rod", 20),
        number(f"amplitude {quantity.unit}", 18),
        number("phase deg", 10),
    )
    rows = [
        [
            f"order {names[i]}",
            show(abs(quantity.values[i]), error),
            show_phase(complex(quantity.values[i]), error),
        ]
        for i in loud
    ]
    if not rows:
        return paragraph("couple of the rod: zero at every order"), {quantity.path}
    lines = table(columns, rows)
    further = len(acting) - len(rows)
    if further:
        lines += paragraph(f"{further} further orders, faint or high, are in the result file")
    return lines, {quantity.path}


# ----------------------------------------------------------------------------
# Axial force of the motor's skewed conductors: its largest orders, and what they add up to.
# ----------------------------------------------------------------------------

_MOTOR_ROWS = 8
_FOLDER = "excitation/motor/"
_SCALARS = tuple(_FOLDER + name for name in ("mean_force", "sum_of_amplitudes", "peak", "rms"))


def motor(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    single, shown = scalars(result.record, _SCALARS, _FOLDER)
    if single:
        single += paragraph(
            "The sum of amplitudes is a bound: no turn reaches it unless all orders peak at once. "
            "Where rotor and stator sit on one body the force loads the bearing and does not shake "
            "the body."
        )
    title = "Motor: axial force of skewed conductors"
    details = {"axial force of the motor by order": _motor_orders(result.record)}
    return section(title, [(single, shown)], details)


def _motor_orders(record: Record) -> tuple[list[str], set[str]]:
    hit = along(record, _FOLDER + "axial_force", "order")
    if hit is None:
        return [], set()
    quantity, orders = hit
    values, error = np.asarray(quantity.values), quantity.error_estimate
    acting = np.flatnonzero(~quantity.zero)
    largest = acting[np.argsort(-np.abs(values[acting]), kind="stable")][:_MOTOR_ROWS]
    rows = [
        [
            str(int(orders[i])),
            show(abs(values[i]), error),
            quantity.unit,
            show_phase(complex(values[i]), error),
        ]
        for i in largest
    ]
    columns = (number("order", 14), number("amplitude", 14), number("unit", 8), number("phase deg"))
    lines = table(columns, rows) if rows else paragraph("zero at every order")
    if len(acting) > len(rows):
        lines += paragraph(
            f"the {len(rows)} largest; {len(acting) - len(rows)} further orders are in the result "
            "file"
        )
    return lines, {quantity.path}


# ----------------------------------------------------------------------------
# The cylinders of a pump: when the valves open, what is drawn, what it takes, torque by order.
# ----------------------------------------------------------------------------

ROOT = "excitation/pump/"
_PUMP_SCALARS = tuple(
    ROOT + name
    for name in ("suction_opens", "discharge_opens", "swept_volume", "volumetric_efficiency",
                 "flow", "work", "power", "mean_torque")
)  # fmt: skip
#: orders below this share of the largest one stay in the result file
_SMALL = 1e-2
_MOST = 12
_WORDS = (
    "The suction valve opens so long after top dead centre, the discharge valve after bottom dead "
    "centre; both close at the dead centres. Work is of one cylinder in a turn, flow and power are "
    "of all; the torque of the liquid brakes the crankshaft."
)


def pump(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    lines, shown = scalars(result.record, _PUMP_SCALARS, ROOT)
    if not shown:
        return None
    details = {"torque of the pump by order": _pump_orders(result.record)}
    blocks = [(lines + paragraph(_WORDS), {*shown, f"{ROOT}pressure"})]
    return section("Pump: valves, volumes and torque", blocks, details)


def _pump_orders(record: Record) -> tuple[list[str], set[str]]:
    torque = having(record, ROOT + "torque", "order")
    if torque is None:
        return [], set()
    size = magnitudes(torque)
    large = np.flatnonzero((size > 4.0 * torque.error_estimate) & (size >= _SMALL * size.max()))
    rows = [
        [
            f"{torque.axes[0].values[place]:g}",
            show(size[place], torque.error_estimate),
            show_phase(complex(torque.values[place]), torque.error_estimate),
        ]
        for place in large[:_MOST]
    ]
    columns = (Column("order", 8), number("torque N*m", 16), number("phase deg", 12))
    left = len(size) - len(rows)
    words = f"the other {left} orders are zero or weaker, and in the result file"
    return table(columns, rows) + (paragraph(words) if left else []), {torque.path}
