"""Claim: slopes are derivatives, deviations cost what they are said to, kinks are not hidden."""

import numpy as np
import pytest

from vibecalc.core.study.search.problem import Problem
from vibecalc.core.study.search.sensitivity import cost_of_deviation, slopes_at
from vibecalc.errors import NumericalFailure

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
