"""Claim: a search without a trustworthy answer says so, with what, where and what to do; points
that cannot be evaluated are counted and gone around.
"""

import numpy as np
import pytest

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem
from vibecalc.errors import NumericalFailure


def test_infeasible_names_the_least_violated_point():
    def evaluate(x):
        return x[0], [x[0] - 2.0, -x[0] - 0.5, 5.0]

    with pytest.raises(NumericalFailure) as caught:
        minimise(Problem(evaluate, [-1], [1]), starts=2)
    text = str(caught.value)
    assert "no point within the bounds keeps all limits" in text
    assert "margin 0 is -1.25, margin 1 is -1.25" in text
    assert "margin 2" not in text
    assert "relax these limits" in text


def with_hole(x):
    if 0.2 < x[0] < 0.45:
        raise NumericalFailure("an order is on an undamped natural frequency")
    return (x[0] - 0.5) ** 2 + x[1] ** 2, [x[1] - 0.1]


def test_points_that_fail_are_counted_and_gone_around():
    found = minimise(Problem(with_hole, [0, 0], [1, 1], first=[0.1, 0.1]))
    assert found.variables == pytest.approx([0.5, 0.1], abs=1e-12)
    assert found.failures > 0
    assert found.failure_messages == ("an order is on an undamped natural frequency",)
    failed = [one for one in found.history if np.isinf(one.objective)]
    assert failed and not any(one.feasible for one in failed)


def test_no_start_can_be_evaluated():
    with pytest.raises(NumericalFailure, match=r"none of the 4 starting points.*natural frequency"):
        minimise(Problem(lambda x: with_hole(np.array([0.3, 0])), [0], [1]), starts=3)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_not_a_number_is_a_failed_point(bad):
    def evaluate(x):
        return (bad if x[0] > 0.6 else (x[0] - 0.5) ** 2 + 1), []

    found = minimise(Problem(evaluate, [0], [1], first=[0.1]), starts=4)
    assert found.variables[0] == pytest.approx(0.5, abs=1e-9)
    assert found.failures > 0
    assert found.failure_messages == ("the objective is not a finite number",)


def test_infinite_margins():
    """A masked peak is infinite: its margin is minus infinity, and the point is gone around."""

    def evaluate(x):
        return x[0], [-np.inf if x[0] < 0.5 else x[0] - 0.6, np.inf]

    found = minimise(Problem(evaluate, [0], [1]), starts=3)
    assert found.variables[0] == pytest.approx(0.6, abs=1e-12)
    assert found.margin_multipliers == pytest.approx([1.0, 0.0])
    assert "the margin of a limit is not a finite number" in found.failure_messages


def test_unbounded_objective():
    def evaluate(x):
        return (-np.inf if x[0] > 0.9 else -x[0]), []

    with pytest.raises(NumericalFailure, match=r"minus infinity at .* no smallest value"):
        minimise(Problem(evaluate, [0], [1]))


def test_starts_beyond_the_budget_are_left_out(monkeypatch):
    monkeypatch.setattr("vibecalc.core.study.search.local_search.MOST_EVALUATIONS", 20)
    found = minimise(
        Problem(lambda x: ((x[0] - 0.3) ** 2 + np.exp(x[1]), [x[1]]), [-1, -1], [1, 1])
    )
    assert found.variables == pytest.approx([0.3, 0.0], abs=1e-9)
    assert any("ended the search after" in note for note in found.notes)


def test_flat_objective_says_so():
    found = minimise(Problem(lambda x: (1.0, [x[0] - 0.5]), [0], [1], first=[0.1]))
    assert found.method == "flat"
    assert found.margins[0] >= -1e-9
    assert found.free_directions == 1
    assert any("does not change" in note for note in found.notes)


def test_all_variables_held():
    found = minimise(Problem(lambda x: (x @ x, [x[0] - 0.5]), [1, 2], [1, 2]))
    assert (found.method, found.objective, found.evaluations) == ("fixed", 5.0, 1)
    with pytest.raises(NumericalFailure, match=r"held by equal bounds.*breaks a limit: margin 0"):
        minimise(Problem(lambda x: (x @ x, [x[0] - 1.5]), [1, 2], [1, 2]))
    with pytest.raises(NumericalFailure, match=r"held by equal bounds.*cannot be evaluated"):
        minimise(Problem(lambda x: (np.nan, []), [1, 2], [1, 2]))


def test_a_saddle_is_not_an_optimum():
    """The only start is the saddle of x y; the optima are two corners."""
    found = minimise(Problem(lambda x: (x[0] * x[1], []), [-1, -1], [1, 1]), starts=0)
    assert found.objective == -1.0
    assert sorted(found.variables) == [-1.0, 1.0]
    assert sorted(found.active_bounds) == [-1, 1]


def test_singular_optimum_has_an_honest_error():
    """At the bottom of a fourth power a variable is known to a fourth root of round-off."""
    found = minimise(Problem(lambda x: ((x[0] - 0.3) ** 4 + 1.0, []), [-1], [1]), starts=1)
    assert abs(found.variables[0] - 0.3) <= 10 * found.variables_error[0]
    assert abs(found.objective - 1.0) <= found.objective_error < 1e-10
