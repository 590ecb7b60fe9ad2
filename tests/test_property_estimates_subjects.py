"""Claim: error estimates of absorbers, plates and rolls are honest, and tolerances kept or said.

Seeded random machines are run from their case tables and held against the truth of each result:
primaries with one or more absorbers, given or tuned by every norm and kind, against 50 digits
(`truth_absorber.py`); plates, from amplitudes with phases or from levels that contradict each other
a little, against 40 digits (`truth_measurement.py`); one to four cylinders that roll, free and on
mounts, with every motor curve and interpolation, against 20 Gauss points on each panel, whose own
error 24 tell (`truth_roll.py`) and which are themselves held against DOP853 here. At most 1 % of
the estimates are below a tenth of the true error, at most 5 % above a thousand times of it. One
machine that is refused (exit 3) is no wrong one.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
import pytest
from estimate_counts import Reported, broken_promises, hold, reported_or_refused
from exact_roll import exact_harmonics, exact_turn
from random_absorbers import random_absorber
from random_machines import Table
from random_plates import random_measured_plate
from random_rolls import random_roll
from truth_absorber import judge_absorber
from truth_measurement import judge_plate
from truth_roll import judge_roll, truth_of

from vibecalc.core.case.load import validate
from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.model import build_roll, roll_drive


class Subject(NamedTuple):
    """What draws and judges its machines; seeds of the quick test, and estimates it has at least.

    `broken` is the share of estimates beyond the tolerance, of which nothing was said.
    """

    draw: Callable[[int], Table]
    judge: Callable[[Table], Reported]
    few: tuple[int, ...]
    least: int
    broken: float = 0.0


def small_plate(seed: int) -> Table:
    """A plate with a coarse map."""
    plate = random_measured_plate(seed)
    plate["measurement"]["plate"]["points"] = 2
    return plate


SUBJECTS = {
    "absorber": Subject(random_absorber, judge_absorber, (6, 7, 9, 13, 17), 90),
    # 6: least squares of levels, whose sum of squares is flat at the end; 398: steps of rounding
    # along the phase that is free lengthened the motion
    "plate": Subject(small_plate, judge_plate, (6, 398), 60),
    "roll": Subject(random_roll, judge_roll, (14,), 50, broken=0.001),
}


def reported_of(subject: Subject, seeds: Iterable[int]) -> list[Reported]:
    """The machines that run."""
    found = list(reported_or_refused((subject.draw(seed) for seed in seeds), subject.judge))
    reported = [one for one in found if isinstance(one, Reported)]
    print(f"{len(reported)} machines run, {len(found) - len(reported)} refused")
    return reported


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.long] * (n in ("plate", "absorber"))) for n in SUBJECTS],
)
def test_estimates_of_a_few_machines(name: str) -> None:
    subject = SUBJECTS[name]
    reported = reported_of(subject, subject.few)
    judged = [one for each in reported for one in each.judged]
    assert len(reported) == len(subject.few) and len(judged) > subject.least
    # the truth tells: its own noise is far below most estimates, but of what cancels to zero
    assert sum(one.noise <= 0.1 * one.estimate for one in judged) > 0.7 * len(judged)
    hold(judged, name)
    assert [one for each in reported for one in broken_promises(each)] == []


@pytest.mark.long
@pytest.mark.parametrize("name", SUBJECTS)
def test_estimates_of_three_hundred_machines(name: str) -> None:
    subject = SUBJECTS[name]
    if name == "plate":
        subject = subject._replace(draw=random_measured_plate)
    reported = reported_of(subject, range(100, 400))
    assert len(reported) > 280
    judged = [one for each in reported for one in each.judged]
    hold(judged, name)
    broken = [one for each in reported for one in broken_promises(each)]
    assert len(broken) <= subject.broken * len(judged), broken


@pytest.mark.long
def test_the_truth_of_a_roll_against_another_method() -> None:
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
