"""Claim: a difference without its sign is brought to zero, and a set of zeros is said to be one."""

import itertools

import numpy as np
import pytest
from long_but import long_but

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem

BOX3 = ([-2.0] * 3, [2.0] * 3)


def sphere(x):
    return abs(x @ x - 1.0), []


# objective, lower, upper, first, dimension of the set of zeros
CASES = {
    "plane": (lambda x: (abs(x[0] + 2 * x[1] - 1), []), [-1] * 2, [2] * 2, None, 1),
    "sphere": (sphere, *BOX3, [0.3, 0.2, 0.9], 2),
    "large numbers": (lambda x: (1e6 * sphere(x)[0], []), *BOX3, [0.3, 0.2, 0.9], 2),
    "starts at a zero": (lambda x: (abs(x[0] - x[1]), []), [-1] * 2, [1] * 2, [0.25, 0.25], 1),
    "energy of degree two": (
        lambda x: (abs(28 - (1 + 0.3 * np.sin(x[0])) * (2 * x[1] ** 2 + x[2] ** 2)), []),
        [0, 0, 0],
        [6.28, 10, 10],
        [1, 7, 7],
        2,
    ),
    "kinked itself": (
        lambda x: (abs(abs(x[0]) + abs(x[1]) - 1), []),
        [-2] * 2,
        [2] * 2,
        [0.4, 0.3],
        1,
    ),
    "worst of two": (
        lambda x: (max(abs(x[0] + x[1] - 1), abs(x[0] * x[2] - 0.1)), []),
        [-1] * 3,
        [2] * 3,
        None,
        1,
    ),
    "one variable": (lambda x: (abs(np.cos(x[0])), []), [0], [6], None, 0),
}


@pytest.mark.parametrize("starts", [0, pytest.param(3, marks=pytest.mark.long)])
@pytest.mark.parametrize("name", long_but(CASES, *list(CASES)[::3]))
def test_zero_is_reached_and_its_freedom_counted(name, starts):
    evaluate, lower, upper, first, free = CASES[name]
    found = minimise(Problem(evaluate, lower, upper, first=first), starts=starts)
    corners = itertools.product(*zip(lower, upper, strict=True))
    largest = max(evaluate(np.array(corner, dtype=float))[0] for corner in corners)
    assert found.method == "zero"
    assert 0.0 <= found.objective <= found.objective_error < 1e-10 * largest
    assert found.free_directions == free
    assert any("continuum" in note or "does not change" in note for note in found.notes) == (
        free > 0
    )


def test_limits_are_kept_on_the_way_to_zero():
    found = minimise(Problem(lambda x: (sphere(x)[0], [x[0] - 0.9, x[1] - 0.1]), *BOX3), starts=3)
    assert found.objective <= found.objective_error < 1e-12
    assert np.all(found.margins >= -1e-12)
