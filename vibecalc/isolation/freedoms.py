"""A rigid body of which some of the six motions are left out, because nothing drives them.

The kept ones are indices (f,) into x y z rx ry rz. What is left out is zero, not free: the caller
has made sure that neither masses nor mounts nor forces couple it with what is kept.
"""

import numpy as np

from vibecalc.response.matrices import Matrices


def restricted(matrices: Matrices, kept: np.ndarray) -> Matrices:
    """The rows and columns (f, f) of the kept motions."""
    place = np.ix_(kept, kept)
    return Matrices(*(matrix[place] for matrix in matrices))


def held(matrices: Matrices, kept: np.ndarray) -> Matrices:
    """All six, those left out held by springs of their own that nothing loads.

    Each has the stiffness that gives it the largest frequency of the kept ones, so that nothing is
    lost to rounding. With all six kept the matrices are as they were.
    """
    out = np.setdiff1d(np.arange(6), kept)
    if not len(out):
        return matrices
    mass, stiffness = np.diagonal(matrices.mass), np.diagonal(matrices.stiffness)
    spring = mass[out] * float(np.max(stiffness[kept] / mass[kept]))
    copies = [np.array(matrix) for matrix in matrices]
    for matrix in copies:
        matrix[out], matrix[:, out] = 0.0, 0.0
    made = Matrices(*copies)
    made.mass[out, out], made.stiffness[out, out] = mass[out], spring
    return made


def all_six(values: np.ndarray, kept: np.ndarray, axis: int = -1) -> np.ndarray:
    """Values of the kept motions along `axis` among all six, zero for the others."""
    moved = np.moveaxis(values, axis, -1)
    full = np.zeros((*moved.shape[:-1], 6), dtype=values.dtype)
    full[..., kept] = moved
    return np.moveaxis(full, -1, axis)
