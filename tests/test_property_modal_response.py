"""Claim: a sum of modes gives the response of the direct solution, in both error estimates: for
repeated modes, for modes without stiffness, close to resonances; and it refuses to answer on one.
"""

import numpy as np
import pytest

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import WithError
from vibecalc.parts.matrices import assemble
from vibecalc.response.forced import dynamics, modal_response, response
from vibecalc.response.modal_damping import (
    damped_basis,
)
from vibecalc.response.modes import modes


def load_of(generator: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    value: np.ndarray = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    return value


def both(matrices: Matrices, frequency: np.ndarray, load: np.ndarray) -> tuple[WithError, ...]:
    """By modes and directly; the two must agree."""
    nothing = np.zeros(load.shape)
    summed = modal_response(matrices, modes(matrices).shape, frequency, load, nothing)
    direct = response(dynamics(matrices, frequency), load, nothing)
    assert np.all(np.abs(summed.value - direct.value) <= summed.error + direct.error)
    return summed, direct


def square_matrices(damping: float) -> Matrices:
    """Four equal mounts about the centre: x and y at one frequency, rx and ry at another."""
    corners = np.array([[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.4, 0.4)])
    each = np.broadcast_to(np.eye(3), (4, 3, 3))
    mass = np.diag([100.0, 100.0, 100.0, 8.0, 8.0, 14.0])
    along = np.zeros((3, 3))
    along[:2, :2] = damping
    return assemble(mass, corners, 1e5 * each, np.broadcast_to(along, (4, 3, 3)), 0.02e5 * each)


@pytest.mark.parametrize("damping", [0.0, 40.0], ids=["apart", "coupled"])
def test_repeated_modes_in_any_basis(damping: float) -> None:
    """Dampers along (1, 1, 0) couple the pair x, y in one basis and not in another."""
    matrices, generator = square_matrices(damping), np.random.default_rng(2)
    shapes = modes(matrices)
    assert np.sum(np.diff(shapes.natural_frequency) < 1e-12 * shapes.natural_frequency[1:]) >= 2
    frequency = np.concatenate([shapes.natural_frequency, [3.0, 500.0]])
    load, nothing = load_of(generator, (8, 6)), np.zeros((8, 6))
    direct = response(dynamics(matrices, frequency), load, nothing)
    turned = shapes.shape.copy()
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    turned[:, :2] = turned[:, :2] @ turn
    for basis in (shapes.shape, damped_basis(matrices, shapes).shape, turned):
        summed = modal_response(matrices, basis, frequency, load, nothing)
        assert np.all(np.abs(summed.value - direct.value) <= summed.error + direct.error)
        assert np.all(summed.error < 1e-12 * np.abs(summed.value).max(axis=-1, keepdims=True))


def floating() -> Matrices:
    """A body held along z only: five motions that no stiffness holds."""
    each = np.zeros((3, 3))
    each[2, 2] = 1e5
    mass = np.diag([50.0, 50.0, 50.0, 4.0, 5.0, 6.0])
    none = np.zeros((1, 3, 3))
    return assemble(mass, np.array([[0.1, 0.0, 0.0]]), each[None], none, none)


def test_modes_without_stiffness_answer_as_free_masses() -> None:
    matrices = floating()
    shapes = modes(matrices)
    assert np.count_nonzero(shapes.eigenvalue <= shapes.eigenvalue_error) >= 4
    frequency, load = np.array([2.0, 200.0]), load_of(np.random.default_rng(1), (2, 6))
    summed, _ = both(matrices, frequency, load)
    for number, w in enumerate(frequency):
        free = [0, 1, 3, 5]
        expected = -load[number, free] / (w * w * np.diagonal(matrices.mass)[free])
        np.testing.assert_allclose(summed.value[number, free], expected, rtol=1e-13)
    with pytest.raises(NumericalFailure, match="excitation at 0 rad/s"):
        modal_response(matrices, shapes.shape, np.zeros(1), load[:1], np.zeros((1, 6)))
