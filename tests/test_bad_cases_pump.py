"""Claim: a pump that contradicts itself, or leaves the plane of its crank, is refused in words."""

import copy
from typing import Any

import pytest
from pump_cases import FOUR, GEOMETRY, LIQUID, pump_with, table_with

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.errors import CaseError, NumericalFailure
from vibecalc.excitation.pressure_cycle import pump_card, pump_turn

TRAIN, CYCLE = "machine__crank_train__", "machine__crank_train__pump_cycle__"

#: keys set -> words of the one problem that follows
PHYSICS: tuple[tuple[dict[str, Any], tuple[str, ...]], ...] = (
    (
        {"isolation__model": "rigid_body"},
        ("leave the body free", "turning about y", "'planar' for two mounts"),
    ),
    (
        {"machine__mounts__positions": [[0.0, 0.0, -0.2]]},
        ("free in the plane of the crank", "nothing resists turning about x through (0, 0, -0.2)"),
    ),
    (
        {
            "machine__mounts__positions": [*FOUR[:3], [0.3, 0.4, -0.2]],
            "machine__mounts__each": {"stiffness": [6e4, 6e4, 9e4]},
        },
        ("stiffness couples", "turning about x with turning about y"),
    ),
    (
        {f"{TRAIN}cylinders": [{"name": "1", "position": 0.01}]},
        ("tilts the body out of it", "0.01 m along the crankshaft", "'rigid_body'"),
    ),
    (
        {"machine__body__inertia_products": [0.5, 0.0, 0.0]},
        ("mass couples", "turning about x with turning about y"),
    ),
    ({"isolation__up": "x"}, ("with the crankshaft level", "up = 'x'")),
    (
        {f"{CYCLE}bulk_modulus": 1e14},
        ("too stiff", "9.8e-08 of its volume", "1.5 to 2.3 GPa"),
    ),
    (
        {f"{CYCLE}dead_volume": 0.02},
        ("draws nothing", "109.2 cm^3 of 62.83 cm^3", "below 1.151e+04 cm^3"),
    ),
)

#: keys set -> words; the form is judged before the physics
FORM: tuple[tuple[dict[str, Any], tuple[str, ...]], ...] = (
    (
        {f"{CYCLE}discharge_pressure": "1 bar"},
        ("at a higher pressure than it draws", "pressure 1 bar"),
    ),
    ({"machine__cycle": "two_stroke"}, ("cycle is for a machine of kind 'engine'",)),
    ({f"{TRAIN}firing_order": ["1"]}, ("firing_order is for a machine of kind 'engine'",)),
    (
        {f"{TRAIN}cylinders": [{"name": "1", "pressure_scale": 1.0}]},
        ("pressure_scale is for a machine of kind 'engine'",),
    ),
    ({"machine__shell": {"inertia": 1.0}}, ("of kind 'pump' has no [machine.shell]",)),
    ({f"{TRAIN}gas_interpolation": "cubic"}, ("of kind 'pump' has no gas_interpolation",)),
    ({"machine__kind": "engine"}, ("[machine.crank_train.pump_cycle] is for a machine of kind",)),
    ({"machine__kind": "machine"}, ("is for a machine of kind 'pump'", "kind = 'machine'")),
)


@pytest.mark.parametrize(("settings", "words"), PHYSICS)
def test_physics(settings: dict[str, Any], words: tuple[str, ...]) -> None:
    (problem,) = check_machine(pump_with(**settings))
    reported = " ".join((problem.message, problem.found, problem.allowed, problem.hint))
    for expected in words:
        assert expected in reported, reported


@pytest.mark.parametrize(("settings", "words"), FORM)
def test_form(settings: dict[str, Any], words: tuple[str, ...]) -> None:
    with pytest.raises(CaseError) as caught:
        validate(table_with(**settings))
    reported = " ".join(f"{one.message} {one.found} {one.allowed}" for one in caught.value.problems)
    for expected in words:
        assert expected in reported


@pytest.mark.parametrize("key", ["pump_cycle", "bore"])
def test_what_a_pump_needs(key: str) -> None:
    table = copy.deepcopy(table_with())
    del table["machine"]["crank_train"][key]
    with pytest.raises(CaseError, match=f"needs {key}: the "):
        validate(table)


def test_the_planar_model_takes_what_is_even() -> None:
    assert check_machine(pump_with()) == []
    assert check_machine(pump_with(machine__mounts__positions=FOUR)) == []
    two = [{"name": "1", "position": 0.0}, {"name": "2", "crank_phase": "180 deg"}]
    assert check_machine(pump_with(machine__crank_train__cylinders=two)) == []


def test_a_pump_that_only_springs_is_refused() -> None:
    soft = LIQUID._replace(dead_volume=1.2e-3, discharge_pressure=1e8)
    for kernel in (pump_turn, pump_card):
        with pytest.raises(NumericalFailure, match="nothing is drawn"):
            kernel(soft, GEOMETRY)
