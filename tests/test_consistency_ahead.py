"""Claim: a point of a search that a check refuses, or arrays cannot compute, has its own run."""

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import load_case
from vibecalc.core.study.binding import Binding, Foreseen
from vibecalc.errors import NumericalFailure


def binding_of(name: str) -> Binding:
    return Binding(load_case(CASES[name]))


def test_points_that_need_a_run_of_their_own_are_left_to_it() -> None:
    study = binding_of("generator_mount_design")
    undamped = study.first * np.array([1.0, 0.0, 1.0])  # a run-up without bound
    wanted = frozenset({study.goal.quantity, *(limit.quantity for limit, _ in study.held)})
    assert Foreseen().find(study, study.first, wanted) is not None
    assert Foreseen().find(study, undamped, wanted) is None
    binding = binding_of("compressor_balance")
    beyond = binding.first.copy()
    beyond[0] = -1.0  # an unbalance below zero, which the schema refuses
    assert Foreseen().find(binding, beyond, frozenset({binding.goal.quantity})) is None
    with pytest.raises(NumericalFailure):
        binding.evaluate(beyond)
