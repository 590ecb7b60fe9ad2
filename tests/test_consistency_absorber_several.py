"""Claim: responses, peaks and derivatives of several absorbers agree with matrices, grids and
differences; tunings agree with closed forms, with one absorber's own solver and with global search.
"""

from itertools import product

import numpy as np
import pytest
from scipy.optimize import differential_evolution

from vibecalc.absorber.several import Several, several_amplitude
from vibecalc.absorber.several_peaks import several_peaks, several_slopes
from vibecalc.absorber.transfer import EXCITATIONS, RESPONSES, transfer_of
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.several import _in_order, several_tuning
from vibecalc.absorber.tuning.several_search import TuningProblem

TREES = [(0,), (0, 0), (0, 1), (0, 1, 1), (0, 0, 1), (0, 1, 2)]
UNBOUND = {
    ("unbalance", "velocity"), ("unbalance", "acceleration"), ("unbalance", "transmitted_force"),
    ("base", "acceleration"), ("base", "transmitted_force"),
}  # fmt: skip


def random_system(rng, parent):
    n = len(parent)
    m = rng.uniform(0.02, 0.3, n)
    return Several(
        rng.uniform(0.01, 0.2), m, m * rng.uniform(0.5, 1.5, n), m * rng.uniform(0.05, 0.3, n),
        parent,
    )  # fmt: skip


def by_matrices(system, x):
    """Primary and secondaries under a unit force, and under a unit motion of the ground."""
    n = len(system.parent)
    m, k, z = system.mass_ratio, system.stiffness_ratio, system.secondary_damping
    z1 = system.primary_damping
    mass, stiff, drag = np.diag([1.0, *m]), np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    stiff[0, 0], drag[0, 0] = 1.0, z1
    for i, p in enumerate(system.parent):
        for table, value in ((stiff, k[i]), (drag, z[i])):
            table[i + 1, i + 1] += value
            table[p, p] += value
            table[i + 1, p] -= value
            table[p, i + 1] -= value
    forces = np.zeros((len(x), n + 1), dtype=complex)
    forces[:, 0] = 1.0
    whole = stiff + 2j * x[:, None, None] * drag - x[:, None, None] ** 2 * mass
    unit = np.linalg.solve(whole, forces[..., None])[..., 0]
    return unit, unit * (1.0 + 2j * z1 * x)[:, None]


@pytest.mark.parametrize("parent", TREES)
def test_response_is_that_of_the_matrices(parent):
    rng = np.random.default_rng(4)
    system, x = random_system(rng, parent), np.linspace(0.1, 3.0, 60)
    by_force, by_ground = by_matrices(system, x)
    drag = 1.0 + 2j * system.primary_damping * x
    for excitation, motion in (("force", by_force), ("base", by_ground),
                               ("unbalance", by_force * x[:, None] ** 2)):  # fmt: skip
        ground = 1.0 if excitation == "base" else 0.0
        for j, p in enumerate(parent, start=1):
            expected = {
                "displacement": motion[:, 0], "velocity": 1j * x * motion[:, 0],
                "acceleration": -(x**2) * motion[:, 0],
                "transmitted_force": drag * (motion[:, 0] - ground),
                "secondary_displacement": motion[:, j],
                "relative_displacement": motion[:, j] - motion[:, p],
            }  # fmt: skip
            for response, value in expected.items():
                found = several_amplitude(system, x, excitation, response, j)
                assert np.max(np.abs(found - value)) < 1e-12 * np.max(np.abs(value)) + 1e-12


@pytest.mark.parametrize(
    ("parent", "step"),
    [((0, 1), 4), *(pytest.param(parent, 1, marks=pytest.mark.long) for parent in TREES)],
)
def test_peaks_and_derivatives(parent, step):
    rng = np.random.default_rng(6)
    x = np.linspace(0.0, 3.0, 60001)
    pairs = [pair for pair in product(EXCITATIONS, RESPONSES) if pair not in UNBOUND]
    for pair in pairs[::step]:
        system = random_system(rng, parent)
        kind = (*pair, int(rng.integers(1, len(parent) + 1)))
        found = several_peaks(system, *kind)
        curve = np.abs(several_amplitude(system, x, *kind))
        tops = (curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])
        inside = found.frequency < 3.0
        assert found.frequency[inside] == pytest.approx(x[1:-1][tops], abs=2e-4)
        assert np.max(curve) <= found.largest + found.largest_error
        assert np.max(curve) >= found.largest * (1.0 - 1e-5)
        _against_differences(system, found, kind)


def _against_differences(system, found, kind):
    transfer, n = transfer_of(*kind[:2]), len(system.parent)
    slopes = several_slopes(system, found.frequency, transfer, kind[2])
    assert slopes.level == pytest.approx(2.0 * np.log(found.magnitude), abs=1e-11)
    point = np.concatenate([
        system.stiffness_ratio, system.secondary_damping, [system.primary_damping],
        system.mass_ratio,
    ])  # fmt: skip
    for i, value in enumerate(point):
        levels, firsts = [], []
        for sign in (1.0, -1.0):
            moved = point.copy()
            moved[i] += sign * 1e-5 * value
            there = Several(
                moved[2 * n], moved[2 * n + 1 :], moved[:n], moved[n : 2 * n], system.parent
            )
            peaks = several_peaks(there, *kind)
            levels.append(2.0 * np.log(peaks.magnitude))
            firsts.append(several_slopes(there, peaks.frequency, transfer, kind[2]).first)
        step = 2e-5 * value
        first, second = (levels[0] - levels[1]) / step, (firsts[0] - firsts[1]) / step
        assert np.all(np.abs(first - slopes.first[:, i]) < 1e-6 * (1.0 + np.abs(first)))
        assert np.all(np.abs(second - slopes.second[:, i]) < 1e-4 * (100.0 + np.abs(second)))


@pytest.mark.long
def test_one_absorber_has_its_known_optimum():
    half = several_tuning(0.5, [0.5], (0,))
    assert half.peak == pytest.approx(1.5 / np.sqrt(2.0), rel=1e-13)
    assert half.stiffness_ratio[0] == pytest.approx(1.0 / 27.0, rel=1e-10)
    assert half.secondary_damping[0] / np.sqrt(0.5 / 27.0) == pytest.approx(1 / np.sqrt(6), 1e-10)


@pytest.mark.long
@pytest.mark.parametrize(
    "kind",
    [
        ("force", "displacement"),
        ("base", "velocity"),
        ("force", "velocity"),
        ("unbalance", "displacement"),
        ("base", "displacement"),
    ],
    ids="-".join,
)
def test_one_absorber_by_both_solvers(kind):
    for z1, m in ((0.0, 1e-4), (0.0, 0.1), (0.1, 0.01), (0.3, 10.0), (0.6, 0.2)):
        exact = minimax(z1, m, *kind)
        found = several_tuning(z1, [m], (0,), *kind)
        assert found.peak == pytest.approx(float(exact.largest), rel=1e-10)


def certified(found, count):
    """Equal peaks, weights that add to one, slopes that cancel, a minimum along what is left."""
    assert len(found.frequency) == count
    assert np.all(found.weight > 0.0) and np.sum(found.weight) == pytest.approx(1.0, abs=1e-8)
    assert found.residual < 1e-7 and found.curvature > 0.0
    assert 0.0 < found.peak_error < 1e-8


def test_two_in_parallel_have_three_equal_peaks():
    found = several_tuning(0.0, [0.05, 0.05], (0, 0))
    certified(found, 3)
    system = Several(0.0, found.mass_ratio, found.stiffness_ratio, found.secondary_damping, (0, 0))
    peaks = several_peaks(system)
    assert peaks.magnitude == pytest.approx(np.full(3, found.peak), rel=1e-10)
    assert found.peak < 4.589 and not found.no_help


@pytest.mark.long
def test_two_in_series_need_no_damper_on_the_first():
    equal = several_tuning(0.0, [0.05, 0.05], (0, 0))
    shared = several_tuning(0.0, [0.05, 0.05], (0, 0), share_masses=True)
    assert shared.peak < equal.peak
    assert np.sum(shared.mass_ratio) == pytest.approx(0.1, rel=1e-14)
    found = several_tuning(0.0, [0.09, 0.01], (0, 1), share_masses=True)
    certified(found, 3)
    assert found.secondary_damping[0] == 0.0 and found.on_lower[2]
    assert found.peak < shared.peak


@pytest.mark.long
def test_an_absorber_that_is_best_fastened_to_another_is_said_to_be():
    # of two that hang on the first, one does better as a part of it: two in a row are left
    found = several_tuning(0.0, [0.06, 0.02, 0.02], (0, 1, 1))
    row = several_tuning(0.0, [0.08, 0.02], (0, 1))
    assert np.sum(np.isinf(found.stiffness_ratio)) == 1
    assert found.peak == pytest.approx(row.peak, rel=1e-11)
    system = Several(
        0.0, found.mass_ratio, found.stiffness_ratio, found.secondary_damping, (0, 1, 1)
    )
    assert several_peaks(system).largest == pytest.approx(found.peak, rel=1e-11)


def test_damped_primary_beyond_the_threshold_has_a_set_of_optima():
    found = several_tuning(0.8, [0.05, 0.05], (0, 0))
    assert found.is_set and found.no_help and found.peak == 1.0


def _peak_on_grid(masses, parent):
    x = np.linspace(0.5, 1.6, 500)

    def value(v):
        n = len(masses)
        system = Several(0.0, masses, masses * v[:n], masses * v[n:], parent)
        return float(np.max(np.abs(several_amplitude(system, x))))

    return value


@pytest.mark.parametrize(
    ("masses", "parent"),
    [
        pytest.param([0.05, 0.05], (0, 0), marks=pytest.mark.long),
        pytest.param([0.09, 0.01], (0, 1), marks=pytest.mark.long),
    ],
)
def test_a_global_search_finds_nothing_lower(masses, parent):
    masses = np.array(masses)
    found = several_tuning(0.0, masses, parent)
    search = differential_evolution(
        _peak_on_grid(masses, parent), [(0.3, 2.0)] * 2 + [(1e-4, 0.5)] * 2, seed=1, popsize=12,
        maxiter=120, tol=1e-10, polish=False,
    )  # fmt: skip
    n = len(masses)
    there = Several(0.0, masses, masses * search.x[:n], masses * search.x[n:], parent)
    reached = several_peaks(there).largest
    assert found.peak <= reached
    assert reached <= found.peak * 1.01


@pytest.mark.long
@pytest.mark.parametrize(
    ("masses", "parent"),
    [([0.03, 0.03, 0.04], (0, 0, 0)), ([0.08, 0.01, 0.01], (0, 1, 2)),
     ([0.06, 0.02, 0.02], (0, 1, 1)), ([0.06, 0.02, 0.02], (0, 0, 1))],
)  # fmt: skip
def test_a_global_search_for_three_finds_nothing_lower(masses, parent):
    masses = np.array(masses)
    found = several_tuning(0.0, masses, parent)
    for seed in range(3):
        search = differential_evolution(
            _peak_on_grid(masses, parent), [(0.1, 4.0)] * 3 + [(0.0, 1.0)] * 3, seed=seed,
            popsize=20, maxiter=800, tol=1e-10, polish=False,
        )  # fmt: skip
        there = Several(0.0, masses, masses * search.x[:3], masses * search.x[3:], parent)
        assert found.peak <= several_peaks(there).largest * (1.0 + 1e-9)


def test_absorbers_that_nothing_tells_apart_come_by_rising_stiffness() -> None:
    problem = TuningProblem(
        0.0, np.array([0.05, 0.02, 0.05]), (0, 0, 0), "force", "displacement",
        np.zeros(6), np.full(6, np.inf),
    )  # fmt: skip
    point = np.array([0.3, 0.5, 0.1, 1.0, 2.0, 3.0])
    assert _in_order(problem, point).tolist() == [0.1, 0.5, 0.3, 3.0, 2.0, 1.0]
    found = several_tuning(0.0, [0.05, 0.05], (0, 0))
    assert found.stiffness_ratio[0] < found.stiffness_ratio[1]
