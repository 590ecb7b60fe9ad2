"""Claim: a dynamic motor that cannot be, or cannot be followed as asked, is refused in words."""

import copy
import tomllib
from typing import Any

import numpy as np
import pytest
from refused import refusals, said_of, with_keys

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import validate
from vibecalc.core.case.raw import set_key
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.errors import CaseError, NumericalFailure, Problem
from vibecalc.excitation.induction_motor import InductionMotor, steady_torque
from vibecalc.roll.model import fitted_motor

ROLL = tomllib.loads(starter("roll"))

MOTOR = {"kind": "dynamic", "poles": 6, "voltage": "400 V", "stator_resistance": "50 mohm"}
TWO = InductionMotor(
    314.0, 3, 330.0, 0.05, 0.001, 0.03, np.array([0.06, 0.4]), np.array([3e-3, 2e-3])
)


def data_of(**changes: Any) -> dict[str, Any]:
    data = copy.deepcopy(ROLL)
    data["machine"]["motor"] |= MOTOR
    for key, value in changes.items():
        set_key(data, key.replace("__", "."), value)
    return data


def problems(**changes: Any) -> list[Problem]:
    return check_machine(validate(data_of(**changes)))


def test_the_motor_is_fine() -> None:
    for cages in ("single", "double", "triple"):
        case = validate(data_of(machine__motor__cages=cages))
        assert check_machine(case) == []
        assert machine_warnings(case) == []


@pytest.mark.parametrize(("kind", "change", "place", "words"), refusals("roll", "dynamic"))
def test_refused(kind: str, change: str, place: str, words: list[str]) -> None:
    (problem,) = check_machine(validate(with_keys(data_of(), change)))
    assert ".".join(map(str, problem.path)) == place
    for word in words:
        assert word in said_of(problem), word


def test_no_more_than_there_are_cages() -> None:
    with pytest.raises(CaseError) as caught:
        validate(data_of(machine__motor__cages="quadruple"))
    assert "'triple'" in str(caught.value.problems[0].allowed)


def test_a_line_of_forty_hertz_gets_a_sentence() -> None:
    (text,) = machine_warnings(validate(data_of(machine__motor__poles=4)))
    assert "4 poles" in text and "33.33 Hz" in text


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
        found = problems(machine__motor__stator_resistance=0.4, machine__motor__slip_table=table)
        assert [one.path[-1] for one in found] == ["stator_resistance"] * refused


def test_more_cages_than_the_table_knows() -> None:
    """The table of two cages leaves a third one open, and the transients with it."""
    slip = np.array([0.0, 0.5, 1.0, 2.0, 4.0, 7.0, 12.0, 20.0, 40.0, 70.0, 104.0])
    table = {"slip": slip.tolist(), "torque": [0.0, *steady_torque(TWO, slip[1:]).value.tolist()]}
    more = {"machine__motor__slip_table": table, "machine__motor__voltage": 330.0 * np.sqrt(1.5)}
    more["machine__motor__synchronous_speed"] = 314.0 / 3.0
    good = validate(data_of(**more)).machine.motor
    assert good is not None
    fitted = fitted_motor(good)
    assert fitted is not None and fitted.fit.worst_relative < 1e-9
    three = validate(data_of(**more, machine__motor__cages="triple")).machine.motor
    assert three is not None
    with pytest.raises(NumericalFailure, match="does not settle the parameters of a triple cage"):
        fitted_motor(three)
