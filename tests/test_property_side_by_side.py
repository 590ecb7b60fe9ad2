"""Claim: searches side by side find what they find alone, in fewer rounds, and end together."""

import threading

import numpy as np
import pytest

from vibecalc.core.study.search import local_search
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Infeasible, Problem
from vibecalc.core.study.search.side_by_side import side_by_side
from vibecalc.errors import NumericalFailure


def hills(x):
    """Some local optima, one limit."""
    return np.cos(3.0 * x[0]) + 0.3 * x[0] ** 2 + (x[1] - 0.4 * x[0]) ** 2, [2.0 - x @ x]


def searched(rounds):
    problem = Problem(hills, [-2.0, -2.0], [2.0, 1.5], ahead=rounds.append)
    return minimise(problem, starts=7)


def test_same_optima_in_half_the_rounds(monkeypatch):
    few, many = [], []
    together = searched(few)
    monkeypatch.setattr(local_search, "TOGETHER", 1)
    alone = searched(many)
    assert np.array_equal(together.variables, alone.variables)
    assert together.objective == alone.objective
    assert together.evaluations == alone.evaluations
    for one, other in zip(together.history, alone.history, strict=True):
        assert np.array_equal(one.end, other.end)
    assert len(few) < 0.5 * len(many)


def test_each_waits_until_all_have_asked():
    met = []

    def search(count):
        def run(ask):
            for turn in range(count):
                ask([np.array([count, turn])])
                met.append((count, turn))
            return count

        return run

    asked = []
    found = side_by_side([search(1), search(3)], lambda points: asked.append(len(points)))
    assert found == [1, 3]
    assert asked == [2, 1, 1, 0]
    assert met == [(1, 0), (3, 0), (3, 1), (3, 2)]


def test_what_one_raises_ends_all():
    def fails(ask):
        ask([np.zeros(1)])
        raise NumericalFailure("there is no smallest value")

    def waits(ask):
        while True:
            ask([np.zeros(1)])

    before = threading.active_count()
    with pytest.raises(NumericalFailure, match="no smallest value"):
        side_by_side([waits, fails, waits], lambda points: None)
    for thread in threading.enumerate():
        if thread.daemon:
            thread.join(5.0)
    assert threading.active_count() == before


def test_a_limit_that_cannot_be_kept_is_given_up_soon():
    def evaluate(x):
        return (x[0] - 0.3) ** 2, [-1.0 - 0.0 * x[0]]

    with pytest.raises(Infeasible) as failure:
        minimise(Problem(evaluate, [0.0], [1.0]), starts=2)
    assert failure.value.violation == 1.0
    assert failure.value.evaluations < 80
