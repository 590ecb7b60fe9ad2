"""What a sweep says: before it starts, after it ends, and its report."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibecalc.core.case.load import LoadedCase
from vibecalc.core.report.check import time_in_words
from vibecalc.core.report.sweep.limits import Limits, judge, limit_lines, share_within_limits
from vibecalc.core.report.sweep.statistics import (
    extreme_lines,
    index_lines,
    point_lines,
    statistic_lines,
)
from vibecalc.core.report.sweep.view import SweepView, causes, example, failure_lines, view_of
from vibecalc.core.report.writing import (
    heading,
    many,
    number,
    pairs,
    paragraph,
    table,
    text_of,
    titled,
)
from vibecalc.core.results.catalogue import CATALOGUE
from vibecalc.core.results.layout import DONE, NOT_RUN, STATUS_WORDS, is_accuracy
from vibecalc.core.results.record import Result
from vibecalc.core.results.sweep_file import SweepResult, opened
from vibecalc.core.study.sweep.checks import UNSHARED_AXES

# ----------------------------------------------------------------------------
# What `sweep` says before it starts and after it ends, in words and as plain objects.
# ----------------------------------------------------------------------------


def render_forecast(loaded: LoadedCase, found: Mapping[str, Any], output: Path) -> str:
    """What a sweep will be, as `forecast` of `core/study/sweep/prepare.py` has it, as text."""
    sizes = " x ".join(map(str, found["shape"]))
    sampling, failures, chunks = found["sampling"], found["failures"], found["chunks"]
    shape = f", a grid of {sizes}" if sampling == "grid" else f", {sampling} sampling"
    tried = f"estimated from {many(found['tried'], 'trial point')}"
    size = f"{found['chunk_size']} points each" if chunks > 1 else "all points"
    processes = many(found["processes"], "process", "processes")
    rows = [
        ("points", f"{found['points']}{shape}"),
        ("strategy", f"{found['strategy']}: {found['reason']}"),
        ("chunks", f"{chunks}, {size}"),
        ("time", f"{time_in_words(found['seconds'])} with {processes}, {tried}"),
        ("file", f"about {1e-6 * found['bytes']:.3g} MB, {output}"),
    ]
    if failures:
        rows.append(("failed", f"{len(failures)} of those tried: {failures[0]}"))
    lines = [f"{loaded.path}: {loaded.case.title}", *pairs(rows, 10), "", "kept"]
    lines += pairs([(one["quantity"], _shape_words(one)) for one in found["kept"]], 48)
    return "\n".join([*lines, "", "nothing was written"])


def outcome_object(sweep: SweepView, output: Path) -> dict[str, Any]:
    """What `--json` prints of the file of a sweep."""
    counts = Counter(sweep.status.tolist())
    return {
        "case": sweep.name,
        "result": str(output),
        "points": sweep.count,
        "shape": list(sweep.shape),
        "statuses": {STATUS_WORDS[status]: many for status, many in sorted(counts.items())},
        "failures": [
            {
                "status": STATUS_WORDS[cause.status],
                "message": cause.words,
                "points": int(cause.points.size),
                "example": int(cause.points[0]),
            }
            for cause in causes(sweep)
        ],
        "quantities": {
            path: {"unit": one.unit, "axes": [axis.name for axis in one.axes]}
            for path, one in sweep.quantities.items()
        },
        "left_out": dict(sweep.left_out),
        "limits": [
            {
                "quantity": limit.quantity,
                "where": dict(limit.where),
                limit.side: limit.bound,
                "unit": sweep.quantities[limit.quantity].unit,
                "kept": int(np.count_nonzero(limit.kept)),
                "broken": int(np.count_nonzero(limit.broken)),
                "undecided": int(np.count_nonzero(limit.open)),
            }
            for limit in judge(sweep).limits
        ],
    }


def failure_words(sweep: SweepView, most: int = 5) -> list[str]:
    """One line for each of the most frequent causes of failure, for stderr."""
    found = causes(sweep)
    lines = [
        f"  {many(cause.points.size, 'point')}: {cause.title}; for example {example(sweep, cause)}"
        for cause in found[:most]
    ]
    if len(found) > most:
        lines.append(f"  and {len(found) - most} other causes, see the report")
    return lines


def _shape_words(one: Mapping[str, Any]) -> str:
    if one["axes"] is None:
        return str(one["reason"])
    axes = " x ".join(f"{name} ({length})" for name, length in one["axes"].items())
    return ", ".join(filter(None, (axes or "one number", one["unit"])))


def missing_words(missing: Sequence[tuple[int, int]], most: int = 4) -> str:
    """Gaps of a sweep in words: 12 to 40, 77."""
    gaps = [str(first) if first == last else f"{first} to {last}" for first, last in missing[:most]]
    more = f" and {len(missing) - most} other gaps" if len(missing) > most else ""
    return ", ".join(gaps) + more


# ----------------------------------------------------------------------------
# The report of a sweep as text: stable digits, as that of a single run.
# ----------------------------------------------------------------------------

_AXES = "key", number("points"), number("from"), number("to"), "unit", "spacing"


def render_sweep(sweep: SweepView) -> str:
    """The whole report of a sweep, at most 100 columns wide.

    Raises
    ------
    ResultError
        A limit of the case names an entry that the sweep does not have.
    """
    return text_of(sweep_lines(sweep))


def sweep_lines(sweep: SweepView) -> list[str]:
    """The blocks of that report."""
    judged = judge(sweep)
    lines = [*heading(str(sweep.case.get("title") or sweep.name), 1), *_identity(sweep)]
    lines += titled("Summary", paragraph(conclusion(sweep, judged)))
    provenance = sweep.head.result.provenance.items()
    sections = (
        ("What varies", _varied(sweep)),
        ("Limits", limit_lines(sweep, judged)),
        ("Results by point", point_lines(sweep)),
        ("Smallest and largest values", extreme_lines(sweep)),
        ("Statistics of the samples", statistic_lines(sweep)),
        ("Sobol indices", index_lines(sweep)),
        ("Points without a result", failure_lines(sweep)),
        ("Not stored", [line for words in _not_stored(sweep) for line in paragraph(words)]),
        (
            "Provenance",
            pairs(
                [
                    ("sha256 of the case", sweep.head.result.case_sha256),
                    ("sha256 of the sweep", sweep.head.identity),
                    *((name, str(text)) for name, text in provenance),
                ]
            ),
        ),
    )
    return lines + [line for one in sections if one[1] for line in titled(*one)]


def _not_stored(sweep: SweepView) -> Iterator[str]:
    """What cannot be stored and why, and what runs have besides where nobody said what to keep."""
    yield from map(": ".join, sweep.left_out.items())
    if sweep.case.get("sweep", {}).get("keep"):
        return
    planned = {
        path for row in sweep.head.result.plan for path in row.get("quantities", "").split(", ")
    }
    others = [
        CATALOGUE[path].axes
        for path in planned - {*sweep.quantities, *sweep.left_out}
        if path in CATALOGUE and not {*CATALOGUE[path].axes} & {*UNSHARED_AXES}
    ]
    along = Counter(axis for axes in others for axis in axes)
    if along:
        most = sorted(along, key=lambda axis: (-along[axis], axis))
        yield (
            f"{many(len(others), 'result')} with several entries, along {', '.join(most[:8])}: "
            "`keep` in [sweep], or --keep, stores those that it names"
        )


def report_file(of: Path | Result, *, full: bool = False) -> str:
    """The report of a file or a result, be it of a run, a sweep or a measurement of methods.

    `full` lists the error estimates of a run; the others have none to list. Raises ResultError if
    the file cannot be read.
    """
    return text_of(file_lines(of, full=full))


def file_lines(of: Path | Result, *, full: bool = False) -> list[str]:
    """The blocks of that report."""
    with opened(of) as found:
        if isinstance(found, SweepResult):
            return sweep_lines(view_of(found))
        if is_accuracy(found):
            from vibecalc.core.report.accuracy import accuracy_lines

            return accuracy_lines(found)
        from vibecalc.core.report.text import report_lines

        return report_lines(found, full=full)


def file_object(path: Path, *, full: bool = False) -> dict[str, Any]:
    """What `report --json` prints of a file: as the command that wrote it, without its times."""
    with opened(path) as found:
        if isinstance(found, SweepResult):
            return outcome_object(view_of(found), path)
        if is_accuracy(found):
            from vibecalc.core.report.accuracy import accuracy_object

            return accuracy_object(found, path)
        from vibecalc.core.report.text import as_json

        return as_json(found, path, full=full)


def conclusion(sweep: SweepView, judged: Limits) -> str:
    """One sentence: how many points were computed, failed or are missing, and what they keep."""
    done, left = (np.count_nonzero(sweep.status == status) for status in (DONE, NOT_RUN))
    failed = sweep.count - done - left
    clauses = [f"{done} of {sweep.count} points are computed"]
    if failed:
        clauses.append(f"{failed} failed, see below")
    if left:
        clauses.append(f"{left} {'was' if left == 1 else 'were'} not run")
    if judged.limits:
        clauses.append(share_within_limits(sweep, judged))
    return "; ".join(clauses) + "."


def _identity(sweep: SweepView) -> list[str]:
    sizes = " x ".join(map(str, sweep.shape))
    drawn = "a grid" + (f" of {sizes}" if len(sweep.shape) > 1 else "")
    if not sweep.grid:
        runs = ", in the order that Sobol indices need" if sweep.indices else ""
        drawn = f"{sweep.head.sampling.replace('_', ' ')} sampling{runs}"
    source, points = str(sweep.case.get("source") or ""), f"{sweep.count}, {drawn}"
    head = sweep.head
    rows = [
        ("case", sweep.name),
        ("source", source),
        ("points", points),
        ("vibecalc", head.result.version),
    ]
    return pairs(row for row in rows if row[1])


def _varied(sweep: SweepView) -> list[str]:
    rows: list[list[str]] = []
    for axis in sweep.head.axes:
        spacing = "log" if axis.logarithmic else _steps(axis.table[:, 0])
        for column, key in enumerate(axis.keys):
            values = axis.table[:, column]
            count, step = (str(len(values)), spacing) if column == 0 else ("in step", "")
            if not sweep.grid:
                count, step, values = "", "drawn", np.sort(values)
            if not key.choices:
                ends = [key.number(values[0]), key.number(values[-1])]
                rows.append([key.key, count, *ends, key.written_unit, step])
                continue
            if sweep.grid:
                count, step = str(len(values)), "choice"
                names = (key.choices[round(float(value))] for value in values)
            rows.append([key.key, count, "", "", "", step])
            listed = ", ".join(names if sweep.grid else key.choices)
            rows.append([f"  {listed}", "", "", "", "", ""])
    return table(_AXES, rows)


def _steps(values: np.ndarray) -> str:
    steps = np.diff(values)
    even = steps.size and np.ptp(steps) <= 1e-6 * np.max(np.abs(steps))
    return "linear" if even else "listed"
