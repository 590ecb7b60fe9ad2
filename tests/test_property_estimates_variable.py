"""Claim: the error estimates of a shaft line with variable inertias are honest.

Seeded random engines (`random_line_studies.py`) with light to heavy pistons; the truth is the
motion by collocation in time with more orders, and multipliers from Chebyshev points
(`exact_variable_inertia.py`). At most 1 % of the estimates are below a tenth of the true error, at
most 5 % above a thousand times of it. A tolerance that is missed is said, an unstable line refused.
"""

import numpy as np
import pytest
from exact_variable_inertia import VariableTruth
from random_line_studies import random_variable_line
from scipy.integrate import solve_ivp
from study_inputs import StudyInputs
from study_report import StudyReport, hold
from truth_variable import judge_variable

from vibecalc.core.case.load import validate
from vibecalc.errors import NumericalFailure

#: with a range of speeds; one whose vibration turns as a whole for the most part
FEW = (3,)
MANY = range(100, 400)


@pytest.fixture(scope="module")
def few() -> list[StudyReport]:
    return [judge_variable(random_variable_line(seed)) for seed in FEW]


def test_estimates_against_truth(few: list[StudyReport]) -> None:
    assert sum(len(report.judged) for report in few) > 10 * len(FEW)
    assert [report.missing for report in few] == [[]] * len(FEW)
    hold(few)


def test_truth_returns_to_itself_in_time() -> None:
    """DOP853 over one cycle from the motion by collocation; small deviations by its multipliers."""
    line = VariableTruth(StudyInputs(validate(random_variable_line(3))))
    speed, n = line.inputs.speed, len(line.inputs.inertia)
    motion = line.motion(speed, 40, exact=True)
    turn = 1j * speed * motion.order[:, None]
    begin = np.concatenate([(turn**k * motion.angle).sum(axis=0).real for k in range(2)])
    period = line.inputs.cycle / speed
    crank = np.linspace(0.0, line.inputs.cycle, 400, endpoint=False)
    wave = np.exp(1j * crank[:, None] * motion.order)
    angle, fast, faster = ((wave @ (turn**k * motion.angle)).real for k in range(3))
    value, slope, _ = line.inertia(crank[:, None] + angle)
    taken = value * faster + 0.5 * slope * (speed + fast) ** 2 - line.gas(speed, crank)
    load = sum(
        share * taken[:, member].sum(axis=1).mean() / share.sum() for member, share in line.pieces
    )

    def rates(time: float, state: np.ndarray) -> np.ndarray:
        place = np.array([speed * time])
        own, bend, _ = (part[0] for part in line.inertia(place[:, None] + state[:n]))
        torque = line.gas(speed, place)[0] + load - 0.5 * bend * (speed + state[n:]) ** 2
        torque = torque - line.stiffness @ state[:n] - line.damping @ state[n:]
        return np.concatenate([state[n:], torque / own])

    end = solve_ivp(rates, (0.0, period), begin, method="DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
    size = np.abs(begin).max()
    assert np.abs(end - begin).max() < 1e-8 * size


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_estimates_of_three_hundred_lines() -> None:
    reports, refused = [], []
    for seed in MANY:
        try:
            reports.append(judge_variable(random_variable_line(seed)))
        except NumericalFailure as failure:
            refused.append((seed, str(failure)))
    judged = [one for report in reports for one in report.judged]
    low, high = (sum(getattr(one, which) for one in judged) for which in ("too_low", "too_high"))
    counts = f"{len(judged)} estimates, {low} too low, {high} too high"
    print(f"{len(reports)} lines, {len(refused)} refused: {counts}", refused)
    assert len(refused) <= 0.1 * len(MANY), refused
    assert [path for report in reports for path in report.missing] == []
    hold(reports)
