"""Claim: the rod's harmonics agree with quadrature in 30 digits, and their errors are honest."""

import mpmath as mp
import numpy as np
import pytest
from exact_rod import fourier, rod_angle
from long_but import long_but

from vibecalc.errors import NumericalFailure
from vibecalc.kinematics.rod_angle import largest_rod_acceleration, rod_angle_harmonics

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
