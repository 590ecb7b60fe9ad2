"""Claim: the assurance of two sets of modes knows no units, signs or scales, and is 1 or 0 where it
must be. Errors bound the true ones.
"""

import mpmath
import numpy as np
import pytest
from isolation_machines import exact, random_body

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.response.energies import mass_of
from vibecalc.response.modes import modal_assurance, modes

SEEDS = range(10)


def metres_and_radians(length: float) -> np.ndarray:
    """Weight (6, 6) under which a turn counts as the way it makes at a distance `length`, in m."""
    return np.diag([1.0, 1.0, 1.0, length**2, length**2, length**2])


def exactly(value: np.ndarray) -> Bounded:
    return Bounded(value, np.zeros(np.shape(value)))


@pytest.mark.parametrize("seed", SEEDS)
def test_modes_of_one_machine_are_orthogonal_under_its_mass(seed: int) -> None:
    matrices, generator = random_body(seed).matrices, np.random.default_rng(seed)
    shapes = modes(matrices)
    set_ = Bounded(shapes.shape, shapes.shape_error)
    scaled = set_.value * generator.choice([-1.0, 1.0], 6) * 10.0 ** generator.uniform(-5, 5, 6)
    found = modal_assurance(set_, exactly(scaled), mass_of(matrices))
    assert np.all(np.abs(found.value - np.eye(6)) <= found.error)
    assert np.all(found.error < 1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_unit_of_length_does_not_matter(seed: int) -> None:
    generator = np.random.default_rng(seed)
    first, second = generator.normal(size=(2, 6, 3))
    unit = np.array([1e3, 1e3, 1e3, 1.0, 1.0, 1.0])[:, None]
    metres = modal_assurance(exactly(first), exactly(second), exactly(metres_and_radians(0.5)))
    weight = exactly(metres_and_radians(500.0))
    millimetres = modal_assurance(exactly(first * unit), exactly(second * unit), weight)
    assert np.all(np.abs(metres.value - millimetres.value) <= metres.error + millimetres.error)
    # without a weight that knows of it, the unit decides
    bare = modal_assurance(exactly(first * unit), exactly(second * unit), exactly(np.eye(6)))
    assert np.max(np.abs(bare.value - metres.value)) > 0.01


@pytest.mark.parametrize("seed", SEEDS)
def test_value_and_error_against_fifty_digits(seed: int) -> None:
    generator = np.random.default_rng(seed)
    matrices = random_body(seed).matrices
    weight = exactly(matrices.mass)
    first = exactly(generator.normal(size=(6, 2)) + 1j * generator.normal(size=(6, 2)))
    shift = 1e-9 * generator.normal(size=(6, 2))
    known = Bounded(generator.normal(size=(6, 2)), np.abs(shift))
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
