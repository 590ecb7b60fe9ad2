"""Claim: responses, peaks and derivatives of several absorbers agree with matrices, grids and
differences; tunings have as many equal peaks as they should.
"""

from itertools import product

import numpy as np
import pytest
from two_masses import amplitude

from vibecalc.absorber.modal import driven, fitted, highest, magnitude, one_mode, tops_within
from vibecalc.absorber.transfer import EXCITATIONS, RESPONSES, Absorber
from vibecalc.absorber.tuning.band import band_tuning
from vibecalc.absorber.tuning.levels import BandProblem
from vibecalc.errors import NumericalFailure

TREES = [(-1,), (-1, -1), (-1, 0), (-1, 0, 0), (-1, -1, 0), (-1, 0, 1)]
UNBOUND = {
    ("unbalance", "velocity"), ("unbalance", "acceleration"), ("unbalance", "transmitted_force"),
    ("base", "acceleration"), ("base", "transmitted_force"),
}  # fmt: skip
READ = {"relative_displacement": "travel"}


def random_system(rng, carrier):
    n = len(carrier)
    m = rng.uniform(0.02, 0.3, n)
    modes = one_mode(rng.uniform(0.01, 0.2), n)
    return fitted(modes, m, m * rng.uniform(0.5, 1.5, n), m * rng.uniform(0.05, 0.3, n), carrier)


def test_one_absorber_is_the_one_of_the_two_mass_system_limits_included():
    x = np.linspace(0.0, 3.0, 301)
    for k, z in ((0.08, 0.02), (0.0, 0.02), (0.08, 0.0), (np.inf, 0.1), (0.0, 0.0)):
        system = fitted(one_mode(0.1), 0.1, k, z)
        for response in ("displacement", "secondary_displacement", "relative_displacement"):
            found = magnitude(system, x, "force", READ.get(response, response))[0][0]
            expected = amplitude(Absorber(0.1, 0.1, k, z), x, "force", response)
            assert np.max(np.abs(found - expected)) < 1e-13 * np.max(np.abs(expected)) + 1e-15
    free = fitted(one_mode(0.0, 2), [0.1, 0.1], 0.0, 0.0, (-1, 0))
    at_resonance = [
        magnitude(free, np.ones(1), "force", "travel", place)[0][0, 0] for place in (0, 1)
    ]
    assert np.isinf(at_resonance[0]) and at_resonance[1] == 0.0
    assert np.isinf(highest(free, "force", "travel")[0][0])
    assert highest(free, "force", "travel", absorber=1)[0][0] == 0.0


@pytest.mark.parametrize(
    ("carrier", "step"),
    [((-1, 0), 4), *(pytest.param(carrier, 1, marks=pytest.mark.long) for carrier in TREES)],
)
def test_peaks_and_derivatives(carrier, step):
    rng = np.random.default_rng(6)
    x = np.linspace(0.0, 3.0, 60001)
    pairs = [pair for pair in product(EXCITATIONS, RESPONSES) if pair not in UNBOUND]
    for excitation, response in pairs[::step]:
        system = random_system(rng, carrier)
        kind = (excitation, READ.get(response, response))
        place = int(rng.integers(len(carrier)))
        found = tops_within(system, *kind, absorber=place)
        curve = np.abs(magnitude(system, x, *kind, place)[0][0])
        tops = (curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])
        inside = (found.place.value > 0.0) & (found.place.value < 3.0)
        assert found.place.value[inside] == pytest.approx(x[1:-1][tops], abs=2e-4)
        largest, error, _ = (part[0] for part in found.largest(1))
        assert largest * (1.0 - 1e-5) <= np.max(curve) <= largest + error
        _against_differences(system, found.place.value[inside], kind, place)


def _against_differences(system, x, kind, place):
    """Derivatives of H by k, z and x, first and mixed, at places x."""
    rows, count = np.zeros(len(x), dtype=int), system.mass.shape[1]
    here, by = driven(system, *kind, place).with_gradient(rows, x)
    point = np.concatenate(system[2:4], axis=1)[0]
    for i, value in enumerate(point):
        step = 1e-5 * value
        sides = []
        for sign in (1.0, -1.0):
            k, z = np.split(point + sign * step * np.eye(2 * count)[i], 2)
            there = fitted(system.modes, system.mass, k, z, system.carrier)
            sides.append(driven(there, *kind, place).with_gradient(rows, x))
        pairs = [(sides[s][0].value, sides[s][0].first, sides[s][1].first) for s in (0, 1)]
        slope, mixed, second = ((a - b) / (2.0 * step) for a, b in zip(*pairs, strict=True))
        size = np.abs(here.value) / value
        assert np.all(np.abs(slope - by.first[:, i]) < 1e-6 * size)
        assert np.all(np.abs(mixed - by.by_place[:, i]) < 1e-4 * (np.abs(mixed) + size))
        assert np.all(np.abs(second - by.second[:, i]) < 1e-4 * (np.abs(second) + size[:, None]))


def problem(z1, masses, carrier=(), *pair, **limits):
    masses = np.array(masses)
    pair = pair or ("force", "displacement")
    return BandProblem(one_mode(z1, len(masses)), masses, *pair, carrier=carrier, **limits)


def test_two_in_parallel_have_three_equal_peaks():
    found = band_tuning(problem(0.0, [0.05, 0.05]))
    assert len(found.frequency) == 3 and np.all(found.weight > 0.0)
    assert np.sum(found.weight) == pytest.approx(1.0, abs=1e-8)
    assert found.residual < 1e-7 and 0.0 < found.largest_error < 1e-8
    system = fitted(one_mode(0.0, 2), [0.05, 0.05], found.stiffness_ratio, found.secondary_damping)
    tops = tops_within(system, "force", "displacement")
    inside = (tops.place.value > 0.0) & np.isfinite(tops.place.value)
    assert tops.height.value[inside] == pytest.approx(np.full(3, found.largest), rel=1e-10)
    assert found.largest == pytest.approx(4.100280, abs=1e-6) and not found.is_set
    # nothing tells these two apart: they come by rising stiffness
    assert found.stiffness_ratio[0] < found.stiffness_ratio[1]


@pytest.mark.long
def test_two_in_series_need_no_damper_on_the_first():
    found = band_tuning(problem(0.0, [0.08, 0.02], (-1, 0)))
    assert found.secondary_damping[0] == 0.0 and found.lower[2]
    assert found.largest < band_tuning(problem(0.0, [0.05, 0.05])).largest
    # of two that hang on the first, one does better as a part of it: two in a row are left
    three = band_tuning(problem(0.0, [0.06, 0.02, 0.02], (-1, 0, 0)))
    assert np.sum(np.isinf(three.stiffness_ratio)) == 1
    assert three.largest == pytest.approx(found.largest, rel=1e-11)


def test_damped_primary_beyond_the_threshold_has_a_set_of_optima():
    found = band_tuning(problem(0.8, [0.05, 0.05]))
    assert found.is_set and found.largest == pytest.approx(1.0, abs=1e-15)


def test_a_response_that_grows_without_bound_is_refused():
    with pytest.raises(NumericalFailure, match="without bound"):
        band_tuning(problem(0.1, [0.05, 0.05], (), "unbalance", "velocity"))
