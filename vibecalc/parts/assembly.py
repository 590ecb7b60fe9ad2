"""Mass, stiffness and damping of a rigid body on its mounts, put together."""

import numpy as np

from vibecalc.numerics.matrices import Matrices
from vibecalc.numerics.rounding import DATA_ROUNDINGS, UNIT_ROUNDOFF


def displacement_at(position: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 6) that take body coordinates to the displacement of points (..., 3).

    u = t + r x p for a translation t and a small rotation r, in metres.
    """
    point = np.asarray(position, dtype=float)
    x, y, z = point[..., 0], point[..., 1], point[..., 2]
    transform = np.zeros((*point.shape[:-1], 3, 6))
    transform[..., [0, 1, 2], [0, 1, 2]] = 1.0
    transform[..., 0, 4], transform[..., 0, 5] = z, -y
    transform[..., 1, 3], transform[..., 1, 5] = -z, x
    transform[..., 2, 3], transform[..., 2, 4] = y, -x
    return transform


def assemble(
    mass_matrix: np.ndarray,
    position: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    structural: np.ndarray,
) -> Matrices:
    """Add up the mounts of a body.

    Parameters
    ----------
    mass_matrix : (6, 6) about the reference point, static moments included, positive definite.
    position : (mounts, 3) from the reference point, m.
    stiffness, damping, structural : (mounts, 3, 3) symmetric, along the body's axes, in N/m,
        N s/m and N/m (loss factor times stiffness).

    Source: C. M. Harris and A. G. Piersol, Shock and Vibration Handbook, 5th ed., chapter 3.
    """
    transform = displacement_at(position)
    size = np.abs(transform)
    rounding = (len(transform) + 6 + DATA_ROUNDINGS) * UNIT_ROUNDOFF

    def add_up(blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        total = np.sum(transform.swapaxes(-1, -2) @ blocks @ transform, axis=0)
        terms = np.sum(size.swapaxes(-1, -2) @ np.abs(blocks) @ size, axis=0)
        return 0.5 * (total + total.T), rounding * terms

    mass = np.asarray(mass_matrix, dtype=float)
    total_stiffness, stiffness_error = add_up(np.asarray(stiffness, dtype=float))
    total_damping, damping_error = add_up(np.asarray(damping, dtype=float))
    total_structural, structural_error = add_up(np.asarray(structural, dtype=float))
    return Matrices(
        mass,
        total_stiffness,
        total_damping,
        total_structural,
        DATA_ROUNDINGS * UNIT_ROUNDOFF * np.abs(mass),
        stiffness_error,
        damping_error,
        structural_error,
    )
