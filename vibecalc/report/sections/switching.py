"""The change from one operation to the other: how far it moves the body, and for how long."""

import math
from collections.abc import Sequence

import numpy as np

from vibecalc.report.lookup import having, labels, magnitudes, table_of
from vibecalc.report.numbers import rpm, show
from vibecalc.report.sections.section import Section
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Quantity, Record, Result

_STEM = "response/switching/"
_WAYS = (("reversal", "through rest"), ("instant", "at once"))
_VECTORS = (
    ("translation_peak", "largest displacement m"),
    ("rotation_peak", "largest rotation rad"),
    ("ground_force_peak", "force on the ground N"),
    ("ground_couple_peak", "couple on the ground N*m"),
)
_SCALARS = (
    ("kinetic_energy_peak", "largest kinetic energy J"),
    ("slow_kinetic_energy", "  if infinitely slow J"),
    ("worst_kinetic_energy_peak", "  at the worst crank angle J"),
    ("worst_angle", "  which is deg"),
    ("peak_time", "  time from start of change s"),
    ("peak_speed", "  at a crank speed of rpm"),
    ("potential_energy_peak", "largest potential energy J"),
    ("settle_time", "settles, from end of change s"),
)
_DIGITS = 5
_PER_TABLE = 4
_PASSAGES = 16

#: title of a column, way and place on the axis of changes
_Case = tuple[str, str, int]


def switching(result: Result) -> Section | None:
    """The section, None if the result has no change between operations."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_STEM))
    cases = _cases(record)
    if not cases:
        return None
    lines = _steady(result)
    for first in range(0, len(cases), _PER_TABLE):
        lines += [""] if lines else []
        lines += _table(record, cases[first : first + _PER_TABLE])
    lines += _passages(record)
    return Section("Switching between operations", lines, shown)


def _cases(record: Record) -> list[_Case]:
    found: list[_Case] = []
    for way, words in _WAYS:
        quantity = having(record, f"{_STEM}{way}/kinetic_energy_peak", "change")
        if quantity is not None:
            names = labels(quantity.axes[0])
            found += [(f"{name} {words}", way, i) for i, name in enumerate(names)]
    return found


def _steady(result: Result) -> list[str]:
    steady = having(result.record, _STEM + "steady_energy", "operation")
    if steady is None:
        return []
    each = [
        f"{name} {show(value, steady.error_estimate)} {steady.unit}"
        for name, value in zip(labels(steady.axes[0]), steady.values, strict=True)
    ]
    words = "largest kinetic energy of the steady states: " + ", ".join(each)
    options = table_of(result.case, "response", "switching")
    settled = options.get("settled")
    if isinstance(settled, int | float):
        words += f"; settled means within {100.0 * settled:g} % of the steady motion"
    return paragraph(words)


def _table(record: Record, cases: list[_Case]) -> list[str]:
    columns = (Column("on the way", 30), *(number(title, 16) for title, _, _ in cases))
    rows = []
    for name, words in _VECTORS:
        cells = []
        for _, way, i in cases:
            quantity = having(record, f"{_STEM}{way}/{name}", "change", "direction")
            cells.append("" if quantity is None else _largest(quantity, i))
        rows.append([words, *cells])
    for name, words in _SCALARS:
        found = [(having(record, f"{_STEM}{way}/{name}", "change"), i) for _, way, i in cases]
        rows.append([words, *("" if q is None else _scalar(q, i) for q, i in found)])
        if name == "kinetic_energy_peak":
            rows.append(["  times the larger steady one", *_ratios(record, found)])
    return table(columns, [row for row in rows if any(row[1:])])


def _largest(quantity: Quantity, change: int) -> str:
    """Largest of the directions, with its name."""
    values = magnitudes(quantity)[change]
    top = int(np.argmax(values))
    text = show(values[top], quantity.error_estimate, _DIGITS)
    return text if text == "0" else f"{text} {labels(quantity.axes[1])[top]}"


def _scalar(quantity: Quantity, change: int) -> str:
    """One reading; angles in degrees and speeds in rpm, as the titles say."""
    value, error = float(quantity.values[change]), quantity.error_estimate
    if quantity.unit == "rad":
        return f"{math.degrees(value):.1f}"
    if quantity.unit == "rad/s":
        value, error = rpm(value), rpm(error)
    return show(value, error, _DIGITS)


def _ratios(record: Record, found: Sequence[tuple[Quantity | None, int]]) -> list[str]:
    steady = having(record, _STEM + "steady_energy", "operation")
    larger = 0.0 if steady is None else float(np.max(steady.values))
    if not larger > 0.0:
        return [""] * len(found)
    return ["" if q is None else show(float(q.values[i]) / larger, digits=3) for q, i in found]


def _passages(record: Record) -> list[str]:
    """Resonances that the crank runs through on its way, if the result lists them."""
    stem = _STEM + "passage/"
    names = ("change", "mode", "order", "speed", "time", "haste")
    found = {name: having(record, stem + name, "passage") for name in names}
    speed = found["speed"]
    if speed is None or any(found[name] is None for name in ("change", "mode", "order", "time")):
        return []
    changes = having(record, _STEM + "reversal/kinetic_energy_peak", "change")
    titles = labels(changes.axes[0]) if changes is not None else []
    whole = [found[name] for name in ("mode", "order")]
    rows = []
    # Low orders carry the large forces: they are shown first, in the order of time.
    order = np.asarray(whole[1].values) if whole[1] is not None else np.arange(len(speed.values))
    for i in sorted(np.argsort(order, kind="stable")[:_PASSAGES].tolist()):
        which = int(found["change"].values[i]) - 1 if found["change"] is not None else 0
        title = titles[which] if 0 <= which < len(titles) else str(which + 1)
        row = [title, *(str(int(q.values[i])) for q in whole if q is not None)]
        row.append(show(rpm(float(speed.values[i]))))
        for quantity in (found["time"], found["haste"]):
            row.append("" if quantity is None else show(quantity.values[i]))
        rows.append(row)
    columns = (
        Column("resonance passed in", 24),
        number("mode", 6),
        number("order", 6),
        number("at rpm", 12),
        number("after s", 12),
        number("haste", 12),
    )
    lines = ["", *table(columns, rows)]
    rest = len(speed.values) - len(rows)
    lines += paragraph(
        "haste above 1: the resonance has no time to build up"
        + (f"; {rest} further passages of higher order are in the result file" if rest else "")
    )
    return lines
