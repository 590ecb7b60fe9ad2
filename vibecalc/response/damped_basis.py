"""Repeated modes as the damping sees them: each with a damping of its own."""

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.matrices import Matrices
from vibecalc.response.modes import CLUSTER, Modes, largest_positive

#: a smaller coupling, relative to the largest loss, is round-off
_COUPLED = 1e-13


def damped_basis(matrices: Matrices, shapes: Modes) -> Modes:
    """The same modes, with repeated ones turned until the damping does not couple them.

    Modes of one frequency may be combined at will. Where some combination has no damping, an order
    on that frequency has no bound, though each mode of another basis seems damped. The loss that
    counts is H + w C at their own frequency w. A basis that it does not couple stays as it is.
    """
    values, error = shapes.eigenvalue, shapes.eigenvalue_error
    apart = np.diff(values) > CLUSTER * (error[1:] + error[:-1])
    cluster = np.concatenate([[0], np.cumsum(apart)])
    if cluster[-1] == len(values) - 1:
        return shapes
    turned, doubt = shapes.shape.copy(), shapes.shape_error.copy()
    for number in range(cluster[-1] + 1):
        members = np.flatnonzero(cluster == number)
        if len(members) == 1:
            continue
        basis = shapes.shape[:, members]
        frequency = float(np.mean(shapes.natural_frequency[members]))
        loss = basis.T @ (matrices.structural + frequency * matrices.damping) @ basis
        coupling = np.max(np.abs(loss - np.diag(np.diagonal(loss))))
        if not coupling > _COUPLED * np.max(np.diagonal(loss)):
            continue
        _, turn = np.linalg.eigh(0.5 * (loss + loss.T))
        turned[:, members] = basis @ turn
        spread = shapes.shape_error[:, members] + 8.0 * UNIT_ROUNDOFF * np.abs(basis)
        doubt[:, members] = spread @ np.abs(turn)
    return shapes._replace(
        shape=turned * largest_positive(matrices.mass, turned), shape_error=doubt
    )
