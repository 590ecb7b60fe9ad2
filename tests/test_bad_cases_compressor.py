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
from refused import hold, problems_of, told

from vibecalc.core.case.rules import cross_check
from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.schema import Case

COMPRESSOR = """
schema = 1
title = "two cylinders"
[machine]
kind = "compressor"
speed = 361.0
[machine.crank_train]
axis = "z"
stroke_axis = "y"
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


PLAY = {"clearance": 4e-5, "stiffness": 1.75e8}
GAS = "machine__crank_train__gas_pressure"
PIN = "machine__joints__wrist_pin"
OPERATIONS = WHOLE["response"]["operations"]

REFUSED: dict[str, dict[str, Any]] = {
    "a cut series with the moment of a rod": {
        "machine__crank_train__rod__inertia": 2e-5,
        "kinematics": {"series": "truncated", "terms": 1},
    },
    "three at once": {
        "machine__body__mass_matrix__values__4__5": 0.06,
        "machine__mounts__stiffness_matrix__values__5__5": -1.0,
        f"{PIN}__clearance": 1.0,
    },
    "two of form at once": {
        "excitation__working": ["C"],
        "machine__motor__torque__order": [0, 0, 1],
    },
    "a sign that differs": {"machine__body__mass_matrix__values__4__5": 0.06},
    "many pairs": {
        "machine__mounts__stiffness_matrix__values__3": [1.0, 2.0, 3.0, 2600.0, 5.0, 6.0]
    },
    "no mass along y": {"machine__body__mass_matrix__values__1": [0.0] * 6},
    "negative stiffness about z": {"machine__mounts__stiffness_matrix__values__5__5": -1600.0},
    "coupled with nothing of its own": {"machine__mounts__stiffness_matrix__values__3__3": 0.0},
    "coupling as large as both": {
        "machine__mounts__damping_matrix": {
            # one direction is worse than all others: of equal ones the processor would choose
            "values": [[1.0 if i != j else 0.4 if i else 0.3 for i in range(6)] for j in range(6)],
            "units": ["N*s/m", "N*s", "N*m*s"],
        }
    },
    "an inertia that is none": {
        "machine__body__mass_matrix__values__4": [0.0, 0.0, 0.0, 0.0, 0.36, -0.24],
        "machine__body__mass_matrix__values__5": [0.0, 0.0, 0.0, 0.0, -0.24, 0.16],
    },
    "huge in SI only": {
        "machine__body__mass_matrix__units": ["Gg", "kg*m", "kg*m^2"],
        "machine__body__mass_matrix__values__0__0": 1e19,
    },
    "pistons heavier than the machine": {"machine__crank_train__piston_mass": 33.0},
    "nobody works": {"excitation__working": ["C"]},
    "capitals": {"excitation__balanced_for": ["A", "b"]},
    "one cylinder twice": {"response__operations__0__working": ["A", "B", "A"]},
    "a balance of strangers": {"response__balances__0__balanced_for": ["B", "Z"]},
    "joints of a stranger": {"machine__joints__cylinder": "Z"},
    "nothing weighs": {"response__operations": [{**each, "weight": 0.0} for each in OPERATIONS]},
    "torque on the body": {"excitation__driven_machine": "separate"},
    "no damping": {"machine__mounts__modal_damping": None},
    "a damping matrix of zeros": {
        "machine__mounts__modal_damping": None,
        "machine__mounts__damping_matrix": {"values": [[0.0] * 6] * 6},
    },
    "loss factor alone": {
        "machine__mounts__modal_damping": None,
        "machine__mounts__loss_factor": 0.1,
    },
    "angles that go back": {f"{GAS}__crank_angle": [0.0, 3.0, 2.0, 2.0 * np.pi]},
    "a jump": {f"{GAS}__crank_angle": [0.0, 3.0, 3.0, 2.0 * np.pi]},
    "ten degrees short": {f"{GAS}__crank_angle": ["0 deg", "90 deg", "270 deg", "350 deg"]},
    "degrees without their unit": {f"{GAS}__crank_angle": [0.0, 90.0, 270.0, 360.0]},
    "pressure that does not come back": {f"{GAS}__pressure": [9e5, 0.0, 0.0, 8e5]},
    "below vacuum": {f"{GAS}__pressure": [9e5, 0.0, -1.5e5, 9e5]},
    "an order twice": {"machine__motor__torque__order": [0, 2, 2]},
    "clearance as the stroke": {f"{PIN}__clearance": 0.0254},
    "bore in millimetres": {"machine__joints__bore": {"clearance": 0.05, "stiffness": 1e8}},
    "no clearance in a study": {"response__impact__clearances": [1e-5, 0.0]},
    "a clearance twice": {"response__impact__clearances": [1e-5, 2e-5, 1e-5]},
    "neighbours far apart": {"response__impact__perturbation": 4e-5},
    "too stiff": {f"{PIN}__stiffness": 2e18},
    "too soft": {f"{PIN}__stiffness": 1e4},
    "a damper for a spring": {f"{PIN}__contact_damping": 1e6},
    "a film of pitch": {f"{PIN}__film_damping": 1e8},
    "long steps": {
        "response__impact__method": "rk4",
        "response__impact__steps": 128,
        "response__impact__orders": 50,
    },
    "more orders than steps hold": {
        "response__impact__method": "rk4",
        "response__impact__steps": 400,
        "response__impact__orders": 200,
    },
    "a crank that creeps": {"machine__speed": 0.01},
    "days of impacts": {"response__impact__members": 10000, "response__impact__revolutions": 400},
    "days of fixed steps": {
        "response__impact__method": "rk4",
        "response__impact__steps": 1_000_000,
    },
    "no rod to be free": {
        "machine__joints__crank_pin": PLAY,
        "machine__crank_train__rod": None,
        "machine__crank_train__rotating_mass": 0.1,
    },
    "nothing on the pin": {
        "machine__joints__crank_pin": PLAY,
        "machine__crank_train__cylinders__0__reciprocating_mass": 0.01,
    },
    "a cylinder that stands": {"excitation__working": ["B"], "machine__joints__cylinder": "A"},
}


OTHER_MOUNTS = {"each": {"stiffness": 1e4}, "positions": [[0.1, 0.0, -0.2], [-0.1, 0.1, -0.2]]}
FORM: dict[str, dict[str, Any]] = {
    "mass and box": {"machine__body": {}},
    "block": {"machine__body__inertia_block": {}},
    "each": {"machine__mounts__each": {}},
    "bounded": {"machine__mounts": {**OTHER_MOUNTS, "damping_matrix": {}}},
    "no unit": {"machine__mounts__stiffness_matrix__units": ["N/m", "newton meter", "x"]},
    "far unit": {"machine__body__mass_matrix__units": ["kg", "kg*m", "kg*Ym^9/m^7"]},
    "isolation": {"isolation": {"model": "pitch"}},
    "no body": {"machine__body": None},
    "no joints": {"machine__joints": None},
    "no bore": {"machine__crank_train__bore": None},
    "columns": {f"{GAS}__pressure": [1.0] * 9},
    "no operation": {"response__operations": None},
    "balance twice": {"response__balances": [{"name": "x"}, {"name": "x"}]},
}


ALLOWED: list[dict[str, Any]] = [
    {"machine__crank_train__rod__inertia": 2e-5},
    {"kinematics": {"series": "truncated", "terms": 1}},
    # impacts alone need neither body nor mounts, nor gas
    {"machine__body": None, "machine__mounts": None, "response": {"impact": {}}},
    {"machine__crank_train__bore": None, "machine__crank_train__gas_pressure": None},
    # defaults written out, as a resolved case has them
    {
        "machine__body": None,
        "machine__mounts": None,
        "response": {"method": "direct", "energies": False, "impact": {}},
    },
    {"machine__body__inertia_products": [0.0, 0.0, 0.0]},
    # units of one's own, a rounding apart from symmetry, a free motion
    {"machine__mounts__stiffness_matrix__units": ["N/mm", "N", "lbf*in"]},
    {"machine__mounts__stiffness_matrix__values__4__0": -9000.000000001},
    {"machine__mounts__stiffness_matrix__values__5": [0.0] * 6},
    # a mass matrix need not be that of a mass and its inertia
    {
        "machine__body__mass_matrix__values__0": [35.0, 2.0, 0.0, 0.0, 0.0, 0.0],
        "machine__body__mass_matrix__values__1": [2.0, 37.0, 0.0, 0.0, 0.0, 0.0],
    },
    # the table may begin anywhere
    {f"{GAS}__crank_angle": ["-180 deg", "-90 deg", "90 deg", "180 deg"]},
    {"machine__motor__torque__order": [2, 0, 1]},
    {"excitation__working": ["B"]},
    {"machine__joints__crank_pin": PLAY, "machine__joints__bore": PLAY},
    {"response__impact__clearances": [1e-6, 1e-4], "response__impact__method": "euler"},
    {
        "machine__mounts": {
            "each": {"stiffness": 1e4, "damping": 5.0},
            "positions": [*OTHER_MOUNTS["positions"], [0.0, 0.2, 0.0]],
        }
    },
]


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


SI = ("N/m", "N", "N*m")

WARNED: dict[str, dict[str, Any]] = {
    "motor": {"excitation": None, "response__switching": None},
    "joints": {"response__impact": None},
    "gas": {"response__impact": None},
    "loss factor": {"machine__mounts__loss_factor": 0.1},
    "rod": {"machine__crank_train__rod__inertia": 5e-5},
}


def _form(changes: dict[str, Any]) -> str:
    return told(cross_check(data_of(**changes)))


def _warned(changes: dict[str, Any]) -> str:
    case = compressor(**changes)
    assert check_machine(case) == []
    return "\n".join(machine_warnings(case))


MESSAGES = {
    **{n: lambda _, row=row: told(problems_of(data_of(**row))) for n, row in REFUSED.items()},
    **{f"form: {name}": lambda _, row=row: _form(row) for name, row in FORM.items()},
    **{f"warned: {name}": lambda _, row=row: _warned(row) for name, row in WARNED.items()},
}


@pytest.mark.parametrize("name", MESSAGES)
def test_words_and_key(name: str, tmp_path: Path) -> None:
    hold("bad_cases_compressor", name, MESSAGES[name], tmp_path)
