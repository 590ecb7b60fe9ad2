"""Claim: an optimum does not depend on units, and its error estimates are honest on random problems
whose optimum is known exactly.
"""

import itertools
import threading

import numpy as np
import pytest
from long_but import long_but

from vibecalc.core.study.search import local_search
from vibecalc.core.study.search.minimise import minimise
from vibecalc.core.study.search.problem import Infeasible, Problem
from vibecalc.core.study.search.side_by_side import side_by_side
from vibecalc.errors import NumericalFailure

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


# ----------------------------------------------------------------------------
# A difference without its sign is brought to zero, and a set of zeros is said to be one.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# Searches side by side find what they find alone, in fewer rounds, and end together.
# ----------------------------------------------------------------------------


def hills(x):
    """Some local optima, one limit."""
    return np.cos(3.0 * x[0]) + 0.3 * x[0] ** 2 + (x[1] - 0.4 * x[0]) ** 2, [2.0 - x @ x]


def searched(rounds):
    problem = Problem(hills, [-2.0, -2.0], [2.0, 1.5], ahead=rounds.append)
    return minimise(problem, starts=7)


def test_same_optima_in_half_the_rounds(monkeypatch):
    few, many = [], []
    together = searched(few)
    monkeypatch.setattr(local_search, "TOGETHER", 1)
    alone = searched(many)
    assert np.array_equal(together.variables, alone.variables)
    assert together.objective == alone.objective
    assert together.evaluations == alone.evaluations
    for one, other in zip(together.history, alone.history, strict=True):
        assert np.array_equal(one.end, other.end)
    assert len(few) < 0.5 * len(many)


def test_each_waits_until_all_have_asked():
    met = []

    def search(count):
        def run(ask):
            for turn in range(count):
                ask([np.array([count, turn])])
                met.append((count, turn))
            return count

        return run

    asked = []
    found = side_by_side([search(1), search(3)], lambda points: asked.append(len(points)))
    assert found == [1, 3]
    assert asked == [2, 1, 1, 0]
    assert met == [(1, 0), (3, 0), (3, 1), (3, 2)]


def test_what_one_raises_ends_all():
    def fails(ask):
        ask([np.zeros(1)])
        raise NumericalFailure("there is no smallest value")

    def waits(ask):
        while True:
            ask([np.zeros(1)])

    before = threading.active_count()
    with pytest.raises(NumericalFailure, match="no smallest value"):
        side_by_side([waits, fails, waits], lambda points: None)
    for thread in threading.enumerate():
        if thread.daemon:
            thread.join(5.0)
    assert threading.active_count() == before


def test_a_limit_that_cannot_be_kept_is_given_up_soon():
    def evaluate(x):
        return (x[0] - 0.3) ** 2, [-1.0 - 0.0 * x[0]]

    with pytest.raises(Infeasible) as failure:
        minimise(Problem(evaluate, [0.0], [1.0]), starts=2)
    assert failure.value.violation == 1.0
    assert failure.value.evaluations < 80
