"""Claim: where there is no periodic solution, that is said."""

import numpy as np
from periodic_problems import TURN, linear_rhs

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.periodic.panels import PeriodicProblem

EDGES = np.linspace(0.0, TURN, 37)


def saddle_rhs(level):
    """y' = level + sin(x) / 2 - (y - 1)^2: two periodic solutions, or none for a low level."""

    def rhs(x, y, piece):
        v = y[..., 0] - 1.0
        return (level + 0.5 * np.sin(x) - v**2)[..., None], (-2.0 * v)[..., None, None]

    return rhs


def test_no_periodic_solution_is_said():
    problem = PeriodicProblem(saddle_rhs(-0.5), EDGES)
    assert not solve_periodic(problem, 4, [2.0]).converged[0]
    march = march_turns(problem.rhs, EDGES, [5.0], floor=-2.0)
    assert march.stalled[0] and not march.converged[0]
    assert 0.0 <= march.stalled_at[0] < TURN


def test_marching_tells_which_members_have_a_solution():
    level = np.array([0.3, -0.3, 0.02, 1.0, -0.02])[:, None, None]
    rhs = saddle_rhs(level)
    march = march_turns(rhs, EDGES, np.full(5, 8.0), floor=-3.0, tolerance=1e-9)
    # exactly: a solution exists above a level near 0.06 (mean of the square of the ripple)
    assert march.converged.tolist() == [True, False, False, True, False]
    assert march.stalled.tolist() == [False, True, True, False, True]
    assert np.isnan(march.stalled_at[[0, 3]]).all() and not np.isnan(march.stalled_at[1])
    both = [0, 3]
    start = march.path[both, :1]
    finer = solve_periodic(PeriodicProblem(saddle_rhs(level[both]), EDGES), 6, start)
    assert finer.converged.all()
    assert np.abs(finer.left[:, 0, 0] - march.path[both, -1]).max() < 1e-5
    # the upper one of the two solutions: stable, above 1 on average
    assert np.all(finer.left.mean(axis=(1, 2)) > 1.0)


def test_a_multiplier_of_one_has_no_single_solution():
    flat = linear_rhs(lambda x: np.cos(x) + 1.0, np.zeros_like)
    for guess in ([0.0], [1.0]):
        assert not solve_periodic(PeriodicProblem(flat, EDGES), 3, guess).converged[0]

    def still(x, y, piece):
        return np.ones_like(y), np.zeros((*y.shape, y.shape[-1]))

    assert not solve_periodic(PeriodicProblem(still, EDGES), 2, [1.0, 2.0]).converged[0]
