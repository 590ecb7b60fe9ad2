"""Runs a case and holds every error estimate of its record against the exact results."""

from collections.abc import Iterable, Iterator
from typing import Any

import mpmath
import numpy as np
from estimate_counts import Uncertain as Judged
from estimate_counts import flat
from exact_results import exact_results
from mpmath import mpf
from random_machines import Table

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

DIGITS = 50


def judge(table: Table) -> list[Judged]:
    """Every quantity of a run of a case table next to the truth."""
    case = validate(table)
    record = run_case(case)
    with mpmath.workdps(DIGITS):
        judged = list(judge_record(case, record))
    missing = set(record) - {one.path for one in judged}
    assert not missing, f"no truth for {sorted(missing)}"
    return judged


def judge_record(case: Case, record: Record) -> Iterator[Judged]:
    """The same for a record that is there already, at the caller's precision."""
    return judge_rows(exact_results(case, record), record)


def judge_rows(rows: Iterable[tuple[str, Any, Any]], record: Record) -> Iterator[Judged]:
    """Path, values found and exact ones (of all entries, or of some) next to the estimates."""
    for path, found, exact in rows:
        values, truth = np.ravel(found).tolist(), list(flat(exact))
        assert len(values) == len(truth), path
        errors = [_distance(value, true) for value, true in zip(values, truth, strict=True)]
        sizes = [abs(true) for true in truth if mpmath.isfinite(true)]
        estimate = record[path].error_estimate
        error, size = max(errors, default=mpf(0)), max(sizes, default=mpf(0))
        yield Judged(path, float(error), estimate, float(size))


def _distance(value: complex, true: Any) -> mpf:
    if not np.isfinite(value) and value == true:
        return mpf(0)
    return abs(mpmath.mpmathify(value) - true)
