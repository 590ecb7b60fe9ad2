"""Motion of a plate from readings in the report: motion, levels by position, uncertainty."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibecalc.core.report.rows import Cells, Found, Made, Rows, first, part_of, rows_of
from vibecalc.core.report.sections import Section, having, labels, section, table_of
from vibecalc.core.report.writing import Column, number, paragraph, rpm, show, table
from vibecalc.core.results.record import Quantity, Record, Result
from vibecalc.numerics.rounding import ranked

_STEM = "measurement/"
_MOST = 48
#: path, heading, and what writes a value of the quantity
_Told = tuple[str, str, Callable[[Any, Quantity], str]]


def _of(name: str, head: str, factor: float = 1.0, form: str = "{:.2f}") -> Cells:
    return Cells(name, head, lambda value, _: form.format(factor * value), right=True)


_DEGREES = math.degrees(1.0)


def level_words(case: Mapping[str, Any], kind: str = "", unit: str = "m/s^2") -> str:
    """`dB re 1e-5 m/s^2`, with the reference of the case."""
    given: Any = table_of(case, "measurement").get(f"{kind}reference_level")
    return f"dB re {float(given or 1.0):g} {unit}".replace("e-0", "e-")


def angular_level_words(case: Mapping[str, Any]) -> str:
    """The same of roll and pitch: `dB re 1 rad/s^2`."""
    return level_words(case, "angular_", "rad/s^2")


# ----------------------------------------------------------------------------
# Readings next to the motion found from them, and the motions that levels leave open.
# ----------------------------------------------------------------------------

#: dB; residuals below it are those of readings that the motion meets exactly
_MET = 1e-6


def _apart(found: Found) -> np.ndarray:
    """Readings that the motion does not meet, the largest residual first."""
    size = np.abs(found[-1].values)
    rank = ranked(size)
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
    lines, _ = rows_of(record, _READINGS)
    residual = having(record, f"{_STEM}reading/residual", "reading")
    if residual is not None:
        met, count = int(np.sum(np.abs(residual.values) <= _MET)), len(residual.values)
        words = f"{met} of {count} levels are reproduced exactly: the motion is solved from them"
        lines += paragraph(words) if met else []
    signals = having(record, _STEM + "signal/residual", "signal")
    if signals is None:
        return lines
    worst = int(np.argmax(signals.values))
    return lines + paragraph(
        f"{len(signals.values)} readings with phases; largest residual: "
        f"{labels(signals.axes[0])[worst]}, {show(signals.values[worst], digits=3)} standard "
        "uncertainties"
    )


_CANDIDATES = Rows(
    "candidate",
    "motion",
    (
        Cells("chosen", "", lambda value, _: "selected" if value else ""),
        _of("worst_residual", "residual dB"),
        _of("translation_level", "origin dB"),
        _of("translation_phase", "phase deg", _DEGREES),
        _of("roll_phase", "roll deg", _DEGREES),
        _of("pitch_phase", "pitch deg", _DEGREES),
    ),
    f"{_STEM}candidate",
    places=first(_MOST),
    note="named by harmonic and signs of the roll and pitch phases; reversing all phases gives the "
    "same levels everywhere",
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
    return lines + paragraph(f"best further reading to distinguish them: {listed}")


# ----------------------------------------------------------------------------
# Motion of a plate from readings: what moves how, levels by position, what is unsure.
# ----------------------------------------------------------------------------

_PARTS = ("translation", "roll", "pitch")
_MOST_LEVELS, _MOST_CHANNELS = 72, 24
#: least uncertainty that is written out, in dB or degrees
_LEAST = 0.01


def measurement(result: Result) -> Section | None:
    """The section, None if the result has no motion from readings."""
    record = result.record
    shown = frozenset(path for path in record if path.startswith(_STEM))
    if not shown:
        return None
    details = {
        "levels at every position": _by_order(record, "position", _LEVELS, _MOST_LEVELS),
        "readings and their residuals": readings(record),
        "motions compatible with the levels": candidates(record),
    }
    known = having(record, _STEM + "roll_level", "order") is not None
    linear, angular = level_words(result.case), angular_level_words(result.case)
    told = _MOTION._replace(note=_MOTION.note.format(linear=linear, angular=angular))
    motion = rows_of(record, told)[0] if known else []
    blocks = [motion, _quiet(record, linear)]
    return section("Motion of the plate", blocks, details, shown)


def _level(value: float, _: object = None) -> str:
    return f"{float(value) + 0.0:.2f}" if math.isfinite(value) else "zero"


def _degrees(value: float) -> str:
    return f"{math.degrees(value):.1f}"


def _unsure(size: float) -> str:
    """An uncertainty, of which two decimals say enough."""
    if not math.isfinite(size):
        return " -"
    return f"{size:.2f}" if size >= _LEAST else f"<{_LEAST}"


def _told(path: str, off: str, write: Callable[[float], str], factor: float = 1.0) -> Made:
    """A result by order in words, with its standard uncertainty."""

    def made(record: Record) -> Quantity | None:
        found = having(record, _STEM + path, "order")
        if found is None:
            return None
        words = [write(value) for value in found.values.tolist()]
        sizes = having(record, f"{_STEM}uncertainty/{off}", "order")
        for i, size in enumerate(() if sizes is None else factor * sizes.values):
            words[i] += f" +-{_unsure(size)}"
        return part_of(found, np.array(words), *found.axes)

    return made


_LEVEL_HEADS, _PHASE_HEADS = (
    ("translation dB", "roll dB", "pitch dB"),
    ("phase: translation", "roll", "pitch deg"),
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
    note="translation: of the origin, {linear}; roll and pitch: {angular}; phases relative to the "
    "reference position; +-: standard uncertainty (resolution, stated uncertainty and, with "
    "phases, scatter); -: undetermined",
)  # fmt: skip


def _sure(value: float, _: Quantity) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "-"


_LEVELS = (
    ("level/standard", "total dB", _level),
    ("uncertainty/level", "+-", _sure),
    ("level/no_roll", "no roll", _level),
    ("level/no_pitch", "no pitch", _level),
    ("level/only_translation", "transl.", _level),
    ("level/only_roll", "roll", _level),
    ("level/only_pitch", "pitch", _level),
)
_ORDERS = (
    ("record/acceleration", "m/s^2", lambda value, one: show(abs(value), one.error_estimate)),
    ("record/uncertainty", "+-", lambda value, _: show(value, digits=2)),
    ("record/phase", "phase deg", lambda value, _: f"{math.degrees(value):.2f}"),
    ("record/phase_uncertainty", "+-", lambda value, _: f"{math.degrees(value):.2g}"),
)


def _by_order(record: Record, axis: str, columns: Sequence[_Told], most: int) -> list[str]:
    """Results by the entries of an axis and by order, a line for each pair."""
    found = [having(record, _STEM + path, axis, "order") for path, _, _ in columns]
    if found[0] is None:
        return []
    names, orders = (labels(one) for one in found[0].axes)
    rows = []
    for i, j in np.ndindex(len(names), len(orders)):
        cells = ["" if one is None else write(one.values[i, j], one)
                 for one, (_, _, write) in zip(found, columns, strict=True)]  # fmt: skip
        rows.append([names[i] if j == 0 else "", orders[j], *cells])
    heads = [number(head) for head in ("order", *(head for _, head, _ in columns))]
    lines = table((Column(axis), *heads), rows[:most])
    if len(rows) > most:
        lines += paragraph(f"{len(rows) - most} more rows in the result file")
    return lines


def records(result: Result) -> Section | None:
    """Amplitude and phase of each channel and harmonic with what the blocks leave open."""
    record = result.record
    speed = having(record, _STEM + "record/block_speed", "channel", "block")
    lines = _by_order(record, "channel", _ORDERS, _MOST_CHANNELS)
    if speed is None or not lines:
        return None
    low, high = (show(rpm(float(one))) for one in (np.min(speed.values), np.max(speed.values)))
    at = f"{low} rpm" if low == high else f"{low} to {high} rpm"
    words = f"{speed.values.shape[1]} blocks of whole turns at {at}; +-: standard uncertainty of"
    words += " the mean (scatter of blocks and angle); phases: lead relative to the first pulse"
    return section("Orders of the records", [lines + paragraph(words)])


def _quiet(record: Record, reference: str) -> list[str]:
    lines: list[str] = []
    total = having(record, _STEM + "level/all_orders", "position")
    if total is not None:
        names, values = labels(total.axes[0]), total.values
        order = np.argsort(values, kind="stable")[:12]
        listed = "; ".join(f"{names[i]}: {_level(values[i])}" for i in order)
        lines += paragraph(f"level at the positions, all harmonics, {reference}: {listed}")
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
    heads = map(number, ("order", "x m", "y m", "acceleration m/s^2"))
    return [*lines, "", *paragraph("point of least motion on the plate:"), *table([*heads], rows)]
