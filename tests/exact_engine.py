"""Results of a shaft line in many digits, from the case; what has no truth says why."""

from collections.abc import Iterator

import mpmath
from exact_engine_modes import modal_results
from exact_engine_ranges import range_results
from exact_engine_steady import (
    ROOT,
    Reader,
    Truth,
    excitation,
    margins,
    operating,
    operating_limits,
    own_rows,
)
from random_engines import Table
from study_report import StudyReport, silent_of
from truth_report import judge_rows

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case
from vibecalc.schema import Case

DIGITS = 40
#: beginnings of paths, and why there is no truth for them
NO_TRUTH = {
    "modes/frequency_error": "an estimate itself",
    "modes/holzer_residual": "what rounding leaves; its truth is zero and its estimate says so",
    "masked/": "how near a resonance digits are left is a matter of definition",
    "hammering/gear": "a number of a row",
    "excitation/rank": "the order of sums that have a truth",
    "separation/operating/order": "the order of a margin that has a truth",
    "separation/range/order": "the order of a margin that has a truth",
    "separation/operating/sufficient": "a yes or no",
    "separation/range/sufficient": "a yes or no",
    "largest/mode": "named by a rule of thumb",
    "largest/order": "named by a rule of thumb",
    "peak/mode": "named by a rule of thumb",
    "peak/order": "named by a rule of thumb",
    "peak/section": "a number of a row",
    "limit/section": "a number of a row",
    "limit/basis/": "values of the case, copied or by a closed form that has a test of its own",
    "exceeded/limit": "a number of a row",
    "exceeded/permitted": "a yes or no",
    "barred/permitted": "a yes or no",
    "limit/each/": "the largest uses once more, by section",
}


def engine_results(case: Case, record: Record) -> Iterator[Truth]:
    """All quantities of the line that have a truth, next to it."""
    reader = Reader(case, record)
    yield from modal_results(reader)
    yield from excitation(reader)
    for place in reader.others:
        yield from operating(reader, place)
    yield from own_rows(reader)
    yield from margins(reader)
    yield from operating_limits(reader)
    if reader.torsion.speeds is not None:
        yield from range_results(reader)


def judge_engine(table: Table) -> StudyReport:
    """Every quantity of a run of a case table next to its truth; NumericalFailure if it refuses."""
    case = validate(table)
    record = run_case(case)
    with mpmath.workdps(DIGITS):
        rows = (
            (path, found[0] if found else record[path].values, truth)
            for path, truth, *found in engine_results(case, record)
        )
        judged = list(judge_rows(rows, record))
    known = {one.path for one in judged}
    missing = [
        path
        for path in record
        if path not in known and not path.removeprefix(ROOT).startswith(tuple(NO_TRUTH))
    ]
    return StudyReport(judged, missing, silent_of(judged, record, case.accuracy.rtol))
