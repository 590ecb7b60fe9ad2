"""Motion of a plate from readings in the report: motion, levels by position, uncertainty."""

import math

import numpy as np

from vibecalc.core.report.sections import (
    Section,
    having,
    labels,
    section,
)
from vibecalc.core.report.writing import Column, hertz, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result

# ----------------------------------------------------------------------------
# Readings next to the motion found from them, and the motions that levels leave open.
# ----------------------------------------------------------------------------

_STEM = "measurement/"
_MOST = 48
#: dB; residuals below it are those of readings that the motion meets exactly
_MET = 1e-6


def readings(record: Record) -> list[str]:
    """Levels read that the motion does not meet exactly, the largest residual first."""
    entries = {
        name: having(record, f"{_STEM}reading/{name}", "reading")
        for name in ("read", "computed", "residual")
    }
    residual = entries["residual"]
    if residual is None:
        return _signals(record)
    names = labels(residual.axes[0])
    size = np.abs(np.asarray(residual.values))
    apart = [int(i) for i in np.argsort(-size, kind="stable") if size[i] > _MET]
    rows = []
    for i in apart[:_MOST]:
        values = [entries[name] for name in ("read", "computed")]
        cells = ["" if one is None else f"{float(one.values[i]):.2f}" for one in values]
        rows.append([names[i], *cells, f"{float(residual.values[i]):+.2f}"])
    columns = (
        Column("order: reading"),
        number("read dB"),
        number("computed dB"),
        number("residual dB"),
    )
    met = len(names) - len(apart)
    words = f"{met} of {len(names)} levels are met exactly; the motion was found from them"
    lines = table(columns, rows) if rows else []
    return lines + (paragraph(words) if met else []) + _signals(record)


def _signals(record: Record) -> list[str]:
    residual = having(record, _STEM + "signal/residual", "signal")
    if residual is None:
        return []
    values = np.asarray(residual.values)
    worst = int(np.argmax(values))
    name = labels(residual.axes[0])[worst]
    return paragraph(
        f"{len(values)} readings with phases; the one that the motion misses most is {name}, by "
        f"{show(values[worst], digits=3)} times its standard uncertainty"
    )


def candidates(record: Record) -> list[str]:
    """Every motion that the levels leave, and the reading that would tell most."""
    chosen = having(record, _STEM + "candidate/chosen", "candidate")
    if chosen is None:
        return []
    names = labels(chosen.axes[0])
    columns = [
        ("worst_residual", 1.0, "residual dB"),
        ("translation_level", 1.0, "origin dB"),
        ("translation_phase", math.degrees(1.0), "phase deg"),
        ("roll_phase", math.degrees(1.0), "roll deg"),
        ("pitch_phase", math.degrees(1.0), "pitch deg"),
    ]
    rows = []
    for i, name in enumerate(names):
        row = [name, "taken" if chosen.values[i] else ""]
        for path, factor, _ in columns:
            quantity = having(record, f"{_STEM}candidate/{path}", "candidate")
            row.append("" if quantity is None else f"{factor * float(quantity.values[i]):.2f}")
        rows.append(row)
    heads = (Column("motion"), Column(""), *(number(words) for *_, words in columns))
    lines = table(heads, rows[:_MOST])
    lines += paragraph(
        "named by harmonic and the signs of the phases of roll and pitch; the same with all phases "
        "turned round has the same levels everywhere"
    )
    further = having(record, _STEM + "further/difference", "further")
    if further is not None and len(further.values):
        listed = ", ".join(
            f"{name} ({float(value):+.1f} dB)"
            for name, value in zip(labels(further.axes[0]), further.values, strict=True)
        )
        lines += paragraph(f"the next reading that would tell them apart best: {listed}")
    return lines


# ----------------------------------------------------------------------------
# Motion of a plate from readings: what moves how, levels by position, what is unsure.
# ----------------------------------------------------------------------------

_PARTS = ("translation", "roll", "pitch")
_LEVELS = (
    ("standard", "whole"),
    ("no_roll", "no roll"),
    ("no_pitch", "no pitch"),
    ("only_translation", "transl."),
    ("only_roll", "roll"),
    ("only_pitch", "pitch"),
)
_MOST_LEVELS = 72


def measurement(result: Result) -> Section | None:
    """The section, None if the result has no motion from readings."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_STEM))
    if not shown:
        return None
    details = {
        "levels at every position": _levels(record),
        "readings and their residuals": readings(record),
        "motions that the levels leave open": candidates(record),
    }
    blocks = [_motion(record), _quiet(record)]
    return section("Motion of the plate from readings", blocks, details, shown)


def _motion(record: Record) -> list[str]:
    level = having(record, _STEM + "roll_level", "order")
    if level is None:
        return []
    orders = labels(level.axes[0])
    frequency = having(record, _STEM + "frequency", "order")
    rows = []
    for i, order in enumerate(orders):
        row = [order, "" if frequency is None else show(hertz(float(frequency.values[i])))]
        row += [_with_uncertainty(record, f"{part}_level", i) for part in _PARTS]
        row += [_degrees(record, part, i) for part in _PARTS]
        rows.append(row)
    columns = (
        number("order"),
        number("Hz"),
        number("origin dB"),
        number("roll dB"),
        number("pitch dB"),
        number("phase: origin"),
        number("roll"),
        number("pitch deg"),
    )
    words = (
        "levels refer to reference_level and, of roll and pitch, to angular_reference_level; "
        "phases to the reference position; +- is the standard uncertainty from the last digits "
        "read, what is stated next to them and, with phases, the scatter; - where it is open"
    )
    return table(columns, rows) + paragraph(words)


def _with_uncertainty(record: Record, name: str, place: int) -> str:
    value = having(record, _STEM + name, "order")
    uncertainty = having(record, f"{_STEM}uncertainty/{name}", "order")
    if value is None:
        return ""
    return _level(value.values[place]) + _plus_minus(uncertainty, place, 1.0)


def _degrees(record: Record, part: str, place: int) -> str:
    value = having(record, f"{_STEM}phase/{part}", "order")
    uncertainty = having(record, f"{_STEM}uncertainty/{part}_phase", "order")
    if value is None:
        return ""
    degrees = math.degrees(float(value.values[place]))
    return f"{degrees:.1f}" + _plus_minus(uncertainty, place, math.degrees(1.0))


def _plus_minus(uncertainty: Quantity | None, place: int, factor: float) -> str:
    if uncertainty is None:
        return ""
    value = factor * float(uncertainty.values[place])
    return f" +-{value:.2f}" if math.isfinite(value) else " +- -"


def _level(value: float) -> str:
    return f"{float(value) + 0.0:.2f}" if math.isfinite(value) else "zero"


def _levels(record: Record) -> list[str]:
    first = having(record, _STEM + "level/standard", "position", "order")
    if first is None:
        return []
    uncertainty = having(record, _STEM + "uncertainty/level", "position", "order")
    positions, orders = labels(first.axes[0]), labels(first.axes[1])
    rows = []
    for place, position in enumerate(positions):
        for i, order in enumerate(orders):
            row = [position if i == 0 else "", order]
            for part, _ in _LEVELS:
                quantity = having(record, f"{_STEM}level/{part}", "position", "order")
                row.append("" if quantity is None else _level(quantity.values[place, i]))
            sure = "" if uncertainty is None else _plus_minus_alone(uncertainty.values[place, i])
            rows.append([*row[:3], sure, *row[3:]])
    columns = (
        Column("position"),
        number("order"),
        number("whole dB"),
        number("+-"),
        *(number(words) for _, words in _LEVELS[1:]),
    )
    lines = table(columns, rows[:_MOST_LEVELS])
    if len(rows) > _MOST_LEVELS:
        lines += paragraph(f"and {len(rows) - _MOST_LEVELS} more rows in the result file")
    return lines


def _plus_minus_alone(value: float) -> str:
    return f"{float(value):.2f}" if math.isfinite(value) else "-"


def _quiet(record: Record) -> list[str]:
    lines: list[str] = []
    total = having(record, _STEM + "level/all_orders", "position")
    if total is not None:
        names, values = labels(total.axes[0]), np.asarray(total.values)
        order = np.argsort(values, kind="stable")
        listed = ", ".join(f"{names[i]} {_level(values[i])}" for i in order[:12])
        lines += paragraph(f"positions, the quietest first, dB of all harmonics together: {listed}")
    x, y, least = (
        having(record, f"{_STEM}quiet/{name}", "order") for name in ("x", "y", "amplitude")
    )
    if x is None or y is None or least is None:
        return lines
    rows = [
        [order, show(x.values[i]), show(y.values[i]), show(least.values[i], least.error_estimate)]
        for i, order in enumerate(labels(x.axes[0]))
    ]
    singles = [
        record.quantities.get(f"{_STEM}quiet/all_orders_{name}") for name in ("x", "y", "amplitude")
    ]
    if all(single is not None for single in singles):
        rows.append(
            ["all", *(show(s.values[()], s.error_estimate) for s in singles if s is not None)]
        )
    columns = (number("order"), number("x m"), number("y m"), number("m/s^2"))
    return [*lines, "", *paragraph("where on the plate it moves least:"), *table(columns, rows)]
