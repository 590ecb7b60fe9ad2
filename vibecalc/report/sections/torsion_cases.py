"""The first table on a shaft line: quantities by cases, with limit and flag, and where they are.

A case is the line with all cylinders firing, with a misfire, or without its dampers. The limits of
a case file are for the line as the file describes it; in the columns beside it they are marks only.
"""

from collections.abc import Iterator

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import show
from vibecalc.report.sections.torsion_case_checks import frequencies, gears, stress_limits
from vibecalc.report.sections.torsion_scenes import (
    ABOVE,
    ANY,
    OPERATING,
    Row,
    Scene,
    bound_of,
    own_entry,
    scenes,
)
from vibecalc.report.sections.torsion_terms import MEGA, MILLI, TORSION, meeting, names, turns
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record, Result

#: words, path below `TORSION`, factor from SI, unit as shown
_LARGEST = (
    ("torque, half range", "torque_half_range", 1.0, "N*m"),
    ("stress, half range", "stress_half_range", MEGA, "N/mm^2"),
    ("twist, half range", "twist_half_range", MILLI, "mrad"),
)
_DAMPERS = (
    ("heat in a damper", "damper/heat", 1.0, "W"),
    ("travel in a damper", "damper/travel", MILLI, "mrad"),
)


def cases_table(result: Result) -> list[str]:
    """Lines of the table of cases and of the places below it."""
    columns = scenes(result)
    rows = [
        row
        for part in (frequencies, _largest, stress_limits, _dampers, gears)
        for row in part(result, columns)
    ]
    if not rows:
        return []
    head = [Column("quantity", 33), Column("unit", 6)]
    head += [number(scene.title, 11) for scene in columns]
    head += [number("limit", 8), Column("flag", 12)]
    lines = table(head, [
        [row.words, row.unit, *(row.value.get(scene.prefix, "") for scene in columns), row.limit,
         row.flag]
        for row in rows
    ])  # fmt: skip
    if any(text.endswith(ABOVE) for row in rows for text in row.value.values()):
        lines += paragraph("!: above the limit, which the case sets for another column.")
    places = [
        [row.words if first else "", scene.name if len(columns) > 1 else "", *row.where[prefix]]
        for row in rows
        for first, scene, prefix in _places(row, columns)
    ]
    if places:
        head = [Column("where", 33), Column("case", 12), Column("section or mode", 18),
                Column("at", 32)]  # fmt: skip
        lines += ["", *table(head, places)]
    return lines


def _places(row: Row, columns: list[Scene]) -> Iterator[tuple[bool, Scene, str]]:
    there = [scene for scene in columns if scene.prefix in row.where]
    for place, scene in enumerate(there):
        yield place == 0, scene, scene.prefix


def _largest(result: Result, columns: list[Scene]) -> Iterator[Row]:
    """Torque, stress and twist: the worst section over the speeds, and at the operating speed."""
    record = result.record
    for words, name, factor, unit in _LARGEST:
        for way, path in ((ANY, f"largest/{name}"), (OPERATING, name)):
            found = {
                scene.prefix: top
                for scene in columns
                if (top := _top(record, scene.prefix, path, factor)) is not None
            }
            if not found:
                continue
            limit, flag, most = bound_of(result, TORSION + path, factor)
            value, where = {}, {}
            for prefix, (size, text, section) in found.items():
                value[prefix] = text + (ABOVE if prefix and size > most else "")
                at = _at_speed(record, prefix, name, section) if way == ANY else OPERATING
                endless = ("", "undamped criticals, listed below")
                where[prefix] = (section, at) if np.isfinite(size) else endless
            yield Row(f"{words}, {way}", unit, value, limit, flag, where)


def _top(record: Record, prefix: str, path: str, factor: float) -> tuple[float, str, str] | None:
    """Size, text and section of the largest entry; None if there is none above zero."""
    quantity = having(record, TORSION + prefix + path, "section")
    if quantity is None:
        return None
    # the twist of a damper is the travel of its ring, which has a row of its own
    rings = set(names(record, "damper/travel", "damper"))
    named = labels(quantity.axes[0])
    counts = np.array([label not in rings for label in named])
    values = np.where(counts, np.asarray(quantity.values, dtype=float), 0.0)
    if not np.any(values > 0.0):
        return None
    place = int(np.argmax(values))
    size = factor * float(values[place])
    return size, show(size, factor * quantity.error_estimate, 5), named[place]


def _at_speed(record: Record, prefix: str, name: str, section: str) -> str:
    """Where the largest entry of a section is; a quantity may have a speed of its own."""
    paths = [f"{prefix}largest/{own}" for own in (name.replace("half_range", "speed"), "speed")]
    speed = next((s for path in paths if (s := own_entry(record, path, section)) is not None), None)
    if speed is None:
        return ANY
    mode, order = (
        own_entry(record, f"{prefix}largest/{part}", section) for part in ("mode", "half_order")
    )
    met = "" if mode is None or order is None else meeting(mode, order)
    return f"{turns(speed)} rpm" + (f" ({met})" if met else "")


def _dampers(result: Result, columns: list[Scene]) -> Iterator[Row]:
    record = result.record
    for words, path, factor, unit in _DAMPERS:
        value, where = {}, {}
        limit, flag, most = bound_of(result, TORSION + path, factor)
        for scene in columns:
            quantity = having(record, TORSION + scene.prefix + path, "damper")
            if quantity is None:
                continue
            sizes = factor * np.asarray(quantity.values, dtype=float)
            place = int(np.argmax(sizes))
            text = show(sizes[place], factor * quantity.error_estimate, 5)
            value[scene.prefix] = text + (ABOVE if scene.prefix and sizes[place] > most else "")
            where[scene.prefix] = (labels(quantity.axes[0])[place], OPERATING)
        if value:
            yield Row(f"{words}, {OPERATING}", unit, value, limit, flag, where)
