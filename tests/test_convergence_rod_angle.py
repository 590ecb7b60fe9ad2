"""Claim: the rod's harmonics go to those of a very long rod and of a rod as long as the crank."""

import numpy as np
import pytest

from vibecalc.kinematics.rod_angle import largest_rod_acceleration, rod_angle_harmonics


def test_a_long_rod_swings_like_the_sine():
    # phi = y + y^3/6 + 3 y^5/40 + ..., y = lam sin t
    ratios = np.array([0.2, 0.1, 0.05, 0.025])
    angle = rod_angle_harmonics(ratios, 1.0, highest_order=3).angle.value
    first = np.abs(angle[:, 1] + 1j * ratios * (1.0 + ratios**2 / 8.0))
    third = np.abs(angle[:, 3] - 1j * ratios**3 / 24.0)
    for rest in (first, third):
        rate = np.log2(rest[:-1] / rest[1:])
        assert np.all(np.abs(rate - 5.0) < 0.1)
    # the fifth power's share of order 1 is 3/40 * 10/16
    assert first[-1] == pytest.approx(ratios[-1] ** 5 * 3.0 / 64.0, rel=2e-3)


def test_a_rod_as_long_as_the_crank_swings_like_a_triangle():
    # phi = arcsin(sin t): phi' jumps between 1 and -1, phi'' has impulses, 4/pi at every odd order
    order = np.array([1, 3, 5, 7])
    limit = 4.0j / np.pi * np.array([1, -1, 1, -1])
    gaps = 10.0 ** -np.arange(2.0, 7.0)
    ours = rod_angle_harmonics(1.0 - gaps, 1.0, highest_order=8).acceleration
    distance = np.abs(ours.value[:, order] - limit)
    # the triangle's tips are round over an angle of sqrt(gap), so that about gap n^2 log(1/gap n^2)
    # is missing: a tenth of the gap leaves a tenth of it, but for the logarithm
    rate = distance[:-1] / distance[1:]
    assert np.all(np.diff(rate, axis=0) > 0.0)
    assert np.all(rate < 10.0)
    assert np.all(rate[-1] > 7.5)
    assert np.all(ours.error[-1] < 1e-12)
    assert largest_rod_acceleration(1.0 - 1e-6, 1.0).value == pytest.approx(707.1, rel=1e-4)
