"""What a mode is made of, and what damps it."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.matrices import Matrices
from vibecalc.response.modes import Modes


def energy_fraction(matrices: Matrices, shapes: Modes) -> WithError:
    """Share of each coordinate in the kinetic energy of each mode, and its error.

    Value and error are (modes, 6). Each row sums to 1; an entry v_i (M v)_i / (v M v) can be
    slightly negative where the mass centre is off the reference point.
    """
    moved = matrices.mass @ shapes.shape
    energy = shapes.shape * moved
    total = np.sum(energy, axis=0)
    size_moved = np.abs(matrices.mass) @ np.abs(shapes.shape)
    error = (
        shapes.shape_error * np.abs(moved)
        + np.abs(shapes.shape) * (np.abs(matrices.mass) @ shapes.shape_error)
        + 10.0 * UNIT_ROUNDOFF * np.abs(shapes.shape) * size_moved
        + np.abs(shapes.shape) * (matrices.mass_error @ np.abs(shapes.shape))
    )
    return WithError((energy / total).T, (error / total).T)


def damping_ratio(matrices: Matrices, shapes: Modes) -> WithError:
    """Damping ratio of each mode (modes,), and its error: v C v / (2 w) + v H v / (2 w^2).

    Exact for proportional damping, the usual estimate otherwise; the structural part is half the
    loss factor that the mode sees at its own frequency. Raises NumericalFailure for a mode that
    nothing holds, whose ratio has no meaning.
    """
    free = np.flatnonzero(shapes.eigenvalue <= shapes.eigenvalue_error)
    if free.size:
        number = int(free[0]) + 1
        raise NumericalFailure(
            f"mode {number} has no damping ratio: nothing holds the body in it (its stiffness is "
            f"zero to rounding); give the mounts stiffness in that direction"
        )
    frequency = shapes.natural_frequency
    vector, size = shapes.shape, np.abs(shapes.shape)
    viscous = np.sum(vector * (matrices.damping @ vector), axis=0) / (2.0 * frequency)
    loss = np.sum(vector * (matrices.structural @ vector), axis=0) / (2.0 * shapes.eigenvalue)
    rounding = 14.0 * UNIT_ROUNDOFF

    def doubt(matrix: np.ndarray, matrix_error: np.ndarray) -> np.ndarray:
        spread = matrix_error + rounding * np.abs(matrix)
        moved = np.abs(matrix @ vector)
        total: np.ndarray = np.sum(
            size * (spread @ size) + 2.0 * shapes.shape_error * moved, axis=0
        )
        return total

    relative = shapes.eigenvalue_error / shapes.eigenvalue + 4.0 * UNIT_ROUNDOFF
    error = (
        doubt(matrices.damping, matrices.damping_error) / (2.0 * frequency)
        + doubt(matrices.structural, matrices.structural_error) / (2.0 * shapes.eigenvalue)
        + relative * (np.abs(viscous) + np.abs(loss))
    )
    return WithError(viscous + loss, error)


def modal_force(shapes: Modes, force: np.ndarray, force_error: np.ndarray) -> WithError:
    """Force (..., 6) on each mode (..., modes), with the error up to which it may be zero."""
    size = np.abs(shapes.shape)
    value = force @ shapes.shape
    error = force_error @ size + np.abs(force) @ (shapes.shape_error + 8.0 * UNIT_ROUNDOFF * size)
    return WithError(value, error)
