"""Claim: least squares with weights that are not negative, and linear programs of few unknowns,
come as low as scipy's."""

import numpy as np
import pytest
from scipy.optimize import linprog, nnls

from vibecalc.numerics.matrices import nonnegative_least_squares
from vibecalc.torsion.damper_design.descend import lowest_vertex


@pytest.mark.parametrize("seed", range(40))
def test_least_squares_with_weights_that_are_not_negative(seed: int) -> None:
    """Also of columns that are there twice, of a heavy row, and of sizes far apart."""
    random = np.random.default_rng(seed)
    for number in range(20):
        rows, columns = random.integers(1, 7), random.integers(1, 30)
        table = random.normal(size=(rows, columns))
        if number % 2:
            table *= 10.0 ** random.uniform(-3, 3, columns)
        if number % 5 == 0:
            table[-1] = 1e3
        if number % 7 == 0:
            table[:, columns // 2 :] = table[:, : columns - columns // 2]
        right = random.normal(size=rows) if number % 3 else np.append(np.zeros(rows - 1), 1.0)
        weights, least = nonnegative_least_squares(table, right), nnls(table, right)[1]
        assert np.all(weights >= 0.0)
        left = np.linalg.norm(table @ weights - right)
        assert left <= least + 1e-8 * np.linalg.norm(right)


@pytest.mark.parametrize("penalty", [5.0, 1e4, np.inf])
@pytest.mark.parametrize("seed", range(20))
def test_the_lowest_vertex_of_a_linear_program(seed: int, penalty: float) -> None:
    """Of peaks that fall and rise with a step within a box, some of them against limits."""
    random = np.random.default_rng(seed)
    for _ in range(20):
        unknowns, peaks = random.integers(1, 4), random.integers(1, 40)
        slope, level = random.normal(size=(peaks, unknowns)), 1.0 - 0.5 * random.random(peaks)
        section = random.random(peaks) < 0.7
        section[0] = True
        rows = np.hstack([slope, -1.0 * section[:, None], -1.0 * ~section[:, None]])
        right = np.where(section, 0.0, 1.0) - level
        last = [0.0, 1.0] if penalty == np.inf else [1.0, penalty]
        cost = np.append(np.zeros(unknowns), last)
        radius = 10.0 ** random.uniform(-3, 0)
        low, high = -radius * random.random(unknowns), radius * random.random(unknowns)
        box = [*zip(low, high, strict=True), (None, None), (0.0, None)]
        least = linprog(cost, rows, right, bounds=box, method="highs").fun
        sides = np.eye(unknowns, unknowns + 2)
        above = np.append(np.zeros(unknowns + 1), -1.0)
        rows = np.vstack([rows, sides, -sides, above])
        right = np.concatenate([right, high, -low, [0.0]])
        first = int(np.argmax(np.where(section, level, -np.inf)))
        held = peaks + np.where(slope[first] > 0.0, unknowns, 0) + np.arange(unknowns)
        point = lowest_vertex(cost, rows, right, [first, *held.tolist(), len(rows) - 1])
        assert point is not None
        assert np.all(rows @ point <= right + 1e-11)
        assert abs(cost @ point - least) <= 1e-11 * max(1.0, abs(least))
