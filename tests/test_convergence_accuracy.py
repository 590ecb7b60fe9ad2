"""Claim: errors are measured in three norms, and failures and what time cut short are named."""

import math

import numpy as np
import pytest
from accuracy_topics import (
    FULL,
    ONCE,
    Clock,
    exact,
    solver,
    topic,
    undefined,
    unstable,
)

from vibecalc.core.accuracy.topic import Answer, Reference, Topic, errors_of, measure
from vibecalc.core.results.layout import (
    TRIAL_DONE,
    TRIAL_FAILED,
    TRIAL_NOT_RUN,
)
from vibecalc.core.results.trials import Trial
from vibecalc.errors import NumericalFailure


def measured(asked: Topic) -> tuple[Trial, ...]:
    return measure(asked, *ONCE).trials


def test_three_norms() -> None:
    truth = np.array([3.0 + 4.0j, 0.0, 1e-7])

    def errors(values: np.ndarray, true: np.ndarray) -> tuple[float, float, float]:
        return errors_of(Answer(values, 1.0, 0.3), Reference(true, 0.0, "", 0.1))

    found = errors(truth * np.array([1.01, 1.0, 2.0]), truth)
    assert found == pytest.approx((0.01, 20.0 * math.log10(1.01), 0.2))
    assert errors(np.array([0.0, 5.0]), np.array([2.0, 5.0]))[1] == math.inf
    assert errors(np.zeros(2), np.zeros(2))[:2] == (0.0, 0.0)
    assert errors(np.ones(2), np.zeros(2))[0] == math.inf
    with pytest.raises(ValueError, match=r"shape \(2,\) for a truth of shape \(1,\)"):
        errors(np.ones(2), np.ones(1))


def test_failures_are_listed_with_their_cause() -> None:
    asked = topic(solver(unstable, 2, 4, 8), solver(undefined, 1, 2))
    trials = measured(asked)
    assert [one.status for one in trials] == [
        TRIAL_FAILED,
        TRIAL_FAILED,
        TRIAL_DONE,
        TRIAL_FAILED,
        TRIAL_FAILED,
    ]
    assert [one.cause for one in trials] == [
        "the step is above the limit of stability",
        "LinAlgError: singular matrix",
        "",
        "the answer is not a number",
        "the answer is infinite",
    ]
    assert all(one.worst_relative == math.inf for one in trials if one.status == TRIAL_FAILED)


def test_a_series_ends_where_its_time_does_and_the_default_is_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    monkeypatch.setattr("vibecalc.core.accuracy.topic.time", clock)
    asked = topic(solver(clock.slow, 1.5, 6, 7, 8, default=8), solver(exact))
    trials = measure(asked, 20.0, 0).trials
    done, late = TRIAL_DONE, TRIAL_NOT_RUN
    assert [one.status for one in trials] == [done, done, late, done, done]
    assert trials[2].cause == "the time limit of its topic was reached"
    assert [one.seconds for one in trials] == [1.5, 6.0, math.inf, 8.0, 0.0]


def test_a_reference_that_is_not_finite_is_a_failure() -> None:
    broken = FULL._replace(reference=lambda: Reference(np.array([np.nan]), 0.0, ""))
    with pytest.raises(NumericalFailure, match="not finite"):
        measured(broken)
