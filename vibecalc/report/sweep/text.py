"""The report of a sweep as text: fixed columns and stable digits, as that of a single run."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vibecalc.report.sweep.extremes import extreme_lines
from vibecalc.report.sweep.failures import failure_lines
from vibecalc.report.sweep.limit_lines import kept_share, limit_lines
from vibecalc.report.sweep.limits import Limit, judge
from vibecalc.report.sweep.sampled import index_lines, statistic_lines
from vibecalc.report.sweep.view import SweepView
from vibecalc.report.tables import Column, fold, number, pairs, paragraph, table
from vibecalc.results.sweep_layout import DONE, NOT_RUN

_AXES = (
    Column("key", 42),
    number("points", 9),
    number("from", 12),
    number("to", 12),
    Column("unit", 10),
    Column("spacing", 8),
)


def render_sweep(sweep: SweepView) -> str:
    """The whole report of a sweep, at most 100 columns wide.

    Raises
    ------
    ResultError
        A limit of the case names an entry that the sweep does not have.
    """
    limits, missing = judge(sweep)
    title = fold(str(sweep.case.get("title") or sweep.name), 98)
    lines = [*title, "=" * max(len(line) for line in title), *_identity(sweep)]
    lines += _titled("Summary", paragraph(conclusion(sweep, limits)))
    sections = (
        ("What varies", _varied(sweep)),
        ("Limits", limit_lines(sweep, limits, missing)),
        ("Smallest and largest values", extreme_lines(sweep)),
        ("Statistics of the samples", statistic_lines(sweep)),
        ("Sobol indices", index_lines(sweep)),
        ("Points without a result", failure_lines(sweep)),
        ("Not kept", _left_out(sweep)),
        ("Provenance", pairs((name, str(text)) for name, text in sweep.provenance.items())),
    )
    for name, section in sections:
        if section:
            lines += _titled(name, section)
    return "\n".join(lines) + "\n"


def report_file(path: Path, *, full: bool = False) -> str:
    """The report of a file, be it of a run, a sweep or a measurement of methods.

    `full` lists the error estimates of a run; the others have none to list. Raises ResultError if
    the file cannot be read.
    """
    from vibecalc.results.sweep_file import is_sweep, open_sweep

    if is_sweep(path):
        from vibecalc.report.sweep.opened import view_of

        with open_sweep(path) as opened:
            return render_sweep(view_of(opened))
    from vibecalc.results.accuracy_layout import is_accuracy
    from vibecalc.results.store import read_result

    result = read_result(path)
    if is_accuracy(result):
        from vibecalc.report.accuracy.text import render_accuracy

        return render_accuracy(result)
    from vibecalc.report.text import render_report

    return render_report(result, full=full)


def conclusion(sweep: SweepView, limits: Sequence[Limit]) -> str:
    """One sentence: how many points were computed, failed or are missing, and what they keep."""
    count = {status: int(np.count_nonzero(sweep.status == status)) for status in (DONE, NOT_RUN)}
    failed = sweep.count - sum(count.values())
    clauses = [f"{count[DONE]} of {sweep.count} points are computed"]
    if failed:
        clauses.append(f"{failed} failed, see below")
    if count[NOT_RUN]:
        clauses.append(f"{count[NOT_RUN]} {'was' if count[NOT_RUN] == 1 else 'were'} not run")
    if limits:
        clauses.append(kept_share(sweep, limits))
    return "; ".join(clauses) + "."


def _identity(sweep: SweepView) -> list[str]:
    rows = [("case", sweep.name)]
    if sweep.case.get("source"):
        rows.append(("source", str(sweep.case["source"])))
    rows.append(("points", _points(sweep)))
    return pairs([*rows, *sweep.facts], 20)


def _points(sweep: SweepView) -> str:
    if not sweep.grid:
        method = sweep.sampling.replace("_", " ")
        runs = ", in the order that Sobol indices need" if sweep.indices else ""
        return f"{sweep.count}, {method} sampling{runs}"
    sizes = " x ".join(str(size) for size in sweep.shape)
    return f"{sweep.count}, a grid" + (f" of {sizes}" if len(sweep.shape) > 1 else "")


def _varied(sweep: SweepView) -> list[str]:
    rows = []
    if sweep.grid:
        for axis in sweep.grid:
            spacing = "log" if axis.logarithmic else _steps(axis.values[:, 0])
            for column, key in enumerate(axis.keys):
                values = axis.values[:, column]
                if key.names:
                    names = ", ".join(key.names[round(float(value))] for value in values)
                    rows.append([key.key, str(len(values)), "", "", "", "choice"])
                    rows.append([f"  {names}", "", "", "", "", ""])
                    continue
                ends = [key.number(values[0]), key.number(values[-1])]
                count = str(len(values)) if column == 0 else "in step"
                rows.append([key.key, count, *ends, key.unit, spacing if column == 0 else ""])
        return table(_AXES, rows)
    drawn = sweep.values_of(np.arange(sweep.count))
    for column, key in enumerate(sweep.keys):
        if key.names:
            rows.append([f"{key.key}: {', '.join(key.names)}", "", "", "", "", "drawn"])
            continue
        ends = [key.number(end) for end in (drawn[:, column].min(), drawn[:, column].max())]
        rows.append([key.key, "", *ends, key.unit, "drawn"])
    return table(_AXES, rows)


def _steps(values: np.ndarray) -> str:
    steps = np.diff(values)
    even = steps.size and np.ptp(steps) <= 1e-6 * np.max(np.abs(steps))
    return "linear" if even else "listed"


def _left_out(sweep: SweepView) -> list[str]:
    lines: list[str] = []
    for path, reason in sweep.left_out.items():
        lines += paragraph(f"{path}: {reason}")
    return lines


def _titled(title: str, lines: list[str]) -> list[str]:
    return ["", title, "-" * len(title), *lines]
