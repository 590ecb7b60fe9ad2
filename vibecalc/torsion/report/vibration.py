"""Vibration of a shaft line at the operating speed and over the range of speeds."""

import numpy as np

from vibecalc.core.report.sections import Section, having, labels, speed_of
from vibecalc.core.report.writing import Column, number, paragraph, show, show_phase, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.torsion.report.line import (
    DEGREES,
    MEGA,
    MILLI,
    TORSION,
    cell,
    elastic_modes,
    entry,
    first_firing,
    joined,
    meeting,
    order_text,
    place_of,
    range_words,
    speed_range,
    turns,
    vector,
    worst_section,
)

# ----------------------------------------------------------------------------
# Vibration of a shaft line at the operating speed: sections, stations, dampers, gears, orders.
# ----------------------------------------------------------------------------

_ORDERS = 12


def torsion_steady(result: Result) -> Section | None:
    """The section, None if the line was not driven at the operating speed."""
    record = result.record
    torque = having(record, TORSION + "torque_half_range", "section")
    if torque is None:
        return None
    lines: list[str] = []
    blocks = (
        _sections(record, torque), _orders(record), _stations(record), _dampers(record),
        _gears(record),
    )  # fmt: skip
    for block in blocks:
        if block:
            lines += ["", *block] if lines else block
    speed = speed_of(result)
    at = f" ({turns(speed)} rpm)" if speed is not None else ""
    return Section(f"Vibration of the line at the operating speed{at}", lines, frozenset())


def _of(record: Record, name: str, axis: str) -> Quantity | None:
    return having(record, TORSION + name, axis)


def _sections(record: Record, torque: Quantity) -> list[str]:
    twist, stress = (_of(record, f"{name}_half_range", "section") for name in ("twist", "stress"))
    mean, peak, bound, heat = (
        _of(record, name, "section")
        for name in ("torque_mean", "torque_peak", "torque_bound", "section_heat")
    )
    columns = [Column("section", 24), number("torque\nN*m", 10), number("its mean\nN*m", 10),
               number("its peak\nN*m", 10), number("bound\nN*m", 10), number("stress\nN/mm^2", 9),
               number("twist\nmrad", 9), number("heat\nW", 9)]  # fmt: skip
    rows = [
        [name, cell(torque, i), cell(mean, i), cell(peak, i), cell(bound, i),
         entry(stress, name, MEGA), cell(twist, i, MILLI), cell(heat, i, digits=4)]
        for i, name in enumerate(labels(torque.axes[0]))
    ]  # fmt: skip
    words = (
        "Torque, stress and twist: half range of the synthesis of all orders, on the section's "
        "own shaft; peak: largest magnitude with the mean torque; bound: sum of the magnitudes of "
        "all orders, which no phases exceed."
    )
    return [*paragraph(words), *table(columns, rows)]


def _orders(record: Record) -> list[str]:
    """The strongest orders in the most loaded section."""
    torque = having(record, TORSION + "torque", "section", "half_order")
    name = worst_section(record)
    place = None if name is None else place_of(torque, name)
    if torque is None or name is None or place is None:
        return []
    stress = having(record, TORSION + "stress", "section", "half_order")
    twist = having(record, TORSION + "twist", "section", "half_order")
    row = np.asarray(torque.values)[place]
    chosen = np.sort(np.argsort(-np.abs(row), kind="stable")[:_ORDERS])
    columns = [number("order", 6), number("torque\nN*m", 12), number("phase\ndeg", 9),
               number("twist\nmrad", 11), number("twist\ndeg", 11),
               number("stress\nN/mm^2", 11)]  # fmt: skip
    rows = [
        [order_text(torque.axes[1].values[i]), cell(torque, (place, i)),
         show_phase(complex(row[i]), torque.error_estimate), cell(twist, (place, i), MILLI),
         cell(twist, (place, i), DEGREES), _stress_of(stress, name, int(i))]
        for i in chosen
    ]  # fmt: skip
    more = f"; the strongest {_ORDERS} of {row.size}" if row.size > _ORDERS else ""
    words = (
        f"Orders in section {name!r}, 0-to-peak, phase from the firing of "
        f"{first_firing(record)}{more}:"
    )
    return [*paragraph(words), *table(columns, rows)]


def _stress_of(stress: Quantity | None, name: str, order: int) -> str:
    place = place_of(stress, name)
    return "" if place is None else cell(stress, (place, order), MEGA)


def _stations(record: Record) -> list[str]:
    half, peak = (_of(record, f"angle_{name}", "station") for name in ("half_range", "peak"))
    if half is None:
        return []
    heat = _of(record, "station_heat", "station")
    warm = heat is not None and bool(np.any(np.asarray(heat.values) > 0.0))
    columns = [Column("station", 28), number("half range\nmrad", 12), number("half range\ndeg", 12),
               number("peak\nmrad", 12), number("peak\ndeg", 12)]  # fmt: skip
    columns += [number("heat\nW", 12)] if warm else []
    rows = []
    for i, name in enumerate(labels(half.axes[0])):
        row = [name, cell(half, i, MILLI), cell(half, i, DEGREES), cell(peak, i, MILLI),
               cell(peak, i, DEGREES)]  # fmt: skip
        rows.append([*row, cell(heat, i)] if warm else row)
    return [*paragraph("Angles of the stations against the steady turn, all orders together:"),
            *table(columns, rows)]  # fmt: skip


def _dampers(record: Record) -> list[str]:
    heat, travel = (_of(record, f"damper/{name}", "damper") for name in ("heat", "travel"))
    one = heat or travel
    if one is None:
        return []
    hottest = having(record, TORSION + "speeds/heat", "damper", "speed")
    columns = [Column("damper", 28), number("heat\nW", 12), number("travel, peak\nmrad", 13),
               number("travel, peak\ndeg", 13)]  # fmt: skip
    columns += [number("most heat\nW", 12), number("at\nrpm", 10)] if hottest is not None else []
    rows = []
    for i, name in enumerate(labels(one.axes[0])):
        row = [name, cell(heat, i), cell(travel, i, MILLI), cell(travel, i, DEGREES)]
        if hottest is not None:
            course = np.asarray(hottest.values, dtype=float)[i]
            top = int(np.argmax(course))
            row += [show(course[top], hottest.error_estimate, 5),
                    turns(float(hottest.axes[1].values[top]))]  # fmt: skip
        rows.append(row)
    words = "Dampers: heat is the mean power, travel that of the ring against its station"
    if hottest is not None:
        words += "; most heat: the largest of the speeds that were computed"
    return [*paragraph(words + ":"), *table(columns, rows)]


def _gears(record: Record) -> list[str]:
    mean = _of(record, "gear/mean_torque", "gear")
    if mean is None:
        return []
    moving, least = (
        _of(record, f"gear/{name}_torque", "gear") for name in ("alternating", "least")
    )
    hammers = vector(record, "gear/hammers", "gear")
    columns = [Column("gear", 28), number("mean torque\nN*m", 13), number("alternating\nN*m", 13),
               number("least\nN*m", 13), Column("  teeth", 26)]  # fmt: skip
    rows = []
    for i, name in enumerate(labels(mean.axes[0])):
        verdict = ""
        if hammers is not None:
            verdict = "  HAMMER: torque reverses" if hammers[i] else "  stay in contact"
        rows.append([name, cell(mean, i), cell(moving, i), cell(least, i), verdict])
    words = (
        "Gears at the operating speed, torque on the first wheel; alternating: half range of all "
        "orders; least: smallest torque over the cycle in the sense of its mean, negative where "
        "the teeth part:"
    )
    return [*paragraph(words), *table(columns, rows)]


# ----------------------------------------------------------------------------
# Vibration of a shaft line over the speeds: criticals, worst sections, with and without damper.
# ----------------------------------------------------------------------------

_MOST = 24
#: ranges that nothing damps, by name
_NAMED = 8


def torsion_speeds(result: Result) -> Section | None:
    """The section, None without critical speeds."""
    if having(result.record, TORSION + "critical/speed", "mode", "half_order") is None:
        return None
    lines = _criticals(result)
    for block in (_worst(result.record), _summits(result.record), _masked(result.record)):
        if block:
            lines += ["", *block]
    return Section(f"Critical speeds and vibration, {range_words(result)}", lines, frozenset())


def _criticals(result: Result) -> list[str]:
    """Orders by modes, in rpm, only what lies within the range."""
    speed = having(result.record, TORSION + "critical/speed", "mode", "half_order")
    if speed is None:
        return []
    low, high = speed_range(result)
    modes, values = elastic_modes(result), np.asarray(speed.values, dtype=float)
    major = vector(result.record, "excitation/major", "half_order")
    columns = [number("order", 6), Column("major", 5)]
    columns += [number(f"mode {mode + 1}", 10) for mode in modes]
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
    if not rows:
        return paragraph(f"No order meets a mode from {range_words(result)}.")
    words = f"Critical speeds in rpm from {range_words(result)} (major orders: *):"
    return [*paragraph(words), *table(columns, rows)]


def _worst(record: Record) -> list[str]:
    """The largest half ranges of each section at any speed, beside those without dampers."""
    torque = having(record, TORSION + "largest/torque_half_range", "section")
    if torque is None:
        return []
    twist, stress = (
        having(record, f"{TORSION}largest/{name}_half_range", "section")
        for name in ("twist", "stress")
    )
    speed, mode, order = (
        vector(record, f"largest/{name}", "section") for name in ("speed", "mode", "half_order")
    )
    bare = having(record, TORSION + "bare/largest/torque_half_range", "section")
    gain = having(record, TORSION + "reduction", "section")
    columns = [Column("section", 21), number("torque\nN*m", 10), number("stress\nN/mm^2", 9)]
    columns += [number("twist\nmrad", 9), number("at\nrpm", 8), Column("mode, order", 18)]
    if bare is not None:
        columns += [number("without\ndampers", 10), number("over", 6)]
    rows = []
    for i, name in enumerate(labels(torque.axes[0])):
        row = [name, cell(torque, i), entry(stress, name, MEGA), entry(twist, name, MILLI),
               "" if speed is None else turns(speed[i]),
               "" if mode is None or order is None else meeting(mode[i], order[i])]  # fmt: skip
        if bare is not None:
            row += [entry(bare, name), entry(gain, name, digits=3)]
        rows.append(row)
    words = (
        "Largest half range of each section at any of these speeds, maxima between the points "
        "included; mode and order blank at an end of the range, or where several orders make it"
        + ("; over: torque without dampers over that with them." if bare is not None
                      else ".")
    )  # fmt: skip
    return [*paragraph(words), *table(columns, rows)]


def _summits(record: Record) -> list[str]:
    speed = vector(record, "summit/speed", "summit")
    torque = having(record, TORSION + "summit/torque_half_range", "summit")
    if speed is None or torque is None:
        return []
    section, mode, order = (
        vector(record, f"summit/{name}", "summit") for name in ("section", "mode", "half_order")
    )
    known = having(record, TORSION + "torque_half_range", "section")
    named = [] if known is None else labels(known.axes[0])
    columns = [number("rpm", 10), number("torque\nN*m", 13), Column("in section", 28),
               Column("mode, order", 24)]  # fmt: skip
    sizes = np.asarray(torque.values, dtype=float)
    strongest = np.sort(np.argsort(-sizes, kind="stable")[:_MOST])
    rows = []
    for i in strongest:
        place = int(section[i]) - 1 if section is not None else -1
        rows.append([
            turns(speed[i]), cell(torque, int(i)),
            named[place] if 0 <= place < len(named) else "",
            "" if mode is None or order is None else meeting(mode[i], order[i]),
        ])  # fmt: skip
    more = f" (the highest {_MOST} of {sizes.size})" if sizes.size > _MOST else ""
    words = (
        f"Maxima over the speed of the section with most torque and, where it is another, of the "
        f"most stressed one{more}; mode and order: of the critical next to it whose order peaks "
        "there, blank where several orders make it or at an end of the range:"
    )
    return [*paragraph(words), *table(columns, rows)]


def _masked(record: Record) -> list[str]:
    low, high = (vector(record, f"masked/{end}", "masked") for end in ("from", "to"))
    if low is None or high is None:
        return []
    mode, order = (vector(record, f"masked/{name}", "masked") for name in ("mode", "half_order"))
    words = []
    for i, (start, stop) in enumerate(zip(low, high, strict=True)):
        met = "" if mode is None or order is None else meeting(mode[i], order[i])
        ends = turns(start) if turns(start) == turns(stop) else f"{turns(start)} to {turns(stop)}"
        words.append(f"{ends} rpm" + (f" ({met})" if met else ""))
    more = len(words) - _NAMED
    listed = words[:_NAMED] + ([f"{more} more ranges"] if more > 0 else [])
    return paragraph(f"Nothing damps the line at {joined(listed)}: the vibration has no bound.")
