"""The first page: limits with margins, one sentence of conclusion, published beside computed."""

from collections.abc import Sequence

from vibecalc.report.limits import LimitRow
from vibecalc.report.numbers import show, show_percent
from vibecalc.report.references import KNOWN, MEASURED, OUTSIDE, WITHIN, ReferenceRow
from vibecalc.report.tables import Column, fold, number, paragraph, table

_LIMITS = (
    Column("limit on", 37),
    number("bound", 16),
    number("computed", 11),
    number("margin", 11),
    Column("unit", 7),
    Column("verdict", 11),
)
_REFERENCES = (
    Column("published number (source)", 44),
    number("published", 10),
    number("computed", 11),
    Column("unit", 7),
    number("difference", 11),
    Column("verdict", 10),
)
#: Longer values, such as a root written out, are shown with as many digits as ours.
LONGEST_PRINTED = 10


def limits(rows: Sequence[LimitRow]) -> list[str]:
    """The table of limits, in the order of the case."""
    cells = []
    for row in rows:
        bounds = []
        if row.min is not None:
            bounds.append(f"min {row.min:.6g}")
        if row.max is not None:
            bounds.append(f"max {row.max:.6g}")
        picks = _picks(row.where)
        entry = f"worst {row.label}" if row.label not in ("", picks) else picks
        source = f"({row.source})" if row.source else ""
        cells.append(
            [
                _name(_LIMITS, row.quantity, row.at, entry, source),
                "\n".join(bounds),
                show(row.computed, row.error_estimate),
                show(row.margin, row.error_estimate),
                row.unit,
                limit_verdict(row),
            ]
        )
    return table(_LIMITS, cells) if cells else []


def limit_verdict(row: LimitRow) -> str:
    """`kept` or `BROKEN`, or whether an expected break came."""
    if row.expect == "kept":
        return "kept" if row.kept else "BROKEN"
    return "KEPT, not broken as expected" if row.kept else "broken, as expected"


def references(rows: Sequence[ReferenceRow], most: int | None = None) -> list[str]:
    """The table of references with notes below, numbered where a source is known to differ.

    With `most`, only so many of those that come out are shown and the others are counted.
    """
    shown = brief(rows, most)
    hidden = len(rows) - len(shown)
    cells: list[list[str]] = []
    notes = known_notes(shown)
    for row in shown:
        verdict = row.verdict.upper() if row.verdict == OUTSIDE else row.verdict
        if row.verdict == KNOWN:
            verdict = f"known [{notes.index(_note(row)) + 1}]"
        cells.append(
            [
                _name(_REFERENCES, row.quantity, row.at, _picks(row.where), f"({row.source})"),
                row.printed if len(row.printed) <= LONGEST_PRINTED else show(row.value),
                show(row.computed, row.error_estimate),
                row.unit,
                show_percent(row.relative_difference),
                verdict,
            ]
        )
    if not cells:
        return []
    lines = table(_REFERENCES, cells)
    if hidden:
        lines += paragraph(f"and {_many(hidden, 'more published number')} that come out")
    for i, note in enumerate(notes):
        lines += paragraph(note, f"[{i + 1}]")
    return lines


def known_notes(rows: Sequence[ReferenceRow]) -> list[str]:
    """Why sources are known to differ, each reason once, in the order of the rows."""
    return list(dict.fromkeys(_note(row) for row in rows if row.verdict == KNOWN))


def conclusion(references: Sequence[ReferenceRow], limits: Sequence[LimitRow]) -> str:
    """One sentence: what holds, what does not, and by how much."""
    clauses = []
    missed = [row for row in limits if not row.satisfied]
    if limits:
        kept = sum(row.kept for row in limits)
        verb = "is" if 1 in (kept, len(limits)) else "are"
        clause = f"{kept} of {_many(len(limits), 'limit')} {verb} kept"
        broken = [row for row in limits if not row.kept]
        if broken:
            first = min(broken, key=lambda row: row.margin)
            where = f" at {first.label}" if first.label else ""
            clause += (
                f"; {first.quantity}{where} breaks its bound by "
                f"{show(-first.margin)} {first.unit}".rstrip()
            )
            if not missed:
                clause += ", as the case expects"
        clauses.append(clause)
    counted = [row for row in references if row.within is not None]
    if counted:
        good = sum(bool(row.within) for row in counted)
        clauses.append(f"{good} of {_many(len(counted), 'counted published number')} come out")
    known = sum(row.verdict == KNOWN for row in references)
    measured = sum(row.verdict == MEASURED for row in references)
    if known:
        clauses.append(f"{known} known to differ, with the reason, {_is(known)} shown only")
    if measured:
        clauses.append(f"{measured} measured {_is(measured)} shown only")
    return "; ".join(clauses) + "." if clauses else "The case names no limit and no reference."


def brief(rows: Sequence[ReferenceRow], most: int | None) -> list[ReferenceRow]:
    """All rows that do not simply come out, and the first `most` of those that do."""
    come_out = [i for i, row in enumerate(rows) if row.verdict == WITHIN]
    hidden = set() if most is None else set(come_out[most:])
    return [row for i, row in enumerate(rows) if i not in hidden]


def _note(row: ReferenceRow) -> str:
    note = row.known_difference + (f" (shown by {row.shown_by})" if row.shown_by else "")
    if row.agrees:
        note += " - yet it agrees within its tolerance: remove the note or the row"
    return note


def _is(count: int) -> str:
    return "is" if count == 1 else "are"


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _picks(where: object) -> str:
    if not isinstance(where, dict):
        return ""
    return ", ".join(f"{axis}={entry}" for axis, entry in where.items())


def _name(columns: Sequence[Column], quantity: str, at: str, *remarks: str) -> str:
    """The path, and below it, a little to the right, what else belongs to the row."""
    name = quantity + (" (start)" if at == "start" else "")
    below = fold(" ".join(remark for remark in remarks if remark), columns[0].width - 2)
    return "\n".join([name, *(f"  {line}" for line in below if line)])
