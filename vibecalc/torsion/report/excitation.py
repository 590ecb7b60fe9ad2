"""What the cylinders do to a shaft line: order table, and vector sums by mode and order."""

import math

import numpy as np

from vibecalc.core.report.sections import Section, having, scalar_of
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, show_phase, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    MEGA,
    MOST_ORDERS,
    TORSION,
    asked,
    cell,
    elastic_modes,
    order_text,
    vector,
)

EXCITATION = TORSION + "excitation/"
_SCALARS = (("mean_torque", "mean torque of all cylinders", 1.0, "N*m"),
            ("mean_indicated_pressure", "mean indicated pressure of a healthy cylinder", 1e-5,
             "bar"),
            ("power", "indicated power of all cylinders", 1e-3, "kW"))  # fmt: skip
#: of the largest amplitude: less is shown as zero
_NOTHING = 1e-7
_MODES = 4
#: places in the ranking of orders that are told, and orders of one place
_RANKS, _ALIKE = 3, 6
_WIDE = 9


def torsion_excitation(result: Result) -> Section | None:
    """The section, None if the result has no torque of the cylinders."""
    record = result.record
    total = having(record, EXCITATION + "total", "half_order")
    if total is None:
        return None
    words = [
        f"{text} {show(factor * value, digits=5)} {unit}"
        for name, text, factor, unit in _SCALARS
        if (value := scalar_of(record, EXCITATION + name)) is not None
    ]
    lines = paragraph(f"At the operating speed: {', '.join(words)}.") if words else []
    sums, strongest = _vectors(result)
    lines += ["", *strongest] if strongest else []
    return Section(
        "Excitation by the cylinders",
        lines,
        frozenset(),
        "torque of one cylinder and vector sums by order",
        ("", *_orders(record, total), "", *sums),
    )


def _orders(record: Record, total: Quantity) -> list[str]:
    """Cosine and sine of gas, inertia and total, of one cylinder from its firing position on."""
    gas, inertia = (having(record, EXCITATION + name, "half_order") for name in ("gas", "inertia"))
    pressure = having(record, EXCITATION + "tangential_pressure", "half_order")
    columns = [number("order", 5)]
    for word in ("gas", "inertia", "total"):
        columns += [number(f"{word}\ncos", _WIDE), number(f"{word}\nsin", _WIDE)]
    columns += [
        number("ampli-\ntude", 9),
        number("phase\ndeg", 7),
        number("t.pressure\nN/mm^2", 10),
    ]
    values = np.asarray(total.values)
    nothing = max(_NOTHING * float(np.max(np.abs(values))), total.error_estimate)
    rows = []
    for i, order in enumerate(np.asarray(total.axes[0].values, dtype=float)[:MOST_ORDERS]):
        row = [order_text(order)]
        for part in (gas, inertia, total):
            one = complex(np.asarray(part.values)[i]) if part is not None else None
            row += ["", ""] if one is None else [
                _narrow(one.real, nothing), _narrow(-one.imag, nothing)]  # fmt: skip
        row += [show(abs(values[i]), nothing, 4), show_phase(complex(values[i]), nothing),
                cell(pressure, i, MEGA, 4)]  # fmt: skip
        rows.append(row)
    words = (
        "Torque of one cylinder by order in N*m, from its own firing top dead centre: cos and sin "
        "of a cos(q t) + b sin(q t), amplitude 0-to-peak, phase of the cosine (positive leads); "
        "tangential pressure: amplitude over piston area and crank radius."
    )
    return [*paragraph(words), *table(columns, rows), *_rest(values.size)]


def _narrow(value: float, nothing: float) -> str:
    texts = [show(value, nothing, digits) for digits in (4, 3, 2)]
    return next((text for text in texts if len(text) <= _WIDE), texts[-1])


def _rest(count: int) -> list[str]:
    more = count - MOST_ORDERS
    return paragraph(f"and {more} higher orders, in the result file") if more > 0 else []


def _vectors(result: Result) -> tuple[list[str], list[str]]:
    """The table of vector sums by mode and order; the orders that lead."""
    record = result.record
    silent = asked(result).get("misfire")
    sums = having(record, EXCITATION + "vector_sum", "mode", "half_order")
    work = having(record, EXCITATION + "intensity", "mode", "half_order")
    natural = vector(record, "modes/natural_frequency", "mode")
    modes = elastic_modes(result)[:_MODES]
    if sums is None or natural is None or not modes:
        return [], []
    major, factor = (
        vector(record, f"excitation/{name}", "half_order") for name in ("major", "bank_factor")
    )
    columns = [number("order", 6)]
    columns.append(Column("major", 5) if factor is None else number("major\nbanks", 5))
    for mode in modes:
        columns += [number(f"mode {mode + 1}\nsum", 9), number("torque\nN*m", 10)]
    rows = []
    for i, order in enumerate(np.asarray(sums.axes[1].values, dtype=float)[:MOST_ORDERS]):
        row = [order_text(order), "*" if major is not None and major[i] else ""]
        if factor is not None:
            row[1] += (
                f"{factor[i]:.3f}".lstrip("0")
                if 5e-4 < factor[i] < 0.9995
                else (f"{factor[i]:.0f}")
            )
        for mode in modes:
            row += [_sum(sums, mode, i), cell(work, (mode, i), digits=4)]
        rows.append(row)
    listed = ", ".join(f"{mode + 1}: {show(hertz(natural[mode]), digits=4)} Hz" for mode in modes)
    words = (
        f"Vector sums over the cylinders by mode ({listed}) and order. Sum: each cylinder is a "
        "vector as long as the shape at its station, turned by order times firing angle; the "
        "length of the sum of all, divided by the sum of their lengths (1: all point one way, 0: "
        "they cancel). Torque: 0-to-peak on the mode, with the largest angle of the shape 1. Major "
        "orders (*): all cylinders in phase."
    )
    if factor is not None:
        words = words.replace(
            "all cylinders in phase.",
            "the cylinders of each bank in phase, beside what the angle between the banks leaves "
            "of their sums (1: all; 0: they cancel, and the order is not major).",
        )
    if isinstance(silent, list | tuple) and silent:
        words += " The sums count all cylinders alike, as if all fired; the torques do not."
    strongest = [*_ranked(record, sums, modes), *_strongest(work, modes)]
    return [*paragraph(words), *table(columns, rows), *_rest(sums.values.shape[1])], strongest


def _sum(sums: Quantity, mode: int, place: int) -> str:
    size = abs(complex(np.asarray(sums.values)[mode, place]))
    return f"{size:.4f}" if size > max(sums.error_estimate, 5e-13) else "0"


def _ranked(record: Record, sums: Quantity, modes: list[int]) -> list[str]:
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
            own = np.flatnonzero(places == number_)
            listed = ", ".join(order_text(orders[i]) for i in own[:_ALIKE])
            more = " ..." if len(own) > _ALIKE else ""
            groups.append(f"{listed}{more} ({_sum(sums, mode, int(own[0]))})")
        words.append(f"mode {mode + 1}: {'; '.join(groups)}")
    return paragraph(f"Orders ranked by vector sum, equal ones together: {'. '.join(words)}.")


def _strongest(work: Quantity | None, modes: list[int]) -> list[str]:
    if work is None:
        return []
    orders = np.asarray(work.axes[1].values, dtype=float)
    sizes = np.abs(np.asarray(work.values))
    words = []
    for mode in modes:
        top = int(np.argmax(sizes[mode]))
        if sizes[mode, top] > 0.0 and math.isfinite(sizes[mode, top]):
            words.append(f"order {order_text(orders[top])} on mode {mode + 1}")
    return paragraph(f"Largest torque: {', '.join(words)}.") if words else []
