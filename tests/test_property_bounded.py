"""Bounds carried through formulas hold for random data, against mpmath, and are not idle."""

from typing import Any

import mpmath
import numpy as np
import pytest

from vibecalc.numerics import bounded as b
from vibecalc.numerics.bounded import Bounded

FORMULAS = {
    "sum": lambda x, y, z: x + y - z,
    "cancelling": lambda x, y, z: (x * x - y * y) / (x - y) - 0.5 * z,
    "powers": lambda x, y, z: x * y / (z + 3.0) + 2.0 / x,
    "reflected": lambda x, y, z: 1.0 - (3.0 + x) * y,
}


@pytest.mark.parametrize("formula", FORMULAS.values(), ids=FORMULAS)
@pytest.mark.parametrize("imaginary", [0.0, 1.0], ids=["real", "complex"])
def test_errors_of_data_and_rounding_stay_below_the_bound(formula: Any, imaginary: float) -> None:
    rng = np.random.default_rng(8)
    shape = (3, 200)
    values = rng.uniform(0.5, 2.0, shape) + 1j * imaginary * rng.uniform(-1.0, 1.0, shape)
    values = values if imaginary else values.real
    errors = 10.0 ** rng.uniform(-15.0, -9.0, shape)
    found = formula(*(Bounded(v, e) for v, e in zip(values, errors, strict=True)))
    moved = (
        errors * np.exp(2j * np.pi * rng.uniform(size=shape))
        if imaginary
        else errors * rng.choice([-1.0, 1.0], shape)
    )
    shares = []
    with mpmath.workdps(40):
        for k in range(shape[1]):
            data = [
                mpmath.mpmathify(v) + mpmath.mpmathify(m)
                for v, m in zip(values[:, k], moved[:, k], strict=True)
            ]
            true = formula(*data)
            shares.append(
                float(abs(mpmath.mpmathify(found.value[k]) - true) / mpmath.mpf(found.error[k]))
            )
    assert max(shares) <= 1.0 + 1e-6
    assert max(shares) > 0.1


def test_sums_norms_products_and_roots_against_forty_digits() -> None:
    rng = np.random.default_rng(9)
    x = rng.normal(size=(50, 30)) * 10.0 ** rng.uniform(-3, 3, (50, 30))
    matrix = rng.normal(size=(30, 4))
    errors = 1e-13 * np.abs(x)
    value = Bounded(x, errors)
    with mpmath.workdps(40):
        exact = mpmath.matrix((x * (1.0 + 1e-13)).tolist())
        rows = [[exact[i, j] for j in range(30)] for i in range(50)]
        truths = {
            "sum": (value.sum(), [mpmath.fsum(row) for row in rows]),
            "norm": (value.norm(), [mpmath.norm(row) for row in rows]),
            "product": (
                value @ matrix,
                [[mpmath.fdot(row, column) for column in matrix.T.tolist()] for row in rows],
            ),
            "from the left": (
                matrix.T @ value.T,
                [[mpmath.fdot(row, column) for row in rows] for column in matrix.T.tolist()],
            ),
            "root": (b.sqrt(abs(value)), [[mpmath.sqrt(abs(one)) for one in row] for row in rows]),
            "square": (b.square(value), [[one * one for one in row] for row in rows]),
        }
        for name, (found, truth) in truths.items():
            off = [
                abs(mpmath.mpf(v) - t)
                for v, t in zip(np.ravel(found.value).tolist(), _flat(truth), strict=True)
            ]
            share = np.array([float(o) for o in off]) / np.ravel(
                np.broadcast_to(found.error, found.shape)
            )
            assert share.max() <= 1.0 + 1e-3, name
            assert share.max() > 0.05, name


def test_a_root_next_to_zero_is_off_by_the_root_of_the_error() -> None:
    found = b.sqrt(Bounded(np.array([0.0, 1e-20, 4.0]), np.array([1e-18, 1e-18, 1e-10])))
    assert found.error == pytest.approx([1e-9, 1e-9, 2.5e-11], rel=1e-5)


def _flat(nested: Any) -> list[Any]:
    return [x for one in nested for x in (one if isinstance(one, list) else [one])]


def test_a_largest_value_is_off_by_those_that_may_be_it() -> None:
    found = b.maximum(Bounded(np.array([5.0, 5.0]), np.array([1e-20, 0.1])), Bounded(
        np.array([3.0, 4.9]), np.array([1.0, 1.0])))  # fmt: skip
    assert found.value.tolist() == [5.0, 5.0]
    assert found.error == pytest.approx([1e-20, 0.9])
