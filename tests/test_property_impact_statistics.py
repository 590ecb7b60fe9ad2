"""Claim: statistics of impacts do not depend on the order of members; who leads and when runs part
is read off as a plain count would."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vibecalc.impact.runs import APART, TOGETHER, parting
from vibecalc.impact.statistics import (
    IMPACT,
    Statistic,
    dominance,
    dominant,
    dominant_from,
    mean_over_runs,
    quantiles,
)

sizes = st.floats(0.0, 1e6)


@settings(max_examples=30)
@given(
    arrays(np.float64, (2, 6, 4), elements=st.floats(-1e6, 1e6)),
    st.permutations(range(6)),
)
def test_members_may_stand_in_any_order(values, order):
    for one, two in zip(
        (mean_over_runs(values), *quantiles(values, (0.05, 0.5, 0.95))),
        (mean_over_runs(values[:, order]), *quantiles(values[:, order], (0.05, 0.5, 0.95))),
        strict=True,
    ):
        scale = 1e-12 * max(np.max(np.abs(values)), 1e-300)
        np.testing.assert_allclose(one.value, two.value, rtol=0.0, atol=scale)
        np.testing.assert_allclose(one.standard_error, two.standard_error, rtol=1e-6, atol=scale)


@given(st.floats(-1e9, 1e9), st.integers(2, 9), st.integers(1, 9))
def test_what_never_changes_has_no_scatter(value, members, revolutions):
    values = np.full((1, members, revolutions), value)
    found = quantiles(values, (0.05, 0.95))
    for statistic in found:
        assert statistic.value[0] == value
        assert statistic.standard_error[0] == 0.0
    mean = mean_over_runs(values)
    assert abs(mean.value[0] - value) <= 1e-15 * abs(value)
    assert mean.standard_error[0] <= 1e-15 * abs(value)


@given(arrays(np.int64, st.integers(1, 12), elements=st.integers(0, 2)))
def test_dominant_from_is_a_count_from_the_end(leading):
    order = len(leading)
    while order > 0 and leading[order - 1] == IMPACT:
        order -= 1
    expected = order + 1 if order < len(leading) else 0
    assert dominant_from(leading) == expected


@settings(max_examples=30)
@given(
    arrays(np.float64, (2, 8), elements=sizes),
    arrays(np.float64, (2, 8), elements=st.floats(0.0, 10.0)),
    arrays(np.float64, 8, elements=sizes),
    arrays(np.float64, 8, elements=sizes),
)
def test_dominance_names_the_largest(value, uncertainty, shaking, motor):
    found = dominance(Statistic(value, uncertainty), shaking, motor)
    for c in range(2):
        for n in range(8):
            three = (shaking[n], value[c, n], motor[n])
            assert three[found.dominant[c, n]] == max(three)
    np.testing.assert_array_equal(
        found.dominant_from, dominant_from(dominant(value, shaking, motor))
    )
    sure = dominance(Statistic(value, np.zeros_like(value)), shaking, motor)
    assert not np.any(sure.dominant_spread) and not np.any(sure.dominant_from_spread)
    # an uncertainty that can change what dominates an order shows
    flips = (value - 2 * uncertainty > shaking) != (value + 2 * uncertainty > shaking)
    assert np.all((found.dominant_spread > 0.0)[flips & (motor == 0.0)])


@given(st.floats(-14.0, -2.0), st.floats(0.05, 6.0), st.integers(1, 20))
def test_exponential_parting(exponent, rate, turns):
    start = 10.0**exponent
    distances = np.minimum(start * np.exp(rate * np.arange(turns + 1)), 1.0)
    found = parting(distances)
    when = np.log(APART / start) / rate
    # a distance beyond 1, as of runs that have parted, is no part of the exponential
    reaches = distances[-1] >= APART
    if not reaches:
        assert np.isinf(found.revolutions)
    elif start * np.exp(rate * np.ceil(when)) <= 1.0 and start > TOGETHER:
        assert abs(found.revolutions - when) < 1e-9 * (1.0 + when)
        assert abs(found.rate - rate) < 1e-9 * rate
    else:
        assert np.floor(when) <= found.revolutions <= np.ceil(when) + 1e-9


def test_runs_that_fall_together_never_part():
    found = parting(np.array([[1e-6, 1e-12, 0.0, 0.0], [0.5, 1.0, 1.0, 1.0]]))
    assert np.isinf(found.revolutions[0]) and found.rate[0] == np.log(TOGETHER / 1e-6) / 3
    assert found.revolutions[1] == 0.0
