"""The pages around the stages: verdicts first; warnings, methods, accuracy at the end."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from vibecalc.core.report.defects import failed_parts, survived
from vibecalc.core.report.sections import (
    Section,
    largest_of,
    magnitudes,
    read_as,
    section,
    table_of,
)
from vibecalc.core.report.verdicts import (
    KNOWN,
    MEASURED,
    OUTSIDE,
    WITHIN,
    ReferenceRow,
    as_read,
    bounds_of,
    label_of,
    place_of,
)
from vibecalc.core.report.writing import (
    many,
    number,
    pairs,
    paragraph,
    read,
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
    Quantity,
    Result,
    Verdict,
)
from vibecalc.core.results.tolerance import UNRESOLVED, ToleranceSummary, is_check, summarised
from vibecalc.units import convert

# ----------------------------------------------------------------------------
# The first page: limits with margins, the conclusion, reference numbers next to ours.
# ----------------------------------------------------------------------------

_LIMITS = ("limit on", number("bound"), number("computed"), number("margin"), "unit", "verdict")
_REFERENCES = ("reference number (source)", number("reference"), number("computed"), "unit",
               number("difference"), "verdict")  # fmt: skip
#: Longer values, such as a root written out, are shown with as many digits as ours.
LONGEST_PRINTED = 10
#: A computed number is shown with its digits next to a published one of no more than so many times
#: its size, even where both are within the error estimate of the quantity as a whole.
_COMPARABLE = 1e3
#: a page of the documents as methods name it, and how a report names it
_PAGE, _NAMED = re.compile(r"docs/(\w+)\.md"), r"vibecalc documents, \1"
#: digits of ours next to a published number
_DIGITS = 6
#: sources that match, and reasons why others differ, that a brief report names
_MOST_SOURCES, _MOST_REASONS = 6, 2
#: broken limits that the conclusion names
_MOST_BROKEN = 4
#: what a case says in the place of a test that shows a difference
_NOT_SHOWN = "not reproducible"


def limits(rows: Sequence[Verdict]) -> list[str]:
    """The table of limits: those of the case in its order, then those of rules and makers."""
    cells = []
    for row in map(as_read, rows):
        picks = _picks(row.where)
        entry = f"worst {label_of(row)}" if row.label not in ("", picks) else picks
        name = _name(row, row.borne or entry, f"({row.source})" if row.source else "")
        shown, bounds = show(row.computed, row.error_estimate), "\n".join(bounds_of(row))
        cells.append([name, bounds, shown, margin(row), row.unit, limit_verdict(row)])
    return table(_LIMITS, cells)


def margin(row: Verdict) -> str:
    """What is left to the bound, with its error where that leaves the verdict open."""
    open_ = row.state == UNDECIDED
    return show(row.margin, row.error_estimate if open_ else float(row.error_estimate))


def limit_verdict(row: Verdict) -> str:
    """`kept`, `barred`, `BROKEN` or `UNDECIDED`, or whether an expected break came."""
    if row.expect == KEPT:
        return row.state if row.satisfied else row.state.upper()
    if row.satisfied:
        return "broken, as expected"
    return f"{row.state.upper()}, not broken as expected"


def references(rows: Sequence[ReferenceRow]) -> list[str]:
    """The table of references with notes below, numbered where a source is known to differ."""
    cells, notes = list[list[str]](), dict[str, str]()
    for row in rows:
        verdict = row.verdict.upper() if row.verdict in (OUTSIDE, UNRESOLVED) else row.verdict
        if row.verdict == KNOWN:
            verdict = f"known {notes.setdefault(_note(row, shown=True), f'[{len(notes) + 1}]')}"
        name = _name(row, _picks(row.where), f"({row.source})")
        cells.append([name, _printed(row), computed(row), row.unit, difference(row), verdict])
    below = [line for note, mark in notes.items() for line in paragraph(note, mark)]
    return table(_REFERENCES, cells) + below


def brief(rows: Sequence[ReferenceRow]) -> list[str]:
    """Which sources match, and what differs: once for each reason, measured numbers one by one.

    A row that is missed stands under the verdicts.
    """
    sources = Counter(_source(row) for row in rows if row.verdict == WITHIN)
    named = ", ".join(f"{source} ({count})" for source, count in sources.most_common(_MOST_SOURCES))
    further = len(sources) - _MOST_SOURCES
    named += f" and {many(further, 'more source')}" * (further > 0)
    lines = paragraph(f"match: {named}") if named else []
    known: dict[str, list[ReferenceRow]] = {}
    for row in (row for row in rows if row.verdict == KNOWN):
        known.setdefault(_note(row), []).append(row)
    measured = [row for row in rows if row.verdict == MEASURED]
    said = [f"{_compared(row, 'printed')}: {reason}"
            + f" (the same for {many(len(others), 'more number')})" * bool(others)
            for reason, (row, *others) in [*known.items()][:_MOST_REASONS]]  # fmt: skip
    said += [_compared(row, MEASURED) for row in measured[:_MOST_REASONS]]
    left = ((len(known), "more reason"), (len(measured), "more measured number"))
    hidden = [many(n - _MOST_REASONS, noun) for n, noun in left if n > _MOST_REASONS]
    words = f"and {' and '.join(hidden)}; `vibecalc report --full` shows all"
    below = [line for one in said for line in paragraph(one, "-")]
    return [*lines, *below, *(paragraph(words) if hidden else [])]


def _compared(row: ReferenceRow, kind: str) -> str:
    name = read_as(row.quantity, row.unit, entry=bool(row.where))[0]
    where = ", ".join(f"{axis.replace('_', ' ')} {entry}" for axis, entry in row.where.items())
    name += (f", {where}" if where else "") + (" (start)" if row.at == "start" else "")
    ours = f" {kind} ({row.source}), {computed(row, digits=4)} {row.unit}".rstrip()
    return f"{name}: {_printed(row)} {row.unit}".rstrip() + f"{ours} computed, {difference(row)}"


def _printed(row: ReferenceRow) -> str:
    fits = len(row.printed) <= LONGEST_PRINTED
    return row.printed if fits else show(row.value, digits=_DIGITS)


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
    if not row.resolved:
        return show(row.computed, Estimate(row.error_estimate, 0.0))
    error = min(row.error_estimate, abs(row.value) / _COMPARABLE or math.inf)
    return show(row.computed, error, digits)


def conclusion(references: Sequence[ReferenceRow], limits: Sequence[Verdict]) -> str:
    """One sentence: what holds, what does not, and by how much."""
    clauses = list[str]()
    if limits:
        kept, barred = (sum(row.state == one for row in limits) for one in (KEPT, BARRED))
        clauses.append(f"{kept} of {many(len(limits), 'limit')} "
                       + f"{_is(1 if len(limits) == 1 else kept)} kept")  # fmt: skip
        clauses += [f"{barred} {_is(barred)} exceeded in barred speed ranges only"] * bool(barred)
        broken = [row for row in limits if row.state == BROKEN and not row.satisfied]
        clauses += [_spoken(row) + _broken(row) for row in broken[:_MOST_BROKEN]]
        left = len(broken) - _MOST_BROKEN
        clauses += [f"{left} more {_is(left)} broken"] if left > 0 else []
        expected = sum(row.state == BROKEN and row.satisfied for row in limits)
        clauses += [f"{expected} {_is(expected)} broken, as expected"] if expected else []
        clauses += [f"{_spoken(row)} is undecided: {row.decided_by} would decide it"
                    for row in limits if row.state == UNDECIDED]  # fmt: skip
    counted = [row for row in references if row.within is not None]
    if counted:
        good = sum(bool(row.within) for row in counted)
        verb = "matches" if good == 1 else "match"
        clauses.append(f"{good} of {many(len(counted), 'counted reference number')} {verb}")
    known = sum(row.verdict == KNOWN for row in references)
    measured = sum(row.verdict == MEASURED for row in references)
    if known and counted:
        clauses.append(f"{known} {'differs' if known == 1 else 'differ'} for a known reason")
    elif known:
        clauses.append(
            f"none of {many(known, 'published number')} is reproduced, for known reasons"
        )
    if measured:
        clauses.append(f"{many(measured, 'measured number')} for comparison")
    return "; ".join(clauses) + "." if clauses else ""


def _is(count: int) -> str:
    return "is" if count == 1 else "are"


def _note(row: ReferenceRow, *, shown: bool = False) -> str:
    """Why the source is known to differ, with what shows it if asked for."""
    note = row.known_difference
    if shown and row.shown_by:
        by = "" if row.shown_by.startswith(_NOT_SHOWN) else "shown by "
        note += f" ({by}{row.shown_by})"
    if row.agrees:
        note += " - but it agrees within its tolerance: remove the note or the row"
    return note


def _broken(row: Verdict) -> str:
    """What a broken limit is used by, or by how much it is missed."""
    if row.element and row.max and math.isfinite(row.utilisation):
        use = f"{show(100.0 * row.utilisation, digits=4)} %"
        if not row.unit:
            return f": {use} of what is allowed"
        borne, allowed = (show(one, digits=4) for one in (row.computed, row.max))
        return f": {borne} {row.unit}, allowed {allowed}, {use}"
    side = "max" if row.max is not None and row.computed > row.max else "min"
    limit = getattr(row, side)
    if limit is None or not math.isfinite(row.computed):
        return " violates its limit"
    unit = read_as(row.quantity, row.unit)[1]
    factor = convert(1.0, row.unit, unit)
    computed, limit = (show(factor * one, digits=4) for one in (row.computed, limit))
    return f": {computed} {read(unit)}".rstrip() + f", {side} {limit}"


def _spoken(row: Verdict) -> str:
    """The quantity of a limit in words, and where it counts."""
    if row.element:
        at = f", at {show(rpm(row.speed), digits=4)} rpm" if math.isfinite(row.speed) else ""
        return row.borne + at
    where = f" at {place_of(row)}" if place_of(row) else ""
    return read_as(row.quantity, row.unit)[0] + where


def _picks(where: Mapping[str, object]) -> str:
    return ", ".join(f"{axis}={entry}" for axis, entry in where.items())


def _name(row: Verdict | ReferenceRow, *remarks: str) -> str:
    """The path, and below it, a little to the right, what else belongs to the row."""
    below = " ".join(filter(None, remarks))
    return row.quantity + (" (start)" if row.at == "start" else "") + f"\n  {below}" * bool(below)


# ----------------------------------------------------------------------------
# The tolerance of a run: how much of it was reached, and what each stage took for that.
# ----------------------------------------------------------------------------


def tolerance(result: Result) -> Section | None:
    """Results that reach `[accuracy] rtol`, the worst of them, and those that are exempt."""
    found = _summary(result)
    if found is None:
        return None
    words = f"rtol = {found.rtol:g} met by {found.met} of {found.held} results"
    if found.worst:
        share = UNRESOLVED if found.share >= 1.0 else show_error(found.share)
        words += f"; largest relative error {share}: {found.worst}"
    rows = [("tolerance", words)]
    rows += [("exempt", f"{count}: {words}") for words, count in found.exempt]
    return section("Tolerance", [pairs(rows)])


def _summary(result: Result) -> ToleranceSummary | None:
    rtol = table_of(result.case, "accuracy").get("rtol")
    found = None if rtol is None else summarised(result.record, float(rtol))
    return found if found is not None and (found.held or found.exempt) else None


# ----------------------------------------------------------------------------
# The end of the report: warnings, methods, accuracy, and what changes from run to run.
# ----------------------------------------------------------------------------

_CHANGING = "Provenance (changes from run to run)"


def closings(result: Result) -> Iterator[Section]:
    """The last sections of a full report, and what could not be made of it."""
    for make in (tolerance, accuracy, methods_section, plan_section, provenance):
        made = survived(make.__name__, partial(make, result))
        yield from [made] if made else []
    yield from failures()


def failures() -> list[Section]:
    """What could not be made of a report."""
    failed = [line for one in failed_parts() for line in paragraph(one, "-")]
    made = section("Parts left out because of a bug in vibecalc", [failed])
    return [made] if made else []


def warnings(result: Result) -> Section | None:
    """Warnings of the run, equal ones once with their count."""
    lines: list[str] = []
    for text, count in Counter(result.record.warnings).items():
        lines += paragraph(text + (f" ({count} times)" if count > 1 else ""), "-")
    return section("Warnings", [lines])


def plan_section(result: Result) -> Section | None:
    """Which stages ran and why, as planned before anything was computed."""
    rows = []
    for row in result.plan:
        told = (f"{key}: {row[key]}" for key in ("parts", "orders", "cost") if row.get(key))
        rows.append((row.get("stage", "stage"), "; ".join(filter(None, (row.get("why"), *told)))))
    return section("Plan", [pairs(rows)])


def methods_section(result: Result) -> Section | None:
    """Methods that took part, with where they are published."""
    said = [
        f"{one.name}: {one.purpose}. {_PAGE.sub(_NAMED, one.citation)}"
        for one in result.record.methods
    ]
    lines = [line for i, words in enumerate(said, 1) for line in paragraph(words, f"[{i}]")]
    return section("Methods", [lines])


def accuracy(result: Result) -> Section | None:
    """Largest magnitude of each quantity, its error estimate and their ratio."""
    rows = []
    for one in (one for one in result.record.values() if one.values.size):
        values, error = magnitudes(one), one.error_estimate
        top = largest_of(values) if values.dtype.kind in "biuf" else 0.0
        cells = show(top, error), one.unit, show_error(error), _shown_ratio(one, abs(top))
        rows.append([one.path, *cells])
    rtol = table_of(result.case, "accuracy").get("rtol")
    title = "Accuracy: error estimates" + ("" if rtol is None else f" (requested: rtol = {rtol:g})")
    heads = ("quantity", number("largest"), "unit", number("error"), number("relative"))
    return section(title, [table(heads, rows)])


def _shown_ratio(quantity: Quantity, largest: float) -> str:
    error, zero = quantity.error_estimate, quantity.estimate.is_zero(largest)
    if math.isinf(largest):
        return "unbounded"
    if error and largest <= error:
        return "a check" if is_check(quantity.path) else "zero" if zero else UNRESOLVED
    # Where all cancels the estimate is all there is; that is no loss of accuracy.
    return show_error(float(error) / largest if error and not is_check(quantity.path) else 0.0)


def provenance(result: Result) -> Section | None:
    """Time per stage, versions, and how to run the case again. Nothing stable stands below."""
    total = sum(result.timings.values())
    planned = {row.get("stage", ""): row.get("cost", "") for row in result.plan}
    times = [*result.timings.items(), *[("together", total)] * (len(result.timings) > 1)]
    rows = [[stage, f"{seconds:.4f}", f"{100.0 * seconds / total:.1f}", planned.get(stage, "")]
            for stage, seconds in times if total]  # fmt: skip
    known = [(str(key), str(value)) for key, value in result.provenance.items() if key != "command"]
    heads = "stage", number("s"), number("share %"), "work"
    return section(_CHANGING, [table(heads, rows), pairs([*known, ("rerun", rerun(result))])])


def rerun(result: Result) -> str:
    """The command that makes this result again."""
    return str(result.provenance.get("command") or f"vibecalc run {result.name}.toml")
