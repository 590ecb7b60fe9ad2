"""Claim: modes keep their digits and add up to the direct solution, whatever the symmetry and
what holds the body; the assurance of two sets of them is the true one within its error.
"""

import mpmath
import numpy as np
import pytest
from isolation_machines import exact, gibson_body, random_body

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear, dynamics, response
from vibecalc.parts.matrices import assemble
from vibecalc.response.modes import modal_assurance, modes
from vibecalc.response.system import MountedBody, in_modes


def exactly(value: np.ndarray) -> Bounded:
    return Bounded(value, np.zeros(np.shape(value)))


def exact_load(generator: np.random.Generator, count: int) -> np.ndarray:
    value: np.ndarray = generator.normal(size=(count, 6)) + 1j * generator.normal(size=(count, 6))
    return value


def test_repeated_modes_are_aligned_with_the_coordinates() -> None:
    """Equal stiffness in all directions: three translations at one frequency, none mixed."""
    body = gibson_body()
    shapes = modes(body.matrices)
    share = MountedBody(matrices=body.matrices, shapes=shapes).energy_fraction()
    repeated = np.isclose(shapes.natural_frequency, 20.0, rtol=1e-12)
    assert np.sum(repeated) == 3
    assert np.max(share.value, axis=1) == pytest.approx(np.ones(6), abs=1e-12)
    assert sorted(np.argmax(share.value, axis=1)) == list(range(6))
    assert np.max(share.error) < 1e-10


def test_modes_that_rounding_alone_tells_apart_stay_orthonormal() -> None:
    """Two pairs of equal frequencies on a square of mounts, each stiffness off by roundings."""
    generator = np.random.default_rng(3)
    position = np.array([[x, y, z] for x in (-0.25,) for y in (-0.25, 0.25) for z in (-0.25, 0.25)])
    mass = np.diag([150.0, 150.0, 150.0, 9.0, 7.0, 7.0])
    for _ in range(200):
        stiffness = 2.5e5 * (1.0 + 1e-14 * generator.uniform(-1.0, 1.0, 4))[:, None, None]
        stiffness = stiffness * np.eye(3)
        matrices = assemble(mass, position, stiffness, 0.0 * stiffness, 0.1 * stiffness)
        shapes = modes(matrices)
        gram = shapes.shape.T @ matrices.mass @ shapes.shape
        assert np.abs(gram - np.eye(6)).max() < 1e-14
        ratio = MountedBody(matrices=matrices, shapes=shapes).damping_ratio()
        assert np.all(np.abs(ratio.value - 0.05) <= ratio.error)


def square_matrices(damping: float) -> Linear:
    """Four equal mounts about the centre: x and y at one frequency, rx and ry at another."""
    corners = np.array([[x, y, 0.0] for x in (-0.4, 0.4) for y in (-0.4, 0.4)])
    each = np.broadcast_to(np.eye(3), (4, 3, 3))
    mass = np.diag([100.0, 100.0, 100.0, 8.0, 8.0, 14.0])
    along = np.zeros((3, 3))
    along[:2, :2] = damping
    return assemble(mass, corners, 1e5 * each, np.broadcast_to(along, (4, 3, 3)), 0.02e5 * each)


def by_modes(
    matrices: Linear, basis: np.ndarray, frequency: np.ndarray, load: np.ndarray
) -> Bounded:
    """Motion (m, 6) as a sum of modes."""
    drive = exactly(load) @ basis
    return response(dynamics(in_modes(matrices, basis), frequency), *drive) @ basis.T


@pytest.mark.parametrize("damping", [0.0, 40.0], ids=["apart", "coupled"])
def test_repeated_modes_in_any_basis(damping: float) -> None:
    """Dampers along (1, 1, 0) couple the pair x, y in one basis and not in another."""
    matrices, generator = square_matrices(damping), np.random.default_rng(2)
    shapes = modes(matrices)
    assert np.sum(np.diff(shapes.natural_frequency) < 1e-12 * shapes.natural_frequency[1:]) >= 2
    frequency = np.concatenate([shapes.natural_frequency, [3.0, 500.0]])
    load, nothing = exact_load(generator, 8), np.zeros((8, 6))
    direct = response(dynamics(matrices, frequency), load, nothing)
    turned = shapes.shape.copy()
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    turned[:, :2] = turned[:, :2] @ turn
    for basis in (shapes.shape, turned):
        summed = by_modes(matrices, basis, frequency, load)
        assert np.all(np.abs(summed.value - direct.value) <= summed.error + direct.error)
        assert np.all(summed.error < 1e-12 * np.abs(summed.value).max(axis=-1, keepdims=True))


def test_modes_without_stiffness_answer_as_free_masses() -> None:
    """A body held along z only: five motions that no stiffness holds."""
    each = np.diag([0.0, 0.0, 1e5])[None]
    mass = np.diag([50.0, 50.0, 50.0, 4.0, 5.0, 6.0])
    matrices = assemble(mass, np.array([[0.1, 0.0, 0.0]]), each, 0.0 * each, 0.0 * each)
    shapes = modes(matrices)
    assert np.count_nonzero(shapes.eigenvalue <= shapes.eigenvalue_error) >= 4
    frequency, load = np.array([2.0, 200.0]), exact_load(np.random.default_rng(1), 2)
    nothing = np.zeros((2, 6))
    summed = by_modes(matrices, shapes.shape, frequency, load)
    direct = response(dynamics(matrices, frequency), load, nothing)
    assert np.all(np.abs(summed.value - direct.value) <= summed.error + direct.error)
    for number, w in enumerate(frequency):
        free = [0, 1, 3, 5]
        expected = -load[number, free] / (w * w * np.diagonal(matrices.mass)[free])
        np.testing.assert_allclose(summed.value[number, free], expected, rtol=1e-13)
    with pytest.raises(NumericalFailure, match="between 0 Hz and 0 Hz is exactly singular"):
        by_modes(matrices, shapes.shape, np.zeros(1), load[:1])


@pytest.mark.parametrize("seed", range(3))
def test_value_and_error_against_fifty_digits(seed: int) -> None:
    generator = np.random.default_rng(seed)
    weight = exactly(np.diagonal(random_body(seed).matrices.mass))
    shift = 1e-9 * generator.normal(size=(6, 3))
    known = Bounded(generator.normal(size=(6, 3)), np.abs(shift))
    found = modal_assurance(known, weight)
    with mpmath.workdps(50):
        w, v = exact(weight.value), exact(known.value) + exact(shift)
        for i in range(3):
            for j in range(3):
                a, b = v[:, i], v[:, j]
                mac = (a @ (w * b)) ** 2 / ((a @ (w * a)) * (b @ (w * b)))
                off = abs(mpmath.mpf(float(found.value[i, j])) - mac)
                assert off <= found.error[i, j]
    assert np.all(found.error < 1e-5)
