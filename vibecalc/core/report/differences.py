"""A comparison of two results in words, as JSON and as JUnit XML."""

import json
import math
import re
from collections.abc import Sequence
from dataclasses import asdict
from xml.etree import ElementTree

from vibecalc.core.report.writing import many, number, table
from vibecalc.core.results.compare import ComparedRow, Comparison, FilePair
from vibecalc.errors import EXIT_DIFFERS, EXIT_FINE, ResultError

_COLUMNS = ("quantity", number("reference"), number("value"), number("difference"),
            number("allowed"), number("ratio"))  # fmt: skip

#: characters that XML 1.0 cannot hold, escaped or not
_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def render_differences(comparison: Comparison, count: int = 10) -> str:
    """The worst offenders as a table of fixed columns, what else differs, and a verdict.

    `count` rows at most are shown of those that differ; where all is the same, of those that
    are not equal to the last bit, the ones that came closest to their tolerance.
    """
    differing = [row for row in comparison.rows if not row.same]
    shown = [row for row in comparison.worst(len(comparison.rows)) if not row.same][:count]
    close = [row for row in comparison.worst(count) if row.ratio > 0]
    lines: list[str] = []
    # what differs by its axis only has equal values: its words stand below the table
    numbers = [row for row in shown or close if row.entries and (row.failed or not row.problems)]
    if numbers:
        title = "Differences, worst first" if differing else "Closest to their tolerance"
        lines += [title, "", *table(_COLUMNS, [_cells(row) for row in numbers]), ""]
    problems = [f"  {row.path}: {problem}" for row in shown for problem in row.problems]
    if len(differing) > len(shown):
        problems.append(f"  {len(differing) - len(shown)} more differ or are missing")
    lines += [*problems, ""] if problems else []
    if comparison.changes:
        changes = (
            f"  {one.what}: {one.reference} became {one.value}" for one in comparison.changes
        )
        lines += ["The cases differ (not counted):", *changes, ""]
    if comparison.ignored:
        further = len(comparison.ignored) - 3
        more = f" and {further} more" * (further > 0)
        lines += [f"Not compared: {', '.join(comparison.ignored[:3])}{more}", ""]
    compared = f"{many(len(comparison.rows), 'quantity', 'quantities')} compared"
    verdict = many(len(differing), "differs", "differ") if differing else "all the same"
    return "\n".join([*lines, f"{compared}, {verdict}."]) + "\n"


def render_files(pairs: Sequence[FilePair], by_name: bool) -> str:
    """What was compared, in words; `by_name` with names, and in one line where it is the same."""
    texts = []
    for pair in pairs:
        if pair.comparison is not None:
            text = render_differences(pair.comparison)
            brief = text if pair.exit_code else text.splitlines()[-1] + "\n"
            texts.append(f"{pair.name}: {brief}" if by_name else text)
    if len(pairs) > 1:
        differ = sum(pair.exit_code == EXIT_DIFFERS for pair in pairs)
        unusable = sum(pair.comparison is None for pair in pairs)
        words = f"{len(pairs) - differ - unusable} of {len(pairs)} files the same"
        words += f", {many(differ, 'differs', 'differ')}" * bool(differ)
        texts.append(f"{words}{f', {unusable} not compared' * bool(unusable)}.\n")
    return "".join(texts)


def differences_object(pairs: Sequence[FilePair], unused: Sequence[str]) -> dict[str, object]:
    """The comparisons for `--json`, of one file as of many: plain lists, numbers and texts.

    Complex numbers are [real, imaginary]; what is infinite or NaN is the text "inf", "-inf" or
    "nan", and a ratio without a bound is null. `unused` are the patterns of rules that fit nothing;
    `error` is that of the files which could not be compared, or null.
    """
    problems = [pair.problem for pair in pairs if pair.problem]
    return {
        "same": not any(pair.exit_code for pair in pairs),
        "error": ResultError("\n".join(problems)).as_object() if problems else None,
        "results": [_pair_object(pair) for pair in pairs],
        "unused_rules": list(unused),
    }


def _pair_object(pair: FilePair) -> dict[str, object]:
    comparison = pair.comparison or Comparison(rows=())
    return {
        "result": pair.name,
        "same": pair.exit_code == EXIT_FINE,
        "problem": pair.problem,
        "quantities": [_row_object(row) for row in comparison.rows],
        "ignored": list(comparison.ignored),
        "changes": [asdict(change) for change in comparison.changes],
    }


def render_junit(pairs: Sequence[FilePair]) -> str:
    """JUnit XML: a suite for each result by its name, a test case for each quantity.

    A result that could not be compared is a suite of one test case, `file`, which fails.
    """
    suites = ElementTree.Element("testsuites", {"name": "vibecalc diff", **_counts(pairs)})
    for pair in pairs:
        attributes = {"name": _xml(pair.name), **_counts([pair])}
        suite, comparison = ElementTree.SubElement(suites, "testsuite", attributes), pair.comparison
        if comparison is None:
            _test_case(suite, "file", "failure", pair.problem)
            continue
        for row in comparison.rows:
            if row.same:
                _test_case(suite, row.path)
                continue
            text = _sentence(row)
            failure = _test_case(suite, row.path, "failure", text)
            failure.text = _xml("\n".join([text, json.dumps(_row_object(row))]))
        for path in comparison.ignored:
            _test_case(suite, path, "skipped", "not compared")
    ElementTree.indent(suites)
    body = ElementTree.tostring(suites, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _counts(pairs: Sequence[FilePair]) -> dict[str, str]:
    comparisons = [pair.comparison for pair in pairs if pair.comparison is not None]
    unusable = len(pairs) - len(comparisons)
    ignored = sum(len(one.ignored) for one in comparisons)
    rows = [row for one in comparisons for row in one.rows]
    failures = sum(not row.same for row in rows) + unusable
    counts = {"tests": len(rows) + ignored + unusable, "failures": failures, "errors": 0}
    return {name: str(count) for name, count in (counts | {"skipped": ignored}).items()}


def _test_case(
    suite: ElementTree.Element, path: str, outcome: str = "", words: str = ""
) -> ElementTree.Element:
    """The outcome of a case, of one that passed the case."""
    folder, _, name = path.rpartition("/")
    place = _xml(folder.replace("/", ".")) or "vibecalc"
    case = ElementTree.SubElement(suite, "testcase", {"classname": place, "name": _xml(name)})
    return ElementTree.SubElement(case, outcome, {"message": _xml(words)}) if outcome else case


def _cells(row: ComparedRow) -> tuple[str, ...]:
    where = f"\n  {row.entry}" if row.entry else ""
    many = f"\n  {row.failed} of {row.entries} entries" if row.failed and row.entries > 1 else ""
    sizes = (_short(row.reference), _short(row.value), f"{row.difference:.2e}",
             f"{row.allowed:.2e}")  # fmt: skip
    return (f"{row.path}{where}{many}", *sizes, _ratio(row.ratio))


def _ratio(ratio: float) -> str:
    """Three digits, or two with an exponent: a number folded in two reads as another one."""
    return f"{ratio:.3g}" if 1e-3 <= ratio < 999.5 or ratio == 0.0 else f"{ratio:.1e}"


def _sentence(row: ComparedRow) -> str:
    parts = list(row.problems)
    if row.failed:
        where = f" at {row.entry}" if row.entry else ""
        values = f"reference {_short(row.reference)}, value {_short(row.value)} {row.unit}".rstrip()
        off = f"difference {row.difference:.3e}, allowed {row.allowed:.3e}"
        parts.append(f"{row.failed} of {row.entries} entries differ; worst{where}: {values}, {off}")
    return f"{row.path}: {'; '.join(parts)}"


def _short(entry: float | complex | str | None) -> str:
    if entry is None:
        return "-"
    if isinstance(entry, str):
        return entry
    if isinstance(entry, complex):
        return f"{entry.real:.8g}\n{entry.imag:+.8g}i"
    return f"{entry:.8g}"


def _row_object(row: ComparedRow) -> dict[str, object]:
    numbers = {name: _json(getattr(row, name))
               for name in ("reference", "value", "difference", "allowed")}  # fmt: skip
    told = {name: getattr(row, name) for name in ("same", "unit", "entry", "failed", "entries")}
    ratio = row.ratio if math.isfinite(row.ratio) else None
    names = {"quantity": row.path, "compare": row.kind, "problems": list(row.problems)}
    return names | told | numbers | {"ratio": ratio}


def _json(entry: float | complex | str | None) -> object:
    if isinstance(entry, complex):
        return [_json(entry.real), _json(entry.imag)]
    if isinstance(entry, float) and not math.isfinite(entry):
        return str(entry)
    return entry


def _xml(text: str) -> str:
    return _NOT_IN_XML.sub("\N{REPLACEMENT CHARACTER}", text)
