"""Claim: a machine in other units of length, mass and time has the same results, estimates too.

That they are right, whatever the axes and phases, `test_property_error_estimates.py` holds.
"""

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from long_but import long_but
from random_machines import Table, random_machine

from vibecalc.core.case.load import validate
from vibecalc.core.results.record import Record
from vibecalc.core.run.plan import planned_quantities
from vibecalc.core.run.run import run_case

MODELS = ("pitch", "rigid_body")
#: two machines; two more with the long tests
SEEDS = long_but(range(4), 1, 2)
CURVES = ("isolation/lever_force/run_up", "isolation/support_force/run_up")
#: exponents of length, mass and time
DIMENSIONS: Mapping[str, tuple[int, int, int]] = {
    "": (0, 0, 0),
    "rad": (0, 0, 0),
    "m": (1, 0, 0),
    "m/s": (1, 0, -1),
    "m/s^2": (1, 0, -2),
    "kg": (0, 1, 0),
    "kg*m": (1, 1, 0),
    "kg*m^2": (2, 1, 0),
    "rad/s": (0, 0, -1),
    "N": (1, 1, -2),
    "N*m": (2, 1, -2),
    "N/m": (0, 1, -2),
    "N*s/m": (0, 1, -1),
    "N*m/rad": (2, 1, -2),
    "N*m*s/rad": (2, 1, -1),
}
KEYS: Mapping[str, str] = {
    **dict.fromkeys(("crank_radius", "rod_length", "wrist_pin_offset", "position", "origin"), "m"),
    **dict.fromkeys(("length", "width", "height", "positions", "lever", "reference_length"), "m"),
    **dict.fromkeys(("crank_pin_to_mass_centre",), "m"),
    **dict.fromkeys(("mass", "reciprocating_mass", "rotating_mass", "piston_mass"), "kg"),
    **dict.fromkeys(("pin_mass",), "kg"),
    **dict.fromkeys(("inertia", "inertia_products"), "kg*m^2"),
    **dict.fromkeys(("speed", "from", "to"), "rad/s"),
    "unbalance": "kg*m",
    "gravity": "m/s^2",
    "stiffness": "N/m",
    "damping": "N*s/m",
}


def machine(seed: int, model: str) -> Table:
    """A random machine with gravity and orders written out."""
    case = random_machine(seed, model, gravity=9.80665)
    case["accuracy"] = {"rtol": 1e-9}
    return case


def run(case: Table) -> Record:
    """All results but the curves of the run-up, which sample where they like."""
    checked = validate(copy.deepcopy(case))
    paths = [path for path in planned_quantities(checked) if path not in CURVES]
    return run_case(checked, wanted=frozenset(paths))


def scaled(value: Any, factors: tuple[float, float, float], key: str = "") -> Any:
    """A case in other units; the factors are those of length, mass and time."""
    if isinstance(value, dict):
        return {name: scaled(item, factors, name) for name, item in value.items()}
    if isinstance(value, list):
        return [scaled(item, factors, key) for item in value]
    if key not in KEYS or isinstance(value, str):
        return value
    return value * factor_of(KEYS[key], factors)


def factor_of(unit: str, factors: tuple[float, float, float]) -> float:
    return float(np.prod([f**e for f, e in zip(factors, DIMENSIONS[unit], strict=True)]))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("powers", long_but([(17, -23, 11), (-20, 30, -13)], (17, -23, 11)))
def test_units_of_length_mass_and_time(seed: int, model: str, powers: tuple[int, ...]) -> None:
    """Powers of two round nothing, so that even error estimates follow."""
    factors = (2.0 ** powers[0], 2.0 ** powers[1], 2.0 ** powers[2])
    case = machine(seed, model)
    one, other = run(case), run(scaled(case, factors))
    assert set(one) == set(other) and len(one) > 10
    for path, quantity in one.quantities.items():
        found = other[path]
        if path == "isolation/modes/shape":
            turn = factors[0] ** -1.0
            factor = factors[1] ** -0.5 * np.array([1, 1, 1, turn, turn, turn])
        else:
            factor = np.asarray(factor_of(quantity.unit, factors))
            estimate = quantity.error_estimate * float(factor)
            assert found.error_estimate == pytest.approx(estimate, rel=0.1), path
        want = quantity.values * factor
        size = float(np.max(np.abs(want), initial=0.0))
        slack = 2.0 * (quantity.error_estimate * float(np.max(factor)) + found.error_estimate)
        off = float(np.max(np.abs(found.values - want), initial=0.0))
        assert off <= 1e-12 * size + slack, f"{path}: {off:.3g} of {size:.3g}"
