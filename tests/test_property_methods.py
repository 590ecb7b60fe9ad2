"""Claim: every method of the table keeps one signature, its bounds, its budget and its word."""

import numpy as np
import pytest
from long_but import long_but
from test_consistency_optimum import KNOWN
from test_property_optimum import valley

from vibecalc.core.study.search.methods import METHODS, hooke_jeeves
from vibecalc.core.study.search.minimise import find, minimise
from vibecalc.errors import NumericalFailure

NAMES = sorted(METHODS)


@pytest.mark.parametrize("name", NAMES)
def test_counts_stays_inside_and_reports_what_evaluate_says(name):
    seen = set()

    def counted(x):
        seen.add(x.tobytes())
        assert np.all(np.abs(x) <= 2)
        return valley(x)

    found = find(name, counted, [-2, -2], [2, 2], first=[-1, 1])
    objective, margins = valley(found.variables)
    assert found.objective == pytest.approx(objective, rel=1e-14)
    assert np.allclose(found.margins, margins, rtol=0, atol=1e-14)
    # what is evaluated beyond the count is the residual at the end
    assert found.evaluations <= len(seen) <= found.evaluations + 120
    assert found.history[0].converged
    assert found.kkt_residual < 1e-3
    assert found.history[0].violation <= 2e-7


@pytest.mark.parametrize("name", NAMES)
def test_a_spent_budget_is_said_and_the_best_point_given(name):
    found = find(name, valley, [-2, -2], [2, 2], first=[-1.5, 1.5], budget=12)
    assert not found.history[0].converged
    assert found.evaluations <= 12
    assert found.history[0].reason == "spent its 12 evaluations"
    assert np.isfinite(found.objective)


@pytest.mark.parametrize("name", NAMES)
def test_a_start_without_a_value_is_a_failure(name):
    def nowhere(x):
        raise NumericalFailure("an order is on a natural frequency")

    with pytest.raises(NumericalFailure, match=r"start of the search.*natural frequency"):
        find(name, nowhere, [0], [1])


@pytest.mark.parametrize("name", NAMES)
def test_points_that_fail_are_gone_around(name):
    def holed(x):
        if x[0] > 0.8:
            raise NumericalFailure("too near")
        return (x[0] - 0.6) ** 2 + (x[1] - 0.4) ** 2, [x[1] - 0.5]

    found = find(name, holed, [0, 0], [1, 1], first=[0.1, 0.9], budget=8000)
    assert found.variables == pytest.approx([0.6, 0.5], abs=2e-4)


@pytest.mark.parametrize(
    "name", long_but(NAMES, *(name for name in NAMES if name != "differential_evolution"))
)
def test_refined_it_is_the_same_optimum(name):
    plain = minimise(valley, [-2, -2], [2, 2], starts=2)
    found = minimise(valley, [-2, -2], [2, 2], starts=2, method=name)
    apart = np.abs(found.variables - plain.variables)
    assert np.all(apart <= found.variables_error + plain.variables_error)
    assert abs(found.objective - plain.objective) <= found.objective_error + plain.objective_error
    assert found.kkt_residual < 1e-7
    # a population is spread over the bounds already: it starts once
    assert len(found.history) == (1 if METHODS[name].everywhere else 3)


def test_a_population_finds_the_deeper_of_two_wells():
    """From a start in the shallow well the local methods stay there."""

    def wells(x):
        return (x[0] ** 2 - 1) ** 2 + 0.3 * x[0], []

    ends = {name: find(name, wells, [-2], [2], first=[1.0]) for name in METHODS}
    for name, end in ends.items():
        deeper = METHODS[name].everywhere
        assert np.sign(end.variables[0]) == (-1 if deeper else 1)


def test_a_kink_has_no_residual():
    found = find("hooke_jeeves", lambda x: (abs(x[0] - 0.3) + 1, []), [0], [1])
    assert found.variables[0] == pytest.approx(0.3, abs=1e-7)
    assert found.kkt_residual == np.inf


def test_first_moves_of_hooke_and_jeeves_are_those_of_their_paper():
    """Up one axis after the other; the pattern move then goes as far again and explores there."""
    points = []

    def called(point):
        points.append(point.copy())
        return float(np.sum((point - 0.9) ** 2))

    hooke_jeeves(called, np.zeros(2), 0.125, 0.125)
    expected = [(0, 0), (1, 0), (1, 1), (2, 2), (3, 2), (3, 3), (5, 5)]
    assert np.array_equal(np.array(points[:7]) * 8, expected)


@pytest.mark.parametrize(
    "name", ["hooke_jeeves", pytest.param("nelder_mead", marks=pytest.mark.long)]
)
@pytest.mark.parametrize("number", KNOWN)
def test_limits_are_kept_without_standing_still_at_them(name, number):
    evaluate, lower, upper, objective, variables = KNOWN[number]
    found = find(name, evaluate, lower, upper, budget=10000)
    assert found.history[0].converged
    assert found.history[0].violation <= 2e-7
    assert abs(found.objective - objective) <= 1e-6
    assert np.max(np.abs(found.variables - variables)) <= 1e-3
    assert found.kkt_residual <= 1e-3
