"""Claim: symmetries, limits and refusals of the slider-crank hold for any machine."""

import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import (
    dropped_acceleration,
    harmonics_with_error,
    motion_harmonics,
    order_for_tolerance,
)
from vibecalc.kinematics.slider_crank import (
    bottom_dead_centre,
    piston_displacement,
    piston_motion,
    stroke,
    top_dead_centre,
)


def machines(count, seed=1):
    generator = np.random.default_rng(seed)
    ratio = generator.uniform(0.01, 0.97, count)
    offset = generator.uniform(-1, 1, count) * 0.95 * (1 / ratio - 1)
    return ratio, offset


def test_a_zero_offset_changes_no_bit():
    ratio, _ = machines(40)
    plain = harmonics_with_error(ratio, 60)
    for zero in (0.0, -0.0, np.zeros(40)):
        other = harmonics_with_error(ratio, 60, zero)
        assert np.array_equal(plain.values, other.values)
        assert np.array_equal(plain.error, other.error)
    mixed = motion_harmonics(np.repeat(ratio, 2), 60, np.tile([0.0, 0.01], 40))
    assert np.array_equal(mixed[::2], plain.values)
    assert not np.array_equal(mixed[1::2], plain.values)


def test_entries_of_an_array_do_not_know_each_other():
    ratio, offset = machines(12)
    together = motion_harmonics(ratio[:, None], 30, offset[:, None] * [[1.0, 0.5]])
    assert together.shape == (12, 2, 31)
    alone = [motion_harmonics(r, 30, 0.5 * e) for r, e in zip(ratio, offset, strict=True)]
    np.testing.assert_allclose(together[:, 1], np.array(alone), rtol=2e-15, atol=0)


def test_mirrored_offset_gives_conjugate_harmonics():
    ratio, offset = machines(50)
    ours, mirrored = motion_harmonics(ratio, 50, offset), motion_harmonics(ratio, 50, -offset)
    assert np.array_equal(mirrored, ours.conj())


def test_without_offset_odd_orders_vanish_and_even_ones_alternate():
    ratio, _ = machines(50)
    values = motion_harmonics(ratio, 41)
    assert np.all(values[:, 3::2] == 0)
    assert np.all(values[:, 1] == 1)
    assert np.all(values.imag == 0)
    assert np.all(values[:, 2::4].real > 0)
    assert np.all(values[:, 4::4].real < 0)


def test_a_small_offset_adds_odd_orders_in_proportion():
    base = motion_harmonics(0.3, 21, 1e-3)[1::2].imag
    for factor in (1e-3, 1e-9, 1e-100):
        scaled = motion_harmonics(0.3, 21, 1e-3 * factor)[1::2].imag
        np.testing.assert_allclose(scaled, base * factor, rtol=1e-5)
    assert np.all(base != 0)


def test_rod_harmonics_have_one_sign_at_the_nearest_pole():
    # what the closed form of the dropped orders stands on
    ratio, offset = machines(300, seed=2)
    values = motion_harmonics(ratio, 80, np.abs(offset))
    values[:, 1] -= 1
    turned = values * (-1j) ** np.arange(81)
    real = turned.real[:, 1:]
    assert np.all(real <= 0)
    assert np.all(np.abs(turned.imag[:, 1:]) <= 1e-15 * np.abs(real))


def test_long_rods_and_high_orders_underflow_to_zero():
    values = harmonics_with_error(1e-3, 400, [[0.0], [0.5]])
    assert np.all(np.isfinite(values.values))
    assert np.all(values.values[..., 200:] == 0)
    nonzero = np.abs(values.values[values.values != 0])
    assert np.all(nonzero >= np.finfo(float).tiny)
    assert np.all(values.error[0, 0, 200::2] > 0)


def test_velocity_and_acceleration_are_derivatives():
    angle = np.linspace(0, 6.2, 63)
    step = 1e-3 * 1j
    for radius, offset in ((0.06, 0.0), (0.06, -0.05), (0.15, 0.03)):

        def position(t, radius=radius, offset=offset):
            return radius * np.cos(t) + np.sqrt(0.04 - (radius * np.sin(t) - offset) ** 2)

        # complex steps: no difference, so no cancellation; Cauchy's formula on a small circle
        circle = step * np.exp(2j * np.pi * np.arange(8) / 8)
        around = position(angle[:, None] + circle)
        motion = piston_motion(angle, radius, 0.2, offset)
        first = np.mean(around / circle, axis=1).real
        second = 2 * np.mean(around / circle**2, axis=1).real
        np.testing.assert_allclose(motion.velocity, first, rtol=0, atol=1e-12)
        np.testing.assert_allclose(motion.acceleration, second, rtol=0, atol=1e-9)


def test_motion_repeats_each_turn_and_mirrors_with_the_offset():
    angle = np.linspace(-3, 3, 25)
    ours = piston_motion(angle, 0.06, 0.2, 0.03)
    mirrored = piston_motion(-angle, 0.06, 0.2, -0.03)
    assert np.array_equal(ours.position, mirrored.position)
    assert np.array_equal(ours.velocity, -mirrored.velocity)
    assert np.array_equal(ours.acceleration, mirrored.acceleration)
    later = piston_motion(angle + 2 * np.pi, 0.06, 0.2, 0.03)
    np.testing.assert_allclose(later.acceleration, ours.acceleration, rtol=0, atol=1e-15)


def test_way_from_top_dead_centre_stays_within_the_stroke():
    ratio, offset = machines(200, seed=3)
    angle = np.random.default_rng(4).uniform(-7, 7, (50, 200))
    way = piston_displacement(angle, ratio, 1.0, ratio * offset)
    whole = stroke(ratio, 1.0, ratio * offset)
    top = top_dead_centre(ratio, 1.0, ratio * offset)
    bottom = bottom_dead_centre(ratio, 1.0, ratio * offset)
    assert np.all(way.value >= 0)
    assert np.all(way.value <= whole * (1 + 1e-13) + way.error)
    at_top = piston_displacement(top.angle, ratio, 1.0, ratio * offset)
    at_bottom = piston_displacement(bottom.angle, ratio, 1.0, ratio * offset)
    assert np.all(at_top.value == 0)
    np.testing.assert_allclose(at_bottom.value, whole, rtol=1e-13)
    assert np.all(whole >= 2 * ratio * (1 - 1e-15))
    np.testing.assert_allclose(stroke(ratio, 1.0), 2 * ratio, rtol=4e-16)


@pytest.mark.parametrize("offset_ratio", [0.0, 0.4])
@pytest.mark.parametrize("rod_ratio", [0.05, 0.2105, 0.3, 0.7])
@pytest.mark.parametrize("rtol", [1e-2, 1e-6, 1e-12])
def test_the_order_for_a_tolerance_is_the_smallest_that_meets_it(rod_ratio, offset_ratio, rtol):
    order = order_for_tolerance(rod_ratio, rtol, offset_ratio)
    amplitude = np.abs(motion_harmonics(rod_ratio, 400, offset_ratio, derivative=2))
    largest = np.max(amplitude)
    assert dropped_acceleration(rod_ratio, order, offset_ratio) <= rtol * largest * (1 + 1e-12)
    assert dropped_acceleration(rod_ratio, order - 1, offset_ratio) > rtol * largest
    np.testing.assert_allclose(
        dropped_acceleration(rod_ratio, order, offset_ratio),
        np.sum(amplitude[:order:-1]),
        rtol=1e-12,
    )


def test_the_error_estimate_is_finite_and_small_up_to_the_edge():
    ratio = 1.0 - 10.0 ** -np.arange(1.0, 8.0)
    values, error = harmonics_with_error(ratio, 60)
    assert np.all(error[:, ::2] <= 2e-14 * np.abs(values[:, ::2]))
    assert np.all(error[:, 1::2] == 0)


@pytest.mark.parametrize(
    ("rod_ratio", "offset_ratio", "found"),
    [
        (1.0, 0.0, "R/L = 1 with e/R = 0"),
        (1.2, 0.0, "R/L = 1.2"),
        (0.0, 0.0, "R/L = 0 with"),
        (-0.3, 0.0, "R/L = -0.29"),
        (0.5, 1.0, "e/R = 1;"),
        (0.5, -1.5, "R/L = 0.5 with e/R = 1.5"),
        (float("nan"), 0.0, "R/L = nan"),
    ],
)
def test_a_crank_that_cannot_turn_is_refused_in_words(rod_ratio, offset_ratio, found):
    with pytest.raises(NumericalFailure) as failure:
        motion_harmonics([0.3, rod_ratio], 4, [0.0, offset_ratio])
    assert found in str(failure.value)
    assert "R + |e| below L" in str(failure.value)


def test_too_many_orders_for_a_tolerance_are_refused_in_words():
    with pytest.raises(NumericalFailure, match=r"more than 16384 harmonics .* choose the highest"):
        order_for_tolerance(1.0 - 1e-8, 1e-12)
