"""Excitation in the report: forces and couples by order, balance table, rod, motor, pump."""

import math

import numpy as np

from vibecalc.core.report.rows import OTHERS, Cells, Found, Rows, loud, others, rows_of
from vibecalc.core.report.sections import (
    FAINT,
    Section,
    having,
    labels,
    scalar_of,
    scalars,
    section,
    stacked,
    together,
)
from vibecalc.core.report.writing import Column, height, number, paragraph, show, show_phase, table
from vibecalc.core.results.record import AT_START, Quantity, Record, Result
from vibecalc.numerics.rounding import ranked

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
    "force: 1 is the amplitude of one cylinder at the order (0-to-peak); couple: times z; rotating "
    "and counter-rotating at order x crank speed: the maximum is their sum"
)


def balance(result: Result) -> tuple[list[str], set[str]]:
    """Lines and the paths shown; nothing if the result has no balance table.

    At an optimum the table of the start follows: how they differ is what was asked.
    """
    notes = "z along the crankshaft, angles of the order"
    lines, shown = _table(result.record, _PREFIX, f"Balance table of equal cylinders ({notes})")
    if lines and _masses_differ(result.record):
        lines += paragraph(
            "the cylinder masses differ: for the resultants see forces and couples by order"
        )
    before, begun = _table(result.record, AT_START + _PREFIX, "Balance table at the start")
    return stacked(lines, before), shown | begun


def _masses_differ(record: Record) -> bool:
    masses = (record.quantities.get(path) for path in _OF_MASS)
    return any(one is not None and np.ptp(one.values) > 0.0 for one in masses)


def _table(record: Record, prefix: str, title: str) -> tuple[list[str], set[str]]:
    found = [having(record, prefix + name, "order", "cylinder") for name in _ENTRIES]
    entries_of = [quantity for quantity in found if quantity is not None]
    if len(entries_of) != len(_ENTRIES):
        return [], set()
    order_axis, cylinder_axis = entries_of[0].axes
    totals = [having(record, f"{prefix}total_{name}", "order") for name in _ENTRIES]
    shown = {one.path for one in (*entries_of, *totals) if one is not None}
    lines = paragraph(f"{title}:")
    for row, order in enumerate(order_axis.values):
        columns = [Column(f"order {int(order)}"), number("angle deg"), number("z m")]
        columns += [number(head) for head in _HEADS]
        cells, errors = [], [_uncertainty(quantity) for quantity in entries_of]
        for i, name in enumerate(labels(cylinder_axis)):
            entries = [float(quantity.values[row, i]) for quantity in entries_of]
            place = show(_position(entries), errors[2] + errors[3])
            cells.append([name, f"{_angle(entries):.2f}", place, *map(show, entries, errors)])
        sums = ["" if one is None else show(one.values[row], _uncertainty(one)) for one in totals]
        below = [["total", "", "", *sums]] if any(sums) else []
        lines += ["", *table(columns, cells, below)]
    sums_of_banks, more = _banks(record, prefix)
    return lines + sums_of_banks, shown | more


def _banks(record: Record, prefix: str) -> tuple[list[str], set[str]]:
    """Sums of several banks: along two directions, and turning with the crank and against it."""
    paths = [f"{prefix}banks/{name}" for name in _BANKS]
    if not record.quantities.keys() >= {*paths}:
        return [], set()
    first, second, *circles = (record[path] for path in paths)
    vectors, names, rows = (first, second), labels(first.axes[1]), list[list[str]]()
    size = np.max([np.abs(one.values).max(0) for one in vectors], axis=0)
    shown = np.flatnonzero(size > 0.0)
    heads = (*(f"along {names[place]}" for place in shown), "rotating", "counter-rotating")
    columns = [number("order"), Column("of"), *map(number, heads)]
    for row, order in enumerate(vectors[0].axes[0].values):
        for of, vector, pair in zip(_KINDS, vectors, (circles[:2], circles[2:]), strict=True):
            lengths = [abs(complex(vector.values[row, place])) for place in shown]
            cells = [show(one, vector.error_estimate) for one in lengths]
            cells += [show(float(one.values[row]), one.error_estimate) for one in pair]
            rows.append([str(int(order)), of, *cells])
    title = "Sums over the banks: vectors, each cylinder along its own axis"
    lines = [*paragraph(f"{title}:"), *table(columns, rows), *paragraph(_WORDS_OF_BANKS)]
    return lines, {*paths}


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
    residual = scalars(record, ["excitation/residual"])
    blocks = [rows_of(record, _PEAKS), residual, rows_of(record, _TURNING)]
    details = {"balance table": balance(result), "counterweights": rows_of(record, _WEIGHTS)}
    if height(orders[0]) <= _BRIEF:
        blocks.insert(0, orders)
    else:
        details["forces and couples by order"] = orders
    # [balance] has what its weights leave
    alone = ", without the balance weights" * ("balance/weight/unbalance" in record)
    return section(f"Excitation: crank train on the body{alone}", blocks, details)


def _excitation_orders(record: Record) -> tuple[list[str], set[str]]:
    rows, silent, shown, left_out = [], [], set(), 0
    for kind in _EXCITATION_KINDS:
        quantity = having(record, f"excitation/{kind}", "order", "direction")
        if quantity is None:
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
            for i in acting[:_ROWS]:
                size, phase = show(abs(column[i]), error), show_phase(complex(column[i]), error)
                rows.append([f"{kind} {direction}", orders[i], size, quantity.unit, phase])
    if not shown:
        return [], shown
    heads = ("component", number("order"), number("amplitude"), "unit", number("phase deg"))
    lines = table(heads, rows)
    if silent:
        lines += paragraph("zero at every order: " + ", ".join(silent))
    if left_out:
        lines += paragraph(f"{left_out} further entries of higher order are in the result file")
    return lines, shown


_OF_WEIGHTS = Cells("force", "force N"), Cells("couple", "couple N*m")
_WEIGHTS = Rows("counterweight", "counterweight, alone", _OF_WEIGHTS, "excitation/counterweight",
                merge=True)  # fmt: skip
_PEAKS = Rows("direction", "largest over {turn}",
              (Cells("force_peak", "force"), Cells("couple_peak", "couple")),
              "excitation", across=True)  # fmt: skip
#: with slave rods: the parts of the force that turn at the order times the crank's speed
_TURNING = Rows("order", "force at order times speed", ("with_crank", "against_crank"),
                "excitation/turning", places=loud(FAINT, _ROWS, 2))  # fmt: skip


# ----------------------------------------------------------------------------
# What of the rod and the piston moves how: masses, and the rod's inertia beyond two points.
# ----------------------------------------------------------------------------

_STEM = "excitation/rod/"
_OF_CYLINDERS = Rows("cylinder", "cylinder", ("reciprocating", "rotating"), merge=True)
_OF_SLAVES = Rows("slave_rod", "slave rod of", ("knuckle",), merge=True)
_MASSES = [one._replace(root="excitation/mass") for one in (_OF_CYLINDERS, _OF_SLAVES)]
_COUPLE = Cells("couple", "amplitude N*m", ""), Cells("couple", "phase deg", show_phase)
_OF_ROD = Rows(
    "order", "couple of the rod", _COUPLE, "excitation/rod", label="order {}",
    places=loud(FAINT, _ROWS), none="couple of the rod: zero at every order",
    rest=others("{left} further orders, faint or high, are in the result file", acting=True),
)  # fmt: skip


def rod(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    record = result.record
    masses = together(*(rows_of(record, of) for of in _MASSES))
    details = {"running gear": together(masses, _inertia(record), rows_of(record, _OF_ROD))}
    return section("Running gear: masses and rod inertia", (), details)


def _inertia(record: Record) -> tuple[list[str], set[str]]:
    names = ("split_inertia", "couple_peak", "couple_bound")
    lines, shown = scalars(record, [_STEM + name for name in names], "excitation/")
    if not lines:
        return [], set()
    words = (
        "moment of inertia of the rod not given; a rod with all its material between its bearings "
        "adds at most the bound to the couple about the crankshaft"
    )
    if scalar_of(record, _STEM + "couple_peak") is not None:
        words = "couple: of one rod about the crankshaft, in addition to its two point masses"
    return lines + paragraph(words), shown


# ----------------------------------------------------------------------------
# Axial force of the motor's skewed conductors: its largest orders, and what they add up to.
# ----------------------------------------------------------------------------

_FOLDER = "excitation/motor/"
_SCALARS = tuple(_FOLDER + name for name in ("mean_force", "sum_of_amplitudes", "peak", "rms"))


def _largest(found: Found) -> np.ndarray:
    """The largest orders, the largest first."""
    size = np.where(found[0].zero, 0.0, np.abs(found[0].values))
    return ranked(size)[: min(8, np.count_nonzero(size))]


_FORCE = Cells("axial_force", "amplitude N"), Cells("axial_force", "phase deg", show_phase)
_OF_MOTOR = Rows(
    "order", "order", _FORCE, "excitation/motor", right=True,
    places=_largest, none="zero at every order",
    rest=others("the {shown} largest; {left} further orders are in the result file", acting=True),
)  # fmt: skip


def motor(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    single, shown = scalars(result.record, _SCALARS, _FOLDER)
    if single:
        single += paragraph(
            "The sum of amplitudes is an upper bound, reached if all orders peak at once. If rotor "
            "and stator sit on one body the force loads the bearing and does not shake the body."
        )
    title = "Motor: axial force of skewed conductors"
    details = {"axial force of the motor by order": rows_of(result.record, _OF_MOTOR)}
    return section(title, [(single, shown)], details)


# ----------------------------------------------------------------------------
# The cylinders of a pump: when the valves open, what is drawn, what it takes, torque by order.
# ----------------------------------------------------------------------------

ROOT = "excitation/pump/"
_PUMP_SCALARS = tuple(
    ROOT + name
    for name in ("suction_opens", "discharge_opens", "swept_volume", "volumetric_efficiency",
                 "flow", "work", "power", "mean_torque")
)  # fmt: skip
_WORDS = (
    "Opening angles: suction valve after top, discharge valve after bottom dead centre; both close "
    "at the dead centres. Work: per cylinder and revolution; flow and power: all cylinders. The "
    "torque of the liquid brakes the crankshaft."
)

_TORQUE = Cells("torque", "torque N*m", ""), Cells("torque", "phase deg", show_phase)
_OF_PUMP = Rows("order", "order", _TORQUE, "excitation/pump", places=loud(1e-2, 12),
                rest=others(OTHERS))  # fmt: skip


def pump(result: Result) -> Section | None:
    """The section, None if the result has nothing of it."""
    lines, shown = scalars(result.record, _PUMP_SCALARS, ROOT)
    if not shown:
        return None
    details = {"torque of the pump by order": rows_of(result.record, _OF_PUMP)}
    blocks = [(lines + paragraph(_WORDS), {*shown, f"{ROOT}pressure"})]
    return section("Pump: valves, volumes and torque", blocks, details)
