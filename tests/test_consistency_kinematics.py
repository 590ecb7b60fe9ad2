"""Claim: harmonics with an offset, and ways from dead centre, agree with 50 digits and more.

Relative error of every harmonic at most 1e-14 to order 200, and error estimates that are neither
too small nor absurdly large. Without an offset they are cases of `stability/hard_kinematics.py`.
"""

import mpmath as mp
import numpy as np
import pytest
from stability.hard_kinematics import closed

from vibecalc.kinematics.harmonics import harmonics_with_error, motion_harmonics
from vibecalc.kinematics.slider_crank import (
    piston_displacement,
    stroke,
    top_dead_centre,
)

OFFSETS = ((0.3, 0.25), (0.2105, -0.5), (0.6, 0.4), (0.05, 15.0), (0.3, 1e-8), (0.9, 1e-3))
SMALLEST = mp.mpf(2) ** -1022


def quadrature(rod_ratio, offset_ratio, orders, points):
    """Complex C_n by the trapezoidal rule, nothing but the law of the motion."""
    lam, offset = mp.mpf(rod_ratio), mp.mpf(offset_ratio)
    turn = [mp.expjpi(mp.mpf(2) * k / points) for k in range(points)]
    motion = [t.real + mp.sqrt(1 - (lam * (t.imag - offset)) ** 2) / lam for t in turn]
    share = {n: mp.mpf(1 if n == 0 else 2) / points for n in orders}
    return {
        n: share[n] * mp.fdot(motion, [mp.conj(turn[n * k % points]) for k in range(points)])
        for n in orders
    }


def assert_honest(estimates, errors):
    """Below a tenth of the true error in at most 1 %, and of its size (only rounding is lucky)."""
    estimates, errors = np.asarray(estimates, float), np.asarray(errors, float)
    assert np.mean(estimates < 0.1 * errors) <= 0.01
    assert np.median(estimates) <= 1000 * np.max(errors)


@pytest.mark.parametrize(
    ("rod_ratio", "offset_ratio"),
    [
        one if place % 3 == 0 else pytest.param(*one, marks=pytest.mark.long)
        for place, one in enumerate(OFFSETS)
    ],
)
def test_harmonics_with_an_offset_hold_fourteen_digits(rod_ratio, offset_ratio):
    orders = (0, 1, 2, 3, 4, 7, 30, 51, 100, 149, 200)
    ours = harmonics_with_error(rod_ratio, 200, offset_ratio)
    # rounding of the quadrature and aliasing have to stay below C_200
    far = 2048 if rod_ratio > 0.8 else 768
    estimates, errors = [], []
    with mp.workdps(280):
        for n, truth in quadrature(rod_ratio, offset_ratio, orders, far).items():
            error = abs(mp.mpmathify(complex(ours.values[n])) - truth)
            assert error <= mp.mpf("1e-14") * abs(truth), f"order {n}"
            estimates.append(ours.error[n] / abs(truth))
            errors.append(error / abs(truth))
    assert_honest(estimates, errors)


def test_acceleration_keeps_its_digits_where_position_has_underflowed():
    with mp.workdps(40):
        orders = tuple(range(2, 101, 2))
        exact = dict(zip(orders, closed(mp.mpf(1e-3), orders), strict=True))
    order = next(n for n in orders if abs(exact[n]) < n**2 * SMALLEST)
    assert motion_harmonics(1e-3, order)[order] == 0
    ours = motion_harmonics(1e-3, order, derivative=2)[order].real
    assert abs(exact[order]) >= SMALLEST
    assert abs(ours / exact[order] - 1) < 1e-14


def exact_motion(angle, radius, length, offset):
    turn, crank, reach, aside = (mp.mpf(float(x)) for x in (angle, radius, length, offset))
    lift, slope = crank * mp.sin(turn), crank * mp.cos(turn)
    across = lift - aside
    rod = mp.sqrt(reach**2 - across**2)
    velocity = -lift - across * slope / rod
    acceleration = -slope + across * lift / rod - slope**2 * reach**2 / rod**3
    return slope + rod, velocity, acceleration


@pytest.mark.parametrize("offset", [0.0, 0.02, -0.1])
def test_way_from_top_dead_centre_keeps_its_digits_at_a_tiny_way(offset):
    radius, length = 0.06, 0.2
    start = float(top_dead_centre(radius, length, offset).angle)
    angles = start + np.concatenate([10.0 ** -np.arange(0.0, 9.0), np.linspace(0.1, 6.2, 20)])
    ours = piston_displacement(angles, radius, length, offset)
    with mp.workdps(50):
        outer = mp.mpf(length) + mp.mpf(radius)
        inner = mp.mpf(length) - mp.mpf(radius)
        top = mp.sqrt(outer**2 - mp.mpf(offset) ** 2)
        bottom = mp.sqrt(inner**2 - mp.mpf(offset) ** 2)
        truth = [top - exact_motion(t, radius, length, offset)[0] for t in angles]
        errors = [abs(mp.mpf(float(x)) - y) for x, y in zip(ours.value, truth, strict=True)]
        assert_honest(ours.error, errors)
        if offset == 0.0:
            assert max(e / y for e, y in zip(errors, truth, strict=True)) < 2e-15
        ours_stroke = mp.mpf(float(stroke(radius, length, offset)))
        assert abs(ours_stroke / (top - bottom) - 1) < 1e-15
