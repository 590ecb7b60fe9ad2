"""Vibration of a shaft line over the speeds: criticals, worst sections, with and without damper."""

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.sections.section import Section
from vibecalc.report.sections.torsion_terms import (
    MEGA,
    MILLI,
    TORSION,
    cell,
    elastic_modes,
    entry,
    joined,
    meeting,
    order_text,
    range_words,
    speed_range,
    turns,
    vector,
)
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

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
