"""The pages around the stages: verdicts first; warnings, methods, accuracy at the end."""

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibecalc.core.report.sections import Section, magnitudes, read_as, table_of
from vibecalc.core.report.verdicts import (
    KNOWN,
    MEASURED,
    OUTSIDE,
    WITHIN,
    ReferenceRow,
    place_of,
)
from vibecalc.core.report.writing import (
    Column,
    fold,
    number,
    pairs,
    paragraph,
    rpm,
    show,
    show_error,
    show_percent,
    table,
)
from vibecalc.core.results.record import (
    BARRED,
    BROKEN,
    KEPT,
    UNDECIDED,
    Estimate,
    Method,
    Quantity,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import UNRESOLVED, ToleranceSummary, is_check, summarised
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# The first page: limits with margins, the conclusion, reference numbers next to ours.
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
#: A computed number is shown with its digits next to a published one of no more than so many times
#: its size, even where both are within the error estimate of the quantity as a whole.
_COMPARABLE = 1e3
#: digits of ours next to a published number
_DIGITS = 6
#: sources that match, and reasons why others differ, that a brief report names
_MOST_SOURCES, _MOST_REASONS = 6, 4
#: broken limits that the conclusion names
_MOST_BROKEN = 4
#: what a case says in the place of a test that shows a difference
_NOT_SHOWN = "not reproducible"


def limits(rows: Sequence[Verdict]) -> list[str]:
    """The table of limits: those of the case in its order, then those of rules and makers."""
    cells = []
    for row in rows:
        bounds = []
        if row.min is not None:
            bounds.append(f"min {row.min:.6g}")
        if row.max is not None:
            bounds.append(f"max {row.max:.6g}")
        picks = _picks(row.where)
        entry = f"worst {row.label}" if row.label not in ("", picks) else picks
        if row.element:
            entry = ", ".join(filter(None, (row.element, row.limit, row.condition)))
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


def margin(row: Verdict) -> str:
    """What is left to the bound, with its error where that leaves the verdict open."""
    open_ = row.state == UNDECIDED
    return show(row.margin, row.error_estimate if open_ else float(row.error_estimate))


def limit_verdict(row: Verdict) -> str:
    """`kept`, `BROKEN` or `UNDECIDED`, or whether an expected break came."""
    if row.expect == KEPT:
        state = "kept but where barred" if row.state == BARRED else row.state
        return state if row.satisfied else state.upper()
    if row.satisfied:
        return "broken, as expected"
    return f"{row.state.upper()}, not broken as expected"


def references(rows: Sequence[ReferenceRow]) -> list[str]:
    """The table of references with notes below, numbered where a source is known to differ."""
    cells: list[list[str]] = []
    notes = list(dict.fromkeys(_note(row, shown=True) for row in rows if row.verdict == KNOWN))
    for row in rows:
        verdict = row.verdict.upper() if row.verdict in (OUTSIDE, UNRESOLVED) else row.verdict
        if row.verdict == KNOWN:
            verdict = f"known [{notes.index(_note(row, shown=True)) + 1}]"
        cells.append(
            [
                _name(_REFERENCES, row.quantity, row.at, _picks(row.where), f"({row.source})"),
                _printed(row),
                computed(row),
                row.unit,
                difference(row),
                verdict,
            ]
        )
    lines = table(_REFERENCES, cells) if cells else []
    for i, note in enumerate(notes):
        lines += paragraph(note, f"[{i + 1}]")
    return lines


def brief(rows: Sequence[ReferenceRow]) -> list[str]:
    """Which sources match, and what differs: once for each reason, measured numbers one by one.

    A row that is missed stands under the verdicts.
    """
    sources = Counter(_source(row) for row in rows if row.verdict == WITHIN)
    named = ", ".join(f"{source} ({count})" for source, count in sources.most_common(_MOST_SOURCES))
    further = len(sources) - _MOST_SOURCES
    named += f" and {_many(further, 'more source')}" if further > 0 else ""
    lines = paragraph(f"match: {named}") if named else []
    known = [row for row in rows if row.verdict == KNOWN]
    reasons = Counter(_note(row) for row in known)
    firsts = [next(row for row in known if _note(row) == reason) for reason in reasons]
    for row in firsts[:_MOST_REASONS]:
        count = reasons[_note(row)] - 1
        more = f" (the same for {_many(count, 'more number')})" if count else ""
        lines += paragraph(f"{_compared(row, 'printed')}: {_note(row)}{more}", "-")
    measured = [row for row in rows if row.verdict == MEASURED]
    for row in measured[:_MOST_REASONS]:
        lines += paragraph(_compared(row, MEASURED), "-")
    left = (
        (len(firsts) - _MOST_REASONS, "more reason"),
        (len(measured) - _MOST_REASONS, "more measured number"),
    )
    hidden = " and ".join(_many(count, noun) for count, noun in left if count > 0)
    return lines + (
        paragraph(f"and {hidden}; `vibecalc report --full` shows all") if hidden else []
    )


def _compared(row: ReferenceRow, kind: str) -> str:
    name = read_as(row.quantity, row.unit, entry=bool(row.where))[0]
    where = ", ".join(f"{axis.replace('_', ' ')} {entry}" for axis, entry in row.where.items())
    name += (f", {where}" if where else "") + (" (start)" if row.at == "start" else "")
    return (
        f"{name}: {_printed(row)} {row.unit}".rstrip()
        + f" {kind} ({row.source}), {computed(row, digits=4)} {row.unit}".rstrip()
        + f" computed, {difference(row)}"
    )


def _printed(row: ReferenceRow) -> str:
    return row.printed if len(row.printed) <= LONGEST_PRINTED else _fit(row.value)


def _source(row: ReferenceRow) -> str:
    """A source without what stands behind its first comma, colon or bracket."""
    return re.split(r"[,:(]", row.source)[0].strip() or "no source named"


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


def computed(row: ReferenceRow, digits: int = _DIGITS) -> str:
    """Our number next to a published one; 0 where it is nothing but round-off."""
    if row.unit == "dB" and row.computed == -math.inf:
        return "zero"
    error = row.error_estimate
    if not row.resolved:
        return show(row.computed, Estimate(error, 0.0))
    if row.value:
        error = min(error, abs(row.value) / _COMPARABLE)
    return _fit(row.computed, error, _REFERENCES[2].width, digits)


def conclusion(references: Sequence[ReferenceRow], limits: Sequence[Verdict]) -> str:
    """One sentence: what holds, what does not, and by how much."""
    clauses = []
    if limits:
        kept = sum(bool(row.kept) for row in limits)
        verb = "is" if 1 in (kept, len(limits)) else "are"
        clause = f"{kept} of {_many(len(limits), 'limit')} {verb} kept"
        barred = sum(row.state == BARRED for row in limits)
        clause += f", {barred} of them by barring a speed range" if barred else ""
        broken = sorted((row for row in limits if row.state == BROKEN), key=lambda r: r.satisfied)
        for row in broken[:_MOST_BROKEN]:
            clause += f"; {_spoken(row)} breaks its bound"
            percent = row.element and not row.unit and row.max == 1.0
            by = (show(-100.0 * row.margin), "%") if percent else (show(-row.margin), row.unit)
            clause += f" by {' '.join(by)}".rstrip() * (row.margin < 0.0)
            clause += ", as the case expects" if row.satisfied else ""
        left = len(broken) - _MOST_BROKEN
        if left > 0:
            clause += f"; {left} more {'is' if left == 1 else 'are'} broken"
            clause += ", as the case expects" if broken[-left].satisfied else ""
        for row in (row for row in limits if row.state == UNDECIDED):
            clause += f"; {_spoken(row)} is undecided: {row.decided_by} would decide it"
        clauses.append(clause)
    counted = [row for row in references if row.within is not None]
    if counted:
        good = sum(bool(row.within) for row in counted)
        verb = "matches" if good == 1 else "match"
        clauses.append(f"{good} of {_many(len(counted), 'counted reference number')} {verb}")
    known = sum(row.verdict == KNOWN for row in references)
    measured = sum(row.verdict == MEASURED for row in references)
    if known:
        what = str(known) if counted else _many(known, "reference number")
        clauses.append(f"{what} {'differs' if known == 1 else 'differ'} for a known reason")
    if measured:
        clauses.append(f"{measured} measured {'is' if measured == 1 else 'are'} for comparison")
    return "; ".join(clauses) + "." if clauses else ""


def _fit(
    value: float, error: float = 0.0, width: int = LONGEST_PRINTED, digits: int = _DIGITS
) -> str:
    """A number with fewer digits where it would not fit: folded in two it reads as another one."""
    texts = [show(value, error, digits) for digits in range(digits, 2, -1)]
    return next((text for text in texts if len(text) <= width), texts[-1])


def _note(row: ReferenceRow, *, shown: bool = False) -> str:
    """Why the source is known to differ, with what shows it if asked for."""
    note = row.known_difference
    if shown and row.shown_by:
        by = "" if row.shown_by.startswith(_NOT_SHOWN) else "shown by "
        note += f" ({by}{row.shown_by})"
    if row.agrees:
        note += " - yet it agrees within its tolerance: remove the note or the row"
    return note


def _spoken(row: Verdict) -> str:
    """The quantity of a limit in words, and where it counts."""
    if row.element:
        at = f"at {show(rpm(row.speed), digits=4)} rpm" if math.isfinite(row.speed) else ""
        return ", ".join(filter(None, (row.element, row.limit, row.condition, at)))
    where = f" at {place_of(row)}" if place_of(row) else ""
    return read_as(row.quantity, row.unit)[0] + where


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
    rows = [("tolerance", _tolerance_words(result, found))]
    rows += [("not held to it", f"{count}: {words}") for words, count in found.exempt]
    return Section("Tolerance", pairs(rows, 16), frozenset())


def _tolerance_words(result: Result, summary: ToleranceSummary) -> str:
    """The line of `tolerance_line`, and the path of the worst."""
    return tolerance_line(result) + (f": {summary.worst}" if summary.worst else "")


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

_CHANGING = "Provenance (changes from run to run)"


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


def accuracy(result: Result) -> Section | None:
    """Largest magnitude of each quantity, its error estimate and their ratio."""
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
        for quantity in result.record.values()
        if np.size(quantity.values)
    ]
    asked = _asked(result.case)
    title = "Accuracy: error estimates" + (f" (asked for: rtol = {asked})" if asked else "")
    return Section(title, table(columns, rows), frozenset()) if rows else None


def appendix(result: Result) -> Section:
    """Tolerance, error and methods in a few lines; no line changes from run to run."""
    rows = []
    found = _summary(result)
    if found is not None and found.held:
        exempt = sum(count for _, count in found.exempt)
        more = f"; {exempt} not held to it" if exempt else ""
        rows.append(("tolerance", _tolerance_words(result, found) + more))
    if result.record.methods:
        rows.append(("methods", "; ".join(dict.fromkeys(map(_short_name, result.record.methods)))))
    rows.append(("case", f"sha256 {result.case_sha256}"))
    return Section("Appendix", pairs(rows, 15), frozenset())


def _short_name(method: Method) -> str:
    """The name of a method without what is said behind a colon or in brackets."""
    return re.split(r"[:(]", method.name)[0].strip()


def run_of(result: Result) -> Section:
    """Seconds by stage, versions and command in three lines. Nothing stable stands below."""
    seconds = [f"{stage} {time:.3f}" for stage, time in result.timings.items()]
    seconds += [f"together {sum(result.timings.values()):.3f}"] if seconds else []
    known = result.provenance
    versions = [
        f"{words} {known[key]}".strip()
        for key, words in (("time", ""), ("vibecalc_version", "vibecalc"), ("python", "python"),
                           ("numpy", "numpy"), ("scipy", "scipy"))
        if known.get(key)
    ]  # fmt: skip
    rows = [("seconds", ", ".join(seconds)), ("run", ", ".join(versions))]
    rows = [(name, words) for name, words in rows if words] + [("command", rerun(result))]
    return Section(_CHANGING, pairs(rows, 15), frozenset())


def provenance(result: Result) -> Section:
    """Time per stage, versions, and how to run the case again. Nothing stable stands below."""
    known = result.provenance.items()
    rows = [(str(key), str(value)) for key, value in known if key != "command"]
    wide = max(24, *(len(name) for name, _ in rows)) if rows else 24
    lines = [*stage_times(result), *pairs([*rows, ("rerun", rerun(result))], wide)]
    return Section(_CHANGING, lines, frozenset())


def rerun(result: Result) -> str:
    """The command that makes this result again."""
    return str(result.provenance.get("command") or f"vibecalc run {result.name}.toml")


def _planned(row: Mapping[str, str]) -> str:
    parts = [row["why"]] if row.get("why") else []
    parts += [f"{key}: {row[key]}" for key in ("parts", "orders", "cost") if row.get(key)]
    return "; ".join(parts)


def _asked(case: Mapping[str, Any]) -> str:
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
    if quantity.estimate.is_zero(largest) or is_check(quantity.path):
        return 0.0
    return float(quantity.error_estimate) / largest if largest else float("inf")


def _shown_ratio(quantity: Quantity) -> str:
    largest = _largest(quantity)
    if np.isinf(largest):
        return "unbounded"
    if quantity.error_estimate and largest <= quantity.error_estimate:
        if is_check(quantity.path):
            return "a check"
        return "zero" if quantity.estimate.is_zero(largest) else UNRESOLVED
    return show_error(_ratio(quantity))
