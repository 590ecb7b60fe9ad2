"""Claim: of several maxima of nearly one height over a cycle the highest bearing load is found."""

import numpy as np

from vibecalc.bearings.crank_loads import cycle_peaks
from vibecalc.numerics.rounding import FloatArray

TURN = 2.0 * np.pi


def test_the_higher_of_twins_on_both_sides_of_a_kink() -> None:
    """Two maxima less than a step of the grid apart, with the kink of a gas table between them."""
    draw = np.random.default_rng(7)
    for _ in range(200):
        kink = draw.uniform(0.1, 3.0)
        before, after = draw.uniform(1e-4, 4e-3, 2)
        steep, steeper = draw.uniform(0.4, 0.6, 2)
        level = 1.0 + steep * np.cos(before) - steeper * np.cos(after)

        def size(
            x: FloatArray,
            left: tuple[float, float, float] = (1.0, steep, kink - before),
            right: tuple[float, float, float] = (level, steeper, kink + after),
            kink: float = kink,
        ) -> FloatArray:
            behind = np.mod(x - kink, TURN) < np.pi
            one, other = (c + a * np.cos(x - place) for c, a, place in (left, right))
            return np.asarray(np.where(behind, other, one))

        kinks = np.array([kink, kink + np.pi])
        top, at = cycle_peaks(lambda x, f=size: f(x)[..., None] + 0j, kinks, TURN)  # type: ignore[misc]
        first, second = 1.0 + steep, level + steeper
        height = max(first, second)
        assert abs(top.value[0] - height) <= top.error[0] + 4e-16 * height
        assert top.error[0] < 1e-9
        if abs(first - second) > 1e-9:
            place = kink - before if first > second else kink + after
            assert abs(at.value[0] - place) <= at.error[0] < 1e-5


def test_the_highest_of_many_tops_of_nearly_one_height() -> None:
    """Twelve equal cylinders with a small difference: the grid alone has them in another order."""
    draw = np.random.default_rng(8)
    for _ in range(40):
        phase, other = draw.uniform(0.0, TURN, 2)
        small = 10.0 ** draw.uniform(-9.0, -5.0)

        def size(
            x: FloatArray, phase: float = phase, other: float = other, small: float = small
        ) -> FloatArray:
            return np.asarray(2.0 + 0.5 * np.cos(12.0 * x + phase) + small * np.cos(x + other))

        tops = (TURN * np.arange(1, 14) - phase) / 12.0
        for _ in range(4):
            slope = -6.0 * np.sin(12.0 * tops + phase) - small * np.sin(tops + other)
            bend = -72.0 * np.cos(12.0 * tops + phase) - small * np.cos(tops + other)
            tops = tops - slope / bend
        height = size(tops).max()
        top, _ = cycle_peaks(lambda x, f=size: f(x)[..., None] + 0j, np.zeros(1), TURN)  # type: ignore[misc]
        assert abs(top.value[0] - height) <= top.error[0] + 2e-15
