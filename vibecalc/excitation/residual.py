"""One number for what a crank train leaves unbalanced."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibecalc.excitation.sums import Excitation, Real
from vibecalc.numerics.rounding import EPSILON


class Residual(NamedTuple):
    """Weighted size (...) of forces and couples in N, and its absolute error."""

    value: Real
    error: Real


def _norm(parts: NDArray[np.float64]) -> Real:
    """Euclidean norm over the last three axes, free of overflow."""
    largest = parts.max(axis=(-3, -2, -1), keepdims=True, initial=0.0)
    scale = np.where(largest > 0.0, largest, 1.0)
    root = np.sqrt(((parts / scale) ** 2).sum(axis=(-3, -2, -1)))
    return np.asarray(scale[..., 0, 0, 0] * root)


def residual(
    excitation: Excitation,
    *,
    force_weight: ArrayLike = 1.0,
    couple_weight: ArrayLike = 1.0,
    reference_length: ArrayLike,
) -> Residual:
    """sqrt(sum over orders of wf^2 |F_n|^2 + wc^2 |M_n|^2 / l^2), in N, at the speed of the input.

    All orders of the excitation count, each vector with its three complex components. The value is
    a norm: it is smooth in angles and masses except where it is zero, as a cone is smooth except
    at its tip. A search that ends in full balance had better work with its square, which is smooth
    everywhere. The error is the same norm of the errors (triangle inequality) plus rounding.
    """
    wf = np.asarray(force_weight, dtype=float)[..., None, None]
    wc = (np.asarray(couple_weight, dtype=float) / np.asarray(reference_length, dtype=float))[
        ..., None, None
    ]
    shape = excitation.force.shape

    def stack(force: Real, couple: Real) -> Real:
        parts = (np.broadcast_to(wf * force, shape), np.broadcast_to(wc * couple, shape))
        return np.stack(parts, axis=-3)

    value = _norm(stack(np.abs(excitation.force), np.abs(excitation.couple)))
    error = _norm(stack(excitation.force_error, excitation.couple_error))
    return Residual(value, error + 3.0 * EPSILON * value)
