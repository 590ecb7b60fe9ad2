"""Claim: Hooke and Jeeves' search does what its paper says, and with limits it still arrives.

Known optima are those of Hock and Schittkowski (1981) in test_consistency_optimum.
"""

import numpy as np
import pytest
from long_but import long_but
from test_consistency_optimum import KNOWN

from vibecalc.core.study.search.methods import find, hooke_jeeves, nelder_mead


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


@pytest.mark.parametrize("search", [hooke_jeeves, nelder_mead])
def test_curved_valley(search):
    called, points = recorded(valley)
    found = search(called, np.array([0.2, 0.75]), 0.1, 1e-8)
    assert found.converged
    assert found.point == pytest.approx([0.75, 0.75], abs=1e-6)
    assert found.evaluations == len(points) < 1000


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
