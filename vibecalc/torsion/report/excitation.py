"""What the cylinders do to a shaft line: critical speeds, order table, vector sums."""

import numpy as np

from vibecalc.core.report.sections import Section, having
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, show_phase, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    MEGA,
    MOST_ORDERS,
    TORSION,
    Detail,
    asked,
    cell,
    elastic_modes,
    mode_names,
    order_text,
    range_words,
    speed_range,
    torque_unit,
    turns,
    vector,
)

EXCITATION = TORSION + "excitation/"
#: of the largest amplitude: less is shown as zero
_NOTHING = 1e-7
_MODES = 4
#: places in the ranking of orders that are shown, orders of one place, critical speeds of a mode
_RANKS, _ALIKE, _CRITICALS = 3, 6, 5
_WIDE = 9


def torsion_excitation(result: Result) -> Section | None:
    """The section, None if the result has no torque of the cylinders."""
    if having(result.record, EXCITATION + "total", "half_order") is None:
        return None
    return Section(
        f"Critical speeds, {range_words(result)}",
        strongest_criticals(result),
        frozenset(),
        "all critical speeds, torques and vector sums by order",
        Detail(result, critical_speeds, cylinder_orders, vector_sums),
    )


def strongest_criticals(result: Result) -> list[str]:
    """For each mode the critical speeds of the orders that excite it most, within the range."""
    record = result.record
    speed = having(record, TORSION + "critical/speed", "mode", "half_order")
    work = having(record, EXCITATION + "intensity", "mode", "half_order")
    if speed is None or work is None:
        return []
    low, high = speed_range(result)
    major = vector(record, "excitation/major", "half_order")
    names, values = mode_names(result), np.asarray(speed.values, dtype=float)
    rows = []
    for mode in elastic_modes(result):
        inside = np.flatnonzero((low <= values[mode]) & (values[mode] <= high))
        ranked = inside[np.argsort(-np.abs(work.values[mode, inside]), kind="stable")]
        cells = [
            f"{order_text(speed.axes[1].values[i])}{'*' * bool(major is not None and major[i])}"
            f" at {turns(values[mode, i])}"
            for i in ranked[:_CRITICALS]
        ]
        if cells:
            rows.append([names[mode], *cells, *[""] * (_CRITICALS - len(cells))])
    if not rows:
        return paragraph(f"No order meets a mode from {range_words(result)}.")
    places = ("strongest", "2nd", "3rd", "4th", "5th")
    columns = (Column("mode"), *(number(place) for place in places))
    words = "Order at rpm, ranked by its torque on the mode; *: major order, cylinders in phase"
    words += " in each bank." if _banks(record) else "."
    return [*table(columns, rows), *paragraph(words)]


def _banks(record: Record) -> bool:
    """Whether cylinders stand in banks, whose angle weakens orders."""
    return vector(record, "excitation/bank_factor", "half_order") is not None


def critical_speeds(result: Result) -> list[str]:
    """Orders by modes, in rpm, only what lies within the range."""
    speed = having(result.record, TORSION + "critical/speed", "mode", "half_order")
    if speed is None:
        return []
    low, high = speed_range(result)
    modes, values = elastic_modes(result), np.asarray(speed.values, dtype=float)
    major = vector(result.record, "excitation/major", "half_order")
    names = mode_names(result)
    columns = [number("order"), Column("major")]
    columns += [number(names[mode]) for mode in modes]
    rows = []
    for i, order in enumerate(np.asarray(speed.axes[1].values, dtype=float)):
        inside = [low <= values[mode, i] <= high for mode in modes]
        if any(inside):
            star = "*" if major is not None and major[i] else ""
            cells = [
                turns(values[mode, i]) if there else ""
                for mode, there in zip(modes, inside, strict=True)
            ]
            rows.append([order_text(order), star, *cells])
    words = f"Critical speeds in rpm from {range_words(result)} (major orders: *):"
    return [*paragraph(words), *table(columns, rows)] if rows else []


def cylinder_orders(result: Result) -> list[str]:
    """Cosine and sine of gas, inertia and total, of one cylinder from its firing position on."""
    record = result.record
    total = record[EXCITATION + "total"]
    gas, inertia = (having(record, EXCITATION + name, "half_order") for name in ("gas", "inertia"))
    pressure = having(record, EXCITATION + "tangential_pressure", "half_order")
    columns = [number("order")]
    for word in ("gas", "inertia", "total"):
        columns += [number(f"{word}\ncos"), number(f"{word}\nsin")]
    columns += [number("ampli-\ntude"), number("phase\ndeg"), number("t.pressure\nN/mm^2")]
    values = np.asarray(total.values)
    nothing = max(_NOTHING * float(np.max(np.abs(values))), total.error_estimate)
    factor, unit = torque_unit(record)
    rows = []
    for i, order in enumerate(np.asarray(total.axes[0].values, dtype=float)[:MOST_ORDERS]):
        row = [order_text(order)]
        for part in (gas, inertia, total):
            one = None if part is None else complex(np.asarray(part.values)[i])
            sides = [] if one is None else [one.real, -one.imag]
            row += [_narrow(side, nothing, factor) for side in sides] or ["", ""]
        one = complex(values[i])
        row += [show(factor * abs(one), factor * nothing, 4), show_phase(one, nothing)]
        row.append(cell(pressure, i, MEGA))
        rows.append(row)
    words = (
        f"Torque of one cylinder by order in {unit}, from its firing top dead centre: cos and sin "
        "of a cos(q t) + b sin(q t), amplitude 0-to-peak, phase of the cosine (positive leads); "
        "tangential pressure: amplitude over piston area and crank radius."
    )
    return [*paragraph(words), *table(columns, rows), *_higher_orders(values.size)]


def _narrow(value: float, nothing: float, factor: float) -> str:
    texts = [show(factor * value, factor * nothing, digits) for digits in (4, 3, 2)]
    return next((text for text in texts if len(text) <= _WIDE), texts[-1])


def _higher_orders(count: int) -> list[str]:
    more = count - MOST_ORDERS
    return paragraph(f"and {more} higher orders, in the result file") if more > 0 else []


def vector_sums(result: Result) -> list[str]:
    """The orders that are strongest, and the table of vector sums by mode and order."""
    record = result.record
    silent = asked(result).get("misfire")
    sums = having(record, EXCITATION + "vector_sum", "mode", "half_order")
    work = having(record, EXCITATION + "intensity", "mode", "half_order")
    natural = vector(record, "modes/natural_frequency", "mode")
    modes = elastic_modes(result)[:_MODES]
    if sums is None or natural is None or not modes:
        return []
    names = mode_names(result)
    factor, unit = torque_unit(record)
    major, bank = (
        vector(record, f"excitation/{name}", "half_order") for name in ("major", "bank_factor")
    )
    columns = [number("order")]
    columns.append(Column("major") if bank is None else number("major\nbanks"))
    for mode in modes:
        columns += [number(f"{names[mode]}\nsum"), number(f"torque\n{unit}")]
    rows = []
    for i, order in enumerate(np.asarray(sums.axes[1].values, dtype=float)[:MOST_ORDERS]):
        row = [order_text(order), "*" if major is not None and major[i] else ""]
        if bank is not None:
            row[1] += (
                f"{bank[i]:.3f}".lstrip("0") if 5e-4 < bank[i] < 0.9995 else (f"{bank[i]:.0f}")
            )
        for mode in modes:
            row += [_sum(sums, mode, i), cell(work, (mode, i), factor)]
        rows.append(row)
    listed = ", ".join(
        f"{names[mode]}: {show(hertz(natural[mode]), digits=4)} Hz" for mode in modes
    )
    words = (
        f"Vector sums over the cylinders by mode ({listed}) and order. Sum: each cylinder is a "
        "vector as long as the shape at its station, turned by order times firing angle; the "
        "length of the sum of all, divided by the sum of their lengths (1: all point one way, 0: "
        "they cancel). Torque: 0-to-peak on the mode, with the largest angle of the shape 1. Major "
        "orders (*): all cylinders in phase."
    )
    if bank is not None:
        words = words.replace(
            "all cylinders in phase.",
            "the cylinders of each bank in phase; banks: what the angle between them leaves of "
            "their sums (1: all; 0: they cancel, and the order is not major).",
        )
    if isinstance(silent, list | tuple) and silent:
        words += " The sums count all cylinders alike, as if all fired; the torques do not."
    ranked = _ranked(record, sums, modes, names)
    return [
        *ranked,
        *paragraph(words),
        *table(columns, rows),
        *_higher_orders(sums.values.shape[1]),
    ]


def _sum(sums: Quantity, mode: int, place: int) -> str:
    size = abs(complex(np.asarray(sums.values)[mode, place]))
    return f"{size:.4f}" if size > max(sums.error_estimate, 5e-13) else "0"


def _ranked(record: Record, sums: Quantity, modes: list[int], names: list[str]) -> list[str]:
    """The orders of the largest vector sums on each mode, those of equal sums together."""
    rank = having(record, EXCITATION + "rank", "mode", "half_order")
    if rank is None:
        return []
    orders = np.asarray(sums.axes[1].values, dtype=float)
    words = []
    for mode in modes:
        places = np.asarray(rank.values)[mode]
        groups = []
        for number_ in sorted(set(places[places > 0].tolist()))[:_RANKS]:
            alike = np.flatnonzero(places == number_)
            listed = ", ".join(order_text(orders[i]) for i in alike[:_ALIKE])
            more = " ..." if len(alike) > _ALIKE else ""
            groups.append(f"{listed}{more} ({_sum(sums, mode, int(alike[0]))})")
        words.append(f"{names[mode]}: {'; '.join(groups)}")
    return paragraph(f"Orders ranked by vector sum, equal ones together: {'. '.join(words)}.")
