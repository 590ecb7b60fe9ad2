"""Claim: a pump that contradicts itself, or leaves the plane of its crank, is refused in words."""

import copy
import json

import pytest
from pump_cases import FOUR, GEOMETRY, LIQUID, pump_with, table_with
from refused import refusals, said_of

from vibecalc.core.case.load import validate
from vibecalc.core.run.machine_checks import check_machine
from vibecalc.errors import CaseError, NumericalFailure
from vibecalc.excitation.pressure_cycle import pump_card, pump_turn


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("pump", "physics"))
def test_physics(case: str, change: str, place: str, words: list[str]) -> None:
    (problem,) = check_machine(pump_with(**json.loads(change)))
    for expected in words:
        assert expected in said_of(problem)


@pytest.mark.parametrize(("case", "change", "place", "words"), refusals("pump", "form"))
def test_form(case: str, change: str, place: str, words: list[str]) -> None:
    with pytest.raises(CaseError) as caught:
        validate(table_with(**json.loads(change)))
    reported = " ".join(map(said_of, caught.value.problems))
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
