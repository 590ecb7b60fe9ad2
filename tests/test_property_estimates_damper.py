"""Claim: the error estimates of a damper's search are honest, its proof and its map included.

Seeded small engines, run from their case tables; the truth of the optimum is Newton's method on the
conditions that hold it, in 60 digits (`exact_damper.py`), for the torques as they are handed to the
search. It starts at the optimum found: it tells how far that is off, not that none is better.
"""

import pytest
from estimate_counts import Uncertain, hold
from random_dampers import random_damper_case
from truth_damper import judge_damper
from truth_report import Judged

from vibecalc.errors import NumericalFailure

#: one whose damping stands at its bound is among the long ones
FEW = (2,)


@pytest.mark.long
def test_estimates_of_a_small_design() -> None:
    judged = [one for seed in FEW for one in judge_damper(random_damper_case(seed), charted=False)]
    assert len(judged) >= 25 * len(FEW)
    assert [one for one in judged if one.too_low] == []
    hold([Uncertain(*one) for one in judged])


@pytest.mark.long
@pytest.mark.timeout(900)
def test_estimates_of_forty_designs() -> None:
    judged: list[Judged] = []
    refused = []
    for seed in range(40):
        try:
            judged += judge_damper(random_damper_case(seed), charted=seed % 3 == 0)
        except NumericalFailure as failure:
            refused.append((seed, str(failure)))
    print(f"{len(refused)} refused")
    assert len(refused) <= 2, refused
    charts = [one for one in judged if "/chart/" in one.path]
    assert len(charts) > 20
    hold([Uncertain(*one) for one in judged], "damper designs")
