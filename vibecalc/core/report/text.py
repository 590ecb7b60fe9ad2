"""The report of a result: as text, and as the object that `--json` prints."""

import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.report import pages
from vibecalc.core.report.brief import fitted, lines_of
from vibecalc.core.report.defects import survived
from vibecalc.core.report.headline import Answer, first_table, with_limits
from vibecalc.core.report.sections import magnitudes, other, section, speed_of, table_of
from vibecalc.core.report.verdicts import ReferenceRow, counted_misses, judge_references, misses
from vibecalc.core.report.writing import (
    finite,
    heading,
    height,
    many,
    pairs,
    paragraph,
    rpm,
    show,
    text_of,
    titled,
)
from vibecalc.core.results.catalogue import HEADLINES
from vibecalc.core.results.named import named
from vibecalc.core.results.record import Quantity, Record, Result, Verdict
from vibecalc.core.results.verdicts import verdicts_of
from vibecalc.core.run.stage import subjects_of

# ----------------------------------------------------------------------------
# The report as text: stable digits, so that two reports can be diffed.
# ----------------------------------------------------------------------------


#: sections of studies, before those of the subjects
OF_STUDIES = (
    "vibecalc.core.report.studies:optimisation",
    "vibecalc.core.report.studies:find",
    "vibecalc.core.report.fit:fit",
)


#: keys of `[document]` that are lines of a title block, with their names
LINES = ("project", "customer", "number", "revision", "date", "author", "checked", "approved")


def sections_of(record: Record) -> list[str]:
    """Sections of studies and of the subjects that a record has quantities of, in their order."""
    there = sorted(subjects_of(record), key=lambda subject: not subject.leads)
    return [*OF_STUDIES, *(where for subject in there for where in subject.sections)]


def render_report(result: Result, *, full: bool = False) -> str:
    """The report of one result, at most 100 columns wide, as `report_lines` gives its blocks."""
    return text_of(report_lines(result, full=full))


def report_lines(result: Result, *, full: bool = False) -> list[str]:
    """The blocks of the report of one result: the answer first.

    Sections appear only for what the result has; what no section knows is listed generically. They
    are as long as the case asks for, by `brief.lines_of`. `full` has all of them, with their
    details, margins of limits, every reference number, the error estimate of every quantity,
    methods and plan. What changes from run to run stands at its end, so that all above it is the
    same text for the same numbers.

    Raises
    ------
    ResultError
        A reference or limit of the case names what the result does not have.
    """
    limits, references = verdicts_of(result), judge_references(result)
    rows = identity(result, full)
    rows += [("sha256 of the case", result.case_sha256), ("vibecalc", result.version)] * full
    words = pages.conclusion(references, limits)
    off = pages.references(pages.missed(references))
    verdicts = [paragraph(words) if words else [], pages.limits(limits) if full else [], off]
    leading = [
        section("Results", [first_table(result, limits)]),
        section("Verdicts", verdicts),
        pages.warnings(result),
    ]
    parts = [survived(where, partial(named(where), result)) for where in sections_of(result.record)]
    first, found = ([one for one in some if one is not None] for some in (leading, parts))
    further = other(result, {path for one in (*first, *found) for path in one.shown})
    found += [further] if further else []
    compared = pages.references(references) if full else pages.brief(references)
    last = section("Reference numbers", [compared])
    found += [last] if last else []
    lines = [*heading(str(result.case.get("title") or result.name), 1), *pairs(rows)]
    lines += [line for one in first for line in titled(one.title, one.lines)]
    closing = pages.closings(result) if full else pages.failures()
    ends = [line for one in closing for line in titled(one.title, one.lines)]
    if full:
        whole = (titled(one.title, [*one.lines, *one.detail]) for one in found)
        return lines + [line for one in whole for line in one] + ends
    return lines + fitted(found, lines_of(result.case) - height([*lines, *ends])) + ends


class Verdicts(NamedTuple):
    """A result held to the references and limits of its case."""

    result: Result

    @property
    def misses(self) -> int:
        """How many that count are missed or undecided."""
        return counted_misses(self.result)

    @property
    def kept(self) -> bool:
        """Whether none is."""
        return not self.misses

    def __str__(self) -> str:
        return render_verdicts(self.result)

    def __repr__(self) -> str:
        verdict = "kept" if self.kept else f"{self.misses} missed or undecided"
        return f"<vibecalc verdicts on {self.result.name!r}: {verdict}>"


def render_verdicts(result: Result) -> str:
    """Limits and references of one result, each miss in words, and the conclusion."""
    limits, references = verdicts_of(result), judge_references(result)
    lines = heading(str(result.case.get("title") or result.name))[1:]
    for reported in (pages.limits(limits), pages.references(references)):
        lines += [*reported, ""] if reported else []
    words = pages.conclusion(references, limits) or "The case names no limit and no reference."
    lines += [line for miss in misses(references, limits) for line in paragraph(miss, "MISSED")]
    return "\n".join([*lines, *paragraph(words)]) + "\n"


def identity(result: Result, full: bool = True) -> list[tuple[str, str]]:
    """Lines of `[document]`, case, source and machine; `remarks` and history stand elsewhere.

    In brief the number of the document with its revision only.
    """
    document = table_of(result.case, "document")
    told = {key: str(document.get(key) or "") for key in LINES}
    told = {"document" if key == "number" else key: words for key, words in told.items()}
    if not full:
        number, revision = told["document"], told["revision"]
        told = {"document": f"{number}, revision {revision}" if number and revision else number}
    said = [*told.items()]
    rows = [*said, ("case", result.name), ("source", str(result.case.get("source") or ""))]
    return [(name, words) for name, words in (*rows, ("machine", _machine(result))) if words]


def _machine(result: Result) -> str:
    machine, speed = table_of(result.case, "machine"), speed_of(result)
    cylinders: Any = table_of(machine, "crank_train").get("cylinders") or ()
    kind = str(machine.get("kind") or "")
    words = (
        "" if kind == "machine" else kind.replace("_", " "),
        many(len(cylinders), "cylinder") if cylinders else "",
        "" if speed is None else f"{show(rpm(speed))} rpm",
    )
    return ", ".join(filter(None, words))


# ----------------------------------------------------------------------------
# The object that `--json` prints. Its keys are a contract with scripts of others.
# ----------------------------------------------------------------------------


def as_json(
    result: Result, path: Path | str | None = None, *, full: bool = False
) -> dict[str, Any]:
    """The result as a plain object that `json.dumps(..., allow_nan=False)` takes.

    `result` is the path of the result file. `headlines` is the first table of the report, in the
    units that people read, each with the limit that decides: bounds, utilisation and verdict, None
    without one. `quantities` has the scalars, a complex one as its
    magnitude, and the lists of the first table (as barred ranges), with `full` all arrays: `value`
    as lists along the `axes`, of what is complex `real` and `imaginary`. What is zero to rounding
    of its terms is 0; what is no larger than its `error` for another reason is not `resolved`. What
    is undefined is None, and so is what is infinite, since JSON has no word for it; an infinite
    limit entry still says `kept: false`. An undecided one has `kept: null` and says what would
    decide it; one that is exceeded in barred ranges only is not kept either, but `satisfied`, as is
    every limit that does what the case expects.
    """
    return {
        "case": result.name,
        "result": None if path is None else str(path),
        "headlines": [_headline(row) for row in with_limits(result, verdicts_of(result))],
        "quantities": {
            quantity.path: quantity_object(quantity)
            for quantity in result.record.values()
            if full or not quantity.axes or _is_listed(quantity.path)
        },
        "references": [_reference(row) for row in judge_references(result)],
        "limits": [_limit(row) for row in verdicts_of(result)],
        "timings": {stage: float(seconds) for stage, seconds in result.timings.items()},
    }


def _headline(row: Answer) -> dict[str, Any]:
    """One row of the first table."""
    told = _parts(row, "name value unit where", quantity="path")
    limit = dict.fromkeys(("min", "max", "utilisation", "verdict"))
    if row.limit is not None:
        limit = _parts(row.limit, "min max utilisation", verdict="state")
    return told | ({"value": 0.0} if row.shown == "0" else {}) | limit


def quantity_object(quantity: Quantity) -> dict[str, Any]:
    """One quantity of that object."""
    told = {"unit": quantity.unit, "error": finite(quantity.error_estimate)}
    if quantity.axes:
        values = quantity.values
        if values.dtype.kind in "fc":
            values = np.where(quantity.zero, 0.0, values)
        halves = values.dtype.kind == "c"
        parts = {"real": values.real, "imaginary": values.imag} if halves else {"value": values}
        axes = [{"name": axis.name, "unit": axis.unit, "values": _list(axis.values)}
                for axis in quantity.axes]  # fmt: skip
        return {name: _list(part) for name, part in parts.items()} | told | {"axes": axes}
    value = magnitudes(quantity).item()
    known = isinstance(value, int | float) and math.isfinite(value)
    zero = isinstance(value, float) and known and quantity.estimate.is_zero(value)
    shown = int(value) if isinstance(value, int) else 0.0 if zero else _plain(value)
    resolved = not known or not quantity.estimate.unresolved(float(value))
    return {"value": shown} | told | {"resolved": resolved}


_REFERENCE = "quantity where source value computed resolved unit relative_difference within kind"
_LIMIT = "quantity where source min max unit computed margin utilisation kept satisfied"


def _parts(row: Any, names: str, **others: str) -> dict[str, Any]:
    """Parts of a row by their names, or by `others`."""
    parts = {name: name for name in names.split()} | others
    return {name: _plain(getattr(row, part)) for name, part in parts.items()}


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return finite(value)
    return dict(value) if isinstance(value, Mapping) else value


def _reference(row: ReferenceRow) -> dict[str, Any]:
    told = _parts(row, _REFERENCE, error="error_estimate")
    return told | {"known_difference": row.known_difference or None}


def _limit(row: Verdict) -> dict[str, Any]:
    told = _parts(row, _LIMIT, error="error_estimate", verdict="state")
    names = ("element", "limit", "condition", "decided_by")
    return told | {name: getattr(row, name) or None for name in names}


def _is_listed(path: str) -> bool:
    """Whether the first table has each entry of an array."""
    return path in HEADLINES and HEADLINES[path].pick == "each"


def _list(values: np.ndarray) -> list[Any]:
    """Nested lists of plain numbers and texts, None for what is not finite."""
    if values.dtype.kind == "f":
        values = np.where(np.isfinite(values), values, np.array(None))
    elif values.dtype.kind not in "biu":
        values = values.astype(str)
    return list(values.tolist())
