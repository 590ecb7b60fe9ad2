"""Claim: what a search computes at once, before it asks, is what runs of single points give.

A point that a check refuses, or whose case arrays cannot compute, has a run of its own.
"""

import numpy as np
import pytest
from shipped_cases import CASES

from vibecalc.core.case.load import load_case
from vibecalc.core.run.columns import Unvaried
from vibecalc.core.study.binding import Binding, Foreseen
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem, Sampler
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
    assert len(foreseen) == 6
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


def test_a_search_counts_what_it_asks_for_and_finds_the_same() -> None:
    asked: list[int] = []

    def bowl(variables: np.ndarray) -> tuple[float, np.ndarray]:
        return float(np.sum((variables - 0.3) ** 2)) + 1.0, np.empty(0)

    bounds = np.zeros(3), np.ones(3)
    alone = minimise(Problem(bowl, *bounds), starts=3)
    told = minimise(
        Problem(bowl, *bounds, ahead=lambda points: asked.append(len(points))), starts=3
    )
    assert alone.evaluations == told.evaluations
    assert np.array_equal(alone.variables, told.variables)
    assert sum(asked) > 0.5 * told.evaluations


def test_no_point_is_told_twice() -> None:
    told: list[np.ndarray] = []
    problem = Problem(lambda x: (float(x.sum()), ()), [0, 0], [2, 2], ahead=told.append)
    sampler = Sampler(problem)
    sampler(np.zeros(2))
    corners = [np.array([a, b]) for a in (0.0, 1.0) for b in (0.0, 1.0)]
    sampler.ahead([*corners, *corners])
    assert [points.tolist() for points in told] == [[[0.0, 2.0], [2.0, 0.0], [2.0, 2.0]]]
    sampler.ahead(corners[:2])
    assert len(told) == 1, "one point alone gains nothing"


def test_what_reads_a_varied_number_is_made_anew() -> None:
    case = load_case(CASES["compressor_balance"]).case
    speed = ("machine", "speed")
    kept = Unvaried([speed])
    made: list[str] = []

    def reads_speed(case: object) -> float:
        made.append("speed")
        return float(case.machine.speed)  # type: ignore[attr-defined]

    def reads_radius(case: object) -> float:
        made.append("radius")
        return float(case.machine.crank_train.crank_radius)  # type: ignore[attr-defined]

    for rate in (100.0, 200.0, 300.0):
        machine = case.machine.model_copy(update={"speed": rate})
        at = case.model_copy(update={"machine": machine})
        assert kept.make("speed", reads_speed, at) == rate
        assert kept.make("radius", reads_radius, at) == case.machine.crank_train.crank_radius
    assert made == ["speed", "radius", "speed", "speed"]
