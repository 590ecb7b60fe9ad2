"""Claim: the front is the known one, ends, bulges and jumps included, and its errors are honest."""

import numpy as np
import pytest

from vibecalc.core.study.search.fronts import front, knee
from vibecalc.core.study.search.problem import Problem


def two_bowls(x):
    """Distances squared from (0, 0) and (1, 0): sqrt(f1) + sqrt(f2) = 1 along the front."""
    return (x[0] ** 2 + x[1] ** 2, (x[0] - 1) ** 2 + x[1] ** 2), []


def test_convex_front_in_closed_form():
    found = front(Problem(two_bowls, [-2, -2], [2, 2]), points=9, starts=2)
    assert found.values[:, 0].size == 9
    assert np.all(np.diff(found.values[:, 0]) > 0)
    assert np.all(np.diff(found.values[:, 1]) < 0)
    exact = (1.0 - np.sqrt(found.values[:, 1])) ** 2
    allowed = found.errors[:, 0] + 2 * found.errors[:, 1]
    assert np.all(np.abs(found.values[:, 0] - exact) <= allowed + 1e-15)
    assert (found.values[:, 0][0], found.values[:, 1][-1]) == pytest.approx((0, 0), abs=1e-14)
    assert (found.values[:, 0][-1], found.values[:, 1][0]) == pytest.approx((1, 1), abs=1e-9)
    assert found.evaluations < 1700  # with those ahead, which a batch computes with the others
    assert not found.notes


def fonseca_fleming(x):
    """A front that bulges inwards, along x0 = x1 between -1/sqrt 2 and 1/sqrt 2."""
    half = 1 / np.sqrt(2)
    return (1 - np.exp(-np.sum((x - half) ** 2)), 1 - np.exp(-np.sum((x + half) ** 2))), []


def test_front_that_weighted_sums_miss():
    found = front(Problem(fonseca_fleming, [-4, -4], [4, 4]), points=5, starts=2)
    assert found.values[:, 0].size == 5
    place = np.mean(found.variables, axis=1)
    exact = 1 - np.exp(-2 * (place - 1 / np.sqrt(2)) ** 2)
    assert found.values[:, 0] == pytest.approx(exact, abs=1e-12)
    assert np.ptp(found.variables, axis=1) == pytest.approx(np.zeros(5), abs=1e-6)
    # in the middle of its bulge the front is above the line between its ends
    assert found.values[:, 0][2] + found.values[:, 1][2] > 1.2


def with_a_jump(x):
    """Along f2 = x the first objective has two valleys: the front leaves out what lies between."""
    return (0.2 * np.cos(3 * np.pi * x[0]) - x[0] + 1.2, x[0]), []


def test_jumps_are_left_out_and_said():
    found = front(Problem(with_a_jump, [0], [1]), points=15, starts=6)
    assert found.values[:, 0].size < 15
    assert any("dominated" in note for note in found.notes)
    # every point is the best of a fine grid for its bound on the second objective
    grid = np.linspace(0, 1, 20001)
    heights = 0.2 * np.cos(3 * np.pi * grid) - grid + 1.2
    for one, two in zip(found.values[:, 0], found.values[:, 1], strict=True):
        assert one <= np.min(heights[grid <= two + 1e-12]) + 1e-9
    assert np.all(np.diff(found.values[:, 0]) > 0)
    assert np.all(np.diff(found.values[:, 1]) < 0)


def test_an_end_that_is_not_unique_takes_the_best_of_the_others():
    """The second objective is zero on a whole edge; of it only one point belongs to the front."""

    def edge(x):
        return ((x[0] - 0.3) ** 2 + (x[1] - 1) ** 2, x[1]), []

    found = front(Problem(edge, [0, 0], [1, 1]), points=4, starts=3)
    assert found.variables[:, 0] == pytest.approx(np.full(4, 0.3), abs=1e-4)
    # the last point gives a millionth of the front away to be well defined
    assert found.values[:, 1][-1] == pytest.approx(1e-6, rel=1e-9)


def test_objectives_that_agree_have_one_best_point():
    found = front(
        Problem(lambda x: (((x[0] - 0.2) ** 2, (x[0] - 0.2) ** 2), []), [0], [1]), points=5
    )
    assert found.values[:, 0].shape == (1,)
    assert "one point is the best for both" in found.notes[0]


# ----------------------------------------------------------------------------
# Three objectives: fronts that are known in closed form.
# ----------------------------------------------------------------------------

CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def test_three_distances_have_a_triangle_for_a_front():
    """Squared distances from three corners: the best are all points of the triangle."""
    found = front(
        Problem(lambda x: (np.sum((x - CORNERS) ** 2, axis=1), []), [-1, -1], [2, 2]), 3, starts=1
    )
    x = found.variables
    assert len(x) == 15 and not found.notes
    assert np.all(x > -1e-9) and np.all(x.sum(axis=1) < 1.0 + 1e-9)
    exact = np.sum((x[:, None, :] - CORNERS) ** 2, axis=2)
    assert np.all(np.abs(found.values - exact) <= found.errors + 1e-15)
    for corner in CORNERS:
        assert np.min(np.linalg.norm(x - corner, axis=1)) < 1e-9


@pytest.mark.long
def test_a_front_that_bulges_inwards():
    """An eighth of a sphere, on which each objective is at its best along a whole edge."""

    def sphere(x):
        c, s = np.cos(x[:2]), np.sin(x[:2])
        return np.array([c[0] * c[1], c[0] * s[1], s[0]]) * (1.0 + x[2]), []

    quarter = np.pi / 2.0
    found = front(Problem(sphere, [0, 0, 0], [quarter, quarter, 1]), 3, points=6, starts=1)
    assert np.linalg.norm(found.values, axis=1) == pytest.approx(1.0, abs=1e-9)
    assert len(found.values) >= 5 and np.max(np.min(found.values, axis=1)) > 0.3


def test_the_knee_is_the_point_furthest_from_the_line_of_the_ends():
    """y = (1 - sqrt x)^2: x + y is least at x = 1/4."""
    x = np.linspace(0.0, 1.0, 41)
    front = np.stack([3.0 * x, 7.0 * (1.0 - np.sqrt(x)) ** 2], axis=1)
    assert x[knee(front)] == 0.25
    assert knee(np.stack([x, 1.0 - x], axis=1)) is None
    assert knee(np.stack([x, 1.0 - x**2], axis=1)) is None
