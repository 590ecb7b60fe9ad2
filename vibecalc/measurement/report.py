"""Motion of a plate from readings in the report: motion, levels by position, uncertainty."""

import math
from collections.abc import Callable

import numpy as np

from vibecalc.core.report.rows import Cells, Found, How, Made, Rows, first, part_of, rows_of
from vibecalc.core.report.sections import Section, having, labels, section
from vibecalc.core.report.writing import Column, number, paragraph, show, table
from vibecalc.core.results.record import Quantity, Record, Result

_STEM = "measurement/"
_MOST = 48


def _fixed(form: str, factor: float = 1.0) -> How:
    """What writes numbers with a fixed count of decimals."""
    return lambda value, _: form.format(factor * value)


def _of(name: str, head: str, factor: float = 1.0, form: str = "{:.2f}") -> Cells:
    return Cells(name, head, _fixed(form, factor), right=True)


_DEGREES = math.degrees(1.0)

# ----------------------------------------------------------------------------
# Readings next to the motion found from them, and the motions that levels leave open.
# ----------------------------------------------------------------------------

#: dB; residuals below it are those of readings that the motion meets exactly
_MET = 1e-6


def _apart(found: Found) -> np.ndarray:
    """Readings that the motion does not meet, the largest residual first."""
    size = np.abs(found[-1].values)
    rank = np.argsort(-size, kind="stable")
    return np.asarray(rank[size[rank] > _MET][:_MOST])


_READINGS = Rows(
    "reading",
    "order: reading",
    (
        _of("read", "read dB"),
        _of("computed", "computed dB"),
        _of("residual", "residual dB", form="{:+.2f}"),
    ),
    f"{_STEM}reading",
    places=_apart,
)


def readings(record: Record) -> list[str]:
    """Levels read that the motion does not meet exactly, the largest residual first."""
    residual = having(record, f"{_STEM}reading/residual", "reading")
    if residual is None:
        return _signals(record)
    met, count = int(np.sum(np.abs(residual.values) <= _MET)), len(residual.values)
    words = f"{met} of {count} levels are met exactly; the motion was found from them"
    lines, _ = rows_of(record, _READINGS)
    return [*lines, *(paragraph(words) if met else []), *_signals(record)]


def _signals(record: Record) -> list[str]:
    residual = having(record, _STEM + "signal/residual", "signal")
    if residual is None:
        return []
    worst = int(np.argmax(residual.values))
    return paragraph(
        f"{len(residual.values)} readings with phases; the one that the motion misses most is "
        f"{labels(residual.axes[0])[worst]}, by {show(residual.values[worst], digits=3)} times its "
        "standard uncertainty"
    )


_CANDIDATES = Rows(
    "candidate",
    "motion",
    (
        Cells("chosen", "", lambda value, _: "taken" if value else ""),
        _of("worst_residual", "residual dB"),
        _of("translation_level", "origin dB"),
        _of("translation_phase", "phase deg", _DEGREES),
        _of("roll_phase", "roll deg", _DEGREES),
        _of("pitch_phase", "pitch deg", _DEGREES),
    ),
    f"{_STEM}candidate",
    places=first(_MOST),
    note="named by harmonic and the signs of the phases of roll and pitch; the same with all "
    "phases turned round has the same levels everywhere",
)


def candidates(record: Record) -> list[str]:
    """Every motion that the levels leave, and the reading that would tell most."""
    if having(record, _STEM + "candidate/chosen", "candidate") is None:
        return []
    lines, _ = rows_of(record, _CANDIDATES)
    further = having(record, _STEM + "further/difference", "further")
    if further is None:
        return lines
    pairs = zip(labels(further.axes[0]), further.values.tolist(), strict=True)
    listed = ", ".join(f"{name} ({value:+.1f} dB)" for name, value in pairs)
    return lines + paragraph(f"the next reading that would tell them apart best: {listed}")


# ----------------------------------------------------------------------------
# Motion of a plate from readings: what moves how, levels by position, what is unsure.
# ----------------------------------------------------------------------------

_PARTS = ("translation", "roll", "pitch")
_LEVELS = {
    "no_roll": "no roll",
    "no_pitch": "no pitch",
    "only_translation": "transl.",
    "only_roll": "roll",
    "only_pitch": "pitch",
}
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
    known = having(record, _STEM + "roll_level", "order") is not None
    motion = rows_of(record, _MOTION)[0] if known else []
    blocks = [motion, _quiet(record)]
    return section("Motion of the plate from readings", blocks, details, shown)


def _level(value: float) -> str:
    return f"{float(value) + 0.0:.2f}" if math.isfinite(value) else "zero"


def _degrees(value: float) -> str:
    return f"{math.degrees(value):.1f}"


def _told(path: str, off: str, write: Callable[[float], str], factor: float = 1.0) -> Made:
    """A result by order in words, with its standard uncertainty."""

    def made(record: Record) -> Quantity | None:
        found = having(record, _STEM + path, "order")
        if found is None:
            return None
        words = [write(value) for value in found.values.tolist()]
        sizes = having(record, f"{_STEM}uncertainty/{off}", "order")
        for i, size in enumerate(() if sizes is None else factor * sizes.values):
            words[i] += f" +-{size:.2f}" if math.isfinite(size) else " +- -"
        return part_of(found, np.array(words), *found.axes)

    return made


_LEVEL_HEADS, _PHASE_HEADS = (
    ("origin dB", "roll dB", "pitch dB"),
    ("phase: origin", "roll", "pitch deg"),
)
_MOTION = Rows(
    "order",
    "order",
    (
        Cells("frequency", "Hz", "Hz"),
        *(Cells(_told(f"{part}_level", f"{part}_level", _level), head, right=True)
          for part, head in zip(_PARTS, _LEVEL_HEADS, strict=True)),
        *(Cells(_told(f"phase/{part}", f"{part}_phase", _degrees, _DEGREES), head, right=True)
          for part, head in zip(_PARTS, _PHASE_HEADS, strict=True)),
    ),
    _STEM.rstrip("/"),
    right=True,
    note="levels refer to reference_level and, of roll and pitch, to angular_reference_level; "
    "phases to the reference position; +- is the standard uncertainty from the last digits "
    "read, what is stated next to them and, with phases, the scatter; - where it is open",
)  # fmt: skip


def _levels(record: Record) -> list[str]:
    first_ = having(record, _STEM + "level/standard", "position", "order")
    if first_ is None:
        return []
    further = {
        name: having(record, f"{_STEM}level/{name}", "position", "order") for name in _LEVELS
    }
    uncertainty = having(record, _STEM + "uncertainty/level", "position", "order")
    rows = []
    for place, position in enumerate(labels(first_.axes[0])):
        for i, order in enumerate(labels(first_.axes[1])):
            off = math.nan if uncertainty is None else uncertainty.values[place, i]
            sure = f"{off:.2f}" if math.isfinite(off) else "-" * (uncertainty is not None)
            row = ["" if one is None else _level(one.values[place, i]) for one in further.values()]
            name = position if i == 0 else ""
            rows.append([name, order, _level(first_.values[place, i]), sure, *row])
    heads = map(number, ("order", "whole dB", "+-", *_LEVELS.values()))
    lines = table((Column("position"), *heads), rows[:_MOST_LEVELS])
    if len(rows) > _MOST_LEVELS:
        lines += paragraph(f"and {len(rows) - _MOST_LEVELS} more rows in the result file")
    return lines


def _quiet(record: Record) -> list[str]:
    lines: list[str] = []
    total = having(record, _STEM + "level/all_orders", "position")
    if total is not None:
        names, values = labels(total.axes[0]), total.values
        order = np.argsort(values, kind="stable")[:12]
        listed = ", ".join(f"{names[i]} {_level(values[i])}" for i in order)
        lines += paragraph(f"positions, the quietest first, dB of all harmonics together: {listed}")
    x, y, least = (having(record, f"{_STEM}quiet/{name}", "order")
                   for name in ("x", "y", "amplitude"))  # fmt: skip
    if x is None or y is None or least is None:
        return lines
    rows = [
        [order, show(x.values[i]), show(y.values[i]), show(least.values[i], least.error_estimate)]
        for i, order in enumerate(labels(x.axes[0]))
    ]
    paths = [f"{_STEM}quiet/all_orders_{name}" for name in ("x", "y", "amplitude")]
    if all(path in record for path in paths):
        of_all = (show(record[path].values[()], record[path].error_estimate) for path in paths)
        rows.append(["all", *of_all])
    heads = map(number, ("order", "x m", "y m", "m/s^2"))
    return [*lines, "", *paragraph("where on the plate it moves least:"), *table([*heads], rows)]
