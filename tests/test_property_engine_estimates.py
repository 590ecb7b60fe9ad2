"""Claim: the error estimates of a shaft line are honest, from the modes to the barred speeds.

Seeded random engines (`random_engines.py`), run from their case tables; the truth of what is stored
is formed anew in 40 digits (`exact_engine*.py`), largest values by a search of their own. At most
1 % of the estimates are below a tenth of the true error, at most 5 % above a thousand times of it.
A tolerance that is missed is said to be missed, or the run refuses.
"""

import pytest
from engine_truth import Report, judge_engine
from random_engines import random_engine
from truth_report import Judged

from vibecalc.errors import NumericalFailure

MOST_TOO_LOW, MOST_TOO_HIGH = 0.01, 0.05
#: the cheapest ones with a cycle, a damper, a branch
FEW = (102,)
#: seeds of the long test, in parts that end in time
PARTS = [range(start, start + 61) for start in range(100, 405, 61)]


def hold(reports: list[Report]) -> None:
    """The claim for a set of engines."""
    judged = [one for report in reports for one in report.judged]
    low = [one for one in judged if one.too_low]
    high = [one for one in judged if one.too_high]
    assert len(low) <= MOST_TOO_LOW * len(judged), low
    assert len(high) <= MOST_TOO_HIGH * len(judged), high
    assert [path for report in reports for path in report.silent] == []


@pytest.fixture(scope="module")
def few() -> list[Report]:
    return [judge_engine(random_engine(seed)) for seed in FEW]


def test_estimates_against_truth(few: list[Report]) -> None:
    judged: list[Judged] = [one for report in few for one in report.judged]
    assert len(judged) > 40 * len(FEW)
    assert sum(one.error > 0.0 for one in judged) > 0.8 * len(judged)
    hold(few)


def test_no_error_without_an_estimate(few: list[Report]) -> None:
    judged = [one for report in few for one in report.judged]
    assert [one for one in judged if one.error > one.estimate == 0.0] == []


@pytest.mark.long
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("seeds", PARTS, ids=lambda part: f"{part[0]}-{part[-1]}")
def test_estimates_of_three_hundred_engines(seeds: range) -> None:
    reports, refused = [], []
    for seed in seeds:
        try:
            reports.append(judge_engine(random_engine(seed)))
        except NumericalFailure as failure:
            refused.append((seed, str(failure)))
    assert len(refused) <= 1, refused
    judged = [one for report in reports for one in report.judged]
    low, high = (sum(getattr(one, which) for one in judged) for which in ("too_low", "too_high"))
    counts = f"{len(judged)} estimates, {low} too low, {high} too high"
    print(f"{len(reports)} engines, {len(refused)} refused: {counts}")
    seen = {one.path for one in judged}
    assert {path for report in reports for path in report.missing} <= seen
    hold(reports)
