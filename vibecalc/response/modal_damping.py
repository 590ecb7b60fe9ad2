"""Damping that is given mode by mode, as a matrix."""

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.matrices import Matrices
from vibecalc.response.modes import Modes


def modal_damping(matrices: Matrices, shapes: Modes, ratio: np.ndarray) -> WithError:
    """Damping matrix C (6, 6) that gives each mode its ratio zeta (6,), and its absolute error.

    C = M V diag(2 zeta w) V^T M with unit modal mass, in N s/m, N s, N m s; it couples no modes.
    A mode without stiffness stays without damping. Of repeated modes the shapes are a choice (see
    `Modes`): the matrix depends on it unless their ratios agree. The ratios count as exact.

    Source: W. T. Thomson, Theory of Vibration with Applications, 5th ed., chapter 6.
    """
    zeta = np.asarray(ratio, dtype=float)
    frequency = shapes.natural_frequency
    size_of_mass, size = np.abs(matrices.mass), np.abs(shapes.shape)
    momentum = matrices.mass @ shapes.shape
    momentum_error = (
        size_of_mass @ (shapes.shape_error + 6.0 * UNIT_ROUNDOFF * size)
        + matrices.mass_error @ size
    )
    rate = 2.0 * zeta * frequency
    rate_error = 2.0 * np.abs(zeta) * shapes.natural_frequency_error
    value = (momentum * rate) @ momentum.T
    large = np.abs(momentum)
    rounding = 10.0 * UNIT_ROUNDOFF * np.abs(rate) + rate_error
    one_side = (momentum_error * np.abs(rate)) @ (large + 0.5 * momentum_error).T
    error = (large * rounding) @ large.T + one_side + one_side.T
    return WithError(0.5 * (value + value.T), error)
