"""Claim: a start-up in a case is what the kernel computes, and ends in the periodic motion.

The steady state that the march of `roll_startup.toml` comes to is held against the collocation of
[response.roll], state by state and level by level. What the case asks for next to it (load, start
angles, a machine that does not start) is said in the result as in the kernel.
"""

import copy
from functools import cache
from typing import Any

import numpy as np
import pytest
from response_machines import run, shipped
from shipped_cases import result_of

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record, Result
from vibecalc.core.run.run import run_case
from vibecalc.roll.report.start_up import start_up as section

ROOT = "response/start_up"
CASE = "roll_startup"


def table(**start_up_options: Any) -> dict[str, Any]:
    """The shipped case without [response.roll] and start angles, with options of its own."""
    found = copy.deepcopy(shipped(CASE))
    del found["response"]["roll"], found["response"]["start_up"]["angles"]
    del found["response"]["start_up"]["start_within"]
    found["response"]["start_up"] |= start_up_options
    return found


def value(record: Record, path: str) -> Any:
    return record[f"{ROOT}/{path}"].values


@cache
def shipped_record() -> Record:
    return result_of(CASE).record


def test_the_shipped_start_settles_where_the_periodic_motion_is() -> None:
    record = shipped_record()
    assert value(record, "settled") == 1
    assert value(record, "running_speed") == pytest.approx(
        float(record["response/roll/speed"].values), rel=1e-5
    )
    cycle = record["response/roll/cycle/shell_acceleration"].values
    half = 0.5 * np.ptp(cycle)
    begin, size = value(record, "turn/begin"), value(record, "turn/shell_acceleration")
    steady = float(value(record, "time_to_steady"))
    assert np.all(np.abs(size[begin >= steady] / half - 1.0) < 0.023)
    assert abs(size[np.searchsorted(begin, steady) - 1] / half - 1.0) > 0.01
    since = np.sum((begin >= 0.4) & (begin < steady))
    assert value(record, "turns_to_steady") == since


@pytest.mark.long
def test_a_load_that_comes_on_lowers_the_speed_by_what_the_motor_slips() -> None:
    # late enough that the unloaded crank has come to the synchronous speed
    speed = value(run(table(duration=1.2, load={"time": [0.0, 0.5], "factor": [0.0, 1.0]})),
                  "load/speed")  # fmt: skip
    synchronous = 900.0 * 2.0 * np.pi / 60.0
    assert speed[0] == pytest.approx(synchronous, rel=1e-4)
    slip = synchronous - float(shipped_record()["response/roll/speed"].values)
    assert speed[0] - speed[1] == pytest.approx(slip, rel=1e-2)


def test_start_angles_part_what_starts_from_what_does_not() -> None:
    record = shipped_record()
    lower, upper = (value(record, f"start_angles/{end}") for end in ("lower", "upper"))
    starts = record[f"{ROOT}/start_angles/starts"]
    angle = starts.axes[0].values
    inside = np.zeros(len(angle), dtype=bool)
    for low, high in zip(lower, upper, strict=True):
        inside |= ((angle >= low) & (angle <= high)) | (angle + 2.0 * np.pi <= high)
    np.testing.assert_array_equal(inside, starts.values == 1)
    fraction = np.sum(upper - lower) / (2.0 * np.pi)
    assert value(record, "start_angles/fraction") == pytest.approx(fraction, rel=1e-12)
    assert "depend on the time allowed, 0.8 s" in " ".join(record.warnings)
    assert len(lower) == 2


@pytest.mark.parametrize(
    ("angle", "starts"), [pytest.param(3.0, 1, marks=pytest.mark.long), (2.85, 0)]
)
def test_a_start_within_such_an_interval_starts(angle: float, starts: int) -> None:
    """On both sides of its lower end, 2.922 rad, under load from the start on."""
    record = run(table(duration=0.8, crank_angle=angle, load=None))
    assert value(record, "started") == starts


def test_a_machine_that_does_not_start_is_a_result_and_said() -> None:
    data = table(duration=0.5, crank_angle=1.0, load=None)
    record = run(data)
    assert value(record, "started") == value(record, "settled") == 0
    assert value(record, "running_speed") == 0.0
    for name in ("time_to_speed", "time_to_steady", "turns_to_steady"):
        assert value(record, name) == np.inf
    assert any("does not start within 0.5 s" in words for words in record.warnings)
    assert any("rocks between crank angles" in words for words in record.warnings)
    assert f"{ROOT}/load/factor" not in record
    result = Result(
        name="rocks", case=data, case_toml="", case_toml_resolved="", case_sha256="",
        record=record, version="",
    )  # fmt: skip
    found = section(result)
    assert found is not None
    text = " ".join(" ".join(found.lines).split())
    assert "IT DOES NOT START within 0.5 s; it does not turn over" in text


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
