"""Claim: the error estimates of the response of a compressor are honest.

Seeded random compressors, their bodies and suspensions given as matrices or as parts, are run from
their case tables; modes, motion, forces on the ground, energies, operations and run-up are held
against an independent truth in 50 digits (`exact_response.py`). At most 1 % of the estimates are
below a tenth of the true error, at most 5 % above a thousand times of it. An error below a quarter
of a last place counts as one of that size: nothing but luck makes it smaller. Energies that are
nothing but round-off are compared by their roots, as amplitudes are.
"""

import copy
from collections.abc import Iterator

import mpmath
import numpy as np
import pytest
from exact_response import response_results
from random_machines import Table
from response_machines import random_compressor
from truth_report import DIGITS, UNIT, Judged

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

MOST_TOO_LOW, MOST_TOO_HIGH = 0.01, 0.05
#: of the range of a peak over the phases there is no truth here; numbers of modes are no estimates
WITHOUT_TRUTH = ("peak_low", "peak_high", "nearest_order", "masked/")


def too_high(one: Judged) -> bool:
    """Above a thousand times the true error."""
    nothing = "_energy" in one.path and one.size < one.estimate
    factor = 1e6 if nothing else 1e3
    met = one.error == one.size == 0.0
    return not met and one.estimate > factor * max(one.error, 0.25 * UNIT * one.size)


def judge_response(table: Table) -> Iterator[Judged]:
    """Every result below `response/` of a run next to the truth."""
    case = validate(copy.deepcopy(table))
    assert check_machine(case) == []
    record, seen = run_case(case), set()
    with mpmath.workdps(DIGITS):
        for path, values, exact in response_results(case, record):
            truth = np.array(exact, dtype=object)
            assert truth.shape == values.shape, path
            off = max(map(abs, np.ravel(truth - values).tolist()), default=0)
            size = max(map(abs, np.ravel(truth).tolist()), default=0)
            seen.add(path)
            yield Judged(path, float(off), record[path].error_estimate, float(size))
    paths = {path for path in record if path.startswith("response/")}
    unreported = {path for path in paths - seen if not any(part in path for part in WITHOUT_TRUTH)}
    assert not unreported, f"no truth for {sorted(unreported)}"


def shortened(seed: int) -> Table:
    """A random machine with few orders; every third with operations, every sixth with a run-up."""
    table = random_compressor(seed)
    table["accuracy"]["rtol"] = max(table["accuracy"]["rtol"], 1e-9)
    response = table["response"]
    if seed % 6:
        del response["run_up"]
    if seed % 3:
        del response["operations"]
        response.pop("balances", None)
    else:
        del response["operations"][2:]
    return table


def hold(judged: list[Judged]) -> None:
    low = [one for one in judged if one.too_low]
    high = [one for one in judged if too_high(one)]
    print(f"{len(judged)} estimates, {len(low)} too low, {len(high)} too high")
    assert len(low) <= MOST_TOO_LOW * len(judged), low
    assert len(high) <= MOST_TOO_HIGH * len(judged), high


@pytest.mark.long
def test_estimates_of_fifteen_machines() -> None:
    judged = [one for seed in range(15) for one in judge_response(shortened(seed))]
    assert len(judged) > 15 * 24
    assert sum(one.error > 0.0 for one in judged) > 0.95 * len(judged)
    assert [one for one in judged if one.error > one.estimate == 0.0] == []
    hold(judged)


@pytest.mark.long
def test_estimates_of_three_hundred_machines() -> None:
    hold([one for seed in range(400, 700) for one in judge_response(shortened(seed))])


@pytest.mark.long
@pytest.mark.timeout(14000)
def test_estimates_of_two_hundred_machines() -> None:
    judged = [one for seed in range(100, 300) for one in judge_response(random_compressor(seed))]
    hold(judged)
