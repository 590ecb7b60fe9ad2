"""Claim: advice of the report comes true: each change it names, run on its own, does what it says.

The truth is a run of each machine so changed, alone, and for some of them an independent
integration (`exact_roll`).
"""

import numpy as np
from roll_machines import SYNCHRONOUS, source_drive, source_machine
from shipped_cases import result_of

from vibecalc.roll.mechanism import RollMachine, as_batch
from vibecalc.roll.report.advice import parameter_words
from vibecalc.roll.running import running_state
from vibecalc.roll.sensitivity import altered, changes, parameters

ORDERS = np.arange(1, 11)
NAMES = ("first stage", "second stage")
MACHINE = as_batch(source_machine())
DRIVE = source_drive()
ONLY = (
    "response.roll.interpolations=false",
    "response.roll.classical=false",
    'response.roll.compare=["euler"]',
)


def changed(words: str, factor: float) -> RollMachine:
    row = next(row for row in parameters(MACHINE, NAMES) if parameter_words(row.name) == words)
    return altered(MACHINE, [(row, factor)])


def test_the_same_changes_written_into_the_case_bring_the_same() -> None:
    level = "response/roll/level/shell_acceleration"
    base = result_of("roll", *ONLY)
    train = base.case["machine"]["crank_train"]  # type: ignore[index]
    rotor = base.case["machine"]["rotor"]["inertia"]  # type: ignore[index]
    radius = train["crank_radius"]
    for word, factor, name, key, value in (
        ("more", 1.1, "crank_radius", "machine.crank_train.crank_radius", radius),
        ("less", 0.9, "rotor_inertia", "machine.rotor.inertia", rotor),
    ):
        found = base.record[f"response/roll/sensitivity/ten_percent_{word}"]
        assert found.error_estimate < 1e-6
        rows = [str(name) for name in found.axes[0].values]
        quiet = (*ONLY, "response.roll.sensitivity=false")
        moved = result_of("roll", *quiet, f"{key}={factor * value!r}")
        np.testing.assert_allclose(
            moved.record[level].values - base.record[level].values,
            found.values[rows.index(name)],
            atol=found.error_estimate + 1e-7,
        )


def test_the_stated_error_bounds_the_true_one() -> None:
    for points in (3, 4):
        found = changes(
            MACHINE, DRIVE, ORDERS, NAMES, (1.1,), points=points, started_at=SYNCHRONOUS
        )[0]
        fine = changes(MACHINE, DRIVE, ORDERS, NAMES, (1.1,), points=10, started_at=SYNCHRONOUS)[0]
        off = np.abs(found.value - fine.value)
        assert found.parameters == fine.parameters
        assert np.all(off <= found.error + fine.error) and np.max(off) > 1e-9


def test_a_change_that_leaves_no_running_state_is_lost_with_the_reason() -> None:
    # a demand of nine tenths of what the motor gives at most: with less motor it stalls
    need = running_state(MACHINE, DRIVE, rtol=1e-6, orders=2, started_at=SYNCHRONOUS).state.demand
    weak = MACHINE._replace(
        motor_scale=0.95**-1 * need.torque / need.breakdown, rotor_inertia=np.array([200.0])
    )
    more, less = changes(weak, DRIVE, (1, 2), NAMES, (1.1, 0.9), points=4, started_at=SYNCHRONOUS)
    assert "motor_torque" in more.parameters and "motor_torque" not in less.parameters
    assert dict(less.lost)["motor_torque"].startswith("no running state exists")
    assert len(less.parameters) + len(less.lost) == len(more.parameters) + len(more.lost)


def test_a_rod_that_would_not_reach_over_the_crank_is_lost_with_the_reason() -> None:
    short = MACHINE._replace(rod_length=np.array([1.05 * 0.0635]))
    more, less = changes(short, DRIVE, (1, 2), NAMES, (1.1, 0.9), points=4, started_at=SYNCHRONOUS)
    assert dict(more.lost).get("crank_radius") == "the rod is too short for the crank"
    assert dict(less.lost).get("rod_length") == "the rod is too short for the crank"
    assert "rotor_inertia" in more.parameters
