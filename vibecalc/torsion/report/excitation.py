"""What the cylinders do to a shaft line: critical speeds, orders, vector sums, conditions."""

from dataclasses import replace

import numpy as np

from vibecalc.core.report.rows import Cells, Found, How, Rows, first, others, part_of, rows_of
from vibecalc.core.report.sections import Section, having, labels, table_of
from vibecalc.core.report.writing import (
    Column,
    hertz,
    number,
    pairs,
    paragraph,
    show,
    show_phase,
    table,
    turns,
)
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import ranked
from vibecalc.torsion.report.line import (
    MOST_ORDERS,
    TORSION,
    asked,
    cell,
    elastic_modes,
    first_shaft,
    frequencies,
    line_of,
    mode_names,
    order_text,
    range_words,
    row_of,
    silent,
    speed_range,
    titled,
    torque_unit,
    vector,
)

EXCITATION = TORSION + "excitation/"
#: of the largest amplitude: less is shown as zero
_NOTHING = 1e-7
_MODES, _STATIONS = 4, 6
#: places in the ranking of orders that are shown, orders of one place
_RANKS, _ALIKE = 3, 6
_PLACES = ("strongest", "2nd", "3rd", "4th", "5th")
_WIDE = 9
#: of the largest torque: less is none
_LEAST = 1e-9


def torsion_excitation(result: Result) -> Section | None:
    """The section, None if the result has no torque of the cylinders."""
    if having(result.record, EXCITATION + "total", "order") is None:
        return None
    makers = critical_speeds, cylinder_orders, vector_sums
    title, details = (
        f"Critical speeds, {range_words(result)}",
        {"all critical speeds, torques and vector sums by order": makers},
    )
    return titled(result, title, strongest_criticals(result), details=details)


def strongest_orders(speed: np.ndarray, work: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Places of the orders (n,) that excite a mode most, the strongest first.

    Of those whose critical `speed` lies within both ends of a range; `work` (n,) as intensity.
    """
    inside = np.flatnonzero((ends[0] <= speed) & (speed <= ends[1]))
    return np.asarray(inside[ranked(np.abs(work[inside]))][: len(_PLACES)])


def strongest_criticals(result: Result) -> list[str]:
    """For each mode the critical speeds of the orders that excite it most, within the range."""
    record, (low, high) = result.record, speed_range(result)
    speed = having(record, TORSION + "critical/speed", "mode", "order")
    work = having(record, EXCITATION + "intensity", "mode", "order")
    if speed is None or work is None:
        return []
    names, values = mode_names(result), np.asarray(speed.values, dtype=float)
    stars, rows = _stars(record, values.shape[1]), []
    for mode in elastic_modes(result):
        strongest = strongest_orders(values[mode], work.values[mode], (low, high))
        cells = [f"{order_text(speed.axes[1].values[i])}{stars[i]} at {turns(values[mode, i])}"
                 for i in strongest]  # fmt: skip
        if cells:
            rows.append([names[mode], *cells, *[""] * (len(_PLACES) - len(cells))])
    if not rows:
        return paragraph(f"No critical speed from {range_words(result)}.")
    words = "Order at rpm, ranked by modal torque; *: major order, cylinders in phase"
    banks = EXCITATION + "bank_factor" in record
    words += " in each bank." if banks else "."
    return [*table((Column("mode"), *map(number, _PLACES)), rows), *paragraph(words)]


def _stars(record: Record, count: int) -> list[str]:
    """`*` for each major order."""
    major = vector(record, "excitation/major", "order")
    return [""] * count if major is None else ["*" * bool(one) for one in major]


def critical_speeds(result: Result) -> list[str]:
    """Orders by modes, in rpm, only what lies within the range."""
    low, high = speed_range(result)
    path, modes = TORSION + "critical/speed", elastic_modes(result)

    def speeds(record: Record) -> Quantity | None:
        found = having(record, path, "mode", "order")
        if found is None:
            return None
        axis = replace(found.axes[0], values=np.array(mode_names(result))[modes])
        return part_of(found, found.values[modes].T, found.axes[1], axis)

    def major(record: Record) -> Quantity | None:
        axis = record[path].axes[1]
        return part_of(record[path], np.array(_stars(record, len(axis.values))), axis)

    def inside(found: Found) -> np.ndarray:
        values = found[-1].values
        return np.flatnonzero(np.any((low <= values) & (values <= high), axis=1))

    columns = (
        Cells(major, "major"),
        Cells(speeds, "{}", lambda speed, _: turns(speed) if low <= speed <= high else ""),
    )
    words = f"Critical speeds in rpm from {range_words(result)} (major orders: *):"
    rows = Rows("order", "order", columns, label="{:.4g}", right=True, places=inside,
                above=words)  # fmt: skip
    return rows_of(result.record, rows)[0] if path in result.record and modes else []


def cylinder_orders(result: Result) -> list[str]:
    """Cosine and sine of gas, inertia and total, of one cylinder from its firing position on."""
    record, (factor, unit) = result.record, torque_unit(result.record)
    total = having(record, EXCITATION + "total", "order")
    if total is None:
        return []
    nothing = max(_NOTHING * float(np.max(np.abs(total.values))), total.error_estimate)

    def narrow(value: float) -> str:
        texts = [show(factor * value, factor * nothing, digits) for digits in (4, 3, 2)]
        return next((text for text in texts if len(text) <= _WIDE), texts[-1])

    sides: tuple[tuple[str, How], ...] = (
        ("cos", lambda one, _: narrow(one.real)), ("sin", lambda one, _: narrow(-one.imag)),
    )  # fmt: skip
    columns = [Cells(name, f"{name}\n{side}", write)
               for name in ("gas", "inertia", "total") for side, write in sides]  # fmt: skip
    columns += [
        Cells("total", "amplitude", lambda one, _: show(factor * abs(one), factor * nothing)),
        Cells("total", "phase\ndeg", lambda one, _: show_phase(one, nothing)),
        Cells("tangential_pressure", "t.pressure\nN/mm^2", "N/mm^2"),
    ]
    words = (
        f"Torque of one cylinder by order in {unit}, from its firing top dead centre: cos and sin "
        "of a cos(q t) + b sin(q t), amplitude 0-to-peak, phase of the cosine (positive leads); "
        "tangential pressure: amplitude / (piston area x crank radius)."
    )
    rows = Rows("order", "order", columns, EXCITATION.rstrip("/"), "{:.4g}", right=True,
                places=first(MOST_ORDERS), rest=others(_HIGHER), above=words)  # fmt: skip
    return rows_of(record, rows)[0]


_HIGHER = "and {left} higher orders, in the result file"
_SUMS = (
    "Sum: vector sum over the cylinders (length: mode shape at the station, angle: order x firing "
    "angle), divided by the sum of the lengths (1: all in phase, 0: they cancel). Torque: modal "
    "torque, 0-to-peak, for the largest angle of the shape 1. Major orders (*): "
)
_BANKS = (
    "the cylinders of each bank in phase; banks: factor on the sum due to the bank angle (1: no "
    "reduction; 0: the banks cancel, and the order is not major)."
)


def vector_sums(result: Result) -> list[str]:
    """The orders that are strongest, and the table of vector sums by mode and order."""
    record, modes, names = result.record, elastic_modes(result)[:_MODES], mode_names(result)
    sums = having(record, EXCITATION + "vector_sum", "mode", "order")
    work = having(record, EXCITATION + "intensity", "mode", "order")
    natural = frequencies(record)
    if sums is None or natural is None or not modes:
        return []
    factor, unit = torque_unit(record)
    bank = vector(record, "excitation/bank_factor", "order")
    columns = [number("order"), Column("major") if bank is None else number("major\nbanks")]
    for mode in modes:
        columns += [number(f"{names[mode]}\nsum"), number(f"torque\n{unit}")]
    stars, rows = _stars(record, sums.values.shape[1]), []
    for i, order in enumerate(sums.axes[1].values[:MOST_ORDERS]):
        row = [order_text(order), stars[i]]
        if bank is not None:
            part = 5e-4 < bank[i] < 0.9995
            row[1] += f"{bank[i]:.3f}".lstrip("0") if part else f"{bank[i]:.0f}"
        for mode in modes:
            row += [_sum(sums, mode, i), cell(work, (mode, i), factor)]
        rows.append(row)
    listed = ", ".join(f"{names[mode]}: {show(hertz(natural[mode]))} Hz" for mode in modes)
    words = f"Vector sums over the cylinders by mode ({listed}) and order. {_SUMS}"
    words += "all cylinders in phase." if bank is None else _BANKS
    if silent(result):
        words += " Sums: as if all cylinders fired; torques: with the misfire."
    more = max(sums.values.shape[1] - MOST_ORDERS, 0)
    return [*_ranked(record, sums, modes, names), *paragraph(words), *table(columns, rows),
            *paragraph(_HIGHER.format(left=more))[: bool(more)]]  # fmt: skip


def _sum(sums: Quantity, mode: int, place: int) -> str:
    size = abs(complex(np.asarray(sums.values)[mode, place]))
    return f"{size:.4f}" if size > max(sums.error_estimate, 5e-13) else "0"


def _ranked(record: Record, sums: Quantity, modes: list[int], names: list[str]) -> list[str]:
    """The orders of the largest vector sums on each mode, those of equal sums together."""
    rank = having(record, EXCITATION + "rank", "mode", "order")
    if rank is None:
        return []
    words = []
    for mode in modes:
        places, groups = np.asarray(rank.values)[mode], []
        for place in sorted(set(places[places > 0].tolist()))[:_RANKS]:
            alike = np.flatnonzero(places == place)
            listed = ", ".join(order_text(one) for one in sums.axes[1].values[alike[:_ALIKE]])
            more = " ..." * (len(alike) > _ALIKE)
            groups.append(f"{listed}{more} ({_sum(sums, mode, int(alike[0]))})")
        words.append(f"{names[mode]}: {'; '.join(groups)}")
    return paragraph(f"Orders ranked by vector sum, equal ones together: {'. '.join(words)}.")


# ----------------------------------------------------------------------------
# What a calculation says of the engine and of what else turns the line.
# ----------------------------------------------------------------------------


def engine_torque(result: Result) -> list[str]:
    """Power, mean torque and mean indicated pressure of the engine."""
    factor, unit = torque_unit(result.record)
    return pairs(
        (title, f"{cell(found, (), by)} {words}")
        for name, title, by, words in (
            ("power", "indicated power", 1e-3, "kW"),
            ("mean_torque", "mean torque", factor, unit),
            ("mean_indicated_pressure", "mean indicated pressure", 1e-5, "bar"),
        )
        if (found := result.record.quantities.get(EXCITATION + name)) is not None
    )


def station_torques(result: Result) -> list[str]:
    """Torques at stations that are not of cylinders alone, by order: amplitude."""
    given = table_of(result.case, "machine", "shaft_line").get("excitations") or ()
    factor, unit = torque_unit(result.record)
    at = {str(one.get("on")) for one in given}
    torque = having(result.record, EXCITATION + "station_torque", "station", "order")
    if torque is None or not given:
        return []
    noise = max(torque.error_estimate, _LEAST * float(np.max(np.abs(torque.values))))
    places = [i for i, name in enumerate(labels(torque.axes[0])) if name in at][:_STATIONS]

    def acting(found: Found) -> np.ndarray:
        return np.flatnonzero(np.any([np.abs(one.values) > noise for one in found], axis=0))

    columns = [
        Cells(row_of(torque.path, i), labels(torque.axes[0])[i],
              lambda one, _: show(factor * abs(one), factor * noise))
        for i in places
    ]  # fmt: skip
    line = line_of(result)
    shaft = "the crankshaft" if line is None else first_shaft(line)
    words = f"Torques at the stations by order of {shaft}, 0-to-peak, {unit}:"
    rows = Rows("order", "order", columns, label="{:.4g}", right=True, places=acting,
                above=words)  # fmt: skip
    return rows_of(result.record, rows)[0]


# ----------------------------------------------------------------------------
# Conditions of the cylinders in words.
# ----------------------------------------------------------------------------

#: folders of the line with all cylinders firing, and in conditions of the cylinders
VARIANTS = ("healthy/", "conditions/")


def variant_words(result: Result, variant: str) -> str:
    """What the cylinders do in a variant: `one cylinder misfiring`."""
    if variant == "healthy/":
        return "all cylinders firing"
    given = table_of(asked(result), "conditions")
    words = ["one cylinder misfiring"] * (given.get("misfire") != "none")
    words += ["one cylinder out of balance"] * bool(given.get("imbalance"))
    words += ["the given cylinder pressures"] * bool(given.get("pressure_scale"))
    return " or ".join(words)
