"""Claim: Hooke and Jeeves' search does what its paper says, and with limits it still arrives.

Known optima are those of Hock and Schittkowski (1981) in test_consistency_optimum.
"""

from collections import Counter

import numpy as np
import pytest
from long_but import long_but
from mount_study import MountStudy
from test_consistency_optimum import KNOWN

from vibecalc.core.study.search.methods import augmented, find, hooke_jeeves, nelder_mead
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Box, Sampler


def recorded(function):
    """The function, and the list of all points that it is called with."""
    points = []

    def called(point):
        points.append(point.copy())
        return function(point)

    return called, points


def valley(point):
    """Rosenbrock's, with the minimum inside the unit cube."""
    x, y = 4.0 * point - 2.0
    return (1.0 - x) ** 2 + 100.0 * (y - x * x) ** 2


def test_first_moves_are_those_of_the_paper():
    """Up one axis after the other; the pattern move then goes as far again and explores there."""
    called, points = recorded(lambda x: float(np.sum((x - 0.9) ** 2)))
    hooke_jeeves(called, np.zeros(2), 0.125, 0.125)
    expected = [(0, 0), (1, 0), (1, 1), (2, 2), (3, 2), (3, 3), (5, 5)]
    assert np.array_equal(np.array(points[:7]) * 8, expected)


def test_a_failed_step_is_tried_the_other_way_and_the_sign_is_kept():
    called, points = recorded(lambda x: float(np.sum(x)))
    found = hooke_jeeves(called, np.array([0.75]), 0.125, 0.125)
    # the third is tried after the second failed; the pattern move then explores downwards first
    assert list(np.ravel(points)[:5] * 8) == [6, 7, 5, 4, 3]
    assert found.point[0] == 0.0


@pytest.mark.parametrize("search", [hooke_jeeves, nelder_mead])
def test_curved_valley(search):
    called, points = recorded(valley)
    found = search(called, np.array([0.2, 0.75]), 0.1, 1e-8)
    assert found.converged
    assert found.point == pytest.approx([0.75, 0.75], abs=1e-6)
    assert found.evaluations == len(points) < 1000


def test_no_point_is_evaluated_twice_and_none_outside():
    called, points = recorded(valley)
    found = hooke_jeeves(called, np.array([0.0, 1.0]), 0.3, 1e-6)
    assert max(Counter(point.tobytes() for point in points).values()) == 1
    assert found.evaluations == len(points)
    assert np.min(points) >= 0.0
    assert np.max(points) <= 1.0


def test_the_end_has_no_lower_neighbour_at_the_last_step():
    generator = np.random.default_rng(5)
    for _ in range(20):
        slope, centre = generator.normal(size=(3, 3)), generator.uniform(size=3)
        matrix = slope @ slope.T + 0.1 * np.eye(3)

        def bowl(x, matrix=matrix, centre=centre):
            return float((x - centre) @ matrix @ (x - centre))

        found = hooke_jeeves(bowl, generator.uniform(size=3), 0.1, 2.0**-17)
        for axis in range(3):
            for side in (2.0**-17, -(2.0**-17)):
                nearby = found.point.copy()
                nearby[axis] = np.clip(nearby[axis] + side, 0.0, 1.0)
                assert bowl(nearby) >= found.value


def test_infinite_values_are_gone_around():
    def holed(x):
        return np.inf if 0.4 < x[0] < 0.45 else float(np.sum((x - 0.7) ** 2))

    found = hooke_jeeves(holed, np.array([0.1, 0.1]), 0.1, 1e-7)
    assert found.point == pytest.approx([0.7, 0.7], abs=1e-6)


@pytest.mark.parametrize(
    "name", ["hooke_jeeves", pytest.param("nelder_mead", marks=pytest.mark.long)]
)
@pytest.mark.parametrize("number", long_but(KNOWN, *list(KNOWN)[:2]))
def test_limits_are_kept_without_standing_still_at_them(name, number):
    evaluate, lower, upper, objective, variables = KNOWN[number]
    found = find(name, evaluate, lower, upper, budget=10000)
    assert found.converged
    assert found.violation <= 2e-7
    assert abs(found.objective - objective) <= 1e-6
    assert np.max(np.abs(found.variables - variables)) <= 1e-3
    assert found.residual <= 1e-3


def test_an_exact_penalty_would_stand_still():
    """The reason for the augmented Lagrangian: at a crease no axis leads downhill."""
    evaluate, lower, upper, objective, _ = KNOWN["35"]

    def creased(unit):
        values, margins = evaluate(np.asarray(lower) + unit * (np.asarray(upper) - lower))
        return values + 1e3 * max(0.0, -min(margins))

    stuck = hooke_jeeves(creased, np.full(3, 0.05), 0.1, 1e-8)
    assert stuck.converged
    assert stuck.value > 1.05 * objective
    sampler = Sampler(evaluate, Box(np.array(lower, float), np.array(upper, float)), 20000)
    walk = augmented(sampler, np.full(3, 0.05), hooke_jeeves)
    assert walk.converged
    assert sampler(walk.unit)[0] == pytest.approx(objective, abs=1e-6)


def test_rounding_does_not_let_it_creep():
    """Down to steps at which a bowl is level to rounding, in a bounded number of points."""
    generator = np.random.default_rng(5)
    for _ in range(20):
        slope, centre = generator.normal(size=(3, 3)), generator.uniform(size=3)
        matrix = slope @ slope.T + 0.1 * np.eye(3)

        def bowl(x, matrix=matrix, centre=centre):
            return float((x - centre) @ matrix @ (x - centre))

        found = hooke_jeeves(bowl, generator.uniform(size=3), 0.1, 1e-12)
        assert found.converged
        assert found.evaluations < 5000
        assert found.point == pytest.approx(centre, abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("name", ["hooke_jeeves", "nelder_mead"])
def test_mount_design_by_direct_search(name):
    study = MountStudy()
    box = ([2e3, 0.0, 0.0], [5e5, 1e3, 10.0])
    best = minimise(study.evaluate, *box, first=[1e4, 50.0, 0.0], starts=0)
    found = find(name, study.evaluate, *box, first=[1e4, 50.0, 0.0], budget=8000)
    assert found.converged
    assert found.objective == pytest.approx(best.objective, rel=1e-6)
    assert np.max(np.abs(found.variables / best.variables - 1.0)) < 1e-5
    assert found.evaluations > 5 * best.evaluations
