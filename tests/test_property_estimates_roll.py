"""Claim: the error estimates of a rolling machine are honest, and the tolerance is kept or said.

Seeded random machines, one to four cylinders, free and on mounts, with every motor curve and
interpolation, other methods, slopes, spreads, are run from their case tables. Truth are 20 Gauss
points on each panel, whose own error 24 tell; the truth itself is held against DOP853 on formulas
of its own. At most 1 % of the estimates are below a tenth of the true error, at most 5 % above a
thousand times of it. One machine that is refused (exit 3) is no wrong one.
"""

import numpy as np
import pytest
from estimate_counts import Reported, broken_promises, hold, reported_or_refused
from exact_roll import exact_harmonics, exact_turn
from random_rolls import random_roll
from truth_roll import judge_roll, truth_of

from vibecalc.core.case.load import validate
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.model import build_roll, roll_drive

FEW = (14,)


def reported_of(seeds: range | tuple[int, ...]) -> list[Reported]:
    """The machines that run."""
    found = list(reported_or_refused((random_roll(seed) for seed in seeds), judge_roll))
    reported = [one for one in found if isinstance(one, Reported)]
    print(f"{len(reported)} machines run, {len(found) - len(reported)} refused")
    return reported


def test_estimates_of_a_few_machines() -> None:
    reported = reported_of(FEW)
    judged = [one for each in reported for one in each.judged]
    assert len(reported) == len(FEW)
    assert len(judged) > 50 * len(FEW)
    # the truth tells: its own noise is far below most estimates, but of what cancels to zero
    assert sum(one.noise < 0.1 * one.estimate for one in judged) > 0.7 * len(judged)
    hold(judged, "roll")
    assert [one for each in reported for one in broken_promises(each)] == []


@pytest.mark.long
def test_estimates_of_three_hundred_machines() -> None:
    reported = reported_of(range(100, 400))
    assert len(reported) > 280
    hold([one for each in reported for one in each.judged], "roll")
    broken = [one for each in reported for one in broken_promises(each)]
    assert len(broken) <= 0.001 * sum(len(each.judged) for each in reported), broken


@pytest.mark.long
def test_the_truth_against_another_method() -> None:
    """Free machines with a table: harmonics of the shell by DOP853 and by 20 points agree."""
    held = 0
    for seed in range(400, 440):
        table = random_roll(seed)
        machine = table["machine"]
        smooth = machine["crank_train"]["gas_interpolation"] == "linear"
        if (
            "stiffness" in machine["shell"]
            or machine["motor"]["kind"] != "slip_table"
            or not smooth
        ):
            continue
        parts = build_roll(validate(table))
        turn = exact_turn(
            as_batch(parts.machine), roll_drive(parts),
            started_at=table["response"]["roll"].get("started_at"), place=(0,),
        )  # fmt: skip
        found = truth_of(table)["response/roll/shell_acceleration"].values
        orders = np.arange(1.0, len(found) + 1)
        exact = exact_harmonics(turn, turn.shell_acceleration, orders)
        assert np.max(np.abs(found - exact)) <= 1e-9 * np.max(np.abs(exact)), seed
        held += 1
    assert held >= 4
