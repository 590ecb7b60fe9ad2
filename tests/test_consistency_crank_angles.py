"""Claim: the flat four-cylinder crank is a minimum of the residual up to a reference length.

With cylinders a distance s apart and cranks at 0, 180, 180, 0 degrees, turn the cranks by (a, b,
-b, -a). The primary force stays, the primary couple becomes s (b - 3a), and an even order n of
relative size r loses 8 n^2 (a^2 + b^2) of its squared force, 16, and gains n^2 s^2 (3a + b)^2 of
squared couple. With k = (s/l)^2, l the reference length, and m the sum of n^2 r^2 over the even
orders, the quadratic form in a and b stops being positive where 9 k^2 - 20 (1 + m) k + 16 m = 0:
above l = s / sqrt(k) the crank is a saddle. Up to a ratio R/L of .3 that is the only way down.
"""

import math

import numpy as np
import pytest
from crank_trains import motion, train

from vibecalc.excitation.balance import residual
from vibecalc.excitation.inertia_forces import reciprocating_excitation
from vibecalc.numerics.bounded import Bounded

SPACING = 0.3
POSITION = SPACING * np.array([-1.5, -0.5, 0.5, 1.5])
FLAT = np.array([0.0, np.pi, np.pi, 0.0])


def train_of(phases: np.ndarray, ratio: float = 0.3, orders: tuple[int, ...] = ()) -> Bounded:
    """Forces and couples per squared speed; with `orders`, of those orders only."""
    harmonics = motion(ratio, 12)
    if orders:
        harmonics = np.where(np.isin(np.arange(13), orders), harmonics, 0.0)
    return reciprocating_excitation(harmonics, **train(phases, positions=POSITION))


def squared(phases: np.ndarray, length: float, ratio: float = 0.3) -> float:
    return float(residual(train_of(phases, ratio), reference_length=length).norm().value) ** 2


def longest(ratio: float) -> float:
    """Reference length above which the flat crank is a saddle."""
    orders = np.arange(2, 13, 2)
    size = np.square(orders) * np.abs(motion(ratio, 12)[orders])
    m = float(np.sum(np.square(orders * size)))
    k = (10.0 * (1.0 + m) + math.sqrt(100.0 * (1.0 + m) ** 2 - 144.0 * m)) / 9.0
    return SPACING / math.sqrt(k)


def falling_directions(length: float, ratio: float) -> int:
    """Negative eigenvalues of the second derivatives of the squared residual."""
    step, unit = 1e-3, np.eye(4)[1:]  # a turn of the whole crank changes nothing
    here = squared(FLAT, length, ratio)
    bend = np.empty((3, 3))
    for i, j in np.ndindex(3, 3):
        around = [
            squared(FLAT + step * (a * unit[i] + b * unit[j]), length, ratio)
            for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1))
        ]
        bend[i, j] = (around[0] - around[1] - around[2] + around[3]) / (4.0 * step**2 * here)
    values = np.linalg.eigvalsh(bend)
    assert np.abs(values).min() > 1e-3  # well above the rounding of the differences
    return int(np.sum(values < 0.0))


@pytest.mark.parametrize("ratio", [0.1, 0.2, 0.3])
@pytest.mark.parametrize(("factor", "expected"), [(0.8, 0), (0.99, 0), (1.01, 1), (1.5, 1)])
def test_flat_crank_is_a_minimum_or_a_saddle(ratio: float, factor: float, expected: int) -> None:
    assert falling_directions(factor * longest(ratio), ratio) == expected


def test_reference_length_of_the_shipped_case_is_on_the_side_of_the_minimum() -> None:
    assert longest(0.3) == pytest.approx(0.1785, abs=5e-5)
    assert 0.15 < longest(0.3) < SPACING
