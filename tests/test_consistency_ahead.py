"""Claim: what a search computes at once, before it asks, is what runs of single points give.

A point that a check refuses, or whose case arrays cannot compute, has a run of its own.
"""

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import load_case
from vibecalc.core.study.binding import Binding, Foreseen
from vibecalc.errors import NumericalFailure


def binding_of(name: str) -> Binding:
    return Binding(load_case(CASES[name]))


def points_of(binding: Binding, count: int) -> np.ndarray:
    share = np.random.default_rng(7).random((count, binding.lower.size))
    return np.asarray(binding.lower + (binding.upper - binding.lower) * share)


@pytest.mark.parametrize("name", ["compressor_balance", "four_cylinder"])
def test_points_at_once_are_single_runs_to_the_last_bit(name: str) -> None:
    binding, wanted = binding_of(name), frozenset({binding_of(name).goal.quantity})
    points, foreseen = points_of(binding, 6), Foreseen()
    foreseen.add(binding, points, wanted)
    for again in (points, points[::-1]):  # the second time one by one, with what was kept
        for point in again:
            found, single = foreseen.find(binding, point, wanted), binding.results(point, wanted)
            assert found is not None
            for path in wanted:
                assert np.array_equal(found[path].values, single[path].values)
                assert found[path].error_estimate == single[path].error_estimate
        foreseen = Foreseen()


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
