"""Claim: the half range of a sum over orders lies between the bounds that samples give."""

import numpy as np
import pytest

from vibecalc.numerics.synthesis import synthesis
from vibecalc.torsion.rough_range import rough_range


@pytest.mark.parametrize("seed", range(8))
def test_half_ranges_lie_between_their_bounds(seed: int) -> None:
    generator = np.random.default_rng(seed)
    count, step = int(generator.integers(1, 60)), [0.5, 1.0][seed % 2]
    order = step * (1 + np.sort(generator.choice(90, count, replace=False)))
    size = 10.0 ** generator.uniform(-8, 8, (40, 1)) / order ** generator.integers(0, 3)
    amplitude = size * (generator.normal(size=(40, count)) + 1j * generator.normal(size=count))
    amplitude[0] = 0.0
    exact = synthesis(order, amplitude).half_range
    low, high = rough_range(order, amplitude.reshape(5, 8, count))
    assert (low.ravel() <= exact).all() and (exact <= high.ravel()).all()
    assert (high.ravel() - low.ravel() <= 0.1 * np.abs(amplitude).sum(axis=1)).all()


def test_many_orders_go_through_a_transform() -> None:
    order = np.arange(1, 200) / 2.0
    amplitude = np.exp(1j * order**2)[None] / order
    (low,), (high,) = rough_range(order, amplitude)
    assert low <= synthesis(order, amplitude).half_range[0] <= high <= 1.1 * low


def test_orders_without_a_common_cycle_have_no_bounds() -> None:
    low, high = rough_range(np.array([1.0, 1.3]), np.ones((3, 2), dtype=complex))
    assert not low.any() and np.isinf(high).all()
