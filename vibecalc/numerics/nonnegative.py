"""Least squares with weights that are not negative, for the multipliers of a constrained search."""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray

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
