"""Claim: modes of a body keep their digits, whatever the unit, the stiffness or the symmetry."""

import numpy as np
import pytest
from isolation_machines import (
    gibson_body,
    random_body,
)

from vibecalc.parts.matrices import assemble
from vibecalc.response.modal_damping import energy_fraction
from vibecalc.response.modes import modes


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_modes_do_not_depend_on_the_unit_of_length(factor: float) -> None:
    """Metres exchanged for another unit: frequencies and energy fractions stay."""
    body = random_body(7)
    scale = np.array([1.0, 1.0, 1.0, factor, factor, factor])
    mass_matrix = body.mass_matrix * np.outer(scale, scale)
    other = assemble(mass_matrix, body.mounts.position * factor, *body.mounts[1:])
    plain, scaled = modes(body.matrices), modes(other)
    assert scaled.natural_frequency == pytest.approx(plain.natural_frequency, rel=1e-10)
    energy = energy_fraction(other, scaled).value
    assert energy == pytest.approx(energy_fraction(body.matrices, plain).value, abs=1e-9)


def test_repeated_modes_are_aligned_with_the_coordinates() -> None:
    """Equal stiffness in all directions: three translations at one frequency, none mixed."""
    body = gibson_body()
    shapes = modes(body.matrices)
    share = energy_fraction(body.matrices, shapes)
    repeated = np.isclose(shapes.natural_frequency, 20.0, rtol=1e-12)
    assert np.sum(repeated) == 3
    assert np.max(share.value, axis=1) == pytest.approx(np.ones(6), abs=1e-12)
    assert sorted(np.argmax(share.value, axis=1)) == list(range(6))
    assert np.max(share.error) < 1e-10


def test_modes_of_very_stiff_and_very_soft_directions_keep_their_digits() -> None:
    """Principal stiffnesses from 1 to 1e12: every frequency to 1e-12, which plain eigh loses."""
    level = np.array([1.0, 1e4, 1e12])
    position = np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0], [0, -1.0, 0]])
    stiffness = np.broadcast_to(np.diag(level), (4, 3, 3))
    matrices = assemble(np.eye(6), position, stiffness, 0.0 * stiffness, 0.0 * stiffness)
    squared = np.concatenate([4.0 * level, [2.0 * 1e12, 2.0 * 1e12, 2.0 * (1e4 + 1.0)]])
    shapes = modes(matrices)
    expected = np.sort(np.sqrt(squared))
    assert shapes.natural_frequency == pytest.approx(expected, rel=1e-12)
    assert np.all(np.abs(shapes.natural_frequency - expected) <= shapes.natural_frequency_error)
