"""Claim: below its threshold of primary damping an absorber helps; above it none of a grid does."""

import numpy as np
import pytest
from scipy.optimize import brentq

from vibecalc.absorber.mean_square import mean_square
from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import EXCITATIONS, Absorber
from vibecalc.absorber.tuning.closed_forms import threshold
from vibecalc.absorber.tuning.mean_square import mean_square_tuning

PAIRS = [
    (excitation, response)
    for excitation in EXCITATIONS
    for response in ("displacement", "velocity", "acceleration", "transmitted_force")
]
QUICK = (("force", "displacement"), ("base", "velocity"))


@pytest.mark.parametrize(
    ("excitation", "response"),
    [one if one in QUICK else pytest.param(*one, marks=pytest.mark.long) for one in PAIRS],
)
def test_the_largest_response_against_its_threshold(excitation, response):
    found = threshold(excitation, response)
    limit = found.primary_damping
    k, z = np.logspace(-3, 1, 10)[:, None], np.logspace(-4, 1, 11)

    def best_and_bare(z1, m):
        bare = float(peaks(Absorber(z1, m, 0.0, 0.0), excitation, response).largest)
        tried = peaks(Absorber(z1, m, m * k, m * z), excitation, response).largest
        weak = peaks(Absorber(z1, m, 0.0, [1e-3, 1e-5]), excitation, response).largest
        return min(float(np.min(tried)), float(np.min(weak))), bare

    for m in (0.01, 5.0):
        below = [0.05, 0.5, 3.0] if np.isinf(limit) else [0.1 * limit, 0.99 * limit]
        for z1 in below:
            best, bare = best_and_bare(z1, m)
            if found.bounded_damped:
                assert best < bare
        if np.isinf(limit):
            continue
        for z1 in (max(1.000001 * limit, 0.01), 2.0 * limit + 0.01):
            best, bare = best_and_bare(z1, m)
            assert best >= bare * (1.0 - 1e-14)
            assert np.isinf(bare) == (not found.bounded_damped)


def locked_threshold(m: float, response: str) -> float:
    """Damping of the primary beyond which a locked mass is best under a white force."""
    whole = 1.0 + m
    if response == "velocity":
        return np.sqrt(0.5 * (whole - np.sqrt(m * whole)))

    def balance(c):
        return (whole + 8 * c - 16 * c * c) ** 2 - 16 * c * m * (16 * c * c - 4 * c - whole)

    ends = (1.0 + np.sqrt(1.0 + 4.0 * whole)) / 8.0, (1.0 + np.sqrt(1.0 + whole)) / 4.0
    return np.sqrt(brentq(balance, *ends))


@pytest.mark.parametrize(
    "response", ["velocity", pytest.param("transmitted_force", marks=pytest.mark.long)]
)
def test_beyond_the_threshold_a_locked_mass_has_the_least_mean_square(response):
    m = np.array([1e-3, 0.1, 0.5, 1.0, 10.0])
    limit = np.array([locked_threshold(float(one), response) for one in m])
    for factor in (0.9, 0.999, 1.001, 2.0):
        z1 = factor * limit
        tuned = mean_square_tuning(z1, m, "force", response)
        locked = mean_square(Absorber(z1, m, np.inf, 0.0), "force", response).value
        assert np.all(tuned.locked == (factor > 1.0))
        if factor < 1.0:
            assert np.all(tuned.value < locked)
        k = np.logspace(-3, 6, 28)[:, None, None] * m
        z = np.logspace(-4, 6, 31)[:, None] * m
        grid = mean_square(Absorber(z1, m, k, z), "force", response).value
        assert np.all(np.min(grid, axis=(0, 1)) >= tuned.value * (1.0 - 1e-13))


def test_ground_acceleration_has_a_threshold_that_depends_on_the_mass():
    # a light secondary may still be tuned where a mere damper no longer helps
    m = np.array([0.01, 0.1])
    tuned = mean_square_tuning(0.55 / np.sqrt(1.0 + m), m, "base", "transmitted_force")
    assert not np.any(tuned.no_help)
    m = np.array([0.2, 1.0])
    limit = 0.5 / np.sqrt(1.0 + m)
    for factor in (0.999, 1.001):
        tuned = mean_square_tuning(factor * limit, m, "base", "transmitted_force")
        assert np.all(tuned.no_help == (factor > 1.0))
        k = np.concatenate([[0.0], np.logspace(-3, 2, 26)])[:, None, None] * m
        z = np.logspace(-7, 2, 37)[:, None] * m
        one = Absorber(factor * limit, m, k, z)
        grid = np.min(mean_square(one, "base", "transmitted_force").value, axis=(0, 1))
        assert np.all(grid >= tuned.value * (1.0 - 1e-13))
