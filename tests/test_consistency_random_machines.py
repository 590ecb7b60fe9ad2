"""Claim: three hundred random machines on mounts do in every result what the equations of motion say.

Bodies of parts, gas, misfire, laws of mounts, stops, foundations, bases, points, run-ups: everything
at once, against the dense model of `dense_results.py`. Kept orders agree to 1e-9 of the size of a
result or the stated error; with as many orders as count the stated error covers what is left out.
"""

import copy

import pytest
from dense_results import Dense, compare
from long_but import long_but
from random_machines import mounted_machine

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case

SEEDS, USUAL = range(300), range(20)
#: paths, or their ends, that are not compared, and why
UNCOMPARED = {
    "speed": "the result at that speed is compared; the place of a flat maximum is no number",
    "kinematics/": "tested by themselves",
    "body/principal_axes": "signs are free",
    "run_up/maxima/": "but for the force at each place: what names order and mode",
    "response/masked/": "of undamped machines, which these are not",
    "response/modes/": "but for frequency, damping and shape: what names the nearest order",
}


def problems(seed: int, deep: bool) -> list[str]:
    """What a run of a random machine has wrong, or has and is not compared."""
    case = mounted_machine(seed)
    checked = validate(copy.deepcopy(case))
    assert not check_machine(checked)
    record = run_case(checked)
    expected = [*Dense(case, record, deep).values()]
    compared = {one.path for one in expected}
    left = [path for path in record if path not in compared and _said(path)]
    return [*filter(None, (compare(one, record) for one in expected)), *left]


def _said(path: str) -> bool:
    return not any(path.endswith(one) or one in path for one in UNCOMPARED)


@pytest.mark.parametrize("seed", long_but(SEEDS, *USUAL))
def test_results_are_those_of_the_equations_of_motion(seed: int) -> None:
    deep = seed not in USUAL or seed % 5 == 0
    assert problems(seed, deep) == []
