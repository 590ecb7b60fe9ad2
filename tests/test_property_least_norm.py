"""Claim: the least norm within discs meets its own lower bound, on any problem drawn."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from vibecalc.numerics.least_norm import LeastNorm, least_norm

Problem = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _drawn(seed: int) -> Problem:
    random = np.random.default_rng(seed)
    sizes = random.integers(1, 3, size=random.integers(1, 6))
    block = np.repeat(np.arange(sizes.size), sizes)
    rows = int(random.integers(1, 14))
    columns = random.normal(size=(rows, block.size)) * 10.0 ** random.uniform(-2, 2, block.size)
    unit = 10.0 ** random.uniform(-9, 9)
    constant = random.normal(size=rows) * 10.0 ** random.uniform(-1, 2)
    return unit * constant, unit * columns, block, 10.0 ** random.uniform(-2, 1, sizes.size)


def _lengths(found: LeastNorm, block: np.ndarray) -> np.ndarray:
    return np.sqrt(np.bincount(block, found.unknowns**2))


@pytest.mark.parametrize("seed", range(40))
def test_the_bound_from_below_meets_the_minimum(seed: int) -> None:
    constant, columns, block, radius = _drawn(seed)
    found = least_norm(constant, columns, block, radius)
    size = np.linalg.norm(constant)
    assert found.value == pytest.approx(np.linalg.norm(constant + columns @ found.unknowns))
    assert found.value - found.lower_bound <= 1e-11 * size
    assert np.all(_lengths(found, block) <= radius * (1.0 + 1e-12))
    held = _lengths(found, block) >= radius * (1.0 - 1e-12)
    assert np.array_equal(found.held, held & found.held)


@pytest.mark.parametrize("loose", [0, 3, 6, 9, 11])
def test_bounds_that_are_far_off_change_neither_minimum_nor_proof(loose: int) -> None:
    """Against bounded-variable least squares, with tight bounds that hold beside loose ones."""
    for seed in range(12):
        random = np.random.default_rng(seed)
        count = int(random.integers(2, 6))
        rows = count + int(random.integers(1, 4))
        columns, constant = random.normal(size=(rows, count)), random.normal(size=rows)
        radius = random.uniform(0.05, 0.5, count)
        radius[random.random(count) < 0.5] *= 10.0**loose
        found = least_norm(constant, columns, np.arange(count), radius)
        other = lsq_linear(columns, -constant, (-radius, radius), method="bvls", tol=1e-15)
        least, size = np.sqrt(2.0 * other.cost), np.linalg.norm(constant)
        assert found.value == pytest.approx(least, abs=1e-14 * size)
        assert -1e-14 * size <= found.value - found.lower_bound <= 1e-14 * size


def test_a_far_bound_that_counts_is_kept() -> None:
    """Two nearly parallel columns reach the target only where both are far out."""
    columns, constant = np.array([[1.0, 1.0], [0.0, 1e-6]]), np.array([0.0, -1.0])
    for radius, expected in ((2e6, 0.0), (5e5, 0.5)):
        both = np.full(2, radius)
        found = least_norm(constant, columns, np.arange(2), both)
        other = lsq_linear(columns, -constant, (-both, both), method="bvls", tol=1e-15)
        assert found.value == pytest.approx(np.sqrt(2.0 * other.cost), abs=1e-8)
        assert found.value == pytest.approx(expected, abs=1e-6)
        assert found.lower_bound <= found.value
