"""Claim: mean squares under white noise are those of quadrature and of 60 digits; their optima are
those of closed forms, and no grid finds less.
"""

import numpy as np
import pytest
from exact_mean_square import exact_mean_square
from mpmath import mp, mpf
from scipy.integrate import quad
from two_masses import amplitude

from vibecalc.absorber.mean_square import WHITE, mean_square
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.mean_square import closed_form, mean_square_tuning

KINDS = {
    "displacement": ("force", "displacement"),
    "velocity": ("force", "velocity"),
    "transmitted": ("force", "transmitted_force"),
    "base": ("base", "transmitted_force"),
    "travel": ("force", "relative_displacement"),
    "base travel": ("base", "relative_displacement"),
}
ALL = [
    ("force", "displacement", ""), ("force", "velocity", ""), ("force", "transmitted_force", ""),
    ("force", "relative_displacement", ""), ("base", "acceleration", ""),
    ("base", "transmitted_force", ""), ("base", "relative_displacement", ""),
    ("base", "displacement", "displacement"), ("base", "velocity", "velocity"),
    ("base", "relative_displacement", "velocity"),
    ("base", "relative_displacement", "displacement"),
    ("unbalance", "displacement", "acceleration"), ("unbalance", "velocity", "acceleration"),
    ("unbalance", "transmitted_force", "acceleration"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("excitation", "response", "white"),
    [
        *ALL[::4],
        *(pytest.param(*one, marks=pytest.mark.long) for k, one in enumerate(ALL) if k % 4),
    ],
)
def test_mean_square_is_the_integral(excitation, response, white):
    rng = np.random.default_rng(3)
    absorber = Absorber(*np.exp(rng.uniform(-2.0, 1.0, 4)))
    power = WHITE[white or ("acceleration" if excitation == "base" else "displacement")]

    def density(t):
        x = np.exp(t)
        return np.abs(amplitude(absorber, x, excitation, response) / x**power) ** 2 * x

    expected = 2.0 * quad(density, -24.0, 24.0, limit=500, epsabs=0.0, epsrel=1e-12)[0]
    found = mean_square(absorber, excitation, response, white)
    assert found.value == pytest.approx(expected, rel=2e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_error_estimate_holds_against_many_digits(kind):
    rng = np.random.default_rng(11)
    with mp.workdps(60):
        for _ in range(25):
            ratios = 10.0 ** rng.uniform([-6, -4, -6, -6], [0.3, 1, 2, 2])
            found = mean_square(Absorber(*ratios), *KINDS[kind])
            exact = exact_mean_square(kind, *ratios)
            assert abs(mpf(float(found.value)) - exact) <= mpf(float(found.error))
            assert float(found.error) <= 1e-13 * float(exact)


def test_limits_lock_free_and_viscous():
    z1, m = 0.2, 0.3
    for excitation, response, mass in (
        ("force", "displacement", 0), ("force", "velocity", -1),
        ("base", "transmitted_force", None),
    ):  # fmt: skip
        locked = mean_square(Absorber(z1, m, np.inf, 0.1), excitation, response).value
        near = mean_square(Absorber(z1, m, 1e9, 1e9), excitation, response).value
        assert locked == pytest.approx(near, rel=1e-7)
        if mass is not None:
            assert locked == pytest.approx(0.5 * np.pi / z1 * (1.0 + m) ** mass, rel=1e-14)
        free = mean_square(Absorber(z1, m, 0.0, 0.0), excitation, response).value
        near = mean_square(Absorber(z1, m, 0.0, 1e-9), excitation, response).value
        assert free == pytest.approx(near, rel=1e-7)
        viscous = mean_square(Absorber(z1, m, 0.0, 0.1), excitation, response).value
        near = mean_square(Absorber(z1, m, 1e-12, 0.1), excitation, response).value
        assert viscous == pytest.approx(near, rel=1e-9)
    assert mean_square(Absorber(z1, m, np.inf, 0.0), "force", "relative_displacement").value == 0.0
    assert mean_square(Absorber(0.0, m, 0.3, 0.0)).value == np.inf


def test_closed_forms_of_crandall_and_mark_and_warburton():
    m = np.array([1e-4, 0.1, 0.5, 1.5, 3.0])
    found = mean_square_tuning(0.0, m)
    assert found.stiffness_ratio == pytest.approx(m * (2 + m) / (2 * (1 + m) ** 2), rel=1e-9)
    damping = np.sqrt(m**3 * (4 + 3 * m) / (16 * (1 + m) ** 3))
    assert found.secondary_damping == pytest.approx(damping, rel=1e-9)
    # Warburton: frequency ratio and damping ratio for ground acceleration, relative motion
    ground = mean_square_tuning(0.0, m, "base", "transmitted_force")
    light = m < 2.0
    tuned = np.sqrt(1 - m[light] / 2) / (1 + m[light])
    assert ground.stiffness_ratio[light] == pytest.approx(m[light] * tuned**2, rel=1e-9)
    ratio = np.sqrt(m[light] * (1 - m[light] / 4) / (4 * (1 + m[light]) * (1 - m[light] / 2)))
    assert ground.secondary_damping[light] == pytest.approx(ratio * m[light] * tuned, rel=1e-9)
    assert list(ground.without_spring) == [False, False, False, False, True]
    for excitation, response in (("force", "velocity"), ("base", "transmitted_force")):
        newton = mean_square_tuning(0.0, m, excitation, response)
        closed = closed_form(m, excitation, response)
        assert newton.value == pytest.approx(closed.value, rel=1e-13)
        assert np.all(np.abs(newton.stiffness_ratio - closed.stiffness_ratio)
                      <= newton.stiffness_error + closed.stiffness_error)  # fmt: skip


@pytest.mark.parametrize(
    ("excitation", "response"),
    [("force", "displacement"), ("force", "velocity"), ("force", "transmitted_force"),
     ("base", "transmitted_force")],
)  # fmt: skip
def test_no_grid_finds_less(excitation, response):
    z1, m = np.meshgrid([0.0, 0.3, 0.6, 2.0], [1e-4, 0.1, 2.1], indexing="ij")
    found = mean_square_tuning(z1, m, excitation, response)
    k = np.concatenate([[0.0], np.logspace(-4, 3, 80)])[:, None]
    z = np.logspace(-6, 3, 100)
    for place in np.ndindex(m.shape):
        one = Absorber(z1[place], m[place], m[place] * k, m[place] * z)
        grid = float(np.min(mean_square(one, excitation, response).value))
        assert found.value[place] <= grid * (1.0 + 1e-13)
