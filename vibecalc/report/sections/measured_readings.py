"""Readings beside the motion found from them, and the motions that levels leave open."""

import math

import numpy as np

from vibecalc.report.lookup import having, labels
from vibecalc.report.numbers import show
from vibecalc.report.tables import Column, number, paragraph, table
from vibecalc.results.record import Record

_STEM = "measurement/"
_MOST = 48
#: dB; residuals below it are those of readings that the motion meets exactly
_MET = 1e-6


def readings(record: Record) -> list[str]:
    """Levels read that the motion does not meet exactly, the largest residual first."""
    found = {
        name: having(record, f"{_STEM}reading/{name}", "reading")
        for name in ("read", "computed", "residual")
    }
    residual = found["residual"]
    if residual is None:
        return _signals(record)
    names = labels(residual.axes[0])
    size = np.abs(np.asarray(residual.values))
    apart = [int(i) for i in np.argsort(-size, kind="stable") if size[i] > _MET]
    rows = []
    for i in apart[:_MOST]:
        values = [found[name] for name in ("read", "computed")]
        cells = ["" if one is None else f"{float(one.values[i]):.2f}" for one in values]
        rows.append([names[i], *cells, f"{float(residual.values[i]):+.2f}"])
    columns = (
        Column("order: reading", 30),
        number("read dB", 12),
        number("computed dB", 12),
        number("residual dB", 12),
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
            found = having(record, f"{_STEM}candidate/{path}", "candidate")
            row.append("" if found is None else f"{factor * float(found.values[i]):.2f}")
        rows.append(row)
    heads = (Column("motion", 14), Column("", 6), *(number(words, 12) for *_, words in columns))
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
