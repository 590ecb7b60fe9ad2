"""Claim: a machine that does not start says what it lacks; one that stands still moves nothing."""

from typing import Any

import pytest
from test_consistency_start_up_stage import table, value

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.run import run_case

PEAKS = ("shell_angle", "shell_acceleration", "rotor_acceleration", "crank_speed", "mount_torque")
FULL, EMPTY = {"time": [0.0], "factor": [1.0]}, {"time": [0.0], "factor": [0.0]}


def start(torque: float, load: Any, angle: float = 0.0, friction: float = 0.0) -> Record:
    """The shipped machine with this torque, in N m, at standstill."""
    data = table(duration=0.2, load=load, crank_angle=angle)
    data["machine"]["motor"]["slip_table"]["torque"][-1] = torque
    data["machine"]["motor"]["slip_table"]["torque"][-2] = 0.5 * torque
    if friction:
        data["machine"]["friction"] = {"torque": friction}
    return run_case(validate(data))


def reason(record: Record) -> str:
    assert value(record, "started") == 0
    (words,) = [text for text in record.warnings if "does not start" in text]
    return words


@pytest.mark.parametrize("load", [EMPTY, FULL])
def test_no_torque_at_standstill(load: Any) -> None:
    """At top dead centre the gas turns nothing either: what rounding leaves there is zero."""
    record = start(0.0, load)
    assert "the motor gives no torque at standstill" in reason(record)
    for name in PEAKS:
        assert value(record, f"{name}_peak") == 0.0 and value(record, f"{name}_peak_time") == 0.0
        assert 0.0 < record[f"response/start_up/{name}_peak"].error_estimate < 1e-6


def test_the_gas_is_stronger_than_the_locked_rotor() -> None:
    words = reason(start(54.2, FULL, angle=2.0))
    assert "it rocks between" in words
    assert "the motor's 54.2 N*m at standstill are no more than the 1197 N*m" in words


def test_friction_holds_it() -> None:
    record = start(5.42, EMPTY, friction=100.0)
    assert "held by friction at crank angle 0 degrees, where the motor gives 5.42" in reason(record)
    assert value(record, "motor_torque_peak") == pytest.approx(5.42, rel=1e-9)
    assert all(value(record, f"{name}_peak") == 0.0 for name in PEAKS)


def test_what_moves_is_no_rounding() -> None:
    record = start(542.0, EMPTY)
    assert all(value(record, f"{name}_peak") > 0.0 for name in PEAKS)
