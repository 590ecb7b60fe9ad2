"""Claim: known orders are found, fronts and cheapest levels are right, failures are named."""

import math

import numpy as np
import pytest
from accuracy_topics import (
    FULL,
    ONCE,
    Clock,
    euler,
    exact,
    gauss,
    monte_carlo,
    runge_kutta,
    solver,
    topic,
    undefined,
    unstable,
)

from vibecalc.core.accuracy.record import fitted
from vibecalc.core.accuracy.topic import Answer, Reference, Solver, Topic, errors_of, measure
from vibecalc.core.results.layout import (
    ALGEBRAIC,
    GEOMETRIC,
    NOT_FITTED,
    TRIAL_DONE,
    TRIAL_FAILED,
    TRIAL_NOT_RUN,
)
from vibecalc.core.results.trials import Trial, cheapest, extra, on_front
from vibecalc.errors import NumericalFailure

NOISE = 1e-14


def trial(error: float, work: float, name: str = "a", setting: float = 1.0) -> Trial:
    return Trial(name, setting, False, work=work, seconds=work, worst_relative=error)


def measured(asked: Topic) -> tuple[Trial, ...]:
    return measure(asked, *ONCE).trials


def more_work(asked: Topic) -> float:
    return extra(measured(asked), NOISE, "work")


@pytest.mark.parametrize(
    ("one", "order", "kind"),
    [
        (solver(euler, 8, 16, 32, 64, 128, 256, 512), 1.0, ALGEBRAIC),
        (solver(runge_kutta, 2, 4, 8, 16, 32, 64, 128, 4096), 4.0, ALGEBRAIC),
        (solver(monte_carlo, 8, 16, 32, 64, 128), 0.5, ALGEBRAIC),
    ],
)
def test_known_orders_are_found_above_round_off(one: Solver, order: float, kind: str) -> None:
    assert fitted(measured(topic(one)), 1e-16) == (kind, pytest.approx(order, abs=0.1))


def test_gauss_points_converge_geometrically() -> None:
    trials = measured(topic(solver(gauss, 1, 2, 3, 4, 5, 6, 7, 8, 9)))
    kind, value = fitted(trials, 1e-16)
    # two more powers of the half interval over the factorial: the slope of the true errors
    drop = math.log10(trials[1].worst_relative / trials[4].worst_relative) / 3.0
    assert kind == GEOMETRIC and value == pytest.approx(drop, rel=0.1)


def test_trials_at_round_off_or_on_a_plateau_do_not_count() -> None:
    falling = [trial(10.0 ** -(2 * k), 1.0, setting=10.0**k) for k in range(2, 6)]
    tail = [trial(1.1e-10, 1.0, setting=1e6), trial(0.9e-10, 1.0, setting=1e7)]
    assert fitted(falling + tail, 1e-16) == (ALGEBRAIC, pytest.approx(2.0))
    # with a worse reference the last of the four is not distinguished from it
    assert fitted(falling, 1e-11) == (ALGEBRAIC, pytest.approx(2.0))
    level = [trial(0.5, 1.0, setting=10.0**k) for k in range(5)]
    for trials, agreement in ((falling, 1e-7), (falling[:2], 1e-16), (level, 1e-16)):
        assert fitted(trials, agreement) == (NOT_FITTED, 0.0)


def test_front_counts_errors_within_the_noise_as_equal() -> None:
    trials = [trial(1e-3, 1), trial(1e-6, 2), trial(2e-6, 3), trial(1e-15, 9), trial(0.0, 10)]
    assert on_front(trials, NOISE, "work") == [True, True, False, True, False]
    failed = Trial("a", 1.0, False, status=TRIAL_FAILED)
    assert on_front([*trials, failed], NOISE, "work")[-1] is False
    assert on_front([trial(1e-3, 1), trial(1e-3, 1)], NOISE, "work") == [True, True]


def test_work_of_the_default_over_the_least() -> None:
    assert more_work(topic(solver(euler, 4, 8), solver(gauss, 2, 3, default=3))) == 1.0
    accurate = topic(solver(gauss, 4, 8, 10, default=10), solver(exact))
    assert more_work(accurate) == pytest.approx(10.0 / 2.0)
    assert more_work(topic(solver(unstable, 2, 8, default=2))) == math.inf
    assert more_work(topic(solver(euler, 4, 8))) == 1.0


def test_cheapest_for_three_targets() -> None:
    pairs = (1e-2, 1.0), (1e-4, 5.0), (9e-4, 4.0), (1e-7, 50.0), (1e-8, 50.0), (np.inf, 0.0)
    trials = [trial(error, work) for error, work in pairs]
    found = [cheapest(trials, target, "work") for target in (1e-3, 1e-6, 1e-9)]
    assert found == [trials[2], trials[4], None]


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


def test_an_overflow_is_a_failure_and_no_warning() -> None:
    def diverging(_: float) -> Answer:
        value = np.array([1e200])
        return Answer(value * value + 0j, 1.0)

    (one,) = measured(topic(solver(diverging)))
    assert one.status == TRIAL_FAILED and one.cause.startswith("FloatingPointError: overflow")


def test_a_series_ends_where_its_time_does_and_the_default_is_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    clock = Clock()
    monkeypatch.setattr("vibecalc.core.accuracy.topic.time", clock)
    asked = topic(solver(clock.slow, 1.5, 6, 7, 8, default=8), solver(exact))
    trials = measure(asked, 20.0, 0).trials
    done, late = TRIAL_DONE, TRIAL_NOT_RUN
    assert [one.status for one in trials] == [done, done, late, done, done]
    assert trials[2].cause == "the time for its question was used up"
    assert [one.seconds for one in trials] == [1.5, 6.0, math.inf, 8.0, 0.0]


def test_a_reference_that_is_not_finite_is_a_failure() -> None:
    broken = FULL._replace(reference=lambda: Reference(np.array([np.nan]), 0.0, ""))
    with pytest.raises(NumericalFailure, match="not finite"):
        measured(broken)
