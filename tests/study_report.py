"""Holds the error estimates of a study of a shaft line against truths with a noise of their own."""

from typing import Any, NamedTuple, TypeAlias

import numpy as np
from truth_report import Judged

from vibecalc.core.results.record import Record
from vibecalc.core.results.tolerance import reached
from vibecalc.schema import Case

MOST_TOO_LOW, MOST_TOO_HIGH = 0.01, 0.05

#: path below the root, true values, what these may be off; then those found, if not all are meant
Truth: TypeAlias = tuple[Any, ...]


class StudyReport(NamedTuple):
    """What was judged, paths without truth or reason, those past rtol and not reported."""

    judged: list[Judged]
    missing: list[str]
    silent: list[str]


def report(
    case: Case, record: Record, root: str, truths: list[Truth], no_truth: dict[str, str]
) -> StudyReport:
    """All truths below `root`; the noise of a truth is taken off its error."""
    judged = [_judged(record, root + name, *truth) for name, *truth in truths]
    seen = {one.path for one in judged}
    named = tuple(root + name for name in no_truth)
    missing = [
        path for path in record
        if path.startswith(root) and path not in seen and not path.startswith(named or "-")
    ]  # fmt: skip
    return StudyReport(judged, missing, silent_of(judged, record, case.accuracy.rtol))


def silent_of(judged: list[Judged], record: Record, rtol: float) -> list[str]:
    """Quantities whose true error is past the tolerance and of which no warning speaks."""
    reported = any("not reached, by error" in text for text in record.warnings)
    silent = []
    for one in judged:
        share = reached(record[one.path], record)
        # what cancels, and what is looked for, has no relative accuracy
        if one.error > rtol * one.size and share is not None and not (reported and share > rtol):
            silent.append(one.path)
    return silent


def _judged(record: Record, path: str, true: Any, noise: float, *found: np.ndarray) -> Judged:
    values = np.asarray(found[0] if found else record[path].values)
    exact = np.asarray(true)
    assert values.shape == exact.shape, (path, values.shape, exact.shape)
    same = ~np.isfinite(values) & (values == exact)
    finite = np.isfinite(values) & np.isfinite(exact)
    gap = np.where(same, 0.0, np.inf)
    gap = np.where(
        finite, np.abs(np.where(finite, values, 0.0) - np.where(finite, exact, 0.0)), gap
    )
    size = float(np.abs(exact[np.isfinite(exact)]).max(initial=0.0))
    error = max(float(gap.max(initial=0.0)) - noise, 0.0)
    return Judged(path, error, float(record[path].error_estimate), size)


def hold(reports: list[StudyReport]) -> None:
    """At most 1 % too low, 5 % too high, and no tolerance missed in silence."""
    judged = [one for report in reports for one in report.judged]
    low = [one for one in judged if one.too_low]
    high = [one for one in judged if one.too_high]
    assert len(low) <= MOST_TOO_LOW * len(judged), low
    assert len(high) <= MOST_TOO_HIGH * len(judged), high
    assert [path for report in reports for path in report.silent] == []
