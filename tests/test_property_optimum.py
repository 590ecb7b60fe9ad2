"""Claim: an optimum does not depend on units, and its error estimates are honest on random problems
whose optimum is known exactly.
"""

import numpy as np
import pytest

from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Problem

SCALES = [(1.0, 1e3), (1e-6, 1e6), (1e5, 1e-9)]


def valley(x):
    """Two local optima, one limit that holds."""
    objective = (x[0] ** 2 - 1) ** 2 + 0.3 * x[0] + (x[1] - 0.2) ** 2 + 0.5 * x[0] * x[1]
    return objective, [1.2 - x[0] ** 2 - x[1] ** 2 * 0.3, x[1] + 0.4 * x[0] - 0.1]


@pytest.mark.parametrize(("unit", "size"), SCALES)
def test_units_do_not_matter(unit, size):
    plain = minimise(Problem(valley, [-2, -2], [2, 2]), starts=5)

    def scaled(x):
        objective, margins = valley(x / unit)
        return size * objective, margins

    found = minimise(Problem(scaled, [-2 * unit, -2 * unit], [2 * unit, 2 * unit]), starts=5)
    assert found.variables / unit == pytest.approx(plain.variables, rel=1e-9)
    assert found.objective / size == pytest.approx(plain.objective, rel=1e-13)
    assert found.margin_multipliers / size == pytest.approx(plain.margin_multipliers, abs=1e-9)


def test_of_equal_optima_the_nearest_to_the_first_start():
    def double_well(x):
        return (x[0] ** 2 - 1) ** 2 + 0.1, []

    for first in (-0.7, 0.7):
        found = minimise(Problem(double_well, [-2], [2], first=[first]), starts=6)
        assert found.variables[0] == pytest.approx(np.sign(first), abs=1e-9)
        assert len(found.optima) == 2


def random_problem(rng):
    """A convex objective and curved limits around an optimum that doubles hold exactly."""
    size = int(rng.integers(1, 4))
    holding = int(rng.integers(0, size + 1))
    count = holding + int(rng.integers(0, 3))
    rays = rng.integers(-8, 9, (size + 1, size)) / 8
    weight = rng.integers(1, 9, size + 1) / 4
    optimum = rng.integers(-24, 25, size) / 32
    normals = rng.integers(-8, 9, (count, size)) / 8
    is_held = np.arange(count) < holding
    pull = np.where(is_held, rng.integers(0, 9, count) / 4, 0.0)
    slack = np.where(is_held, 0.0, rng.integers(1, 9, count) / 4)
    curl = rng.integers(0, 9, count) / 8

    def evaluate(x):
        away = x - optimum
        objective = weight @ np.cosh(rays @ away) + pull @ (normals @ away) + away @ away / 4
        return objective, normals @ away - curl * (away @ away) + slack

    return evaluate, optimum, float(np.sum(weight))


@pytest.mark.parametrize("trials", [15, pytest.param(150, marks=pytest.mark.long)])
def test_errors_are_honest(trials):
    rng = np.random.default_rng(20080319)
    ratios, too_small = [], 0
    for _ in range(trials):
        evaluate, optimum, objective = random_problem(rng)
        found = minimise(Problem(evaluate, [-1] * optimum.size, [1] * optimum.size), starts=0)
        away = np.abs(found.variables - optimum)
        missed = abs(found.objective - objective)
        too_small += bool(
            missed > 10 * found.objective_error or np.any(away > 10 * found.variables_error)
        )
        ratios.append(found.variables_error / np.maximum(away, 1e-15))
        assert found.objective_error < 1e-12
    assert too_small <= 0.01 * trials
    assert np.median(np.concatenate(ratios)) < 100


def test_accuracy_of_the_values_reaches_the_errors():
    """A limit known to 1e-6 only moves the optimum by as much."""

    def slack(x, shift=0.0):
        return (x[0] + 2) ** 2, [x[0] - 0.5 + shift]

    rough = minimise(
        Problem(lambda x: (*slack(x), 1e-6 * np.array([slack(x)[0], 1.0])), [0], [1]), starts=0
    )
    off = minimise(Problem(lambda x: slack(x, 1e-6), [0], [1]), starts=0)
    assert abs(off.variables[0] - 0.5) <= rough.variables_error[0] < 1e-5
    assert abs(off.objective - rough.objective) <= rough.objective_error < 1e-4


def test_noise_is_measured():
    def noisy(x):
        return (x[0] - 0.3) ** 2 + 1e-9 * np.sin(1e10 * x[0]), []

    found = minimise(Problem(noisy, [0], [1]), starts=1)
    assert abs(found.variables[0] - 0.3) <= 10 * found.variables_error[0]
    assert abs(found.objective + 1e-9) <= 1e-8
    assert 1e-10 < found.objective_error < 1e-7


def test_ends_that_differ_where_nothing_depends_on_it_are_one_optimum():
    """A weight of size x at the angle y: at no size the angle is free; two sizes stay two."""

    def weight(x):
        return 0.2 + x[0] * (0.6 + 0.5 * np.cos(x[1])), []

    starts = np.array([[0.3, angle] for angle in (0.2, 1.5, 3.1, 4.6)])
    found = minimise(Problem(weight, [0, 0], [1, 6]), starts=0, further=starts)
    assert len({tuple(np.round(search.end, 3)) for search in found.history}) > 1
    assert [one.found_by for one in found.optima] == [5]
    assert found.objective == pytest.approx(0.2, rel=1e-12)


# ----------------------------------------------------------------------------
# Values that leave something out, as the orders that are not kept.
# ----------------------------------------------------------------------------


def known_with_error(rng, kind):
    """What is computed, the whole of it, and a bound of the difference, of two or three variables.

    A smooth bowl, a norm that vanishes at its optimum, or the largest of planes.
    """
    size = int(rng.integers(2, 4))
    turned = np.linalg.qr(rng.standard_normal((size, size)))[0]
    matrix = turned * 10.0 ** rng.uniform(-1.0, 0.5, size)
    middle, wave, phase = rng.uniform(-0.3, 0.3, size), rng.uniform(-2, 2, size), rng.uniform(0, 6)
    share = 10.0 ** rng.uniform(-5, -2)
    planes = rng.standard_normal((size + 1, size))
    planes -= planes.mean(axis=0)

    pushed = rng.standard_normal(size)

    def bowl(x, share=0.0):
        along = (x - middle) @ matrix
        return 1.0 + along @ along + 0.3 * np.sum(along**3) + share * np.cos(wave @ x + phase)

    def norm(x, share=0.0):
        along = (x - middle) @ matrix + share * pushed / np.linalg.norm(pushed)
        return np.linalg.norm(along)

    def largest(x, share=0.0):
        each = np.cos(wave @ x + phase + np.arange(size + 1))
        return 1.0 + np.max(planes @ (x - middle) + share * each)

    computed = {"bowl": bowl, "norm": norm, "planes": largest}[kind]
    return size, computed, lambda x: computed(x, share), share


@pytest.mark.parametrize("kind", ["bowl", "norm", "planes"])
@pytest.mark.parametrize("trials", [6, pytest.param(60, marks=pytest.mark.long)])
def test_what_is_left_out_of_the_values_is_in_the_errors_of_each_variable(kind, trials):
    """The optimum of the whole is within the errors, which are not of the size of the bounds."""
    rng = np.random.default_rng(1877)
    missed, stated, moved = 0, [], []
    for _ in range(trials):
        size, computed, whole, share = known_with_error(rng, kind)
        bounds = [-1.0] * size, [1.0] * size
        asked = Problem(lambda x, f=computed, off=share: (f(x), [], np.array([off])), *bounds)
        found = minimise(asked, starts=0)
        true = minimise(
            Problem(lambda x, f=whole: (f(x), []), *bounds, first=found.variables), starts=0
        )
        away = np.abs(found.variables - true.variables)
        missed += bool(np.any(away > found.variables_error + true.variables_error))
        assert abs(found.objective - true.objective) <= found.objective_error + 1e-12
        stated.append(found.variables_error)
        moved.append(away)
    stated, moved = np.concatenate(stated), np.concatenate(moved)
    assert missed <= 0.03 * trials
    assert np.all(moved <= 10.0 * stated + 1e-9)
    assert np.median(stated / np.maximum(moved, 1e-9)) < 20.0
