"""Claim: collocation has its orders, kinks inside panels cost them, and split edges settle fast."""

import itertools

import numpy as np
import pytest
from periodic_problems import TURN, end_values, friction_problem, halved, linear_rhs

from vibecalc.numerics.periodic.collocation import carried, newton, solve_periodic, split
from vibecalc.numerics.periodic.other_methods import solve_fourier
from vibecalc.numerics.periodic.panels import PeriodicProblem, evaluate


def bump(x):
    return np.exp(np.sin(x))


def bump_rhs():
    """y = exp(sin x) solves y' = a - b y with b = 1 + cos(2 x) / 2."""

    def b(x):
        return 1.0 + 0.5 * np.cos(2.0 * x)

    return linear_rhs(lambda x: (np.cos(x) + b(x)) * bump(x), b)


@pytest.mark.parametrize("points", [1, 2, 3, 4])
def test_orders_at_the_edges_and_between(points: int):
    ends, between = [], []
    x = np.linspace(0.0, TURN, 501)
    for panels in (12, 24, 48):
        problem = PeriodicProblem(bump_rhs(), np.linspace(0.0, TURN, panels + 1))
        found = solve_periodic(problem, points, [1.0])
        assert found.converged.all()
        ends.append(np.abs(found.ends[0, :, 0] - bump(found.edges[0])).max())
        between.append(np.abs(evaluate(found, x)[0, :, 0] - bump(x)).max())
    rate = np.log2(ends[-2] / ends[-1])
    assert rate == pytest.approx(2 * points, abs=0.25)
    assert np.log2(between[-2] / between[-1]) == pytest.approx(points + 1, abs=0.3)


def table_response(nodes, values, decay):
    """Exact periodic solution at the nodes of y' = table(x) - decay y, the table linear between."""
    width = np.diff(nodes)
    slope = np.diff(values) / width
    particular_left = values[:-1] / decay - slope / decay**2
    particular_right = particular_left + slope * width / decay
    product, total = 1.0, 0.0
    factor = np.exp(-decay * width)
    for f, left, right in zip(factor, particular_left, particular_right, strict=True):
        product, total = product * f, f * (total - left) + right
    found = [total / (1.0 - product)]
    for f, left, right in zip(factor, particular_left, particular_right, strict=True):
        found.append(f * (found[-1] - left) + right)
    return np.array(found)


def test_panels_at_table_nodes_keep_the_order_and_others_lose_it():
    nodes = np.linspace(0.0, TURN, 37)
    values = np.sin(nodes) + 0.5 * np.cos(5.0 * nodes + 1.0)
    values[-1] = values[0]
    exact = table_response(nodes, values, 0.7)
    rhs = linear_rhs(
        lambda x: np.interp(np.mod(x, TURN), nodes, values), lambda x: np.full_like(x, 0.7)
    )
    for points in (2, 3):
        misses = []
        for edges in (nodes, halved(nodes)):
            found = solve_periodic(PeriodicProblem(rhs, edges), points, [0.0])
            misses.append(np.abs(end_values(found, nodes)[0, :, 0] - exact).max())
        assert np.log2(misses[0] / misses[1]) == pytest.approx(2 * points, abs=0.1)
    found = solve_periodic(PeriodicProblem(rhs, nodes), 6, [0.0])
    assert np.abs(found.ends[0, :, 0] - exact).max() < 2e-15
    errors = []
    for panels in (35, 70, 140, 280, 560):
        problem = PeriodicProblem(rhs, np.linspace(0.0, TURN, panels + 1))
        found = solve_periodic(problem, 5, [0.0])
        errors.append(np.abs(evaluate(found, nodes)[0, :, 0] - exact).max())
    # a kink of the forcing within a panel leaves the square of its width, whatever the points
    order = -np.polyfit(np.arange(5), np.log2(errors), 1)[0]
    assert 1.6 < order < 2.4
    assert errors[-1] > 1e-9


def test_edges_at_kinks_of_the_state_settle_quadratically():
    problem = friction_problem(
        lambda x: np.sin(x) + 0.3 * np.cos(2.0 * x), [0.2], [1.0, 12.0], np.linspace(0, TURN, 13)
    )
    final = solve_periodic(problem, 10, [0.1]).edges
    now = newton(problem, solve_periodic(problem._replace(switch=None), 10, [0.1]))
    now = now._replace(stages=now.stages + 0.1, left=now.left + 0.1)
    off = []
    for _ in range(6):
        edges = split(problem, now)
        off.append(np.abs(edges - final).max())
        now = newton(problem, carried(problem, now, edges, 10))
    assert off[1] > 5e-2
    assert off[5] < 1e-8
    ratio = [after / before**2 for before, after in itertools.pairwise(off[1:])]
    assert max(ratio) < 6.0


def test_fourier_collocation_falls_geometrically():
    errors = []
    for points in (9, 17, 25):
        found = solve_fourier(bump_rhs(), points, [1.0])
        errors.append(np.abs(found.values[0, :, 0] - bump(found.x)).max())
    rate = np.array(errors[:-1]) / errors[1:]
    assert np.all(rate > 300.0)
    found = solve_fourier(bump_rhs(), 33, [1.0])
    # harmonics of exp(sin x): the modified Bessel functions I_0(1), 2 I_1(1)
    assert found.harmonics[0, 0, 0] == pytest.approx(1.2660658777520084, rel=1e-13)
    assert found.harmonics[0, 1, 0] == pytest.approx(-2j * 0.5651591039924850, rel=1e-13)
