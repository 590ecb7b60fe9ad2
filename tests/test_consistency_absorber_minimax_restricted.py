"""Claim: with spring or damper given, the best of the other one is found, and limits are said."""

import numpy as np

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.transfer import Absorber
from vibecalc.absorber.tuning.minimax import minimax
from vibecalc.absorber.tuning.restricted import (
    given_damping,
    given_stiffness,
    pure_viscous,
    undamped_spring,
)

Z1, MASS = np.array([0.0, 0.05, 0.3, 0.6]), np.array([0.1, 1e-3, 0.5, 5.0])


def test_a_viscous_damper_is_worse_than_the_optimum_and_better_than_its_neighbours():
    found = pure_viscous(Z1, MASS)
    assert np.all(found.held_by == 1) and np.all(found.largest > minimax(Z1, MASS).largest)
    for factor in (0.99, 1.01):
        assert np.all(peaks(Absorber(Z1, MASS, 0.0, found.value * factor)).largest > found.largest)


def test_each_of_both_given_the_others_optimum_finds_its_own():
    best = minimax(Z1, MASS)
    damper = given_stiffness(Z1, MASS, best.stiffness_ratio)
    spring = given_damping(Z1, MASS, best.secondary_damping)
    np.testing.assert_allclose(damper.value, best.secondary_damping, rtol=1e-9)
    np.testing.assert_allclose(spring.value, best.stiffness_ratio, rtol=1e-9)
    assert np.all(spring.held_by == 2)
    assert np.all(np.abs(spring.largest - best.largest) <= spring.largest_error)


def test_a_damper_from_stock_has_its_own_best_spring():
    damping = 2.0 * minimax(Z1, MASS).secondary_damping
    found = given_damping(Z1, MASS, damping)
    for factor in (0.99, 1.01):
        around = peaks(Absorber(Z1, MASS, found.value * factor, damping))
        assert np.all(around.largest > found.largest)


def test_without_a_damper_no_spring_helps_against_a_force():
    """Each undamped mode meets |H| = 1 / (2 z1 x): the lower one is above the bare system."""
    found = undamped_spring([0.01, 0.1, 0.5], 0.1)
    assert np.all(found.value == 0.0) and np.all(found.held_by == 0)
    bare = 1.0 / (2.0 * np.array([0.01, 0.1, 0.5]) * np.sqrt(1.0 - np.array([0.01, 0.1, 0.5]) ** 2))
    np.testing.assert_allclose(found.largest, bare, rtol=1e-14)


def test_nor_does_one_where_that_bound_says_nothing():
    """z1^2 >= m / (1 + m): held against 100 springs for each pair, from 1e-4 to 1e4 times m."""
    z1, m = np.array([0.3, 0.45, 0.6, 0.7])[:, None], np.array([0.001, 0.01, 0.05, 0.09])
    assert np.all(z1**2 > m / (1.0 + m))
    assert np.all(undamped_spring(z1, m).value == 0.0)
    bare = 1.0 / (2.0 * z1 * np.sqrt(1.0 - z1**2))
    k = m * np.geomspace(1e-4, 1e4, 100)[:, None, None]
    assert np.all(peaks(Absorber(z1, m, k, 0.0)).largest >= bare * (1.0 - 1e-12))
