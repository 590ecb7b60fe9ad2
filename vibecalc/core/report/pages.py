"""The pages around the stages: verdicts first; warnings, methods, accuracy at the end."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibecalc.core.report.sections import START, Section, magnitudes, table_of
from vibecalc.core.report.verdicts import (
    BROKEN,
    KEPT,
    KNOWN,
    MEASURED,
    OUTSIDE,
    UNDECIDED,
    WITHIN,
    LimitRow,
    ReferenceRow,
)
from vibecalc.core.report.writing import (
    DIGITS,
    Column,
    fold,
    number,
    pairs,
    paragraph,
    show,
    show_error,
    show_percent,
    table,
)
from vibecalc.core.results.record import Estimate, Quantity, Result
from vibecalc.core.results.tolerance import CHECKS, UNRESOLVED, ToleranceSummary, summarised
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# The first page: limits with margins, the conclusion, reference numbers beside ours.
# ----------------------------------------------------------------------------

_LIMITS = (
    Column("limit on", 37),
    number("bound", 16),
    number("computed", 11),
    number("margin", 11),
    Column("unit", 7),
    Column("verdict", 11),
)
_REFERENCES = (
    Column("reference number (source)", 44),
    number("reference", 10),
    number("computed", 11),
    Column("unit", 7),
    number("difference", 11),
    Column("verdict", 10),
)
#: Longer values, such as a root written out, are shown with as many digits as ours, or as fit.
LONGEST_PRINTED = 10
#: A computed number is shown with its digits beside a published one of no more than so many times
#: its size, even where both are within the error estimate of the quantity as a whole.
_COMPARABLE = 1e3
#: what a case says in the place of a test that shows a difference
_NOT_SHOWN = "not reproducible"


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
                margin(row),
                row.unit,
                limit_verdict(row),
            ]
        )
    return table(_LIMITS, cells) if cells else []


def margin(row: LimitRow) -> str:
    """What is left to the bound, with its error where that leaves the verdict open."""
    open_ = row.state == UNDECIDED
    return show(row.margin, row.error_estimate if open_ else float(row.error_estimate))


def limit_verdict(row: LimitRow) -> str:
    """`kept`, `BROKEN` or `UNDECIDED`, or whether an expected break came."""
    if row.expect == KEPT:
        return row.state if row.satisfied else row.state.upper()
    if row.satisfied:
        return "broken, as expected"
    return f"{row.state.upper()}, not broken as expected"


def references(rows: Sequence[ReferenceRow], most: int | None = None) -> list[str]:
    """The table of references with notes below, numbered where a source is known to differ.

    With `most`, only so many of those that come out are shown, and of those that are known to
    differ the first for each reason; the others are counted.
    """
    shown = list(rows) if most is None else brief(rows, most)
    cells: list[list[str]] = []
    notes = known_notes(shown)
    for row in shown:
        verdict = row.verdict.upper() if row.verdict in (OUTSIDE, UNRESOLVED) else row.verdict
        if row.verdict == KNOWN:
            verdict = f"known [{notes.index(_note(row)) + 1}]"
        cells.append(
            [
                _name(_REFERENCES, row.quantity, row.at, _picks(row.where), f"({row.source})"),
                row.printed if len(row.printed) <= LONGEST_PRINTED else _fit(row.value),
                computed(row),
                row.unit,
                difference(row),
                verdict,
            ]
        )
    if not cells:
        return []
    lines = table(_REFERENCES, cells)
    hidden = not_shown(rows, shown)
    if hidden:
        lines += paragraph(hidden)
    for i, note in enumerate(notes):
        lines += paragraph(note, f"[{i + 1}]")
    return lines


def brief(rows: Sequence[ReferenceRow], most: int) -> list[ReferenceRow]:
    """The rows worth a line: every miss, the first `most` of those that simply come out and of
    those that are measured, and of those that are known to differ the first for each reason."""
    shown: list[ReferenceRow] = []
    seen: dict[str, int] = {}
    for row in rows:
        kind = _note(row) if row.verdict == KNOWN else row.verdict
        seen[kind] = seen.get(kind, 0) + 1
        allowed = {KNOWN: 1, WITHIN: most, MEASURED: most}.get(row.verdict, len(rows))
        if seen[kind] <= allowed:
            shown.append(row)
    return shown


def not_shown(rows: Sequence[ReferenceRow], shown: Sequence[ReferenceRow]) -> str:
    """What `brief` left out, in words; nothing if it left out nothing."""
    words = []
    for verdict, what in _LEFT_OUT.items():
        count = sum(row.verdict == verdict for row in rows)
        count -= sum(row.verdict == verdict for row in shown)
        if count:
            words.append(f"{_many(count, 'more reference number')} {what}")
    return f"and {', and '.join(words)}; `vibecalc report --full` shows all" if words else ""


_LEFT_OUT = {
    WITHIN: "that come out",
    KNOWN: "known to differ, for these reasons",
    MEASURED: "that are measured",
}


def missed(rows: Sequence[ReferenceRow]) -> list[ReferenceRow]:
    """Reference numbers that ours is not within tolerance of, or too uncertain to be held to."""
    return [row for row in rows if row.verdict in (OUTSIDE, UNRESOLVED)]


def difference(row: ReferenceRow) -> str:
    """Relative; in dB for levels, which are logarithms already, and in degrees for phases."""
    if row.unit != "dB" and not row.cyclic:
        return show_percent(row.relative_difference)
    if not math.isfinite(row.difference):
        return "-"
    if row.unit == "dB":
        return f"{row.difference:+.2f} dB"
    degrees = convert(row.difference, row.unit, "deg")
    return f"{degrees:+.1f} deg" if abs(degrees) >= 0.1 else f"{degrees:+.1g} deg"


def computed(row: ReferenceRow) -> str:
    """Our number beside a published one; 0 where it is nothing but round-off."""
    if row.unit == "dB" and row.computed == -math.inf:
        return "zero"
    error = row.error_estimate
    if not row.resolved:
        return show(row.computed, Estimate(error, 0.0))
    if row.value:
        error = min(error, abs(row.value) / _COMPARABLE)
    return _fit(row.computed, error, _REFERENCES[2].width)


def known_notes(rows: Sequence[ReferenceRow]) -> list[str]:
    """Why sources are known to differ, each reason once, in the order of the rows."""
    return list(dict.fromkeys(_note(row) for row in rows if row.verdict == KNOWN))


def conclusion(references: Sequence[ReferenceRow], limits: Sequence[LimitRow]) -> str:
    """One sentence: what holds, what does not, and by how much."""
    clauses = []
    missed = [row for row in limits if not row.satisfied]
    if limits:
        kept = sum(row.state == KEPT for row in limits)
        verb = "is" if 1 in (kept, len(limits)) else "are"
        clause = f"{kept} of {_many(len(limits), 'limit')} {verb} kept"
        broken = [row for row in limits if row.state == BROKEN]
        if broken:
            first = min(broken, key=lambda row: row.margin)
            where = f" at {first.label}" if first.label else ""
            clause += (
                f"; {first.quantity}{where} breaks its bound by "
                f"{show(-first.margin)} {first.unit}".rstrip()
            )
            if not missed:
                clause += ", as the case expects"
        for row in (row for row in limits if row.state == UNDECIDED):
            where = f" at {row.label}" if row.label else ""
            clause += f"; {row.quantity}{where} is undecided: {row.decided_by} would decide it"
        clauses.append(clause)
    counted = [row for row in references if row.within is not None]
    if counted:
        good = sum(bool(row.within) for row in counted)
        clauses.append(f"{good} of {_many(len(counted), 'counted reference number')} come out")
    known = sum(row.verdict == KNOWN for row in references)
    measured = sum(row.verdict == MEASURED for row in references)
    if known:
        clauses.append(f"{known} known to differ, with the reason, {_is(known)} shown only")
    if measured:
        clauses.append(f"{measured} measured {_is(measured)} shown only")
    return "; ".join(clauses) + "." if clauses else "The case names no limit and no reference."


def _fit(value: float, error: float = 0.0, width: int = LONGEST_PRINTED) -> str:
    """A number with fewer digits where it would not fit: folded in two it reads as another one."""
    texts = [show(value, error, digits) for digits in range(DIGITS, 2, -1)]
    return next((text for text in texts if len(text) <= width), texts[-1])


def _note(row: ReferenceRow) -> str:
    shown = row.shown_by
    if shown and not shown.startswith(_NOT_SHOWN):
        shown = f"shown by {shown}"
    note = row.known_difference + (f" ({shown})" if shown else "")
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


# ----------------------------------------------------------------------------
# The tolerance of a run: how much of it was reached, and what each stage took for that.
# ----------------------------------------------------------------------------

_STAGES = (Column("stage", 28), number("s", 10), number("share %", 8), Column("work", 48))


def tolerance(result: Result) -> Section | None:
    """Results that reach `[accuracy] rtol`, the worst of them, and those that are exempt."""
    found = _summary(result)
    if found is None:
        return None
    rows = [("asked for", f"rtol = {found.rtol:g} of the largest magnitude of each result")]
    rows.append(("reached by", f"{found.met} of {found.held} results"))
    if found.worst:
        rows.append(("the worst", f"{found.worst}, {_share(found.share)}"))
    rows += [("not held to it", f"{count}: {words}") for words, count in found.exempt]
    return Section("Tolerance", pairs(rows, 16), frozenset())


def tolerance_line(result: Result) -> str:
    """The same in one line without the path, empty where a result says nothing of a tolerance."""
    found = _summary(result)
    if found is None:
        return ""
    worst = f", the worst {_share(found.share, 'has ', 'is ')}" if found.worst else ""
    return f"rtol = {found.rtol:g} reached by {found.met} of {found.held} results{worst}"


def _share(share: float, has: str = "", is_: str = "") -> str:
    return f"{is_}{UNRESOLVED}" if share >= 1.0 else f"{has}{show_error(share)}"


def stage_times(result: Result) -> list[str]:
    """A table of seconds by stage, with the work that the plan says it takes."""
    total = sum(result.timings.values())
    if not total:
        return []
    planned = {row.get("stage", ""): row.get("cost", "") for row in result.plan}
    rows = [
        [stage, f"{seconds:.4f}", f"{100.0 * seconds / total:.1f}", planned.get(stage, "")]
        for stage, seconds in result.timings.items()
    ]
    if len(rows) > 1:
        rows.append(["together", f"{total:.4f}", "100.0", ""])
    return [*table(_STAGES, rows), ""]


def _summary(result: Result) -> ToleranceSummary | None:
    rtol = table_of(result.case, "accuracy").get("rtol")
    found = None if rtol is None else summarised(result.record, float(rtol))
    return None if found is None or not found.held + len(found.exempt) else found


# ----------------------------------------------------------------------------
# The end of the report: warnings, methods, accuracy, and what changes from run to run.
# ----------------------------------------------------------------------------

_WORST = 8


def warnings(result: Result) -> Section | None:
    """Warnings of the run, equal ones once with their count."""
    counts: dict[str, int] = {}
    for text in result.record.warnings:
        counts[text] = counts.get(text, 0) + 1
    lines: list[str] = []
    for text, count in counts.items():
        lines += paragraph(text + (f" ({count} times)" if count > 1 else ""), "-")
    return Section("Warnings", lines, frozenset()) if lines else None


def plan_section(result: Result) -> Section | None:
    """Which stages ran and why, as planned before anything was computed."""
    lines: list[str] = []
    for row in result.plan:
        lines += pairs([(row.get("stage", "stage"), _planned(row))], 16)
    return Section("Plan", lines, frozenset()) if lines else None


def methods_section(result: Result) -> Section | None:
    """Methods that took part, with where they are published."""
    lines: list[str] = []
    for i, method in enumerate(result.record.methods):
        lines += paragraph(f"{method.name}: {method.purpose}. {method.citation}", f"[{i + 1}]")
    return Section("Methods", lines, frozenset()) if lines else None


def accuracy(result: Result, full: bool = False) -> Section | None:
    """Largest magnitude, error estimate and their ratio, the worst first unless `full`."""
    quantities = [
        quantity
        for path, quantity in result.record.items()
        if np.size(quantity.values) and (full or not path.startswith(START))
    ]
    if not quantities:
        return None
    chosen = quantities
    if not full:
        # Equal ratios keep the order of the record, so that the table is stable.
        chosen = sorted(quantities, key=lambda quantity: -_ratio(quantity))[:_WORST]
    columns = (
        Column("quantity", 48),
        number("largest", 13),
        Column("unit", 10),
        number("error", 11),
        number("relative", 11),
    )
    rows = [
        [
            quantity.path,
            show(_largest(quantity), quantity.error_estimate),
            quantity.unit,
            show_error(quantity.error_estimate),
            _shown_ratio(quantity),
        ]
        for quantity in chosen
    ]
    lines = table(columns, rows)
    rest = len(quantities) - len(chosen)
    if rest:
        lines += paragraph(f"and {rest} more that are known better; all are in the result file")
    dial = _dial(result.case)
    title = "Accuracy: error estimates" + (f" (asked for: rtol = {dial})" if dial else "")
    return Section(title, lines, frozenset())


def provenance(result: Result) -> Section:
    """Time per stage, versions, and how to run the case again. Nothing stable stands below."""
    rows = [(str(key), str(value)) for key, value in result.provenance.items() if key != "command"]
    wide = max(24, *(len(name) for name, _ in rows)) if rows else 24
    lines = [*stage_times(result), *pairs([*rows, ("rerun", rerun(result))], wide)]
    return Section("Provenance (changes from run to run)", lines, frozenset())


def rerun(result: Result) -> str:
    """The command that makes this result again."""
    return str(result.provenance.get("command") or f"vibecalc run {result.name}.toml")


def _planned(row: Mapping[str, str]) -> str:
    parts = [row["why"]] if row.get("why") else []
    parts += [f"{key}: {row[key]}" for key in ("parts", "orders", "cost") if row.get(key)]
    return "; ".join(parts)


def _dial(case: Mapping[str, Any]) -> str:
    table_ = case.get("accuracy")
    rtol = table_.get("rtol") if isinstance(table_, Mapping) else None
    return "" if rtol is None else f"{rtol:g}"


def _largest(quantity: Quantity) -> float:
    values = magnitudes(quantity)
    if values.dtype.kind not in "biuf":
        return 0.0
    return float(np.max(np.abs(values)))


def _ratio(quantity: Quantity) -> float:
    largest = _largest(quantity)
    if quantity.error_estimate == 0.0 or np.isinf(largest):
        return 0.0
    # Where all cancels the estimate is all there is; that is no loss of accuracy.
    if quantity.estimate.is_zero(largest) or quantity.path.endswith(CHECKS):
        return 0.0
    return float(quantity.error_estimate) / largest if largest else float("inf")


def _shown_ratio(quantity: Quantity) -> str:
    largest = _largest(quantity)
    if np.isinf(largest):
        return "unbounded"
    if quantity.error_estimate and largest <= quantity.error_estimate:
        if quantity.path.endswith(CHECKS):
            return "a check"
        return "zero" if quantity.estimate.is_zero(largest) else UNRESOLVED
    return show_error(_ratio(quantity))
