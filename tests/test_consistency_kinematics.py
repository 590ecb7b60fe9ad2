"""Claim: harmonics, motion and remainders agree with independent truths in 50 digits and more.

Relative error of every harmonic at most 1e-14 for R/L up to .99 and orders to 200, with and without
an offset, and the error estimates are neither too small nor absurdly large.
"""

import mpmath as mp
import numpy as np
import pytest
from long_but import long_but

from vibecalc.kinematics.harmonics import harmonics_with_error, motion_harmonics
from vibecalc.kinematics.slider_crank import (
    piston_displacement,
    piston_motion,
    stroke,
    top_dead_centre,
)
from vibecalc.kinematics.truncated_series import (
    RELATIVE_ERROR,
    truncated_dropped_acceleration,
    truncated_harmonics,
)

RATIOS = (1e-3, 0.1, 0.2105, 0.3, 0.5, 0.9, 0.99)
OFFSETS = ((0.3, 0.25), (0.2105, -0.5), (0.6, 0.4), (0.05, 15.0), (0.3, 1e-8), (0.9, 1e-3))
SMALLEST = mp.mpf(2) ** -1022


def closed_form(rod_ratio, highest_order, digits=40):
    """Real C_n without an offset, from mpmath's 2F1."""
    with mp.workdps(digits):
        lam = mp.mpf(rod_ratio)
        kappa = lam / (1 + mp.sqrt(1 - lam**2))
        values = [mp.mpf(0)] * (highest_order + 1)
        for k in range(highest_order // 2 + 1):
            series = mp.hyp2f1(-0.5, k - mp.mpf(1) / 2, k + 1, kappa**4)
            values[2 * k] = mp.binomial(mp.mpf(1) / 2, k) * kappa ** (2 * k - 1) * series
        values[0] /= 2
        values[1] = mp.mpf(1)
        return values


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


@pytest.mark.parametrize("rod_ratio", long_but(RATIOS, 1e-3, 0.2105, 0.99))
@pytest.mark.parametrize("derivative", [0, 2])
def test_harmonics_hold_fourteen_digits_at_every_order(rod_ratio, derivative):
    ours = harmonics_with_error(rod_ratio, 200, derivative=derivative)
    estimates, errors = [], []
    for n, truth in enumerate(closed_form(rod_ratio, 200)):
        truth *= mp.mpf(n) ** derivative * (-1) ** (derivative // 2)
        if abs(truth) < SMALLEST:
            assert ours.values[n] == 0
            continue
        error = abs(mp.mpmathify(complex(ours.values[n])) - truth)
        assert error <= mp.mpf("1e-14") * abs(truth), f"order {n}"
        estimates.append(ours.error[n] / abs(truth))
        errors.append(error / abs(truth))
    assert_honest(estimates, errors)


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
    truth = closed_form(1e-3, 100)
    order = next(n for n in range(2, 101, 2) if abs(truth[n]) < SMALLEST)
    assert motion_harmonics(1e-3, order)[order] == 0
    ours = motion_harmonics(1e-3, order, derivative=2)[order].real
    exact = -(order**2) * truth[order]
    assert abs(exact) >= SMALLEST
    assert abs(ours / exact - 1) < 1e-14


def exact_motion(angle, radius, length, offset):
    turn, crank, reach, aside = (mp.mpf(float(x)) for x in (angle, radius, length, offset))
    lift, slope = crank * mp.sin(turn), crank * mp.cos(turn)
    across = lift - aside
    rod = mp.sqrt(reach**2 - across**2)
    velocity = -lift - across * slope / rod
    acceleration = -slope + across * lift / rod - slope**2 * reach**2 / rod**3
    return slope + rod, velocity, acceleration


@pytest.mark.parametrize(
    ("radius", "length", "offset"),
    [
        (0.06, 0.2, 0.0),
        (0.5, 2.375, 0.3),
        (0.06, 0.2, -0.13),
        (0.999999, 1.0, 0.0),
        (0.9, 1.0, 0.09),
    ],
)
def test_motion_and_its_error_estimates(radius, length, offset):
    generator = np.random.default_rng(20080319)
    angles = generator.uniform(-7, 7, 150)
    near = np.pi / 2 + generator.normal(size=50) * 10.0 ** generator.uniform(-9, -1, 50)
    angles = np.concatenate([angles, near, [0.0, np.pi / 2, np.pi, -np.pi / 2]])
    ours = piston_motion(angles, radius, length, offset)
    with mp.workdps(50):
        truth = [exact_motion(t, radius, length, offset) for t in angles]
        for part in range(3):
            values, estimates = ours[part], ours[part + 3]
            errors = [
                float(abs(mp.mpf(float(value)) - row[part]))
                for value, row in zip(values, truth, strict=True)
            ]
            assert np.all(estimates <= 1e-14 * (np.max(np.abs(values)) + length))
            assert_honest(estimates, errors)


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


def test_truncated_harmonics_and_their_rest_against_exact_sums():
    with mp.workdps(40):
        for rod_ratio, terms in ((1e-3, 60), (0.3, 7), (0.9, 40), (0.99, 3), (0.999999, 200)):
            lam = mp.mpf(rod_ratio)
            b = [mp.binomial(2 * j, j) / (mp.mpf(4) ** j * (2 * j - 1)) for j in range(terms + 1)]
            ours = truncated_harmonics(rod_ratio, terms, 2 * terms + 1).real
            assert ours[1] == 1
            assert ours[-1] == 0
            for k in range(1, terms + 1, max(1, terms // 9)):
                exact = (-1) ** (k + 1) * mp.fsum(
                    b[j] * lam ** (2 * j - 1) * 2 * mp.binomial(2 * j, j - k) / mp.mpf(4) ** j
                    for j in range(k, terms + 1)
                )
                if abs(exact) >= SMALLEST:
                    assert abs(ours[2 * k] - exact) <= RELATIVE_ERROR * abs(exact)
                else:
                    assert ours[2 * k] == 0
            kept = mp.fsum(2 * j * b[j] * lam ** (2 * j - 1) for j in range(1, terms + 1))
            rest = lam / mp.sqrt(1 - lam**2) - kept
            if rest > mp.mpf("1e-25"):
                ours_rest = truncated_dropped_acceleration(rod_ratio, terms)
                assert abs(ours_rest - rest) <= 1e-12 * rest
