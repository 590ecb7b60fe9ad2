"""Runs an engine and holds every error estimate of its record against the exact results."""

from typing import NamedTuple

import mpmath
from exact_engine import engine_results, reasonless
from random_engines import Table
from truth_report import Judged, judge_rows

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.results.tolerance import reached
from vibecalc.core.run.run import run_case

DIGITS = 40


class Report(NamedTuple):
    """What was judged, paths without truth or reason, those past rtol and not reported."""

    judged: list[Judged]
    missing: list[str]
    silent: list[str]


def judge_engine(table: Table) -> Report:
    """Every quantity of a run of a case table next to its truth.

    Raises NumericalFailure where the run refuses.
    """
    case = validate(table)
    record = run_case(case)
    with mpmath.workdps(DIGITS):
        judged = list(judge_rows(engine_results(case, record), record))
    seen = {one.path for one in judged}
    missing = [path for path in record if path not in seen and reasonless(path)]
    return Report(judged, missing, _silent(judged, record, case.accuracy.rtol))


def _silent(judged: list[Judged], record: Record, rtol: float) -> list[str]:
    """Quantities whose true error is past the tolerance and of which no warning speaks."""
    reported = any("not within rtol" in text for text in record.warnings)
    past = [one.path for one in judged if one.error > rtol * one.size]
    known = {path for path in past if reported and (reached(record[path], record) or 0.0) > rtol}
    # what cancels has no relative accuracy
    exempt = {path for path in past if reached(record[path], record) is None}
    return [path for path in past if path not in known | exempt]
