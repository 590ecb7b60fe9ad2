"""Claim: the error estimates of periodic solutions bound their errors and are not far above."""

import numpy as np
import pytest
from periodic_problems import (
    TURN,
    friction_problem,
    halved,
    random_kinked,
    random_smooth,
)

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.other_methods import march_turns
from vibecalc.numerics.periodic.panels import evaluate
from vibecalc.numerics.periodic.tolerance import estimate_error, solve_to


@pytest.mark.parametrize("make", [random_smooth, random_kinked])
def test_estimates_hold_on_random_problems(make):
    x = np.linspace(0.0, TURN, 701)
    shares, kinks = [], 0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        problem, points = make(rng), int(rng.integers(1, 9))
        found = solve_periodic(problem, points, [0.0])
        error = estimate_error(problem, found)
        # the truth: four times as many panels, 14 points, from another start
        fine = problem._replace(edges=halved(halved(problem.edges)))
        truth = solve_periodic(fine, 14, [0.3], tolerance=1e-15)
        assert found.converged.all() and truth.converged.all()
        assert truth.edge_error.max() < 1e-4
        at_edges = np.abs(evaluate(found, problem.edges) - evaluate(truth, problem.edges)).max()
        between = np.abs(evaluate(found, x) - evaluate(truth, x)).max()
        uncertainty = estimate_error(fine, truth)
        assert at_edges <= error.ends[0, 0] + uncertainty.ends[0, 0]
        assert between <= error.between[0, 0] + uncertainty.between[0, 0]
        shares.append((between / error.between[0, 0], at_edges / error.ends[0, 0]))
        kinks += found.edges.shape[1] - len(problem.edges)
    shares = np.array(shares)
    assert np.all(np.median(shares, axis=0) > 0.3)
    assert np.all(shares[:, 0] > 0.05)
    if make is random_kinked:
        assert kinks > 16


@pytest.mark.parametrize("points", [1, 4])
def test_the_estimate_sees_kinks_inside_panels(points):
    # without a switch the panels are not split
    ratios = []
    for seed in range(12):
        problem = random_kinked(np.random.default_rng(1000 + seed))
        whole = problem._replace(switch=None)
        found = solve_periodic(whole, points, [0.0])
        error = estimate_error(whole, found, kinks_inside=True)
        truth = solve_periodic(problem, 14, [0.0])
        off = np.abs(evaluate(found, problem.edges) - evaluate(truth, problem.edges)).max()
        ratios.append(off / error.ends[0, 0])
    assert max(ratios) < 1.0
    assert np.median(ratios) > 0.1


@pytest.mark.long
def test_a_solution_to_tolerance_keeps_it_and_marching_finds_the_same():
    for seed in range(12):
        problem = random_kinked(np.random.default_rng(seed + 200))
        fine = problem._replace(edges=halved(problem.edges))
        truth = solve_periodic(fine, 16, [0.0], tolerance=1e-15)
        uncertainty = estimate_error(fine, truth).between[0, 0]
        assert uncertainty < 1e-13
        x = np.linspace(0.0, TURN, 301)
        for tolerance in (1e-3, 1e-7, 1e-11):
            found, error = solve_to(problem, tolerance, [0.0])
            off = np.abs(evaluate(found, x) - evaluate(truth, x)).max()
            assert off <= error.between[0, 0] + uncertainty
            assert error.between[0, 0] <= tolerance
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
    error = estimate_error(problem, found)
    # with an excursion of 16 degrees the panels must follow a decay of 30 per radian
    assert error.between[0, 0] < (1e-9 if beyond < 1e-3 else 1e-6)
    x = np.linspace(0.1, 0.1 + TURN, 2001)
    if beyond <= 0.0:
        assert np.abs(evaluate(found, x)[0, :, 0] - np.sin(x)).max() <= error.between[0, 0]
        return
    # cut at the peak too, and with other panels
    edges = np.sort(np.append(np.linspace(0.1, 0.1 + TURN, 50), 0.5 * np.pi))
    truth = solve_periodic(problem._replace(edges=edges), 12, [0.2])
    off = np.abs(evaluate(found, x) - evaluate(truth, x)).max()
    assert off <= error.between[0, 0] + estimate_error(problem, truth).between[0, 0]
    # the kink lowers the peak: never above the smooth solution
    assert found.stages.max() < 1.0
