"""Every result of a primary with absorbers next to the truth in many digits (`exact_tree.py`).

The truth of a tuning starts where the run ended and is Newton's, on the conditions of the optimum
in many digits: it says how far the run is off, not that no other optimum is better (that is held by
`test_consistency_absorber_minimax.py`). Without truth are counts, verdicts, and ratios of a tuning
that is one of many, or held by an end of the frequency range.
"""

import mpmath
from estimate_counts import Reported, against, checked_run
from random_machines import Table
from truth_absorber_response import response_truth
from truth_absorber_tuning import tuning_truth

from vibecalc.absorber.model import build_absorber

DIGITS = 50


def judge_absorber(table: Table) -> Reported:
    """Every result that has a truth."""
    case, record = checked_run(table)
    with mpmath.workdps(DIGITS):
        judged = [
            against(record, *one)
            for truths in (tuning_truth, response_truth)
            for one in truths(case, record, build_absorber(case))
        ]
    return Reported(table, record, judged)
