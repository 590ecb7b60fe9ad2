"""Claim: means, quantiles and Sobol indices are right within the uncertainty they state.

Truth: closed forms, exact fractions, published indices of the Ishigami function.
"""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from vibecalc.core.study.sweep.sampling import (
    FEWEST,
    LEVELS,
    deviation,
    drawn,
    mean,
    quantiles,
    sobol_indices,
)
from vibecalc.errors import NumericalFailure

samples = arrays(float, st.integers(2, 60), elements=st.floats(-1e6, 1e6, allow_subnormal=False))


@settings(max_examples=30)
@given(samples)
def test_mean_is_exact_within_its_error(values):
    exact = sum(map(Fraction, values.tolist())) / len(values)
    found = mean(values)
    assert abs(Fraction(float(found.value)) - exact) <= Fraction(float(found.error))
    assert found.error <= 1e-15 * np.max(np.abs(values)) * len(values)


def test_quantiles_of_even_steps_are_exact():
    values = np.arange(101.0)[::-1] * 2.0
    # 101 1/3 times the level and 1/3 more is the rank, counted from 1
    levels = (0.05, 0.25, 0.5, 0.725, 0.95)
    ranks = [Fraction(304, 3) * Fraction(str(level)) + Fraction(1, 3) for level in levels]
    exact = [float(2 * (rank - 1)) for rank in ranks]
    assert quantiles(values, levels).value == pytest.approx(exact, abs=1e-12)
    between = quantiles(np.array([3.0, 1.0, 2.0, 10.0]), (0.5,))
    assert between.value == pytest.approx([2.5], abs=1e-15)


EXACT = {  # of an exponential variable with mean 1
    "mean": 1.0,
    "deviation": 1.0,
    "quantiles": -np.log1p(-np.array(LEVELS)),
}


@pytest.mark.parametrize("name", list(EXACT))
def test_standard_errors_are_the_scatter_between_samplings(name):
    """400 samplings of 200 exponential values: scatter as stated, and no bias beyond it."""
    statistic = {"mean": mean, "deviation": deviation, "quantiles": quantiles}[name]
    shares = drawn("monte_carlo", np.arange(400 * 200), 1, 400 * 200, 11).reshape(400, 200)
    found = [statistic(-np.log1p(-row)) for row in shares]
    value = np.stack([one.value for one in found])
    stated = np.sqrt(np.mean(np.stack([one.standard_error for one in found]) ** 2, axis=0))
    scatter = np.sqrt(np.mean((value - EXACT[name]) ** 2, axis=0))
    assert np.all((scatter / stated > 0.8) & (scatter / stated < 1.2))
    assert np.all(np.abs(np.mean(value, axis=0) - EXACT[name]) < 0.25 * stated)


def runs_of(function, sampling, points, axes, seed=1):
    """A function at the runs of a design for Sobol indices."""
    both = drawn(sampling, np.arange(points), 2 * axes, points, seed)
    a, b = both[:, :axes], both[:, axes:]
    runs = np.repeat(a[:, None], axes + 2, axis=1)
    runs[:, 1] = b
    for axis in range(axes):
        runs[:, 2 + axis, axis] = b[:, axis]
    return function(runs.reshape(-1, axes))


def ishigami(shares):
    """Ishigami and Homma 1990 with a = 7, b = 0.1 on -pi to pi."""
    x = np.pi * (2.0 * shares - 1.0)
    return np.sin(x[:, 0]) * (1.0 + 0.1 * x[:, 2] ** 4) + 7.0 * np.sin(x[:, 1]) ** 2


def exact_ishigami():
    one = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2
    two, both = 49.0 / 8.0, 8.0 * 0.01 * np.pi**8 / 225.0
    parts = np.array([one, two, 0.0]), np.array([one + both, two, both])
    return tuple(part / (one + two + both) for part in parts)


def sum_and_product(shares):
    """x + 2 y + x y of centred uniform variables: variances 1/12, 4/12 and 1/144."""
    x, y = shares.T - 0.5
    return x + 2.0 * y + x * y


def exact_sum_and_product():
    parts = np.array([12.0, 48.0, 1.0]) / 61.0
    return parts[:2], parts[:2] + parts[2]


FUNCTIONS = [
    (ishigami, 3, exact_ishigami),
    (sum_and_product, 2, exact_sum_and_product),
]


@pytest.mark.parametrize(
    ("function", "axes", "exact", "sampling"),
    [
        *((*one, "sobol") for one in FUNCTIONS),
        (*FUNCTIONS[1], "monte_carlo"),
        *(pytest.param(*one, "monte_carlo", marks=pytest.mark.long) for one in FUNCTIONS[:1]),
    ],
)
def test_indices_of_known_functions(function, axes, exact, sampling):
    found = sobol_indices(runs_of(function, sampling, 4096, axes), axes)
    parts = (found.first, found.first_spread), (found.total, found.total_spread)
    for (value, spread), truth in zip(parts, exact(), strict=True):
        assert np.all(np.abs(value - truth) < 3.5 * spread)
        assert np.all(spread < 0.04)
    assert found.samples == 4096


@pytest.mark.long
def test_standard_errors_of_indices_are_the_scatter_between_samplings():
    found = [sobol_indices(runs_of(ishigami, "monte_carlo", 128, 3, seed), 3) for seed in range(30)]
    for part, truth in enumerate(exact_ishigami()):
        value = np.stack([one[2 * part] for one in found])
        stated = np.sqrt(np.mean(np.stack([one[2 * part + 1] for one in found]) ** 2, axis=0))
        scatter = np.sqrt(np.mean((value - truth) ** 2, axis=0))
        assert np.all((scatter / stated > 0.75) & (scatter / stated < 1.3))


def test_what_has_no_statistic_is_refused():
    with pytest.raises(NumericalFailure, match="too few"):
        mean(np.array([1.0]))
    with pytest.raises(NumericalFailure, match="infinite"):
        quantiles(np.append(np.arange(50.0), np.inf))
    with pytest.raises(NumericalFailure, match=f"they take {FEWEST}"):
        sobol_indices(runs_of(ishigami, "sobol", 8, 3), 3)
    with pytest.raises(NumericalFailure, match="does not vary"):
        sobol_indices(np.full(160, 3.0), 3)
    runs = runs_of(ishigami, "sobol", 32, 3)
    with pytest.raises(NumericalFailure, match="numerical error"):
        sobol_indices(runs, 3, errors=np.full(runs.shape, 100.0))
    with pytest.raises(NumericalFailure, match="no bound"):
        sobol_indices(np.where(runs > 10.0, np.inf, runs), 3)
    with pytest.raises(ValueError, match="between 0 and 1"):
        quantiles(runs, (1.0,))
