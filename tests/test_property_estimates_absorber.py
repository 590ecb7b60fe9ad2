"""Claim: the error estimates of absorbers are honest, and the tolerance is kept or said.

Seeded random primaries with one or more absorbers, given or tuned by every norm and kind, are run
from their case tables and held against 50 digits (`truth_absorber.py`): curves, peaks, poles,
tunings, weights, losses, slopes, other methods. At most 1 % of the estimates are below a tenth of
the true error, at most 5 % above a thousand times of it.
"""

import pytest
from estimate_counts import Reported, broken_promises, hold, reported_or_refused
from random_absorbers import random_absorber
from truth_absorber import judge_absorber

FEW = (3,)


def reported_of(seeds: range | tuple[int, ...]) -> list[Reported]:
    """The machines that run."""
    found = list(reported_or_refused((random_absorber(seed) for seed in seeds), judge_absorber))
    reported = [one for one in found if isinstance(one, Reported)]
    print(f"{len(reported)} machines run, {len(found) - len(reported)} refused")
    return reported


def test_estimates_of_a_few_machines() -> None:
    reported = reported_of(FEW)
    assert len(reported) == len(FEW)
    judged = [one for each in reported for one in each.judged]
    assert len(judged) > 25
    low = [one for one in judged if one.too_low]
    assert low == []
    # of so few one lucky hit counts much: the long run has the share
    assert sum(one.too_high for one in judged) <= 0.2 * len(judged)
    assert [one for each in reported for one in broken_promises(each)] == []


@pytest.mark.long
def test_estimates_of_three_hundred_machines() -> None:
    reported = reported_of(range(100, 400))
    assert len(reported) > 280
    hold([one for each in reported for one in each.judged], "absorber")
    assert [one for each in reported for one in broken_promises(each)] == []
