"""Vibration of a shaft line at the operating speed and over the range of speeds."""

from collections.abc import Callable
from functools import partial

import numpy as np

from vibecalc.core.report.rows import Cells, Found, Rows, named_at, part_of, rows_of
from vibecalc.core.report.sections import Section, having, labels, speed_of
from vibecalc.core.report.writing import Column, number, paragraph, show, show_phase, table
from vibecalc.core.results.described import paths_of
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    DEGREES,
    MEGA,
    MILLI,
    TORSION,
    Detail,
    cell,
    first_firing,
    joined,
    line_of,
    meeting,
    mode_names,
    order_text,
    place_of,
    range_words,
    rows_by,
    torque_unit,
    turns,
    vector,
    worst_section,
)
from vibecalc.torsion.results import PowerBalance

# ----------------------------------------------------------------------------
# Vibration of a shaft line at the operating speed: sections, stations, dampers, gears, orders.
# ----------------------------------------------------------------------------

_ORDERS = 12


def torsion_steady(result: Result) -> Section | None:
    """The section, None if the line was not driven at the operating speed."""
    record = result.record
    if having(record, TORSION + "torque_half_range", "section") is None:
        return None
    lines = _sections(record)
    for block in (_dampers(record), _gears(record), _balance(result)):
        lines += ["", *block] if block else []
    speed = speed_of(result)
    at = f", {turns(speed)} rpm" if speed is not None else ""
    return Section(
        f"Vibration at the operating speed{at}",
        lines,
        frozenset(),
        "orders in the most loaded section, angles of the stations",
        Detail(result, _orders, _stations),
    )


def _sections(record: Record) -> list[str]:
    factor, unit = torque_unit(record)
    torques = ("half_range", "torque"), ("mean", "mean"), ("peak", "peak"), ("bound", "bound")
    lines = rows_by(record, "section", (
        *((f"torque_{name}", factor, f"{words}\n{unit}") for name, words in torques),
        ("stress_half_range", MEGA, "stress\nN/mm^2"),
        ("twist_half_range", MILLI, "twist\nmrad"), ("section_heat", 1.0, "heat\nW"),
    ))  # fmt: skip
    words = "Torque, stress, twist: half ranges. Peak: with the mean. Bound: sum of all orders' "
    words += "amplitudes."
    half = having(record, TORSION + "angle_half_range", "station")
    if half is not None:
        top = int(np.argmax(half.values))
        words += f" Largest angle: {cell(half, top, MILLI)} mrad ({cell(half, top, DEGREES)} deg) "
        words += f"half range, at {labels(half.axes[0])[top]}."
    return [*lines, *paragraph(words)]


def _orders(result: Result) -> list[str]:
    """The strongest orders in the most loaded section."""
    record = result.record
    torque = having(record, TORSION + "torque", "section", "half_order")
    name = worst_section(record)
    place = None if name is None else place_of(torque, name)
    if torque is None or name is None or place is None:
        return []
    stress = having(record, TORSION + "stress", "section", "half_order")
    twist = having(record, TORSION + "twist", "section", "half_order")
    row = np.asarray(torque.values)[place]
    chosen = np.sort(np.argsort(-np.abs(row), kind="stable")[:_ORDERS])
    factor, unit = torque_unit(record)
    columns = [number("order"), number(f"torque\n{unit}"), number("phase\ndeg"),
               number("twist\nmrad"), number("twist\ndeg"),
               number("stress\nN/mm^2")]  # fmt: skip
    rows = [
        [order_text(torque.axes[1].values[i]), cell(torque, (place, i), factor),
         show_phase(complex(row[i]), torque.error_estimate), cell(twist, (place, i), MILLI),
         cell(twist, (place, i), DEGREES), _stress_of(stress, name, int(i))]
        for i in chosen
    ]  # fmt: skip
    more = f"; the strongest {_ORDERS} of {row.size}" if row.size > _ORDERS else ""
    words = f"Orders in section {name!r}, 0-to-peak, phase from {first_firing(record)}{more}:"
    return [*paragraph(words), *table(columns, rows)]


def _stress_of(stress: Quantity | None, name: str, order: int) -> str:
    place = place_of(stress, name)
    return "" if place is None else cell(stress, (place, order), MEGA)


def _stations(result: Result) -> list[str]:
    lines = rows_by(result.record, "station", (
        ("angle_half_range", MILLI, "half range\nmrad"),
        ("angle_half_range", DEGREES, "half range\ndeg"),
        ("angle_peak", MILLI, "peak\nmrad"), ("angle_peak", DEGREES, "peak\ndeg"),
        ("station_heat", 1.0, "heat\nW"),
    ))  # fmt: skip
    words = "Angles of the stations against steady rotation, all orders together:"
    return [*paragraph(words), *lines] if lines else []


def _dampers(record: Record) -> list[str]:
    more: list[tuple[Column, Callable[[int], str]]] = []
    for name, factor, title in (("heat", 1.0, "heat"), ("travel", MILLI, "travel")):
        top = having(record, f"{TORSION}largest/{name}", "damper")
        at = vector(record, f"largest/{name}_speed", "damper")
        if top is not None and at is not None:
            unit = "W" if name == "heat" else "mrad"
            head = number(f"largest {title}\nover speeds, {unit}")
            more += [(head, partial(cell, top, factor=factor)),
                     (number("at\nrpm"), partial(_turns, at))]  # fmt: skip
    return rows_by(record, "damper", (
        ("damper/heat", 1.0, "heat, mean\nW"),
        ("damper/travel", MILLI, "travel, peak\nmrad"),
        ("damper/travel", DEGREES, "travel, peak\ndeg"),
    ), more)  # fmt: skip


def _turns(speed: np.ndarray, place: int) -> str:
    return turns(float(speed[place]))


def _gears(record: Record) -> list[str]:
    hammers = vector(record, "gear/hammers", "gear")
    factor, unit = torque_unit(record)
    teeth = ("  stay in contact", "  HAMMER: torque reverses")
    more = [] if hammers is None else [
        (Column("  teeth"), lambda i: teeth[int(hammers[i])])]  # fmt: skip
    lines = rows_by(record, "gear", (
        ("gear/mean_torque", factor, f"mean torque\n{unit}"),
        ("gear/alternating_torque", factor, f"half range\n{unit}"),
        ("gear/minimum_torque", factor, f"minimum\n{unit}"),
    ), more)  # fmt: skip
    words = "Torque on the first wheel; minimum: in the sense of the mean, negative: teeth part."
    return [*lines, *paragraph(words)] if lines else []


def _balance(result: Result) -> list[str]:
    """Mean torque and power of sources and loads, and what the load station does on top."""
    record, line = result.record, line_of(result)
    rest = record.quantities.get(f"{PowerBalance.ROOT}/rest_torque")
    if rest is None or line is None:
        return []
    factor, unit = torque_unit(record)
    torque, power = factor * float(rest.values), record[f"{PowerBalance.ROOT}/rest_power"].values
    does = "takes" if torque >= 0.0 else "has to GIVE"
    words = f"Own shafts. Station '{line.station_names[line.load_station]}' {does} what is left: "
    words += f"{show(abs(torque), digits=4)} {unit}, {show(1e-3 * abs(float(power)), digits=4)} kW."
    share = record.quantities.get(f"{PowerBalance.ROOT}/load_share")
    if share is not None and np.isfinite(share.values):
        words += (
            f" The loads take {show(100.0 * float(share.values), digits=4)} % of the indicated "
        )
        words += "power, MORE THAN ALL of it." if share.values > 1.01 else "power."
    columns = [
        Cells(path, f"{name}\n{{unit}}", how)
        for path, name, how in zip(
            paths_of(PowerBalance), ("cylinders", "cylinders", "loads", "loads"),
            2 * (unit.replace(" ", "*"), "kW"), strict=False,
        )
    ]  # fmt: skip
    rows = Rows(
        "station", "mean torque and power, of each", columns, digits=4, places=_not_zero, merge=True
    )
    return [*rows_of(record, rows)[0], *paragraph(words)]


def _not_zero(found: Found) -> np.ndarray:
    return np.flatnonzero(np.any([one.values != 0.0 for one in found], axis=0))


# ----------------------------------------------------------------------------
# Vibration of a shaft line over the speeds: worst sections, with and without damper, peaks.
# ----------------------------------------------------------------------------

_MOST = 24
#: ranges that nothing damps, by name
_NAMED = 8


def torsion_speeds(result: Result) -> Section | None:
    """The section, None without a range of speeds."""
    lines = _worst(result)
    masked = _masked(result)
    lines += ["", *masked] if lines and masked else masked
    if not lines:
        return None
    return Section(
        f"Vibration over the speed range, {range_words(result)}",
        lines,
        frozenset(),
        "peaks over the speed",
        Detail(result, _peaks),
    )


def _worst(result: Result) -> list[str]:
    """The largest half ranges of each section over the speeds, and those without dampers."""
    record, names = result.record, mode_names(result)
    factor, unit = torque_unit(record)
    speed, mode, order = (
        vector(record, f"largest/{name}", "section") for name in ("speed", "mode", "half_order")
    )
    more = [] if speed is None else [(number("at\nrpm"), lambda i: turns(float(speed[i])))]
    if mode is not None and order is not None:
        more.append((Column("mode, order"), lambda i: meeting(names, mode[i], order[i])))
    lines = rows_by(record, "section", (
        ("largest/torque_half_range", factor, f"torque\n{unit}"),
        ("largest/stress_half_range", MEGA, "stress\nN/mm^2"),
        ("largest/twist_half_range", MILLI, "twist\nmrad"),
        ("bare/largest/torque_half_range", factor, f"no dampers\n{unit}"),
        ("reduction", 1.0, "ratio"),
    ), more)  # fmt: skip
    words = "Largest half ranges; no mode and order: at an end of the range, or of several orders."
    return [*lines, *paragraph(words)] if lines else []


def _peaks(result: Result) -> list[str]:
    unit, names = torque_unit(result.record)[1].replace(" ", "*"), mode_names(result)
    stem = f"{TORSION}peak"

    def met(record: Record) -> Quantity | None:
        mode, order = (record.quantities.get(f"{stem}/{one}") for one in ("mode", "half_order"))
        if mode is None or order is None:
            return None
        both = zip(mode.values, order.values, strict=True)
        return part_of(mode, np.array([meeting(names, *one) for one in both]), *mode.axes)

    columns = (
        Cells(f"{stem}/speed", "{unit}", "rpm"),
        Cells(f"{stem}/torque_half_range", "torque\n{unit}", unit),
        Cells(named_at(f"{stem}/section", f"{TORSION}torque_half_range"), "in section"),
        Cells(met, "mode, order"),
    )
    lines, _ = rows_of(result.record, Rows("peak", "", columns, digits=4, places=_strongest))
    words = (
        "Peaks over the speed of the section with most torque and, where it is another, of the "
        f"most stressed one, the highest {_MOST}; mode and order: of the nearest critical whose "
        "order peaks there:"
    )
    return [*paragraph(words), *lines] if lines else []


def _strongest(found: Found) -> np.ndarray:
    return np.sort(np.argsort(-found[1].values, kind="stable")[:_MOST])


def _masked(result: Result) -> list[str]:
    record, names = result.record, mode_names(result)
    low, high = (vector(record, f"masked/{end}", "masked") for end in ("from", "to"))
    if low is None or high is None:
        return []
    mode, order = (vector(record, f"masked/{name}", "masked") for name in ("mode", "half_order"))
    words = []
    for i, (start, stop) in enumerate(zip(low, high, strict=True)):
        met = "" if mode is None or order is None else meeting(names, mode[i], order[i])
        ends = turns(start) if turns(start) == turns(stop) else f"{turns(start)} to {turns(stop)}"
        words.append(f"{ends} rpm" + (f" ({met})" if met else ""))
    more = len(words) - _NAMED
    listed = words[:_NAMED] + ([f"{more} more ranges"] if more > 0 else [])
    return paragraph(f"Nothing damps the line at {joined(listed)}: vibration is unbounded there.")
