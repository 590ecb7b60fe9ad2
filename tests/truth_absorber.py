"""Every result of a primary with absorbers next to the truth in many digits (`exact_tree.py`).

The truth of a tuning starts where the run ended and is Newton's, on the conditions of the optimum
in many digits: it says how far the run is off, not that no other optimum is better (that is held by
`test_consistency_absorber_minimax.py`). Without truth are counts, verdicts, and ratios of a tuning
that is one of many, or held by an end of the frequency range.
"""

import copy
from typing import Any

import mpmath
import numpy as np
from estimate_counts import Reported, Uncertain
from mpmath import mp, mpf
from random_machines import Table
from truth_absorber_response import response_truth
from truth_absorber_tuning import tuning_truth
from truth_report import flat

from vibecalc.absorber.model import build_absorber
from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

DIGITS = 50


def judge_absorber(table: Table) -> Reported:
    """Every result that has a truth."""
    case = validate(copy.deepcopy(table))
    assert check_machine(case) == []
    record = run_case(case)
    with mpmath.workdps(DIGITS):
        judged = [
            _judged(record, *one)
            for truths in (tuning_truth, response_truth)
            for one in truths(case, record, build_absorber(case))
        ]
    return Reported(table, record, judged)


def _judged(record: Record, path: str, values: Any, truth: Any, size: float | None) -> Uncertain:
    found, exact = np.ravel(values).tolist(), list(flat(truth))
    assert len(found) == len(exact), (path, len(found), len(exact))
    off = max((_distance(a, b) for a, b in zip(found, exact, strict=True)), default=mpf(0))
    largest = max((abs(b) for b in exact if mp.isfinite(b)), default=mpf(0))
    size = float(largest) if size is None else size
    return Uncertain(path, float(off), record[path].error_estimate, size)


def _distance(value: complex, true: Any) -> mpf:
    if not np.isfinite(value) and not mp.isfinite(true):
        return mpf(0)
    return abs(mpmath.mpmathify(value) - true)
