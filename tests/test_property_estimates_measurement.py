"""Claim: the error estimates of a measured plate are honest, and the tolerance is kept or said.

Seeded random readings, amplitudes with phases or levels alone that contradict each other a little,
are run from their case tables and held against 40 digits (`truth_measurement.py`): motions, levels,
phases, residuals, candidates, maps, quiet places, uncertainties. At most 1 % of the estimates are
below a tenth of the true error, at most 5 % above a thousand times of it.
"""

import pytest
from estimate_counts import Reported, broken_promises, hold, reported_or_refused
from random_plates import random_measured_plate
from truth_measurement import judge_plate

FEW = (6, 398)


def reported_of(seeds: range | tuple[int, ...], points: int = 5) -> list[Reported]:
    """The plates that run, with maps of that many points along each side."""
    plates = [random_measured_plate(seed) for seed in seeds]
    for plate in plates:
        plate["measurement"]["plate"]["points"] = points
    found = list(reported_or_refused(plates, judge_plate))
    reported = [one for one in found if isinstance(one, Reported)]
    print(f"{len(reported)} plates run, {len(found) - len(reported)} refused")
    return reported


def test_estimates_of_a_few_plates() -> None:
    """Among them least squares of levels (6), whose sum of squares is flat at the end.

    In another one (398) steps of rounding along the phase that is free lengthened the motion.
    """
    reported = reported_of(FEW, points=2)
    assert len(reported) == len(FEW)
    hold([one for each in reported for one in each.judged], "plate")
    assert [one for each in reported for one in broken_promises(each)] == []


@pytest.mark.long
def test_estimates_of_three_hundred_plates() -> None:
    reported = reported_of(range(100, 400))
    assert len(reported) > 280
    hold([one for each in reported for one in each.judged], "plate")
    assert [one for each in reported for one in broken_promises(each)] == []
