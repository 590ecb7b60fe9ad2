"""Claim: what Herold (1977), section 6.5, says of mounts comes out, with mounts of our choice.

He has the first harmonic rise from 4.3 to 7.2 dB ("72." in the text at hand), the others hardly
change, and valid levels after twenty to thirty turns only, whatever the period of the crank says.
"""

from functools import cache

import numpy as np
import pytest
from roll_machines import RPM, SHELL, source_drive, source_machine
from scipy.optimize import brentq
from shipped_cases import result_of

from vibecalc.roll.mechanism import as_batch
from vibecalc.roll.running import running_state
from vibecalc.roll.start_up import start_up
from vibecalc.roll.turn import harmonics, readings

CASE = "roll_mounted"
RATIO = 0.05


@cache
def levels(stiffness: float, ratio: float = RATIO) -> np.ndarray:
    """Levels of the shell in dB on mounts of a stiffness and a damping ratio of the shell."""
    damping = 2.0 * ratio * np.sqrt(stiffness * SHELL)
    machine = as_batch(source_machine(shell_stiffness=stiffness, shell_damping=damping))
    turn = running_state(machine, source_drive(), rtol=1e-8, orders=10).state.turn
    shell = readings(machine, source_drive(), turn, pistons=False).shell_acceleration
    return 20.0 * np.log10(np.abs(harmonics(turn, shell, np.arange(1.0, 11.0))[0]))


def test_the_stiffness_of_the_case_is_solved_for() -> None:
    found = brentq(lambda k: levels(k)[0] - 7.2, 3e5, 5e5, xtol=1.0)
    record = result_of(CASE).record
    assert found == pytest.approx(389780.0, abs=1.0)
    assert float(record["find/mount_stiffness/value"].values) == pytest.approx(found, rel=1e-5)
    assert 2.0 * RATIO * np.sqrt(found * SHELL) == pytest.approx(769.05, abs=0.01)


def test_the_rise_is_that_of_the_printed_levels_too() -> None:
    """4.3 and 7.2 are rounded: a rise of 2.8 to 3.0 dB."""
    free = levels(0.0, 0.0)
    assert 2.8 <= levels(389780.0)[0] - free[0] <= 3.0


def test_72_db_cannot_be_meant() -> None:
    """72 dB: in resonance with the crank, at a fiftieth of our damping, the level is 44 dB."""
    resonant = max(levels(k, 1e-3)[0] for k in (1.32e6, 1.33e6, 1.34e6))
    assert resonant == pytest.approx(44.2, abs=0.2)


def test_only_the_first_harmonic_changes_significantly() -> None:
    change = levels(389780.0) - levels(0.0, 0.0)
    assert change[1] == pytest.approx(0.67, abs=0.01)
    assert change[2] == pytest.approx(0.28, abs=0.01)
    assert np.all(np.abs(change[3:]) < 0.2)
    assert np.all(change > 0.0)


def test_twenty_to_thirty_turns_until_the_levels_are_valid() -> None:
    record = result_of(CASE).record
    assert float(record["response/start_up/settled"].values) == 1
    assert 20 <= float(record["response/start_up/turns_to_steady"].values) <= 30


@pytest.mark.long
def test_the_period_of_the_crank_is_steady_long_before() -> None:
    """The source's criterion, one per cent of the period of a turn, is met at once."""
    machine = source_machine(shell_stiffness=389780.0, shell_damping=769.05)
    found = start_up(machine, source_drive(), duration=1.0, speed=900.0 * RPM, tolerance=1e-6)
    period, shaking = found.turns.period, found.turns.amplitude
    assert np.all(np.abs(np.diff(period[1:])) < 0.01 * period[2:])
    assert np.max(np.abs(np.diff(shaking[:6]))) > 0.04 * shaking[-1]
