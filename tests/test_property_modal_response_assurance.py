"""Claim: the assurance of two sets of modes is the true one within its error."""

import mpmath
import numpy as np
import pytest
from isolation_machines import exact, random_body

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import WithError
from vibecalc.response.modes import modal_assurance

SEEDS = range(10)


def exactly(value: np.ndarray) -> WithError:
    return WithError(value, np.zeros(np.shape(value)))


@pytest.mark.parametrize("seed", SEEDS)
def test_value_and_error_against_fifty_digits(seed: int) -> None:
    generator = np.random.default_rng(seed)
    matrices = random_body(seed).matrices
    weight = exactly(matrices.mass)
    first = exactly(generator.normal(size=(6, 2)) + 1j * generator.normal(size=(6, 2)))
    shift = 1e-9 * generator.normal(size=(6, 2))
    known = WithError(generator.normal(size=(6, 2)), np.abs(shift))
    found = modal_assurance(first, known, weight)
    with mpmath.workdps(50):
        w, v = exact(weight.value), exact(first.value)
        u = exact(known.value) + exact(shift)
        for i in range(2):
            for j in range(2):
                a, b = v[:, i], u[:, j]
                a_bar = np.array([mpmath.conj(x) for x in a], dtype=object)
                mac = abs(a_bar @ w @ b) ** 2 / ((a_bar @ w @ a).real * (b @ w @ b))
                off = abs(mpmath.mpf(float(found.value[i, j])) - mac)
                assert off <= found.error[i, j]
    assert np.all(found.error < 1e-5)


def test_a_shape_of_nothing_is_refused() -> None:
    shapes = np.eye(6)[:, :2]
    shapes[:, 1] = 0.0
    with pytest.raises(NumericalFailure, match="shape 2 of the second set is zero"):
        modal_assurance(exactly(np.eye(6)), exactly(shapes), exactly(np.eye(6)))
