"""Claim: the peak over a cycle is the true one, at the first angle that reaches it, with an honest
error, for any harmonics: a search in 40 digits, shapes made to hide it. Of several maxima of nearly
one height the highest bearing load is found.
"""

import mpmath as mp
import numpy as np
import pytest
from exact_peaks import cycle_peak as exact

from vibecalc.bearings.crank_loads import cycle_peaks
from vibecalc.errors import NumericalFailure
from vibecalc.numerics import cycle_peak as module
from vibecalc.numerics.cycle_peak import cycle_peak, vector_cycle_peak
from vibecalc.numerics.rounding import FloatArray


def random_vectors(count, seed):
    generator = np.random.default_rng(seed)
    for _ in range(count):
        size, components = generator.integers(1, 10), generator.integers(1, 4)
        orders = generator.choice(30, size, replace=False)
        decay = 10.0 ** -generator.uniform(0, 8, size) * 10.0 ** generator.uniform(-20, 20)
        parts = generator.normal(size=(2, components, size)) * decay
        harmonics = parts[0] + 1j * parts[1]
        yield np.where(orders == 0, harmonics.real, harmonics), orders


def test_peaks_are_those_of_forty_digits_and_their_errors_honest():
    estimates, errors = [], []
    with mp.workdps(40):
        for harmonics, orders in random_vectors(120, seed=11):
            peak = vector_cycle_peak(harmonics, orders)
            rows = [[mp.mpmathify(complex(one)) for one in row] for row in harmonics]
            estimates.append(float(peak.error))
            errors.append(float(abs(exact(rows, orders.tolist())[0] - mp.mpf(float(peak.value)))))
            assert errors[-1] <= 1e-13 * np.sum(np.abs(harmonics))
            assert 0 <= peak.angle < 2 * np.pi
    estimates, errors = np.array(estimates), np.array(errors)
    assert np.mean(estimates < 0.1 * errors) <= 0.01
    assert np.median(estimates / np.maximum(errors, 1e-3 * estimates)) < 1000


@pytest.mark.parametrize(
    ("harmonics", "orders", "value", "angle"),
    [
        ([1, 0.25], [1, 2], 1.25, 0.0),
        ([1, -0.25], [1, 2], 1.25, np.pi),
        ([1, -0.25, 0.0], [1, 2, 3], 1.25, np.pi),
        ([1, 0.25], [1, 4], 1.25, 0.0),
        ([1, -1 / 16], [2, 4], 1.0625, np.pi / 2),
        ([-2.0], [0], 2.0, 0.0),
        ([3 + 4j], [2], 5.0, (np.pi - np.arctan2(4, 3)) / 2),
        ([-2.0, 0.5], [0, 1], 2.5, np.pi),
        ([0, 0, 0], [0, 1, 2], 0.0, 0.0),
    ],
)
def test_known_peaks(harmonics, orders, value, angle):
    peak = cycle_peak(harmonics, orders)
    assert peak.value == pytest.approx(value, rel=1e-15, abs=0)
    assert peak.angle == pytest.approx(angle, rel=0, abs=1e-14)
    assert peak.value == 0 or 0 < peak.error < 1e-14


def test_flat_tops_where_newton_alone_would_stall():
    # cos a + b cos 2a with b = -1/4: curvature -1 + 1 = 0 at a = 0, the sum falls like a^4
    peak = cycle_peak([1.0, -0.25, 0.3], [1, 2, 0])
    assert peak.value == pytest.approx(1.05, rel=4e-16)
    assert peak.angle == pytest.approx(0.0, abs=1e-3)
    # Fejer kernels and a Chebyshev ripple: many equal or nearly equal tops
    orders = np.arange(41)
    fejer = (1 - orders / 41.0) * np.where(orders == 0, 1, 2)
    for shift in (0.0, 0.1, np.pi):
        peak = cycle_peak(fejer * np.exp(-1j * orders * shift), orders)
        assert peak.value == pytest.approx(41.0, rel=1e-14)
        assert peak.angle == pytest.approx(shift, abs=1e-13)
    ripple = cycle_peak([1.0, 1e-9 * np.exp(-1.7j)], [12, 1])
    # of |cos 12a| the top nearest to a = 1.7 + k pi gains most, with the sign of the top
    tops = np.arange(24) * np.pi / 12
    gains = 1e-9 * np.cos(tops - 1.7) * np.cos(12 * tops)
    assert ripple.value == pytest.approx(1 + gains.max(), rel=1e-15)
    assert ripple.angle == pytest.approx(tops[gains.argmax()], abs=1e-8)


@pytest.mark.parametrize("bad", [np.nan, np.inf, complex(0, np.inf)])
def test_what_is_not_finite_is_refused_in_words(bad):
    values = np.ones((2, 3, 4), dtype=complex)
    values[1, 2, 3] = bad
    with pytest.raises(NumericalFailure, match=r"harmonic \(1, 2, 3\) of \(2, 3, 4\) is .*finite"):
        vector_cycle_peak(values, [1, 2, 3, 4])


@pytest.mark.parametrize("orders", [np.arange(61), np.array([80, 3, 3, 40, 0])])
def test_a_table_of_waves_and_a_transform_give_the_same_peaks(orders, monkeypatch):
    """Up to a number of orders the signal is sampled by the one, beyond by the other."""
    generator = np.random.default_rng(4)
    parts = generator.normal(size=(2, 20, 3, len(orders)))
    found = []
    for table in (0, 1 << 30):
        monkeypatch.setattr(module, "TABLE", table)
        found.append(vector_cycle_peak(parts[0] + 1j * parts[1], orders))
    first, second = found
    assert np.all(np.abs(first.value - second.value) <= first.error)
    # next to a smooth maximum the angle is known to the root of the rounding only
    assert np.max(np.abs(first.angle - second.angle)) < 1e-8


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
