"""Claim: estimates hold where rounding is multiplied: products of matrices far from normal, marches
that come from far away, peaks narrower than 1e-9 of their frequency, light and tuned absorbers.
"""

import mpmath
import numpy as np
import pytest
from exact_mean_square import exact_mean_square
from periodic_problems import halved, random_smooth

from vibecalc.absorber.mean_square import mean_square
from vibecalc.absorber.modal import fitted, highest, one_mode
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.multipliers import product_condition, product_multipliers
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.rounding import EPSILON


def exact_eigenvalues(panels: np.ndarray) -> list[mpmath.mpc]:
    """Eigenvalues of the product by falling modulus, in sixty digits."""
    with mpmath.workdps(60):
        whole = mpmath.eye(panels.shape[-1])
        for one in panels:
            whole = mpmath.matrix(one.tolist()) * whole
        return sorted(mpmath.eig(whole, left=False, right=False), key=lambda v: -abs(v))


def shear(coupling: float, angle: float, second: float = 0.5) -> np.ndarray:
    """Eigenvalues 1 and `second`, their directions 1 / `coupling` apart, in a turned frame."""
    c, s = np.cos(angle), np.sin(angle)
    frame = np.array([[c, -s], [s, c]])
    return frame @ np.array([[1.0, coupling], [0.0, second]]) @ frame.T


@pytest.mark.parametrize("coupling", [0.0, 1e3, 1e5, 1e7])
def test_multipliers_count_how_far_from_normal_a_panel_is(coupling: float) -> None:
    # one panel, and another after one that does nothing
    for panels in (shear(coupling, 0.7)[None], np.stack([np.eye(2), shear(coupling, 2.0)])):
        found = product_multipliers(panels[None])
        exact = [complex(value) for value in exact_eigenvalues(panels)]
        off = np.abs(found.value[0] - exact)
        assert np.all(off <= found.error[0])
        # once for the size of the panel, once for the angle between the directions
        assert np.all(found.error[0] <= 200.0 * EPSILON * (1.0 + coupling**2))
        assert np.all(found.error[0] >= EPSILON * coupling**2)


def test_multipliers_that_meet_lose_half_of_the_digits_and_say_so() -> None:
    panels = shear(1.0, 0.7, 1.0)[None]
    found = product_multipliers(panels[None])
    off = [float(abs(mpmath.mpc(value) - one)) for value, one in
           zip(found.value[0].tolist(), exact_eigenvalues(panels), strict=True)]  # fmt: skip
    assert np.all(np.array(off) <= found.error[0]) and np.all(found.error[0] > 1e-9)


def test_multipliers_below_every_double_are_zero_with_the_smallest_as_their_error() -> None:
    panels = np.broadcast_to(shear(1.0, 0.4, 1e-9), (40, 2, 2))
    found = product_multipliers(panels[None])
    assert found.value[0, 1] == 0.0 and 0.0 < found.error[0, 1] < 1e-300
    assert abs(found.value[0, 0] - 1.0) <= found.error[0, 0] < 1e-11


def test_the_condition_of_a_product_bounds_what_changes_of_its_panels_do() -> None:
    random = np.random.default_rng(4)
    triangles = np.triu(random.normal(size=(1, 6, 3, 3)))
    # diagonals of 1, .1 and .01 in size: multipliers far apart, couplings of order 1
    triangles *= np.where(np.eye(3) > 0.0, [1.0, 0.1, 0.01], 1.0)
    sizes = np.linalg.norm(triangles, axis=2)
    cost = product_condition(triangles, sizes, np.eye(3)[None], [[0, 1, 2]])[0]
    exact = exact_eigenvalues(triangles[0])
    seen = np.zeros(3)
    for _ in range(40):
        moved = random.choice([-1.0, 1.0], size=triangles.shape)
        moved *= 1e-12 * sizes[:, :, None] / np.sqrt(3.0)
        changed = exact_eigenvalues(triangles[0] + moved[0])
        part = [float(abs(a - b) / abs(b)) for a, b in zip(changed, exact, strict=True)]
        seen = np.maximum(seen, np.array(part) / 1e-12)
    assert np.all(seen <= cost) and np.all(cost <= 20.0 * seen)
    assert cost[2] > 100.0


def test_a_march_from_far_above_says_what_is_left() -> None:
    problem = random_smooth(np.random.default_rng(1))
    fine = problem._replace(edges=halved(problem.edges))
    truth = solve_periodic(fine, 12, [0.3], tolerance=1e-15)
    other = solve_periodic(fine, 14, [0.3], tolerance=1e-15)
    uncertainty = float(np.abs(truth.left[0, 0, 0] - other.left[0, 0, 0]))
    assert uncertainty < 1e-13
    for tolerance in (0.1, 1e-4, 1e-13):
        march = march_turns(fine.rhs, fine.edges, [5.0], points=10, tolerance=tolerance)
        off = abs(float(march.path[0, -1] - truth.left[0, 0, 0]))
        size = float(np.max(np.abs(march.path)))
        assert march.converged[0] and march.turns[0] >= 2
        assert off <= float(march.change[0]) + uncertainty + 1e-13 * size
        assert march.change[0] <= max(tolerance, 1e-13) * size


@pytest.mark.parametrize("damping", [5e-10, 3e-13])
def test_several_absorbers_find_a_narrow_resonance(damping: float) -> None:
    for kind in (("force", "displacement"), ("base", "displacement")):
        # tuned far below, so that only the primary system's own damping holds its peak
        for k, z in ((1e-4, 1e-7), (1e-2, 1e-14), (1e-8, 1e-13)):
            one = peaks(Absorber(damping, 0.01, k, z), *kind)
            height, error, _ = highest(fitted(one_mode(damping), 0.01, k, z), *kind)
            assert np.isfinite(height[0]) and error[0] < 1e-1 * height[0]
            assert abs(one.largest - height[0]) <= one.largest_error + error[0]
    # two of one kind are one of twice the ratios
    pair = fitted(one_mode(damping, 2), [0.005] * 2, [5e-5] * 2, [5e-8] * 2)
    height, error, _ = highest(pair, "force", "displacement")
    one = peaks(Absorber(damping, 0.01, 1e-4, 1e-7))
    assert abs(one.largest - height[0]) <= one.largest_error + error[0]


KINDS = {
    ("force", "displacement"): "displacement",
    ("force", "velocity"): "velocity",
    ("force", "transmitted_force"): "transmitted",
    ("base", "transmitted_force"): "base",
}


@pytest.mark.parametrize("m", [1e-10, 1e-7, 1e-4, 0.1, 30.0])
def test_mean_squares_of_tuned_absorbers_keep_their_digits(m: float) -> None:
    random = np.random.default_rng(int(1e3 * -np.log10(m)) % 2**31)
    for pair, name in KINDS.items():
        for k in (m, m / (1.0 + m), m / (1.0 + m) ** 2, m * (1.0 + 1e-3 * random.normal())):
            # light damping of both: the difference of a and b k counts most
            z1 = 0.0 if name == "transmitted" else 10.0 ** random.uniform(-10.0, -1.0)
            z = m * 10.0 ** random.uniform(-8.0, 0.0)
            found = mean_square(Absorber(z1, m, k, z), *pair)
            with mpmath.workdps(80):
                exact = exact_mean_square(name, z1, m, float(k), z)
                off = float(abs(mpmath.mpf(float(found.value)) / exact - 1))
            assert off <= 10.0 * EPSILON, (pair, k, z1, z)
