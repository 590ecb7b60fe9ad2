"""Claim: periodic solutions agree with shooting and closed forms, each member of a batch alone."""

import numpy as np
from periodic_problems import TURN, friction_problem, linear_rhs
from scipy.integrate import solve_ivp

from vibecalc.numerics.periodic.collocation import solve_periodic
from vibecalc.numerics.periodic.multipliers import floquet_multipliers
from vibecalc.numerics.periodic.panels import PeriodicProblem

EDGES = np.linspace(0.0, TURN, 37)


def test_kinked_friction_against_integration_that_stops_at_the_kinks():
    bounds, slopes = np.array([-0.4, 0.1, 0.5]), [0.5, 2.0, 0.3, 5.0]

    def a(x):
        return 1.2 * np.sin(x) + 0.5 * np.cos(3.0 * x)

    problem = friction_problem(a, bounds, slopes, EDGES)
    found = solve_periodic(problem, 8, [0.0])
    crossings = found.edges.shape[1] - len(EDGES)
    assert crossings >= 4
    x, y, stops = 0.0, float(found.left[0, 0, 0]), 0
    events = [lambda x, y, b=b: y[0] - b for b in bounds]
    for event in events:
        event.terminal = True
    while x < TURN:
        piece = int(np.searchsorted(bounds, y, side="right"))
        if np.min(np.abs(bounds - y)) < 1e-9:  # on a kink: the piece it is going to
            slope = problem.rhs(np.array([[[x]]]), np.array([[[[y]]]]), None)[0].item()
            nearest = int(np.argmin(np.abs(bounds - y)))
            piece = nearest + (slope > 0.0)
        fixed = np.array([[piece]])

        def f(x, y, fixed=fixed):
            return problem.rhs(np.array([[[x]]]), y.reshape(1, 1, 1, 1), fixed)[0].ravel()

        away = min(x + 1e-6, TURN)
        step = solve_ivp(f, (x, away), [y], method="DOP853", rtol=1e-13, atol=1e-14)
        x, y = away, float(step.y[0, -1])
        flow = solve_ivp(f, (x, TURN), [y], method="DOP853", rtol=1e-13, atol=1e-14, events=events)
        x, y, stops = float(flow.t[-1]), float(flow.y[0, -1]), stops + (flow.status == 1)
    assert stops == crossings
    multiplier = floquet_multipliers(problem, found).value[0, 0].real
    assert abs(y - found.left[0, 0, 0]) / (1.0 - multiplier) < 1e-11


def test_thresholds_may_differ_between_members():
    bound = np.array([-0.3, 0.05, 0.6])

    def problem(at):
        at = np.reshape(at, (-1, 1, 1))

        def rhs(x, y, piece):
            v = y[..., 0]
            above = v >= at if piece is None else piece[..., None] > 0
            slope = np.where(above, 6.0, 1.0) * np.ones_like(v)
            f = np.sin(x) + 0.4 * np.cos(2.0 * x) - at - slope * (v - at)
            return f[..., None], -slope[..., None, None]

        return PeriodicProblem(rhs, EDGES, lambda y: y[..., 0], at[:, 0])

    together = solve_periodic(problem(bound), 8, np.zeros((3, 1)))
    for member in range(3):
        alone = solve_periodic(problem(bound[member]), together.points, [0.0])
        assert np.abs(alone.left[0, 0] - together.left[member, 0]).max() < 1e-13
    # at a kink stands an edge, and the values at edges are on it
    on = np.abs(together.ends[..., 0] - bound[:, None]).min(axis=1)
    assert np.all(on < 1e-9)


def test_an_unstable_solution_is_found_to_round_off():
    # y' = 3 y + cos x: the multiplier is exp(6 pi) = 1.5e8
    rhs = linear_rhs(np.cos, lambda x: np.full_like(x, -3.0))
    found = solve_periodic(PeriodicProblem(rhs, EDGES), 7, [1.0])
    exact = (-3.0 * np.cos(EDGES) + np.sin(EDGES)) / 10.0
    assert np.abs(found.ends[0, :, 0] - exact).max() < 2e-15
