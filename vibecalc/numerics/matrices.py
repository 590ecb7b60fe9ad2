"""Matrices of a linear system, and least squares whose unknowns are not negative."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray

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

    C. L. Lawson and R. J. Hanson, Solving Least Squares Problems (1974), chapter 23. Importing what
    scipy has of it takes longer than a search. Raises NumericalFailure where it does not end.
    """
    count, size = table.shape[1], np.abs(table).sum(axis=0)
    least = 10.0 * max(table.shape) * EPSILON * float(np.max(size, initial=0.0))
    weights, (used, tried) = np.zeros(count), np.zeros((2, count), dtype=bool)
    for _ in range(_ROUNDS * count + 1):
        found = np.zeros(count)
        found[used] = np.linalg.lstsq(table[:, used], right, rcond=None)[0]
        below = used & (found <= 0.0)
        if np.any(below):
            # as far towards it as none falls below zero; what is zero there is out
            share = np.divide(weights, weights - found, out=np.full(count, 2.0), where=below)
            weights += np.min(share) * (found - weights)
            used &= (share > np.min(share)) & (weights > 0.0)
            weights[~used] = 0.0
            continue
        # what rounding throws out as soon as it is in is not tried again before others are
        tried &= not np.any(found != weights)
        weights = found
        pull = np.where(used | tried, -np.inf, table.T @ (right - table @ weights))
        if not np.any(pull > least):
            return weights
        used[np.argmax(pull)] = tried[np.argmax(pull)] = True
    raise NumericalFailure(
        "least squares with weights that are not negative finds no end: "
        f"{table.shape[1]} conditions on {table.shape[0] - 1} variables are nearly dependent"
    )
