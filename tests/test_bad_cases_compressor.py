"""Claim: matrices, operations, joints, gas pressure and motor that cannot be are refused in words.

Each refusal stands at the key that says it; what is unlikely gets a sentence instead.
"""

import json
import tomllib
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refused import hold, problems_of, rows_with_messages, told, with_keys

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


WHOLE: dict[str, Any] = tomllib.loads(COMPRESSOR)


def data_of(change: str | dict[str, Any]) -> dict[str, Any]:
    """The compressor with the keys of a row."""
    return with_keys(WHOLE, change if isinstance(change, str) else json.dumps(change))


def compressor(change: str | dict[str, Any]) -> Case:
    return Case.model_validate(data_of(change))


@pytest.mark.parametrize("name", rows_with_messages("compressor", "allowed"))
def test_allowed(name: str) -> None:
    _, change = rows_with_messages("compressor", "allowed")[name]
    assert cross_check(data_of(change)) == []
    assert check_machine(compressor(change)) == []


@pytest.mark.parametrize(("apart", "refused"), [(1e-13, False), (3e-12, True)])
def test_symmetric_means_to_a_millionth_of_a_millionth(apart: float, refused: bool) -> None:
    changes = {"machine.mounts.stiffness_matrix.values[3][1]": 1e4 * (1.0 + 3.0 * apart)}
    assert bool(check_machine(compressor(changes))) is refused


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
        changes = {"machine.body.mass_matrix.values": values, "machine.crank_train": LIGHT}
        mass = check_machine(compressor(changes))
        stiffness = check_machine(compressor({"machine.mounts.stiffness_matrix.values": values}))
        assert bool(mass) is (verdict < 1), values
        assert bool(stiffness) is (verdict < 0), values
    assert seen == {-1, 0, 1}


LIGHT = {
    **WHOLE["machine"]["crank_train"],
    "piston_mass": 1e-3,
    "rod": {"mass": 1e-3, "crank_pin_to_mass_centre": 0.016},
}


def _refused(change: str) -> str:
    return told(problems_of(data_of(change)))


def _form(change: str) -> str:
    return told(cross_check(data_of(change)))


def _warned(change: str) -> str:
    case = compressor(change)
    assert check_machine(case) == []
    return "\n".join(machine_warnings(case))


#: beginning of the name, rows, and what makes the message
SORTS = (("", "refused", _refused), ("form: ", "form", _form), ("warned: ", "warned", _warned))
MESSAGES = {
    begin + name: lambda _, change=change, said=said: said(change)
    for begin, sort, said in SORTS
    for name, (_, change) in rows_with_messages("compressor", sort).items()
}


@pytest.mark.parametrize("name", MESSAGES)
def test_words_and_key(name: str, tmp_path: Path) -> None:
    hold("bad_cases_compressor", name, MESSAGES[name], tmp_path)
