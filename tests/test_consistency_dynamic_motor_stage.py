"""Claim: a run with a dynamic motor leaves out what has no running state, and refuses what no
circuit or table settles.
"""

import copy
import tomllib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from shipped_cases import result_of

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import set_key
from vibecalc.core.report.text import render_report
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.core.run.run import run_case
from vibecalc.errors import NumericalFailure
from vibecalc.excitation.induction_motor import InductionMotor, steady_torque
from vibecalc.roll.adapters import motor as roll_motor
from vibecalc.roll.mechanism import RollDrive, RollMachine
from vibecalc.roll.model import fitted_motor
from vibecalc.roll.results import MOTOR as ROOT
from vibecalc.roll.running import Running
from vibecalc.schema import Case

ROLL = tomllib.loads(starter("roll"))

MOTOR = {
    "kind": "dynamic",
    "poles": 6,
    "voltage": "400 V",
    "stator_resistance": "50 mohm",
    "cages": "double",
}


def case_of(**changes: Any) -> Case:
    data = copy.deepcopy(ROLL)
    data["machine"]["motor"] |= MOTOR
    for key, value in changes.items():
        set_key(data, key.replace("__", "."), value)
    return validate(data)


@pytest.mark.parametrize(
    "lost", ["steady torque of its motor", pytest.param("slip table", marks=pytest.mark.long)]
)
def test_what_only_transients_carry(lost: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the machine would do without them is left out where it does nothing, and that is said.

    (Such machines are among those of the kernels' tests.)
    """
    whole, shipped = roll_motor.running_state, result_of("roll_dynamic_motor")

    def reluctant(machine: RollMachine, drive: RollDrive, **rest: Any) -> Running:
        if (drive.circuit is None) == (lost == "slip table"):
            raise NumericalFailure("no running state exists")
        return whole(machine, drive, **rest)

    monkeypatch.setattr(roll_motor, "running_state", reluctant)
    found = run_case(case_of())
    names = {path.removeprefix(f"{ROOT}/") for path in found if path.startswith(ROOT)}
    kept, gone = ("static", "table") if lost == "slip table" else ("table", "static")
    assert f"{kept}_level" in names and f"{gone}_level" not in names
    assert "fit_change" not in names
    assert ("dynamics_change" in names) == ("cycle/static_slip" in names) == (kept == "static")
    assert "response/roll/level/shell_acceleration" in found and "curve" in names
    assert any(f"with the {lost} is left out: no running" in one for one in found.warnings)
    text = render_report(replace(shipped, record=found))
    assert "Motor with transients" in text


TWO = InductionMotor(
    314.0, 3, 330.0, 0.05, 0.001, 0.03, np.array([0.06, 0.4]), np.array([3e-3, 2e-3])
)


def test_the_limit_of_the_resistance() -> None:
    """A motor with resistance R alone behind its terminals gives V^2 / (4 R) at its best."""
    best = 0.0
    for inductance in (1e-6, 1e-5):
        for resistance in np.geomspace(0.01, 1.0, 60):
            motor = InductionMotor(
                100.0 * np.pi, 3, 400.0 * np.sqrt(2.0 / 3.0), 0.4, 0.0, 100.0,
                np.array([resistance]), np.array([inductance]),
            )  # fmt: skip
            best = max(
                best, float(np.max(steady_torque(motor, np.linspace(1.0, 104.0, 400)).value))
            )
    assert 0.98 * 400.0**2 / (4.0 * 0.4 * 104.7198) < best < 400.0**2 / (4.0 * 0.4 * 104.7197)
    slips = ROLL["machine"]["motor"]["slip_table"]["slip"]
    for share, refused in ((0.97, False), (1.03, True)):
        table = {"slip": slips, "torque": np.linspace(0.0, share * best, len(slips)).tolist()}
        found = check_machine(
            case_of(machine__motor__stator_resistance=0.4, machine__motor__slip_table=table)
        )
        assert [one.path[-1] for one in found] == ["stator_resistance"] * refused


def test_more_cages_than_the_table_knows() -> None:
    """The table of two cages leaves a third one open, and the transients with it."""
    slip = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 40.0, 70.0, 104.0])
    table = {"slip": slip.tolist(), "torque": [0.0, *steady_torque(TWO, slip[1:]).value.tolist()]}
    more = {"machine__motor__slip_table": table, "machine__motor__voltage": 330.0 * np.sqrt(1.5)}
    more["machine__motor__synchronous_speed"] = 314.0 / 3.0
    good = case_of(**more).machine.motor
    assert good is not None
    fitted = fitted_motor(good)
    assert fitted is not None and fitted.fit.worst_relative < 1e-9
    three = case_of(**more, machine__motor__cages="triple").machine.motor
    assert three is not None
    with pytest.raises(NumericalFailure, match="does not settle the parameters of a triple cage"):
        fitted_motor(three)
