"""Claim: matrices, operations, joints, gas pressure and motor that cannot be are refused in words.

Each refusal stands at the key that says it; what is unlikely gets a sentence instead.
"""

import copy
import tomllib
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from refused import problems_of

from vibecalc.core.case.load import validate
from vibecalc.core.case.rules import cross_check
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.errors import CaseError, KeyPath, Problem
from vibecalc.parts.matrices import build_system
from vibecalc.schema import Case
from vibecalc.units import convert

FOLDER = Path(__file__).parent / "bad_cases"
MASS = ("machine", "body", "mass_matrix")
MOUNTS = ("machine", "mounts")
TRAIN = ("machine", "crank_train")
JOINTS = ("machine", "joints")
IMPACT = ("response", "impact")

COMPRESSOR = """
schema = 1
title = "two cylinders"
[machine]
kind = "compressor"
speed = 361.0
[machine.crank_train]
axis = "z"
stroke = "y"
crank_radius = 0.0127
rod_length = 0.060
piston_mass = 0.33
rod = { mass = 0.06, crank_pin_to_mass_centre = 0.016 }
bore = 0.041
cylinders = [
  { name = "A", position = -0.1 },
  { name = "B", position = -0.145, crank_phase = "180 deg" },
]
[machine.crank_train.gas_pressure]
crank_angle = ["0 deg", "90 deg", "270 deg", "360 deg"]
pressure = [9e5, 0, 0, 9e5]
[machine.body.mass_matrix]
values = [
  [36.0, 0.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 36.0, 0.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 36.0, 0.0, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.38, 0.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.34, -0.06],
  [0.0, 0.0, 0.0, 0.0, -0.06, 0.16],
]
[machine.mounts]
modal_damping = 0.03
[machine.mounts.stiffness_matrix]
values = [
  [2.3e5, 0.0, 0.0, 0.0, -9000.0, 0.0],
  [0.0, 2.4e5, 0.0, 1e4, 0.0, 0.0],
  [0.0, 0.0, 1.9e5, 0.0, 0.0, 0.0],
  [0.0, 1e4, 0.0, 2600.0, 0.0, 0.0],
  [-9000.0, 0.0, 0.0, 0.0, 3500.0, 0.0],
  [0.0, 0.0, 0.0, 0.0, 0.0, 1600.0],
]
[machine.motor]
rotor_diameter = 0.15
skew_angle = 0.035
torque = { order = [0, 1, 2], cosine = [-15.0, 7.0, 9.0], sine = [0.0, 1.0, 3.0] }
[machine.joints]
wrist_pin = { clearance = 4e-5, stiffness = 1.75e8, contact_damping = 17.5, film_damping = 17.5 }
[excitation]
driven_machine = "cancels_torque"
[response]
operations = [{ name = "both", working = ["A", "B"] }, { name = "A alone", working = ["A"] }]
balances = [{ name = "both", balanced_for = ["A", "B"] }]
switching = { between = ["both", "A alone"], run_down = 0.8, run_up = 0.4 }
[response.impact]
"""


def data_of(**changes: Any) -> dict[str, Any]:
    """The compressor with some keys changed: `machine__motor__torque__order=[..]`; None: away.

    Whole numbers in a key count entries of a list.
    """
    data: dict[str, Any] = copy.deepcopy(WHOLE)
    for key, value in changes.items():
        *tables, last = (int(part) if part.isdigit() else part for part in key.split("__"))
        table: Any = data
        for name in tables:
            table = table[name] if isinstance(name, int) else table.setdefault(name, {})
        if value is None:
            table.pop(last, None)
        else:
            table[last] = copy.deepcopy(value)
    return data


WHOLE: dict[str, Any] = tomllib.loads(COMPRESSOR)


def compressor(**changes: Any) -> Case:
    return Case.model_validate(data_of(**changes))


def words(problem: Problem) -> str:
    return " | ".join((problem.message, problem.found, problem.allowed, problem.hint))


def test_the_compressor_has_neither_problems_nor_warnings() -> None:
    assert cross_check(data_of()) == []
    assert check_machine(compressor()) == []
    assert machine_warnings(compressor()) == []


PLAY = {"clearance": 4e-5, "stiffness": 1.75e8}
ANGLES = [0.0, 2.0, 4.0, 2.0 * np.pi]
GAS = "machine__crank_train__gas_pressure"
PIN = "machine__joints__wrist_pin"
OPERATIONS = WHOLE["response"]["operations"]

REFUSED: list[tuple[str, dict[str, Any], KeyPath, list[str]]] = [
    (
        "a sign that differs",
        {"machine__body__mass_matrix__values__4__5": 0.06},
        (*MASS, "values", 4, 5),
        ["mass matrix is not symmetric", "row 5, column 6: 0.06 kg*m^2; row 6, column 5: -0.06"],
    ),
    (
        "many pairs",
        {"machine__mounts__stiffness_matrix__values__3": [1.0, 2.0, 3.0, 2600.0, 5.0, 6.0]},
        (*MOUNTS, "stiffness_matrix", "values", 0, 3),
        ["row 1, column 4: 0 N; row 4, column 1: 1 N", "and 2 more pairs"],
    ),
    (
        "no mass along y",
        {"machine__body__mass_matrix__values__1": [0.0] * 6},
        (*MASS, "values", 1, 1),
        ["y has a mass of zero", "row 2, column 2: 0 kg", "above zero"],
    ),
    (
        "negative stiffness about z",
        {"machine__mounts__stiffness_matrix__values__5__5": -1600.0},
        (*MOUNTS, "stiffness_matrix", "values", 5, 5),
        ["rz has a stiffness of less than zero", "-1600 N*m", "zero or more"],
    ),
    (
        "coupled with nothing of its own",
        {"machine__mounts__stiffness_matrix__values__3__3": 0.0},
        (*MOUNTS, "stiffness_matrix", "values", 3, 1),
        ["rx has no stiffness of its own, but one with y", "column 2: 10000 N", "whole row"],
    ),
    (
        "coupling as large as both",
        {
            "machine__mounts__damping_matrix": {
                "values": [[1.0 if i != j else 0.5 for i in range(6)] for j in range(6)],
                "units": ["N*s/m", "N*s", "N*m*s"],
            }
        },
        (*MOUNTS, "damping_matrix", "values"),
        ["some motion has a negative damping", "dissipated power of -", " W in ", "rad/s"],
    ),
    (
        "an inertia that is none",
        {
            "machine__body__mass_matrix__values__4": [0.0, 0.0, 0.0, 0.0, 0.36, -0.24],
            "machine__body__mass_matrix__values__5": [0.0, 0.0, 0.0, 0.0, -0.24, 0.16],
        },
        (*MASS, "values"),
        ["some motion has no mass", "kinetic energy of 0 J in ry = 0.6667 rad/s, rz = 1 rad/s"],
    ),
    (
        "huge in SI only",
        {
            "machine__body__mass_matrix__units": ["Gg", "kg*m", "kg*m^2"],
            "machine__body__mass_matrix__values__0__0": 1e19,
        },
        (*MASS, "values", 0, 0),
        ["too far from 1 to compute with", "1e+19 Gg, 1e+25 in SI", "1e+20"],
    ),
    (
        "pistons heavier than the machine",
        {"machine__crank_train__piston_mass": 33.0},
        MASS,
        ["weigh more than the whole machine", "36 kg, with 66"],
    ),
    (
        "nobody works",
        {"excitation__working": ["C"]},
        ("excitation", "working", 0),
        ["no cylinder is named 'C'", "'A', 'B'"],
    ),
    (
        "capitals",
        {"excitation__balanced_for": ["A", "b"]},
        ("excitation", "balanced_for", 1),
        ["no cylinder is named 'b'", "did you mean 'B'?"],
    ),
    (
        "one cylinder twice",
        {"response__operations__0__working": ["A", "B", "A"]},
        ("response", "operations", 0, "working", 2),
        ["cylinder 'A' stands twice in working", "each cylinder once"],
    ),
    (
        "a balance of strangers",
        {"response__balances__0__balanced_for": ["B", "Z"]},
        ("response", "balances", 0, "balanced_for", 1),
        ["no cylinder is named 'Z'"],
    ),
    (
        "joints of a stranger",
        {"machine__joints__cylinder": "Z"},
        (*JOINTS, "cylinder"),
        ["no cylinder is named 'Z'", "'A', 'B'"],
    ),
    (
        "nothing weighs",
        {"response__operations": [{**each, "weight": 0.0} for each in OPERATIONS]},
        ("response", "operations", 0, "weight"),
        ["no operation has a weight above zero"],
    ),
    (
        "torque on the body",
        {"excitation__driven_machine": "separate"},
        ("response", "switching"),
        [
            "without the torque of the masses on the body",
            "not linear in the acceleration of the crank",
        ],
    ),
    (
        "no damping",
        {"machine__mounts__modal_damping": None},
        MOUNTS,
        ["the body never settles", "modal_damping = 0.03"],
    ),
    (
        "a damping matrix of zeros",
        {
            "machine__mounts__modal_damping": None,
            "machine__mounts__damping_matrix": {"values": [[0.0] * 6] * 6},
        },
        MOUNTS,
        ["the body never settles"],
    ),
    (
        "loss factor alone",
        {"machine__mounts__modal_damping": None, "machine__mounts__loss_factor": 0.1},
        MOUNTS,
        ["a loss factor describes steady vibration at one frequency", "modal_damping, a damping_"],
    ),
    (
        "angles that go back",
        {f"{GAS}__crank_angle": [0.0, 3.0, 2.0, 2.0 * np.pi]},
        (*TRAIN, "gas_pressure", "crank_angle", 2),
        ["have to ascend", "171.887339 deg, then 114.591559 deg, in rows 2 and 3"],
    ),
    (
        "a jump",
        {f"{GAS}__crank_angle": [0.0, 3.0, 3.0, 2.0 * np.pi]},
        (*TRAIN, "gas_pressure", "crank_angle", 2),
        ["have to ascend", "each larger than the one before it"],
    ),
    (
        "ten degrees short",
        {f"{GAS}__crank_angle": ["0 deg", "90 deg", "270 deg", "350 deg"]},
        (*TRAIN, "gas_pressure", "crank_angle"),
        ["span one turn", "from 0 deg to 350 deg", "a last angle of 360 deg"],
    ),
    (
        "degrees without their unit",
        {f"{GAS}__crank_angle": [0.0, 90.0, 270.0, 360.0]},
        (*TRAIN, "gas_pressure", "crank_angle"),
        ["span one turn"],
    ),
    (
        "pressure that does not come back",
        {f"{GAS}__pressure": [9e5, 0.0, 0.0, 8e5]},
        (*TRAIN, "gas_pressure", "pressure"),
        ["after a turn", "900000 Pa (9 bar) in the first row, 800000 Pa (8 bar) in the"],
    ),
    (
        "below vacuum",
        {f"{GAS}__pressure": [9e5, 0.0, -1.5e5, 9e5]},
        (*TRAIN, "gas_pressure", "pressure", 2),
        ["pressure[2] is out of range", "-150000 Pa", ">= -100000 Pa"],
    ),
    (
        "an order twice",
        {"machine__motor__torque__order": [0, 2, 2]},
        ("machine", "motor", "torque", "order", 2),
        ["order 2 stands twice"],
    ),
    (
        "clearance as the stroke",
        {f"{PIN}__clearance": 0.0254},
        (*JOINTS, "wrist_pin", "clearance"),
        ["as large as the stroke", "0.0254 m", "'0.04 mm'"],
    ),
    (
        "bore in millimetres",
        {"machine__joints__bore": {"clearance": 0.05, "stiffness": 1e8}},
        (*JOINTS, "bore", "clearance"),
        ["as large as the stroke"],
    ),
    (
        "no clearance in a study",
        {"response__impact__clearances": [1e-5, 0.0]},
        (*IMPACT, "clearances", 1),
        ["clearances[1] is out of range"],
    ),
    (
        "a clearance twice",
        {"response__impact__clearances": [1e-5, 2e-5, 1e-5]},
        (*IMPACT, "clearances", 2),
        ["clearance 1e-05 stands twice"],
    ),
    (
        "neighbours far apart",
        {"response__impact__perturbation": 4e-5},
        (*IMPACT, "perturbation"),
        ["have parted already", "with a clearance of 4e-05 m"],
    ),
    (
        "too stiff",
        {f"{PIN}__stiffness": 2e18},
        (*JOINTS, "wrist_pin", "stiffness"),
        ["too stiff to be followed", "of a revolution", "<= 1.08e+18 N/m"],
    ),
    (
        "too soft",
        {f"{PIN}__stiffness": 1e4},
        (*JOINTS, "wrist_pin", "stiffness"),
        ["so soft that the piston's inertia pushes it in", ">= 2.15e+04 N/m"],
    ),
    (
        "a damper for a spring",
        {f"{PIN}__contact_damping": 1e6},
        (*JOINTS, "wrist_pin", "contact_damping"),
        ["the damper bears the contact alone", "<= 7.6e+05 N*s/m", "'0.1 lbf*s/in'"],
    ),
    (
        "a film of pitch",
        {f"{PIN}__film_damping": 1e8},
        (*JOINTS, "wrist_pin", "film_damping"),
        ["brings the parts to rest too fast", "<= 3.79e+06 N*s/m"],
    ),
    (
        "long steps",
        {
            "response__impact__method": "rk4",
            "response__impact__steps": 128,
            "response__impact__orders": 50,
        },
        (*IMPACT, "steps"),
        ["run away in a contact as stiff as this", ">= 201, or method = 'event_exact'"],
    ),
    (
        "more orders than steps hold",
        {
            "response__impact__method": "rk4",
            "response__impact__steps": 400,
            "response__impact__orders": 200,
        },
        (*IMPACT, "steps"),
        ["response.impact.steps hold", "response.impact.orders", "> 400 steps, or < 200 orders"],
    ),
    (
        "a crank that creeps",
        {"machine__speed": 0.01},
        ("machine", "speed"),
        ["followed over a whole revolution", "0.01 rad/s: about 8", "<= 200000 steps"],
    ),
    (
        "days of impacts",
        {"response__impact__members": 10000, "response__impact__revolutions": 400},
        IMPACT,
        ["would take too long", "steps per revolution of each run", "milliseconds, as estimated"],
    ),
    (
        "days of fixed steps",
        {"response__impact__method": "rk4", "response__impact__steps": 1_000_000},
        IMPACT,
        ["would take too long", "fewer members, revolutions, clearances or fixed steps"],
    ),
    (
        "no rod to be free",
        {
            "machine__joints__crank_pin": PLAY,
            "machine__crank_train__rod": None,
            "machine__crank_train__rotating_mass": 0.1,
        },
        (*JOINTS, "crank_pin"),
        ["needs a rod", "0 kg of rod"],
    ),
    (
        "nothing on the pin",
        {
            "machine__joints__crank_pin": PLAY,
            "machine__crank_train__cylinders__0__reciprocating_mass": 0.01,
        },
        (*JOINTS, "wrist_pin"),
        ["nothing has a mass on the piston's side", "'A'", "0.01 kg that move with the piston"],
    ),
    (
        "a cylinder that stands",
        {"excitation__working": ["B"], "machine__joints__cylinder": "A"},
        (*JOINTS, "cylinder"),
        ["stands still", "'A' is not in [excitation] working"],
    ),
]


@pytest.mark.parametrize(
    ("changes", "path", "expected"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED]
)
def test_refused(changes: dict[str, Any], path: KeyPath, expected: list[str]) -> None:
    problems = problems_of(data_of(**changes))
    assert len(problems) == 1, problems
    assert problems[0].path == path
    assert problems[0].allowed
    for word in expected:
        assert word in words(problems[0])


OTHER_MOUNTS = {"each": {"stiffness": 1e4}, "positions": [[0.1, 0.0, -0.2], [-0.1, 0.1, -0.2]]}
FORM: list[tuple[str, dict[str, Any], KeyPath, str]] = [
    ("mass and box", {"machine__body": {}}, ("machine", "body"), "needs mass or mass_matrix"),
    ("block", {"machine__body__inertia_block": {}}, ("machine", "body", "inertia_block"), "exclud"),
    ("each", {"machine__mounts__each": {}}, (*MOUNTS, "each"), "each and stiffness_matrix exclude"),
    ("bounded", {"machine__mounts": {**OTHER_MOUNTS, "damping_matrix": {}}},
     (*MOUNTS, "damping_matrix"), "needs stiffness_matrix"),
    ("no unit", {"machine__mounts__stiffness_matrix__units": ["N/m", "newton meter", "x"]},
     (*MOUNTS, "stiffness_matrix", "units", 1), "coupling block: wrong dimension"),
    ("far unit", {"machine__body__mass_matrix__units": ["kg", "kg*m", "kg*Ym^9/m^7"]},
     (*MASS, "units", 2), "rotation block: too far from SI"),
    ("isolation", {"isolation": {"model": "pitch"}}, ("isolation",), "not a mass_matrix"),
    ("no body", {"machine__body": None}, ("response",), "[response] needs [machine.body]"),
    ("no joints", {"machine__joints": None}, IMPACT, "needs [machine.joints]"),
    ("no bore", {"machine__crank_train__bore": None}, (*TRAIN, "gas_pressure"), "without bore"),
    ("columns", {f"{GAS}__pressure": [1.0] * 9}, (*TRAIN, "gas_pressure"), "not of one length"),
    ("no operation", {"response__operations": None}, ("response", "switching"), "there are none"),
    ("balance twice", {"response__balances": [{"name": "x"}, {"name": "x"}]},
     ("response", "balances", 1, "name"), "named 'x'"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "path", "expected"), [row[1:] for row in FORM], ids=[row[0] for row in FORM]
)
def test_form(changes: dict[str, Any], path: KeyPath, expected: str) -> None:
    found = [problem for problem in cross_check(data_of(**changes)) if problem.path == path]
    assert found and expected in found[0].message


MISSPELT: list[tuple[str, dict[str, Any]]] = [
    ("mass_matrx", {"machine__body__mass_matrix": None, "machine__body__mass_matrx": {}}),
    ("mas", {"machine__body": {"mas": 36.0, "inertia": [1.0, 1.0, 1.0]}}),
    ("bx", {"machine__body": {"mass": 36.0, "bx": {}}}),
    ("stifness_matrix", {"machine__mounts": {"stifness_matrix": {}}}),
]


@pytest.mark.parametrize(("key", "changes"), MISSPELT, ids=[row[0] for row in MISSPELT])
def test_a_misspelt_key_is_not_missed_as_well(key: str, changes: dict[str, Any]) -> None:
    with pytest.raises(CaseError) as caught:
        validate(data_of(**changes))
    assert [problem.path[-1] for problem in caught.value.problems] == [key]


ALLOWED: list[dict[str, Any]] = [
    # impacts alone need neither body nor mounts, nor gas
    {"machine__body": None, "machine__mounts": None, "response": {"impact": {}}},
    {"machine__crank_train__bore": None, "machine__crank_train__gas_pressure": None},
    # defaults written out, as a resolved case has them
    {"machine__body": None, "machine__mounts": None,
     "response": {"method": "direct", "energies": False, "impact": {}}},
    {"machine__body__inertia_products": [0.0, 0.0, 0.0]},
    # units of one's own, a rounding apart from symmetry, a free motion
    {"machine__mounts__stiffness_matrix__units": ["N/mm", "N", "lbf*in"]},
    {"machine__mounts__stiffness_matrix__values__4__0": -9000.000000001},
    {"machine__mounts__stiffness_matrix__values__5": [0.0] * 6},
    # a mass matrix need not be that of a mass and its inertia
    {"machine__body__mass_matrix__values__0": [35.0, 2.0, 0.0, 0.0, 0.0, 0.0],
     "machine__body__mass_matrix__values__1": [2.0, 37.0, 0.0, 0.0, 0.0, 0.0]},
    # the table may begin anywhere
    {f"{GAS}__crank_angle": ["-180 deg", "-90 deg", "90 deg", "180 deg"]},
    {"machine__motor__torque__order": [2, 0, 1]},
    {"excitation__working": ["B"]},
    {"machine__joints__crank_pin": PLAY, "machine__joints__bore": PLAY},
    {"response__impact__clearances": [1e-6, 1e-4], "response__impact__method": "euler"},
    {"machine__mounts": {**OTHER_MOUNTS, "each": {"stiffness": 1e4, "damping": 5.0}}},
]  # fmt: skip


@pytest.mark.parametrize("changes", ALLOWED)
def test_allowed(changes: dict[str, Any]) -> None:
    assert cross_check(data_of(**changes)) == []
    assert check_machine(compressor(**changes)) == []


@pytest.mark.parametrize(("apart", "refused"), [(1e-13, False), (3e-12, True)])
def test_symmetric_means_to_a_millionth_of_a_millionth(apart: float, refused: bool) -> None:
    key = "machine__mounts__stiffness_matrix__values__3__1"
    assert bool(check_machine(compressor(**{key: 1e4 * (1.0 + 3.0 * apart)}))) is refused


def exactly_definite(matrix: list[list[int]]) -> int:
    """1 positive definite, 0 semidefinite, -1 neither: elimination in whole fractions."""
    rows = [[Fraction(entry) for entry in row] for row in matrix]
    verdict = 1
    for place in range(len(rows)):
        pivot = rows[place][place]
        if pivot < 0 or (pivot == 0 and any(rows[place][place:])):
            return -1
        if pivot == 0:
            verdict = 0
            continue
        for below in range(place + 1, len(rows)):
            share = rows[below][place] / pivot
            rows[below] = [x - share * y for x, y in zip(rows[below], rows[place], strict=True)]
    return verdict


def test_definite_as_exact_arithmetic_says() -> None:
    """Small whole numbers: any negative energy is far above round-off."""
    rng = np.random.default_rng(7)
    seen = set()
    for number in range(100):
        rank = int(rng.integers(4, 8))
        factor = rng.integers(-2, 3, size=(6, rank))
        matrix = factor @ factor.T - int(number % 3 == 0) * np.eye(6, dtype=int)
        values = [[int(entry) for entry in row] for row in matrix]
        verdict = exactly_definite(values)
        seen.add(verdict)
        mass = check_machine(
            compressor(machine__body__mass_matrix__values=values, machine__crank_train=LIGHT)
        )
        stiffness = check_machine(compressor(machine__mounts__stiffness_matrix__values=values))
        assert bool(mass) is (verdict < 1), values
        assert bool(stiffness) is (verdict < 0), values
    assert seen == {-1, 0, 1}


LIGHT = {
    **WHOLE["machine"]["crank_train"],
    "piston_mass": 1e-3,
    "rod": {"mass": 1e-3, "crank_pin_to_mass_centre": 0.016},
}


def test_the_verdict_does_not_depend_on_the_units() -> None:
    units = ["lbf/in", "lbf", "lbf*in"]
    rng = np.random.default_rng(11)
    verdicts = []
    for _ in range(60):
        factor = rng.normal(size=(6, 6))
        matrix = 1e4 * (factor @ factor.T - 0.3 * np.eye(6))
        scale = [1.0 / convert(1.0, unit, si) for unit, si in zip(units, SI, strict=True)]
        written = matrix * np.array(
            [[scale[(i > 2) + (j > 2)] for j in range(6)] for i in range(6)]
        )
        found = [
            check_machine(compressor(machine__mounts__stiffness_matrix=table))
            for table in (
                {"values": matrix.tolist()},
                {"values": written.tolist(), "units": units},
            )
        ]
        reported = [[problem.message for problem in problems] for problems in found]
        assert reported[0] == reported[1]
        verdicts.append(bool(reported[0]))
    assert any(verdicts) and not all(verdicts)


SI = ("N/m", "N", "N*m")

WARNED: list[tuple[str, dict[str, Any], str]] = [
    ("motor", {"excitation": None, "response__switching": None}, "[machine.motor] has no effect"),
    ("joints", {"response__impact": None}, "[machine.joints] have no effect"),
    ("gas", {"response__impact": None}, "the gas pressure has no effect"),
    (
        "loss factor",
        {"machine__mounts__loss_factor": 0.1},
        "the loss factor counts as the damping ratio that it gives each mode at resonance",
    ),
    (
        "rod",
        {"machine__crank_train__rod__inertia": 5e-5},
        "5e-05 kg*m^2, more than the 4.224e-05 kg*m^2 of a rod whose material lies between",
    ),
]


@pytest.mark.parametrize(
    ("changes", "expected"), [r[1:] for r in WARNED], ids=[r[0] for r in WARNED]
)
def test_warned(changes: dict[str, Any], expected: str) -> None:
    case = compressor(**changes)
    assert check_machine(case) == []
    assert any(expected in text for text in machine_warnings(case))


def test_modal_damping_is_not_for_isolation() -> None:
    body = {"mass": 36.0, "inertia": [0.38, 0.34, 0.16]}
    mounts = {**OTHER_MOUNTS, "modal_damping": 0.02}
    mounts["positions"] = [[0.1, 0.0, -0.2], [-0.1, 0.1, -0.2], [-0.1, -0.1, -0.1]]
    case = compressor(
        machine__body=body,
        machine__mounts=mounts,
        isolation={"model": "rigid_body", "up": "y"},
    )
    assert check_machine(case) == []
    assert any("modal_damping counts in [response] only" in text for text in machine_warnings(case))


def test_all_problems_come_at_once() -> None:
    matrices = {
        "machine__body__mass_matrix__values__4__5": 0.06,
        "machine__mounts__stiffness_matrix__values__5__5": -1.0,
    }
    physics = problems_of(data_of(**matrices, machine__joints__wrist_pin__clearance=1.0))
    assert [problem.path[1] for problem in physics] == ["body", "mounts", "joints"]
    form = data_of(excitation__working=["C"], machine__motor__torque__order=[0, 0, 1])
    assert [problem.path[1] for problem in problems_of(form)] == ["motor", "working"]


EXTREMES = [0.0, -0.0, 5e-324, 1e-300, 1e-21, 1e-9, 1.0, -1.0, 1e9, 1e19, -1e19, 1e21, 1e308]


def leaves(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Key paths of all numbers of a case."""
    if isinstance(value, dict | list):
        entries = value.items() if isinstance(value, dict) else enumerate(value)
        return [leaf for key, entry in entries for leaf in leaves(entry, (*path, key))]
    return [path] if isinstance(value, float) else []


def test_extreme_numbers_are_refused_in_words_or_allowed() -> None:
    rng = np.random.default_rng(5)
    verdicts = [0, 0]
    with np.errstate(all="raise", under="ignore"):
        for _ in range(120):
            data = data_of(machine__crank_train__rod__inertia=1e-5, machine__joints__bore=PLAY)
            # most changes of one entry of a matrix only break its symmetry
            paths = [path for path in leaves(data) if "values" not in path or rng.random() < 0.1]
            for _ in range(int(rng.integers(1, 4))):
                *tables, last = paths[int(rng.integers(len(paths)))]
                table: Any = data
                for key in tables:
                    table = table[key]
                table[last] = float(rng.choice(EXTREMES))
            try:
                case = Case.model_validate(data)
            except ValidationError:
                continue
            problems = check_machine(case)
            assert all(problem.message and problem.allowed for problem in problems)
            verdicts[bool(problems)] += 1
            if not problems:
                assert all(isinstance(text, str) for text in machine_warnings(case))
                system = build_system(case.machine)
                assert np.isfinite(system.mass).all() and np.isfinite(system.stiffness).all()
    assert min(verdicts) > 10


NONSENSE: list[Any] = [None, True, 3, -1.5, "", "x.csv", "3 kg", [], [1], {}, [[]]]


def test_checks_of_form_raise_on_no_nonsense() -> None:
    """Every place of the case in turn is something else, or away."""
    whole = data_of(
        isolation={"model": "pitch", "run_up": {"from": 0, "to": 9}},
        reference_table=[
            {"quantity": "q", "axis": "a", "entry": [1], "value": ["1 N"], "unit": "N"}
        ],
    )

    def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
        entries: list[Any] = []
        if isinstance(value, dict | list):
            entries = list(value.items() if isinstance(value, dict) else enumerate(value))
        return [path, *(place for key, entry in entries for place in places(entry, (*path, key)))]

    checked = 0
    for *tables, last in filter(None, places(whole)):
        for value in NONSENSE:
            data = copy.deepcopy(whole)
            holder: Any = data
            for key in tables:
                holder = holder[key]
            if value is None:
                del holder[last]
            else:
                holder[last] = value
            problems = cross_check(data)
            assert all(problem.message for problem in problems)
            checked += 1
    assert checked > 1000


def test_a_cut_series_has_no_terms_for_the_moment_of_a_rod() -> None:
    changed = {"machine__crank_train__rod__inertia": 2e-5}
    cut = {"kinematics": {"series": "truncated", "terms": 1}}
    assert check_machine(compressor(**changed)) == []
    assert check_machine(compressor(**cut)) == []
    (problem,) = check_machine(compressor(**changed, **cut))
    assert problem.path == ("kinematics", "series")
    assert "no terms for the turning of the rod" in words(problem)
    assert problem.also == (*TRAIN, "rod", "inertia")
