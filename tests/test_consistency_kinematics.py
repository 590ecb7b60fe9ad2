"""Claim: harmonics with an offset, ways from dead centre, and harmonics of the rod's angle agree
with quadrature in 30 digits and more.

Relative error of every harmonic of the motion at most 1e-14 to order 200, and error estimates that
are neither too small nor absurdly large. Without an offset they are cases of
`stability/hard_kinematics.py`.
"""

import mpmath as mp
import numpy as np
import pytest
from exact_rod import fourier, rod_angle
from long_but import long_but
from stability.hard_kinematics import closed

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.harmonics import harmonics_with_error, motion_harmonics
from vibecalc.kinematics.rod_angle import largest_rod_acceleration, rod_angle_harmonics
from vibecalc.kinematics.slider_crank import piston_displacement, stroke, top_dead_centre

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


#: R, L, e in m, and samples enough for 25 digits and more
GEOMETRIES = [
    (0.0127, 0.060325, 0.0, 128),
    (0.06, 0.2, 0.015, 256),
    (0.3, 1.0, -0.2, 256),
    (1e-4, 0.1, 0.0, 64),
    (0.02, 1.0, -0.9, 256),
    (0.9, 1.0, 0.0, 512),
    (0.9, 1.0, 0.05, 1024),
    (0.99, 1.0, 0.0, 1024),
]
ORDERS = (0, 1, 2, 3, 4, 5, 8, 9, 16, 17)


def truth(radius, length, offset, samples):
    """Harmonics of phi by quadrature, of its derivatives by (i n)^k, of phi'^2 / 2 likewise."""
    geometry = [mp.mpf(value) for value in (radius, length, offset)]

    def slope(t):
        return geometry[0] * mp.cos(t) / (geometry[1] * mp.cos(rod_angle(t, *geometry)))

    angle = fourier(lambda t: rod_angle(t, *geometry), ORDERS, samples)
    energy = fourier(lambda t: slope(t) ** 2 / 2, ORDERS, samples)
    return {
        "acceleration": [-(n**2) * c for n, c in zip(ORDERS, angle, strict=True)],
        "product": [1j * n * c for n, c in zip(ORDERS, energy, strict=True)],
        "tangent": fourier(lambda t: mp.tan(rod_angle(t, *geometry)), ORDERS, samples),
    }


@pytest.mark.parametrize("geometry", long_but(GEOMETRIES, *GEOMETRIES[1:6:2]))
def test_harmonics_and_their_errors(geometry):
    *lengths, samples = geometry
    ours = rod_angle_harmonics(*lengths, highest_order=max(ORDERS))
    with mp.workdps(30):
        for name, exact in truth(*lengths, samples).items():
            value, error = getattr(ours, name)
            true_error = np.array(
                [
                    float(abs(mp.mpmathify(complex(value[n])) - c))
                    for n, c in zip(ORDERS, exact, strict=True)
                ]
            )
            estimate = error[list(ORDERS)]
            assert np.all(true_error <= estimate + 1e-25), name
            assert estimate.max() <= 1e3 * true_error.max(), name
            size = max(abs(complex(c)) for c in exact)
            assert estimate.max() <= 1e-13 * size, name


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_largest_acceleration_against_digits(geometry):
    radius, length, offset, _ = geometry
    with mp.workdps(40):
        lengths = [mp.mpf(value) for value in (radius, length, offset)]
        side = -1 if offset >= 0.0 else 1
        exact = abs(mp.diff(lambda t: rod_angle(t, *lengths), side * mp.pi / 2, 2))
        ours = largest_rod_acceleration(radius, length, offset)
        true_error = float(abs(mp.mpf(float(ours.value)) - exact))
    assert true_error <= ours.error <= 1e-14 * ours.value


@pytest.mark.parametrize(
    ("lengths", "order", "words"),
    [
        ((1.0, 1.0), 4, "cannot turn over"),
        ((0.5, 1.0, 0.5), 4, "cannot turn over"),
        ((0.5, 1.0, -0.6), 4, "cannot turn over"),
        ((0.0, 1.0), 4, "cannot turn over"),
        ((1.0 - 1e-10, 1.0), 4, "lengthen the rod"),
        ((0.3, 1.0), 1 << 20, "lengthen the rod"),
    ],
)
def test_what_cannot_be_is_refused(lengths, order, words):
    with pytest.raises(NumericalFailure, match=words):
        rod_angle_harmonics(*lengths, highest_order=order)
    if order == 4 and "turn over" in words:
        with pytest.raises(NumericalFailure, match=words):
            largest_rod_acceleration(*lengths)
