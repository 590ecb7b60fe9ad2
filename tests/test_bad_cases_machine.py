"""Claim: a machine that cannot be is refused, at the key that says it, in words with numbers.

Unlikely machines get a sentence in the report instead.
"""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from crank_trains import GENERATOR, generator
from fuzzing import leaves, make_extreme
from pydantic import ValidationError
from refused import hold, told

from vibecalc.core.run.machine_checks import check_machine, machine_warnings
from vibecalc.parts.machine import build_machine
from vibecalc.schema import Case

FLAT = [[-0.4, -0.2, 0.0], [-0.4, 0.2, 0.0], [0.4, -0.2, 0.0], [0.4, 0.2, 0.0]]
RIGID: dict[str, Any] = {"isolation": {"model": "rigid_body"}}


REFUSED: dict[str, dict[str, Any]] = {
    "three at once": {
        "machine__crank_train__rod_length": 0.05,
        "machine__crank_train__stroke_axis": "x",
        "machine__body__box": None,
        "machine__body__inertia": [1.0, 1.0, 9.0],
    },
    "rod shorter than crank": {"machine__crank_train__rod_length": 0.055},
    "rod shorter with offset": {
        "machine__crank_train__rod_length": 0.065,
        "machine__crank_train__wrist_pin_offset": -0.006,
    },
    "rod as long as crank": {"machine__crank_train__rod_length": 0.06},
    "stroke along the shaft": {"machine__crank_train__stroke_axis": "x", "isolation": None},
    "truncated with offset": {
        "machine__crank_train__wrist_pin_offset": 0.004,
        "kinematics": {"series": "truncated", "terms": 1},
    },
    "nothing moves": {"machine__crank_train__reciprocating_mass": 0.0},
    "rod's mass centre outside": {
        "machine__crank_train__reciprocating_mass": None,
        "machine__crank_train__piston_mass": 0.3,
        "machine__crank_train__rod": {"mass": 0.5, "crank_pin_to_mass_centre": 0.25},
    },
    "grams as kilograms": {"machine__crank_train__reciprocating_mass": 400.0},
    "too heavy to compute": {"machine__crank_train__reciprocating_mass": 1e300},
    "too light to compute": {"machine__body__mass": 1e-300},
    "far mount": {"machine__mounts__positions": [[1e200, 0.0, 0.0]]},
    "angle without meaning": {
        "machine__crank_train__cylinders": [{"name": "1", "crank_phase": 1e18}]
    },
    "triangle inequality": {"machine__body__box": None, "machine__body__inertia": [1.0, 2.0, 6.5]},
    "products too large": {
        "machine__body__box": None,
        "machine__body__inertia": [2.0, 3.0, 4.0],
        "machine__body__inertia_products": [2.6, 0.0, 0.0],
    },
    "up is not the stroke": {"isolation__up": "y"},
    "free to pitch: mounts under the centre": {
        "machine__mounts__positions": [[0.0, -0.2, 0.0], [0.0, 0.2, 0.0]],
        "isolation__lever": 0.4,
    },
    "free to pitch: sideways stiffness only": {
        "machine__mounts__each": {"stiffness": [1e4, 1e4, 0.0]}
    },
    "ambiguous lever": {"machine__mounts__positions": [[-0.4, 0.0, 0.0], [0.3, 0.0, 0.0]]},
    "block moves the centre and the levers with it": {
        "machine__body__inertia_block": {
            "mass": 10.0,
            "box": {"length": 0.2, "width": 0.2, "height": 0.1},
            "position": [0.2, 0.0, 0.0],
        }
    },
}


def _refused(changes: dict[str, Any]) -> str:
    return told(check_machine(generator(**changes)))


def _free(stiffness: Any, positions: list[list[float]]) -> str:
    mounts = {"each": {"stiffness": stiffness}, "positions": positions}
    return _refused({"machine__mounts": mounts, **RIGID})


def _warned(changes: dict[str, Any]) -> str:
    case = generator(**changes)
    assert check_machine(case) == []
    return "\n".join(machine_warnings(case))


FREE: dict[str, tuple[Any, list[list[float]]]] = {
    "vertical springs only": ([0.0, 0.0, 1e4], FLAT),
    "no sideways stiffness": ([1e4, 0.0, 1e4], FLAT),
    "all on a line under the centre": (1e4, [[-0.4, 0.0, -0.2], [0.4, 0.0, -0.2]]),
    "one ball joint": ([1e4, 2e4, 3e4], [[0.1, 0.0, -0.3]]),
    "zero stiffness": (0.0, FLAT),
    "line askew": (1e4, [[0.3, 0.3, 0.0], [-0.3, -0.3, 0.0]]),
}


def test_pitch_asks_for_no_other_stiffness() -> None:
    case = generator(machine__mounts__each={"stiffness": [0.0, 0.0, 1e4]})
    assert check_machine(case) == []


def test_stiffness_many_decades_apart_is_not_free() -> None:
    case = generator(machine__mounts__each={"stiffness": [1.0, 1e12, 1e4]}, **RIGID)
    assert check_machine(case) == []


def cylinders(**changes: Any) -> list[dict[str, Any]]:
    return [{"name": "1", "position": -0.3}, {"name": "2", "position": 0.3, **changes}]


WARNED: dict[str, dict[str, Any]] = {
    "rpm as rad/s": {"machine__speed": 4900.0},
    "degrees as radians": {"machine__crank_train__cylinders": cylinders(crank_phase=120.0)},
    "same place": {"machine__crank_train__cylinders": cylinders(position=-0.3)},
    "kN/m as N/m": {"machine__mounts__each__stiffness": 10.0},
    "shaft above the orders": {
        "excitation": {"orders": 1},
        "machine__crank_train__balance_shafts": [
            {"name": "left", "unbalance": 1e-3, "speed_ratio": -2}
        ],
    },
    "bounce coupled with pitch": {
        "isolation__lever": 0.4,
        "machine__mounts__positions": [[-0.4, -0.2, 0.0], [-0.4, 0.2, 0.0], [0.3, 0.0, 0.0]],
    },
    "mounts below the centre": {"machine__mounts__positions": [[x, y, -0.2] for x, y, _ in FLAT]},
    "products of inertia": {
        "machine__body__box": None,
        "machine__body__inertia": [3.0, 6.0, 7.0],
        "machine__body__inertia_products": [0.5, 0.0, 0.0],
    },
}


MESSAGES = {
    **{name: lambda _, row=row: _refused(row) for name, row in REFUSED.items()},
    **{name: lambda _, row=row: _free(*row) for name, row in FREE.items()},
    **{f"warned: {name}": lambda _, row=row: _warned(row) for name, row in WARNED.items()},
}


@pytest.mark.parametrize("name", MESSAGES)
def test_words_and_key(name: str, tmp_path: Path) -> None:
    hold("bad_cases_machine", name, MESSAGES[name], tmp_path)


def test_exact_models_are_not_warned_about() -> None:
    below = [[x, y, -0.2] for x, y, _ in FLAT]
    assert machine_warnings(generator(machine__mounts__positions=below, **RIGID)) == []


RICH = GENERATOR.replace('model = "pitch"', 'model = "MODEL"').replace(
    "box = {",
    "inertia_block = { mass = 5.0, box = { length = 1.0, width = 1.0, height = 0.1 }, "
    "position = [0.1, 0.2, -0.3] }\nbox = {",
)


def test_extreme_numbers_are_refused_or_computed_with() -> None:
    """Seeded mutations: problems in words, or finite arrays; no overflow, no crash."""
    rng = np.random.default_rng(42)
    refused = built = 0
    for _ in range(150):
        data = tomllib.loads(RICH.replace("MODEL", str(rng.choice(["pitch", "rigid_body"]))))
        make_extreme(rng, data, leaves(data))
        try:
            case = Case.model_validate(data)
        except ValidationError:
            continue
        problems = check_machine(case)
        refused += bool(problems)
        assert all(problem.message and problem.allowed for problem in problems)
        if problems:
            continue
        parts = build_machine(case)
        assert all(isinstance(text, str) for text in machine_warnings(case))
        assert parts.body is not None
        assert parts.mounts is not None
        for array in (parts.body.mass_matrix, parts.mounts.stiffness, parts.crank_train.position):
            assert np.isfinite(array).all()
        built += 1
    assert refused > 15
    assert built > 15
