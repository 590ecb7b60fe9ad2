"""Claim: two numbers of points in each panel differ by at least the error of the larger one, as the
running states of roll machines take it, and marching finds the same.
"""

from itertools import pairwise

import numpy as np
import pytest
from periodic_problems import TURN, friction_problem, halved, random_kinked, random_smooth

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.roll.running import point_levels


@pytest.mark.parametrize("make", [random_smooth, random_kinked])
def test_neighbouring_numbers_of_points_differ_by_at_least_the_error_of_the_larger(make):
    x = np.linspace(0.0, TURN, 701)
    kinks = 0
    for seed in range(10):
        problem = make(np.random.default_rng(seed))
        # the truth: four times as many panels, 14 points, from another start
        fine = problem._replace(edges=halved(halved(problem.edges)))
        truth = solve_periodic(fine, 14, [0.3], tolerance=1e-15)
        assert truth.converged.all() and truth.edge_error.max() < 1e-4
        exact = evaluate(truth, x)
        found = [solve_periodic(problem, points, [0.0]) for points in point_levels(1.0)]
        assert all(one.converged.all() for one in found)
        for fewer, more in pairwise(evaluate(one, x) for one in found):
            apart = np.abs(fewer - more).max()
            assert np.abs(more - exact).max() <= apart + 1e-13 * np.abs(exact).max()
        assert apart < 1e-6
        kinks += found[-1].edges.shape[1] - len(problem.edges)
    if make is random_kinked:
        assert kinks > 16


@pytest.mark.long
def test_marching_finds_the_same():
    for seed in range(12):
        problem = random_kinked(np.random.default_rng(seed + 200))
        truth = solve_periodic(
            problem._replace(edges=halved(problem.edges)), 16, [0.0], tolerance=1e-15
        )
        march = march_turns(problem.rhs, halved(halved(truth.edges[0])), [50.0, -50.0])
        assert march.converged.all() and not march.stalled.any()
        off = np.abs(march.path[:, -1] - truth.left[0, 0, 0])
        # near the start far away, one point is as good as several where a panel has a kink in it
        assert np.all(off < march.change + 1e-4)


@pytest.mark.parametrize("beyond", [0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, -1e-9, -0.1])
def test_a_peak_that_grazes_a_kink(beyond):
    # y = sin x below the kink at the peak less `beyond`; above it friction is thirty times larger
    problem = friction_problem(
        lambda x: np.cos(x) + np.sin(x),
        [1.0 - beyond],
        [1.0, 30.0],
        np.linspace(0.1, 0.1 + TURN, 25),
    )
    calls = []

    def counting(x, y, piece):
        calls.append(x.size)
        return problem.rhs(x, y, piece)

    found = solve_periodic(problem._replace(rhs=counting), 8, [0.2])
    assert len(calls) < 60
    # with an excursion of 16 degrees the panels must follow a decay of 30 per radian
    bound = 1e-9 if beyond < 1e-3 else 1e-6
    x = np.linspace(0.1, 0.1 + TURN, 2001)
    if beyond <= 0.0:
        assert np.abs(evaluate(found, x)[0, :, 0] - np.sin(x)).max() < bound
        return
    # cut at the peak too, and with other panels
    edges = np.sort(np.append(np.linspace(0.1, 0.1 + TURN, 50), 0.5 * np.pi))
    truth = solve_periodic(problem._replace(edges=edges), 12, [0.2])
    assert np.abs(evaluate(found, x) - evaluate(truth, x)).max() < bound
    # the kink lowers the peak: never above the smooth solution
    assert found.stages.max() < 1.0
