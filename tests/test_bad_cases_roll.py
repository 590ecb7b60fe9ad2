"""Claim: a roll that cannot be is refused in words, at its line; what is unlikely gets a sentence.

The files of `bad_cases/` stand in `test_bad_cases.py` where their form is wrong, here where it is
their physics. The other rows change one place of a good case.
"""

import json
import tomllib
from typing import Any

import numpy as np
import pytest
from refused import problems_of, refusals, said_of, with_keys
from shipped_cases import judge

from vibecalc.cli.starters import starter
from vibecalc.core.case.load import resolve, validate
from vibecalc.core.case.rules import cross_check
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.core.run.targets import check_targets

ROLL = """
schema = 1
title = "two stages"
[machine]
kind = "compressor"
[machine.crank_train]
crank_radius = 0.05
rod_length = 0.23
piston_mass = 5.0
rod = { mass = 3.0, crank_pin_to_mass_centre = 0.07, inertia = 0.03 }
cylinders = [{ name = "1" }, { name = "2", crank_phase = "180 deg", reciprocating_mass = 4.0 }]
[machine.rotor]
inertia = 1.6
[machine.shell]
inertia = 85.0
[machine.friction]
torque = 1.0
[machine.motor]
kind = "slip_table"
synchronous_speed = "1000 rpm"
slip_table = { slip = [0, "24 rpm", "110 rpm", "1000 rpm"], torque = [0, 420, 870, 420] }
[response.roll]
"""
GOOD: dict[str, Any] = tomllib.loads(ROLL)
CONTROL: dict[str, Any] = tomllib.loads(starter("roll_control"))
DYNAMIC: dict[str, Any] = tomllib.loads(starter("roll"))
DYNAMIC["machine"]["motor"] |= {
    "kind": "dynamic",
    "poles": 6,
    "voltage": "400 V",
    "stator_resistance": "50 mohm",
}
GAS = {"crank_angle": [0.0, 1.0, 4.0, 2.0 * np.pi], "force": [8e3, 0.0, 0.0, 8e3]}
LINEAR = {"kind": "linear", "synchronous_speed": 100.0, "gain": 20.0}
PRESSURE = {"crank_angle": GAS["crank_angle"], "pressure": [5e5, 0.0, 0.0, 5e5]}


def data_of(change: str = "{}") -> dict[str, Any]:
    return with_keys(GOOD, change, GAS=GAS, LINEAR=LINEAR, PRESSURE=PRESSURE)


def sentences(change: str = "{}") -> list[str]:
    case = validate(data_of(change))
    assert check_machine(case) == []
    return machine_warnings(case)


def test_the_good_case_has_neither_problems_nor_warnings() -> None:
    assert cross_check(GOOD) == []
    assert problems_of(GOOD) == []
    assert sentences() == []


@pytest.mark.parametrize(("kind", "change", "place", "words"), refusals("roll", "fine"))
def test_fine_cases_stay_fine_when_resolved(
    kind: str, change: str, place: str, words: list[str]
) -> None:
    case = validate(data_of(change))
    assert check_machine(case) == []
    assert judge().is_valid(data_of(change))
    again = validate(resolve(case))
    assert again == case
    assert check_machine(again) == []


@pytest.mark.parametrize(
    ("kind", "change", "place", "words"), refusals("roll", "roll", "dynamic", "control")
)
def test_refused_at_its_key(kind: str, change: str, place: str, words: list[str]) -> None:
    base = {"roll": GOOD, "dynamic": DYNAMIC, "control": CONTROL}[kind]
    found = problems_of(with_keys(base, change, PRESSURE=PRESSURE))
    text = " ".join(said_of(problem) for problem in found)
    assert ".".join(map(str, found[0].path)) == place, text
    for expected in words:
        assert expected in text
    assert len({(p.path, p.message) for p in found}) == len(found)


@pytest.mark.parametrize(("kind", "change", "place", "words"), refusals("roll", "warned"))
def test_warned_of(kind: str, change: str, place: str, words: list[str]) -> None:
    assert any(words[0] in text for text in sentences(change)), sentences(change)


def test_a_full_model_without_delay_and_every_number_of_cages_are_fine() -> None:
    fine = {"response.control.full_model": True, "response.control.delay": 0.0}
    assert problems_of(with_keys(CONTROL, json.dumps(fine))) == []
    for cages in ("single", "double", "triple"):
        case = validate(with_keys(DYNAMIC, json.dumps({"machine.motor.cages": cages})))
        assert check_machine(case) == [] and machine_warnings(case) == []
    poles = with_keys(DYNAMIC, '{"machine.motor.poles": 4}')
    (text,) = machine_warnings(validate(poles))
    assert "4 poles" in text and "33.33 Hz" in text


def test_idle_cylinders_need_no_gas() -> None:
    key = "machine.crank_train.cylinders[0].gas_force"
    change = {key: "GAS", "excitation": {"working": ["1"]}}
    assert sentences(json.dumps(change)) == []


def test_a_plate_needs_readings_only_and_other_kinds_what_they_always_did() -> None:
    plate = {"schema": 1, "title": "plate", "machine": {"kind": "plate"}}
    case = validate(plate)
    (reported,) = check_machine(case)
    assert "[measurement]" in reported.found and reported.path == ("machine", "kind")
    assert machine_warnings(case) == []
    for kind in ("machine", "compressor"):
        found = problems_of({**plate, "machine": {"kind": kind}})
        assert sorted(problem.path for problem in found) == [
            ("machine", "crank_train"),
            ("machine", "speed"),
        ]
        assert all(problem.message.startswith("missing key '") for problem in found)
        assert all(problem.hint for problem in found)


@pytest.mark.parametrize(("kind", "limit", "place", "words"), refusals("roll", "limit"))
def test_limits_that_name_no_result_of_the_roll(
    kind: str, limit: str, place: str, words: list[str]
) -> None:
    data = data_of(
        '{"machine.crank_train.cylinders[0].gas_force": "GAS",'
        ' "response.roll": {"compare": ["dop853"], "interpolations": true}}'
    )
    case = validate({**data, "limit": [{"max": 1.0, **json.loads(limit)}]})
    assert check_machine(case) == []
    (problem,) = check_targets(case)
    for expected in words:
        assert expected in said_of(problem)
