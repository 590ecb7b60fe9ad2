"""Claim: a roll that cannot be is refused in words, at its line; what is unlikely gets a sentence.

The files of `bad_cases/` stand in `test_bad_cases.py` where their form is wrong, here where it is
their physics. The other rows change one place of a good case.
"""

import copy
import tomllib
from typing import Any

import jsonschema
import numpy as np
import pytest
from refused import problems_of

from vibecalc.core.case.load import resolve, validate
from vibecalc.core.case.raw import set_key
from vibecalc.core.case.rules import cross_check
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.core.run.plan import plan_case
from vibecalc.core.run.targets import check_targets
from vibecalc.errors import Problem
from vibecalc.json_schema import json_schema
from vibecalc.schema import Case

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
GAS = {"crank_angle": [0.0, 1.0, 4.0, 2.0 * np.pi], "force": [8e3, 0.0, 0.0, 8e3]}
LINEAR = {"kind": "linear", "synchronous_speed": 100.0, "gain": 20.0}
PRESSURE = {"crank_angle": GAS["crank_angle"], "pressure": [5e5, 0.0, 0.0, 5e5]}
BOUNDS = {"gain": {"lower": 1, "upper": 9}, "acceleration_feedback": {"lower": -1, "upper": 0}}


def data_of(**changes: Any) -> dict[str, Any]:
    """The good case with some places changed: `machine__rotor__inertia=2`; None takes one away."""
    data = copy.deepcopy(GOOD)
    for key, value in changes.items():
        *above, last = key.split("__")
        if value is None:
            table: Any = data
            for name in above:
                table = table[name]
            table.pop(last)
        else:
            cylinders = key.replace("cylinders__0", "cylinders[0]").replace("s__1", "s[1]")
            set_key(data, cylinders.replace("__", "."), copy.deepcopy(value))
    return data


def words_of(problems: list[Problem]) -> str:
    return "\n".join(
        f"{'.'.join(map(str, p.path))}: {p.message} | {p.found} | {p.allowed} | {p.hint}"
        for p in problems
    )


def sentences(**changes: Any) -> list[str]:
    case = validate(data_of(**changes))
    assert check_machine(case) == []
    return machine_warnings(case)


def test_the_good_case_has_neither_problems_nor_warnings() -> None:
    assert cross_check(GOOD) == []
    assert problems_of(GOOD) == []
    assert sentences() == []


FINE: list[dict[str, Any]] = [
    {"machine__motor": LINEAR},
    {"machine__crank_train__bore": 0.2, "machine__crank_train__gas_pressure": PRESSURE},
    {"machine__crank_train__cylinders__0__gas_force": GAS},
    {"excitation": {"working": ["1"]}},
    {"excitation": {"working": ["1"], "idle": "unloaded"}},
    {"response": {"start_up": {"duration": 2.0, "load": {"time": [0.0], "factor": [0.0]}}}},
    {"response": {"control": {"tune": BOUNDS, "gains": [1.0, 2.0], "target_speed": 90.0}}},
    {"response": {"start_up": {"duration": 2.0}}, "machine__shell__damping": 3.0},
    {"response": {"roll": {"compare": ["euler", "fourier"], "step": 1e-4, "points": 8}}},
    {"response": {"roll": {"started_at": 100.0}, "start_up": {"duration": 1.0}, "control": {}}},
    {"machine__motor__beyond": "hold", "machine__motor__interpolation": "parabola"},
    {
        "machine__motor__kind": "dynamic",
        "machine__motor__poles": 6,
        "machine__motor__voltage": 400,
        "machine__motor__stator_resistance": 0.05,
        "machine__motor__cages": "single",
    },
]


@pytest.mark.parametrize("number", range(len(FINE)))
def test_fine_cases_stay_fine_when_resolved(number: int) -> None:
    case = validate(data_of(**FINE[number]))
    assert check_machine(case) == []
    again = validate(resolve(case))
    assert again == case
    assert check_machine(again) == []


REFUSED: list[tuple[dict[str, Any], str, list[str]]] = [
    (
        {"machine__shell": None, "response__start_up": {"duration": 1.0}},
        "response.roll",
        ["[response.roll] and [response.start_up] need [machine.shell]", "inertia"],
    ),
    (
        {"machine__motor": {**LINEAR, "slip_table": GOOD["machine"]["motor"]["slip_table"]}},
        "machine.motor.slip_table",
        ["'linear' has no slip_table", "'slip_table' or 'dynamic'"],
    ),
    (
        {"machine__motor__kind": "slip_tabel"},
        "machine.motor.kind",
        ["unknown kind 'slip_tabel'", "did you mean 'slip_table'?"],
    ),
    (
        {"machine__motor__syncronous_speed": 3.0, "machine__motor__synchronous_speed": None},
        "machine.motor.syncronous_speed",
        ["did you mean 'synchronous_speed'?"],
    ),
    (
        {"machine__motor__gain": 0.0, "machine__motor__kind": "linear"},
        "machine.motor.gain",
        ["gain is out of range", "> 0 N*m*s/rad"],
    ),
    (
        {"excitation": {"working": ["1"], "orders": 4}},
        "excitation",
        ["[excitation] needs machine.speed", "which cylinders work, with working and idle alone"],
    ),
    ({"excitation": {}}, "excitation", ["[excitation] needs machine.speed"]),
    (
        {"excitation": {"working": ["1"]}, "isolation": {"model": "pitch"}},
        "isolation",
        ["[isolation] needs machine.speed", "a case of its own"],
    ),
    (
        {"response__energies": True},
        "response",
        ["[response] needs machine.speed", "[response] needs [machine.body]"],
    ),
    (
        {"machine__joints": {"wrist_pin": {"clearance": 1e-5, "stiffness": 1e8}}},
        "machine.joints",
        ["[machine.joints] needs machine.speed"],
    ),
    (
        {"excitation": {"working": ["3"]}},
        "excitation.working.0",
        ["no cylinder is named '3'"],
    ),
    (
        {"machine__crank_train__bore": 0.2},
        "machine.crank_train.bore",
        ["[response.roll] cannot use bore without gas_pressure"],
    ),
    (
        {"machine__crank_train__gas_pressure": PRESSURE},
        "machine.crank_train.gas_pressure",
        ["cannot use gas_pressure without bore", "gas_force for each cylinder"],
    ),
    (
        {
            "machine__crank_train__gas_interpolation": "parabola",
            "machine__crank_train__cylinders__0__gas_force": {
                "crank_angle": [0.0, 3.0, 2.0 * np.pi],
                "force": [1.0, 0.0, 1.0],
            },
        },
        "machine.crank_train.cylinders.0.gas_force",
        ["too few rows", "3 rows, with gas_interpolation = 'parabola'", "4 rows or more"],
    ),
    (
        {"machine__motor__slip_table": {"slip": [0, 1], "torque": [5, 9]}},
        "machine.motor.slip_table.torque.0",
        ["begin at slip 0 with torque 0", "5 N*m at slip 0 rad/s"],
    ),
    (
        {"machine__motor__slip_table": {"slip": [0, 1], "torque": [0, 0]}},
        "machine.motor.slip_table.torque",
        ["no torque at any slip"],
    ),
    (
        {"machine__motor__slip_table": {"slip": [], "torque": []}},
        "machine.motor.slip_table.slip",
        ["slip is empty", "torque is empty"],
    ),
    (
        {"machine__motor__slip_table": "curve.csv"},
        "machine.motor.slip_table",
        ["slip_table cannot be a text"],
    ),
    (
        {"response__roll": {"compare": ["rk4", "rk4"], "step": 1e-3}},
        "response.roll.compare.1",
        ["method 'rk4' stands twice"],
    ),
    (
        {"response__roll": {"compare": ["rk4"]}},
        "response.roll",
        ["euler and rk4 need their step"],
    ),
    (
        {"response__roll": {"method": "rk4", "step": 1e-9}},
        "response.roll.step",
        ["too many of them", "steps in a turn"],
    ),
    (
        {"response__roll": {"points": 64}},
        "response.roll.points",
        ["so many nodes in one panel", "1 to 32"],
    ),
    (
        {"response__roll": {"points": 8, "method": "shooting", "compare": ["fourier"]}},
        "response.roll.points",
        ["8 points for 10 orders"],
    ),
    (
        {"response__roll": {"points": 8, "method": "shooting"}},
        "response.roll.points",
        ["points is for the methods collocation and fourier", "method = 'shooting'"],
    ),
    (
        {"response__roll": {"started_at": 900.0}},
        "response.roll.started_at",
        ["more than twice its synchronous speed", "'900 rpm'"],
    ),
    (
        {"response__roll": {"started_at": 100.0}, "machine__shell__stiffness": 3.0},
        "response.roll.started_at",
        ["mounts of 3 N*m/rad and 0 N*m*s/rad"],
    ),
    (
        {"response": {"roll": {}}, "machine__shell__damping": 3.0},
        "machine.shell.damping",
        ["damping alone lets the shell drift", "together with a stiffness"],
    ),
    (
        {"response": {"control": {"full_model": True}}, "machine__shell__damping": 3.0},
        "machine.shell.damping",
        ["damping alone lets the shell drift"],
    ),
    (
        {"response": {"start_up": {"duration": 1.0, "load": {"time": [1.0], "factor": [1.0]}}}},
        "response.start_up.load.time.0",
        ["time has to begin at 0", "1 s in the first row"],
    ),
    (
        {"response": {"control": {"gains": [1.0, -2.0], "motor_gains": [0.0]}}},
        "response.control.motor_gains.0",
        ["motor_gains[0] is out of range", "gains[1] is out of range"],
    ),
    (
        {"response": {"control": {"tune": {**BOUNDS, "orders": [1, 2, 1]}}}},
        "response.control.tune.orders.2",
        ["order 1 stands twice"],
    ),
    (
        {"response": {"control": {"tune": {**BOUNDS, "gain_margin": "6 m"}}}},
        "response.control.tune.gain_margin",
        ["wrong dimension", "'6 m', a length", "a level, e.g. '104 dB'"],
    ),
    (
        {"response": {"control": {"gain": 0.5, "target_speed": 95.0}}},
        "response.control.target_speed",
        ["with a gain of 0.5 and a reference of 104.72 rad/s", "< 52.3599 rad/s"],
    ),
]


@pytest.mark.parametrize("number", range(len(REFUSED)))
def test_refused_at_its_key(number: int) -> None:
    changes, path, words = REFUSED[number]
    found = problems_of(data_of(**changes))
    text = words_of(found)
    assert ".".join(map(str, found[0].path)) == path, text
    for expected in words:
        assert expected in text
    assert len({(p.path, p.message) for p in found}) == len(found)


WARNED: list[tuple[dict[str, Any], str]] = [
    (
        {"machine__crank_train__cylinders__0__gas_force": GAS},
        "no gas acts in cylinder '2', unlike in the others",
    ),
    (
        {
            "machine__crank_train__cylinders__1__reciprocating_mass": 0.0,
            "machine__crank_train__rod": None,
        },
        "the piston of cylinder '2' has a mass of 0 kg",
    ),
    (
        {"machine__friction__torque": 880.0},
        "take about 880 N*m in the mean over a turn, and the motor gives 870 N*m at most",
    ),
    (
        {
            "machine__motor__slip_table": {"slip": [0, 3.0], "torque": [0, 420]},
            "machine__motor__beyond": "hold",
            "response": {"start_up": {"duration": 1.0}},
        },
        "ends at 3 rad/s: its last torque, 420 N*m, is held",
    ),
    (
        {
            "response": {
                "start_up": {"duration": 1.0, "load": {"time": [0.0, 4.0], "factor": [0, 1]}}
            }
        },
        "the load changes at 4 s, after the end of the start-up at 1 s",
    ),
    ({"response": {"start_up": {"duration": 1.0, "crank_angle": 90.0}}}, "'90 deg'?"),
    ({"response": None}, "[machine.motor] has no effect"),
    ({"response": None}, "[machine.shell] has no effect"),
    (
        {"response": None, "machine__crank_train__cylinders__0__gas_force": GAS},
        "the gas force of a cylinder has no effect",
    ),
]


@pytest.mark.parametrize("number", range(len(WARNED)))
def test_warned_of(number: int) -> None:
    changes, words = WARNED[number]
    assert any(words in text for text in sentences(**changes)), sentences(**changes)


def test_idle_cylinders_need_no_gas() -> None:
    gas = {"machine__crank_train__cylinders__0__gas_force": GAS}
    assert sentences(**gas, excitation={"working": ["1"]}) == []


def test_a_plate_needs_readings_only_and_other_kinds_what_they_always_did() -> None:
    plate = {"schema": 1, "title": "plate", "machine": {"kind": "plate"}}
    case = validate(plate)
    (reported,) = check_machine(case)
    assert "[measurement]" in reported.found and reported.path == ("machine", "kind")
    assert machine_warnings(case) == []
    for kind in ("generator", "compressor"):
        found = problems_of({**plate, "machine": {"kind": kind}})
        assert sorted(problem.path for problem in found) == [
            ("machine", "crank_train"),
            ("machine", "speed"),
        ]
        assert all(problem.message.startswith("missing key '") for problem in found)
        assert all(problem.hint for problem in found)


def test_a_misspelt_part_is_reported_once() -> None:
    data = {"schema": 1, "title": "t", "machine": {"kind": "compressor", "sped": 3.0}}
    data["machine"]["crank_train"] = GOOD["machine"]["crank_train"]  # type: ignore[index]
    found = problems_of(data)
    assert [problem.path for problem in found] == [("machine", "sped")]
    assert "did you mean 'speed'?" in found[0].hint


def test_nothing_is_planned_that_needs_a_speed() -> None:

    case: Case = validate(data_of(excitation={"working": ["1"]}))
    assert not {"kinematics", "excitation", "motor"} & {plan.name for plan in plan_case(case)}


JUDGE = jsonschema.Draft202012Validator(json_schema())


def test_the_json_schema_knows_the_kinds() -> None:
    """What a kind of machine or motor needs, and what does not go with it."""
    assert JUDGE.is_valid(GOOD)
    for changes in FINE:
        assert JUDGE.is_valid(data_of(**changes)), changes
    for changes in (
        {"machine__speed": 100.0},
        {"machine__crank_train": None},
        {"machine__motor": None},
        {"machine__kind": "generator"},
        {"machine__kind": "plate"},
        {"machine__motor__kind": "dynamic"},
        {"machine__motor__kind": None},
        {"machine__motor__gain": 3.0},
        {"machine__motor__synchronous_speed": None},
    ):
        data = data_of(**changes)
        assert problems_of(data), changes
        assert not JUDGE.is_valid(data), changes
    assert JUDGE.is_valid({"schema": 1, "title": "plate", "machine": {"kind": "plate"}})


TARGETS: list[tuple[dict[str, Any], list[str]]] = [
    (
        {"quantity": "response/roll/level/shell_acceleration", "where": {"order": 11}},
        ["asks for an order that", "found order = 11", "8, 9, 10", "orders of [response.roll]"],
    ),
    (
        {"quantity": "response/roll/method/level", "where": {"method": "dop583", "order": 1}},
        ["no method named 'dop583'", "'collocation', 'dop853'", "did you mean 'dop853'?"],
    ),
    (
        {
            "quantity": "response/roll/interpolation/level",
            "where": {"interpolant": "trigonometric", "order": 1},
        },
        ["no interpolant named 'trigonometric'", "'linear', 'parabola', 'cubic'"],
    ),
    (
        {"quantity": "response/roll/wall_force_peak", "where": {"cylinder": "3"}},
        ["no cylinder named '3'"],
    ),
    (
        {"quantity": "response/roll/classical/wall_force_peak"},
        ["this case does not compute", "no table of this case asks for it"],
    ),
    ({"quantity": "response/roll/speed", "max": "3 kg"}, ["does not fit", "an angular speed"]),
    (
        {"quantity": "response/roll/level/shell_acceleration", "max": "3 rad/s^2"},
        ["does not fit", "a level, e.g. '104 dB'"],
    ),
]


@pytest.mark.parametrize("number", range(len(TARGETS)))
def test_limits_that_name_no_result_of_the_roll(number: int) -> None:
    limit, words = TARGETS[number]
    data = data_of(
        machine__crank_train__cylinders__0__gas_force=GAS,
        response__roll={"compare": ["dop853"], "interpolations": True},
    )
    case = validate({**data, "limit": [{"max": 1.0, **limit}]})
    assert check_machine(case) == []
    (problem,) = check_targets(case)
    text = f"{problem.message} | found {problem.found} | {problem.allowed} | {problem.hint}"
    for expected in words:
        assert expected in text


def test_limits_of_a_plate_find_no_crank_train() -> None:
    plate = {"schema": 1, "title": "plate", "machine": {"kind": "plate"}}
    limit = {"quantity": "excitation/force", "where": {"order": 1}, "max": "1 N"}
    (problem,) = check_targets(validate({**plate, "limit": [limit]}))
    assert "no table of this case asks for it" in problem.hint
