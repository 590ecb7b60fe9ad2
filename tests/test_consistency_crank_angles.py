"""Claim: whether the flat four-cylinder crank is a minimum hangs on the reference length.

With cylinders a distance s apart and cranks at 0, 180, 180, 0 degrees, a turn of the cranks by
(a, 3a, -3a, -a) leaves primary forces and couples as they are to first order. An even order n loses
80 n^2 a^2 of its squared force (4 cylinders: 16), and gains 36 n^2 a^2 s^2 of squared couple. Over a
reference length l it is a gain below l = s sqrt(9/20) = 0.67 s and a loss above, for any ratio R/L. Up to a
ratio of .3 it is the only such direction.
"""

import math

import numpy as np
import pytest
from crank_trains import motion, train

from vibecalc.excitation.reciprocating import reciprocating_excitation
from vibecalc.excitation.residual import residual

SPACING = 0.3
POSITION = SPACING * np.array([-1.5, -0.5, 0.5, 1.5])
FLAT = np.array([0.0, np.pi, np.pi, 0.0])
TURN = np.array([1.0, 3.0, -3.0, -1.0])
CHANGE = math.sqrt(9.0 / 20.0)


def train_of(phases: np.ndarray, ratio: float = 0.3, orders: tuple[int, ...] = ()):
    """Forces and couples per squared speed; with `orders`, of those orders only."""
    harmonics = motion(ratio, 12)
    if orders:
        harmonics = np.where(np.isin(np.arange(13), orders), harmonics, 0.0)
    return reciprocating_excitation(harmonics, **train(phases, positions=POSITION))


def squared(phases: np.ndarray, length: float, ratio: float = 0.3) -> float:
    return float(residual(train_of(phases, ratio), reference_length=length).value) ** 2


@pytest.mark.parametrize("order", [2, 4, 6])
def test_force_lost_and_couple_gained(order: int) -> None:
    a = 1e-4
    flat, turned = (train_of(FLAT + x * TURN, orders=(order,)) for x in (0.0, a))
    one = abs(flat.force[order - 1, 2]) / 4.0
    force, couple = abs(turned.force[order - 1, 2] / one), abs(turned.couple[order - 1, 1] / one)
    assert (16.0 - force**2) / (order * a) ** 2 == pytest.approx(80.0, rel=1e-4)
    assert (couple / (order * a * SPACING)) ** 2 == pytest.approx(36.0, rel=1e-4)


def test_primary_is_left_alone_to_first_order() -> None:
    for a in (1e-3, 1e-2):
        turned = train_of(FLAT + a * TURN, orders=(1,))
        one = 0.4 * 0.06
        assert np.abs(turned.force).max() < 20.0 * one * a**2
        assert np.abs(turned.couple).max() < 20.0 * one * SPACING * a**2


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
@pytest.mark.parametrize(("factor", "is_best"), [(0.98, True), (1.02, False), (0.5 / CHANGE, True)])
def test_flat_crank_is_a_minimum_or_a_saddle(ratio: float, factor: float, is_best: bool) -> None:
    length = factor * CHANGE * SPACING
    here = squared(FLAT, length, ratio)
    assert (squared(FLAT + 0.02 * TURN, length, ratio) > here) is is_best
    assert falling_directions(length, ratio) == (0 if is_best else 1)
