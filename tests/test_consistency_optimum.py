"""Claim: the optimiser agrees with optima known in closed form.

The numbered problems are from W. Hock and K. Schittkowski, Test Examples for Nonlinear
Programming Codes (1981); the minimax is Charalambous and Conn's second.
"""

import numpy as np
import pytest

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem
from vibecalc.core.study.search.sensitivity import cost_of_deviation, slopes_at
from vibecalc.errors import NumericalFailure

ROOT3 = np.sqrt(3.0)


def hock_schittkowski_24(x):
    margins = [x[0] / ROOT3 - x[1], x[0] + ROOT3 * x[1], 6 - x[0] - ROOT3 * x[1]]
    return ((x[0] - 3) ** 2 - 9) * x[1] ** 3 / (27 * ROOT3), margins


def rosen_suzuki(x):
    a, b, c, d = x
    objective = a * a + b * b + 2 * c * c + d * d - 5 * a - 5 * b - 21 * c + 7 * d
    return objective, [
        8 - a * a - b * b - c * c - d * d - a + b - c + d,
        10 - a * a - 2 * b * b - c * c - 2 * d * d + a + d,
        5 - 2 * a * a - b * b - c * c - 2 * a + b + d,
    ]


KNOWN = {
    "24": (hock_schittkowski_24, [0, 0], [10, 10], -1.0, [3, ROOT3]),
    "43": (rosen_suzuki, [-10] * 4, [10] * 4, -44.0, [0, 1, 2, -1]),
}


@pytest.mark.parametrize("number", KNOWN)
def test_known_optimum_within_its_error(number):
    evaluate, lower, upper, objective, variables = KNOWN[number]
    found = minimise(Problem(evaluate, lower, upper), starts=3)
    assert abs(found.objective - objective) <= found.objective_error < 1e-12
    assert np.all(np.abs(found.variables - variables) <= found.variables_error)
    assert np.all(found.variables_error < 1e-10)
    assert found.kkt_residual < 1e-9


def test_multipliers_are_the_price_of_a_limit():
    found = minimise(Problem(rosen_suzuki, [-10] * 4, [10] * 4), starts=2)
    assert found.margin_multipliers == pytest.approx([1, 0, 2], abs=1e-9)


def charalambous_conn(x):
    return np.array(
        [x[0] ** 2 + x[1] ** 4, (2 - x[0]) ** 2 + (2 - x[1]) ** 2, 2 * np.exp(x[1] - x[0])]
    )


MINIMAX = 1.952224493870659


def test_hidden_kink():
    found = minimise(Problem(lambda x: (max(charalambous_conn(x)), []), [-3, -3], [3, 3]), starts=3)
    assert found.method == "sampled planes"
    assert abs(found.objective - MINIMAX) <= found.objective_error < 1e-8


def test_kink_in_a_limit():
    """Two straight limits in one margin: their corner, 1/110 (1, 4), is the optimum."""
    found = minimise(
        Problem(
            lambda x: (x[0] + x[1], [min(x[0] - 0.25 * x[1], 3 * x[1] - x[0] - 0.1)]),
            [0, 0],
            [1, 1],
        ),
        starts=3,
    )
    assert found.objective == pytest.approx(5 / 110, abs=1e-10)
    assert abs(found.objective - 5 / 110) <= found.objective_error
    assert found.variables == pytest.approx([1 / 110, 4 / 110], abs=1e-9)


# ----------------------------------------------------------------------------
# Slopes, and what deviations cost.
# ----------------------------------------------------------------------------

LOWER, UPPER = [0.1, 1.0, -1.0], [5.0, 100.0, 2.0]


def smooth(x):
    """The second variable runs logarithmically between its bounds."""
    return x[0] ** 2 * x[1] + np.exp(x[2]) / x[1], [1.2 - x[0]]


@pytest.mark.parametrize("at", [(0.5, 20.0, 0.3), (0.1, 1.0, 2.0), (5.0, 100.0, -1.0)])
def test_slopes_inside_and_at_bounds(at):
    x = np.array(at)
    exact = [2 * x[0] * x[1], x[0] ** 2 - np.exp(x[2]) / x[1] ** 2, np.exp(x[2]) / x[1]]
    slope, error = slopes_at(Problem(smooth, LOWER, UPPER), x)
    assert np.all(np.abs(slope - exact) <= error)
    assert np.all(error <= 1e-6 * np.max(np.abs(exact)))


def test_a_kink_has_no_slope_and_the_others_keep_theirs():
    slope, error = slopes_at(
        Problem(lambda x: (abs(x[0] - 0.3) + 2 * x[1], []), [0, 0], [1, 1]), [0.3, 0.5]
    )
    assert list(np.isnan(slope)) == [True, False]
    assert abs(slope[1] - 2.0) <= error[1]


def test_cost_is_that_of_the_worse_direction():
    def bowl(x):
        return 3.0 + (x[0] - 0.5) ** 2 + 2 * x[1], [x[1] - 0.495]

    deviation, loss, error, margin = cost_of_deviation(Problem(bowl, [0, 0], [2, 1]), [0.5, 0.5]).T
    assert np.abs(deviation) == pytest.approx([0.02, 0.01], rel=1e-12)
    assert deviation[1] > 0
    assert np.all(np.abs(loss - [0.0004, 0.02]) <= error)
    # the least margin is that of the other direction: it warns of either
    assert margin == pytest.approx([0.005, -0.005], abs=1e-12)


def test_at_a_bound_only_the_way_inside_counts():
    for at, loss in ((0.0, 0.01), (1.0, -0.01)):
        (row,) = cost_of_deviation(Problem(lambda x: (x[0], []), [0], [1]), [at])
        assert row[:2] == pytest.approx([loss, loss])


def test_a_deviation_without_a_value_is_not_known():
    def alone(x):
        if x[0] != 0.5:
            raise NumericalFailure("singular")
        return 1.0, []

    assert np.all(np.isnan(cost_of_deviation(Problem(alone, [0], [1]), [0.5])))
