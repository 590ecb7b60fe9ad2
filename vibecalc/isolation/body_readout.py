"""Readings of a rigid body's motion: forces of the mounts on the ground, couple over a lever."""

import numpy as np

from vibecalc.isolation.readout import Readout
from vibecalc.isolation.rigid_body import displacement_at
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF
from vibecalc.response.matrices import Matrices


def mount_readout(
    position: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, structural: np.ndarray
) -> Readout:
    """Force of each mount on the ground, rows of three components, for a rigid body."""
    transform = displacement_at(position)
    rounding = (8 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    return Readout((stiffness + 1j * structural) @ transform, damping @ transform, rounding)


def couple_readout(matrices: Matrices, coordinate: int, lever: float) -> Readout:
    """Couple through the mounts about one coordinate over a lever: one row, one component."""
    passing = matrices.stiffness + 1j * matrices.structural
    row = slice(coordinate, coordinate + 1)
    rounding = (len(passing) + 8 + DATA_ROUNDINGS) * UNIT_ROUNDOFF
    return Readout(passing[None, row] / lever, matrices.damping[None, row] / lever, rounding)
