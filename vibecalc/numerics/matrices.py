"""Matrices of a linear system, and least squares whose unknowns are not negative."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import FloatArray

# ----------------------------------------------------------------------------
# A linear machine as matrices, with what rounding may have done to them.
# ----------------------------------------------------------------------------


class Matrices(NamedTuple):
    """Mass, stiffness, damping and structural (loss) matrices, each (6, 6), with absolute errors.

    Units by block: kg, kg m, kg m^2; N/m, N, N m; N s/m, N s, N m s. The error of an entry counts
    the magnitudes of all terms that were added for it, so it stands where an entry cancels to 0.
    """

    mass: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    structural: np.ndarray
    mass_error: np.ndarray
    stiffness_error: np.ndarray
    damping_error: np.ndarray
    structural_error: np.ndarray


def bounded_parts(matrices: Matrices) -> tuple[Bounded, Bounded, Bounded, Bounded]:
    """Mass, stiffness, damping and structural matrix with the error of each."""
    mass, stiffness, damping, structural = map(Bounded, matrices[:4], matrices[4:])
    return mass, stiffness, damping, structural


# ----------------------------------------------------------------------------
# Least squares with weights that are not negative, for the multipliers of a constrained search.
# ----------------------------------------------------------------------------

#: rounds for each unknown; a basis is usually found after two or three
_ROUNDS = 50


def nonnegative_least_squares(table: FloatArray, right: FloatArray) -> FloatArray:
    """Weights (n,) >= 0 that bring `table` (m, n) times the weights nearest to `right` (m,).

    Lawson and Hanson (1974), as scipy has it. Raises NumericalFailure where it does not end.
    """
    from scipy.optimize import nnls

    try:
        weights, _ = nnls(table, right, maxiter=_ROUNDS * table.shape[1])
    except RuntimeError as error:
        raise NumericalFailure(
            "least squares with weights that are not negative finds no end: "
            f"{table.shape[1]} conditions on {table.shape[0] - 1} variables are nearly dependent"
        ) from error
    return np.asarray(weights, dtype=float)
