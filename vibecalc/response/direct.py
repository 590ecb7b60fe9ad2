"""Forced response of a rigid body on mounts, for batches of frequencies at once."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.matrices import Matrices

_CLOSE = 1e-3


class Dynamics(NamedTuple):
    """Dynamic stiffness K + iH + iwC - w^2 M (..., 6, 6), its inverse and its absolute error."""

    stiffness: np.ndarray
    error: np.ndarray
    inverse: np.ndarray


class Undriven(NamedTuple):
    """Modes to leave out: `pairs` (orders, modes), with `shape` (6, modes) and `eigenvalue`."""

    pairs: np.ndarray
    shape: np.ndarray
    eigenvalue: np.ndarray


def dynamics(
    matrices: Matrices, frequency: np.ndarray, undriven: Undriven | None = None
) -> Dynamics:
    """Dynamic stiffness at excitation frequencies (..., orders), rad/s.

    A mode in `undriven` is moved away from the frequency by a stiffness along itself, which
    changes nothing for a force that does not drive it, and keeps its noise from being magnified.
    Raises NumericalFailure where a matrix has no inverse at all.
    """
    rate = np.asarray(frequency)[..., None, None]
    squared = np.square(rate)
    lagging = matrices.structural + rate * matrices.damping
    stiffness = (matrices.stiffness - squared * matrices.mass) + 1j * lagging
    error = (
        matrices.stiffness_error
        + matrices.structural_error
        + rate * matrices.damping_error
        + squared * (matrices.mass_error + 4.0 * UNIT_ROUNDOFF * np.abs(matrices.mass))
        + 2.0 * UNIT_ROUNDOFF * (np.abs(matrices.stiffness) + np.abs(lagging))
    )
    if undriven is not None and np.any(undriven.pairs):
        stiffness = stiffness + _moved(matrices, np.asarray(frequency), undriven)
    scale = 1.0 / np.sqrt(np.diagonal(matrices.mass))
    weight = np.outer(scale, scale)
    try:
        inverse = np.linalg.inv(stiffness * weight) * weight
    except np.linalg.LinAlgError:
        raise NumericalFailure(
            f"a dynamic stiffness matrix between {np.min(frequency):.9g} and "
            f"{np.max(frequency):.9g} rad/s is exactly singular: an order is on an undamped "
            f"natural frequency; give the mounts damping or a loss factor, or move the speed"
        ) from None
    return Dynamics(stiffness, error, inverse)


def _moved(matrices: Matrices, frequency: np.ndarray, undriven: Undriven) -> np.ndarray:
    squared = np.square(frequency)[..., None]
    close = np.abs(squared - undriven.eigenvalue) < _CLOSE * undriven.eigenvalue
    shift = np.where(close & undriven.pairs, squared + undriven.eigenvalue, 0.0)
    momentum = matrices.mass @ undriven.shape
    moved: np.ndarray = (momentum * shift[..., None, :]) @ momentum.T
    return moved


def response(system: Dynamics, force: np.ndarray, force_error: np.ndarray) -> WithError:
    """Complex amplitudes X (..., 6) of D X = F in m and rad, with componentwise errors.

    One step of iterative refinement makes the backward error small in every entry; the bound
    |inv D| (dD |X| + dF) then holds for the forward error (N. J. Higham, Accuracy and Stability
    of Numerical Algorithms, 2nd ed., section 7.2 and chapter 12). F is (..., 6), dF absolute.
    """
    column = force[..., None]
    value = system.inverse @ column
    value = value + system.inverse @ (column - system.stiffness @ value)
    size = np.abs(value)
    doubt = (system.error + 10.0 * UNIT_ROUNDOFF * np.abs(system.stiffness)) @ size
    error = np.abs(system.inverse) @ (doubt + force_error[..., None])
    return WithError(value[..., 0], (error + 4.0 * UNIT_ROUNDOFF * size)[..., 0])
