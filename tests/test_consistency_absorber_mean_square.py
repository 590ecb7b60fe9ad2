"""Claim: mean squares under white noise are those of quadrature and of 60 digits; their optima are
those of closed forms, and no grid finds less.
"""

import numpy as np
import pytest
from exact_mean_square import exact_mean_square
from mpmath import mp, mpf
from scipy.integrate import quad
from scipy.linalg import solve_continuous_lyapunov
from scipy.optimize import minimize
from two_masses import amplitude

from vibecalc.absorber.asked_tables import WARBURTON_PAIRS
from vibecalc.absorber.mean_square import WHITE, mean_square
from vibecalc.absorber.modal import one_mode
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.band import band_tuning
from vibecalc.absorber.tuning.levels import BandProblem, states_of
from vibecalc.absorber.tuning.mean_square import closed_form, mean_square_tuning
from vibecalc.absorber.tuning.warburton import WARBURTON
from vibecalc.core.case.load import validate
from vibecalc.core.run.run import run_case

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


# ----------------------------------------------------------------------------
# Warburton (1982): least amplitude, nearly, and mean square, of the ground as well.
# ----------------------------------------------------------------------------


#: tuning and damping on the absorber's own frequency as Warburton's tables have them, and the peak
TABLE = {
    ("force", "displacement"): lambda m: (
        1 / (1 + m), np.sqrt(3 * m / (8 * (1 + m))), np.sqrt(1 + 2 / m)),
    ("force", "acceleration"): lambda m: (
        1 / np.sqrt(1 + m), np.sqrt(3 * m / (8 * (1 + m / 2))), np.sqrt(2 / (m * (1 + m)))),
    ("base_acceleration", "deflection"): lambda m: (
        np.sqrt(1 - m / 2) / (1 + m), np.sqrt(3 * m / (8 * (1 + m) * (1 - m / 2))),
        (1 + m) * np.sqrt(2 / m)),
}  # fmt: skip


def test_pairs_of_the_tables_are_those_of_the_formulas() -> None:
    assert set(WARBURTON) == set(WARBURTON_PAIRS)


@pytest.mark.parametrize("pair", TABLE)
def test_largest_amplitude_nearly(pair: tuple[str, str]) -> None:
    """Equal heights at two points for any damping; the optimum of all is at most a little lower."""
    m = 0.05
    tuning, own, promised = TABLE[pair](m)
    k, z, height = (float(x) for x in WARBURTON[pair].formula(np.array(m)))
    assert k == pytest.approx(m * tuning**2, rel=1e-14)
    assert z == pytest.approx(own * np.sqrt(m * k), rel=1e-14)
    assert height == pytest.approx(promised, rel=1e-14)
    x = np.linspace(0.5, 1.6, 200001)
    n = m * (1j * x) ** 2 + k
    d = (1 - x**2) * n - m * x**2 * k
    top = {"displacement": n, "acceleration": n * x**2, "deflection": n + m * k}[pair[1]]
    slack = {"displacement": 1.0, "acceleration": x**2, "deflection": 1.0 + m}[pair[1]]
    gap = np.abs(top / d) - np.abs(slack / (1 - (1 + m) * x**2))
    cross = np.flatnonzero((gap[1:] * gap[:-1] < 0) & (np.abs(top / d)[1:] < 3 * promised))
    heights = np.abs(top / d)[cross]
    assert len(heights) == 2
    np.testing.assert_allclose(heights, promised, rtol=1e-3)
    best = band_tuning(
        BandProblem(one_mode(0.0), np.array([m]), *pair, 0.2, 2.5, states_of((0, 0, 0, 0)))
    )
    assert promised <= best.largest <= promised * (1.0 + m / 5.0)
    assert best.stiffness_ratio[0] == pytest.approx(k, rel=5e-3)
    assert best.secondary_damping[0] == pytest.approx(z, rel=2e-2)


def variance(z1: float, m: float, k: float, z: float, response: str) -> float:
    """Mean square of the primary's motion against the ground, white acceleration of it, by the
    equation of Lyapunov; over S of the two-sided density, as the integral of |H|^2."""
    stiff = np.array([[1.0 + k, -k], [-k / m, k / m]])
    drag = 2.0 * np.array([[z1 + z, -z], [-z / m, z / m]])
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiff, -drag]])
    b = np.array([[0.0], [0.0], [-1.0], [-1.0]])
    p = solve_continuous_lyapunov(a, -b @ b.T)
    row = {
        "deflection": np.array([1.0, 0, 0, 0]),
        "acceleration": np.array([-1.0 - k, k, -2.0 * (z1 + z), 2.0 * z]),
    }
    return float(2.0 * np.pi * row[response] @ p @ row[response])


@pytest.mark.parametrize("response", ["deflection", "acceleration"])
def test_mean_squares_under_white_acceleration_of_the_ground(response: str) -> None:
    pair = "base_acceleration", response
    for z1, m, k, z in ((0.0, 0.05, 0.04, 0.01), (0.03, 0.1, 0.08, 0.02), (0.2, 0.7, 0.1, 0.3)):
        found = mean_square(Absorber(z1, m, k, z), *pair)
        assert float(found.value) == pytest.approx(variance(z1, m, k, z, response), rel=1e-10)
    m = 0.08
    form = closed_form(m, *pair)
    square, own = {
        "deflection": ((1 - m / 2) / (1 + m) ** 2,
                       m * (1 - m / 4) / (4 * (1 + m) * (1 - m / 2))),
        "acceleration": ((1 + m / 2) / (1 + m) ** 2,
                         m * (1 + 3 * m / 4) / (4 * (1 + m) * (1 + m / 2))),
    }[response]  # fmt: skip
    assert float(form[0]) == pytest.approx(m * square, rel=1e-13)
    assert float(form[1]) == pytest.approx(np.sqrt(own * m * float(form[0])), rel=1e-13)
    best = mean_square_tuning(0.02, m, *pair)
    place = np.log([float(best.stiffness_ratio), float(best.secondary_damping)])
    own_search = minimize(
        lambda p: variance(0.02, m, *np.exp(p), response), place + 0.1, method="Nelder-Mead",
        options={"xatol": 1e-7, "fatol": 1e-12},
    )  # fmt: skip
    np.testing.assert_allclose(own_search.x, place, atol=1e-5)
    assert own_search.fun == pytest.approx(float(best.value), rel=1e-10)


def test_cases_on_the_ground_have_both() -> None:
    machine = {
        "kind": "absorber", "primary": {"mass": 5e5, "natural_frequency": "0.5 Hz"},
        "secondary": {"mass": 1e4},
    }  # fmt: skip
    tuning = {"excitation": "base_acceleration", "response": "deflection",
              "compare": ["warburton", "numerical"], "mistuning": [0.05]}  # fmt: skip
    for extra in ({"band": {"to": "2 Hz"}}, {"norm": "h2"}):
        case = {"schema": 1, "title": "tower", "machine": machine, "tuning": tuning | extra,
                "response": {"absorber": {"base_acceleration": 0.1}}}  # fmt: skip
        record = run_case(validate(case))
        loss = record["tuning/method/loss"]
        assert abs(loss.values[1]) <= loss.error_estimate
        assert -1e-12 < loss.values[0] < 1e-3 and np.all(
            record["tuning/mistuning/worst"].values > 0
        )
        assert float(record["response/absorber/motion/largest/deflection"].values) < 0.6
