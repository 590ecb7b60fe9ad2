"""Forced response of a rigid body on mounts: direct, as a sum of modes, and how well known."""

import functools
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import SINGULAR, UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Forced response as a sum of modes.
# ----------------------------------------------------------------------------

_ROUNDING = 16.0 * UNIT_ROUNDOFF


class _Parts(NamedTuple):
    """Stiffness, structural, damping and mass matrices, in this order, or what stands for them."""

    stiffness: np.ndarray
    structural: np.ndarray
    damping: np.ndarray
    mass: np.ndarray


def modal_response(
    matrices: Linear,
    shape: np.ndarray,
    frequency: np.ndarray,
    force: np.ndarray,
    force_error: np.ndarray,
) -> Bounded:
    """Complex amplitudes X (..., orders, 6) of D X = F as X = V q, in m and rad, with errors.

    With unit modal mass and modal force f = V^T F,

        q_j = f_j / (w_j^2 - W^2 + i W c_j + i h_j)

    where damping and structural matrices leave the modes apart; then c_j is 2 zeta_j w_j and h_j
    is eta_j w_j^2. Where they couple modes, the coupled modal equations are solved. Modes without
    stiffness and repeated modes are modes like any other. Errors are componentwise bounds to first
    order: one step of refinement leaves rounding, and the uncertainty of matrices and force.

    Parameters
    ----------
    shape : (..., 6, 6) modes in columns, with the leading axes of the matrices; their signs and
        scales do not matter.
    frequency : (..., orders) excitation frequencies W in rad/s.
    force, force_error : (..., orders, 6) complex in N and N m, and absolute.

    Raises
    ------
    NumericalFailure
        Fewer than four digits of the response to an order would be certain: it drives a mode at
        its undamped natural frequency. An undamped mode that it does not drive there (the modal
        force is zero to rounding) is left out of that order.

    Source: W. T. Thomson, Theory of Vibration with Applications, 5th ed., chapter 6.
    """
    rate = np.asarray(frequency, dtype=float)[..., None]
    values = _Parts(matrices.stiffness, matrices.structural, matrices.damping, matrices.mass)
    errors = _Parts(
        matrices.stiffness_error,
        matrices.structural_error,
        matrices.damping_error,
        matrices.mass_error,
    )
    uncertainties = _Parts(
        *(e + _ROUNDING * np.abs(v) for v, e in zip(values, errors, strict=True))
    )
    square = np.sum(shape * (matrices.mass @ shape), axis=-2, keepdims=True)
    vector = shape / np.sqrt(square)
    size = np.abs(vector)
    modal_uncertainty = _Parts(*(size.mT @ uncertainty @ size for uncertainty in uncertainties))
    modal = _Parts(*(vector.mT @ value @ vector for value in values))
    apart = _apart(modal, modal_uncertainty)

    own = _diagonals(modal)
    diagonal = _at(own, rate)
    diagonal_uncertainty = _uncertainty_at(_diagonals(modal_uncertainty), rate)
    drive = force @ vector
    free = np.all(apart, axis=-1)[..., None, :]
    lost = free & (SINGULAR * np.abs(diagonal) <= diagonal_uncertainty)
    idle = lost & (np.abs(drive) <= 4.0 * (force_error + _ROUNDING * np.abs(force)) @ size)
    _refuse(np.any(lost & ~idle, axis=-1), rate)
    moved = np.where(idle, np.square(rate) + own.stiffness, 0.0)
    # one inverse serves all loads unless a mode is left out for some of them
    solve = _solver(modal, diagonal + moved if np.any(idle) else diagonal, apart, rate)

    motion = solve(drive) @ vector.mT
    momentum = matrices.mass @ vector
    held = _at(_Parts(*(motion @ value for value in values)), rate)
    held = held + ((motion @ momentum) * moved) @ momentum.mT
    motion = motion + solve((force - held) @ vector) @ vector.mT

    moving = np.abs(motion)
    uncertainty = _uncertainty_at(_Parts(*(moving @ part for part in uncertainties)), rate)
    bound = solve.magnitudes()
    data = bound(uncertainty @ size) @ size.mT
    _refuse(_uncertain(matrices, force, force_error, data, moving), rate)
    given = bound((force_error + 2.0 * UNIT_ROUNDOFF * np.abs(force)) @ size) @ size.mT
    return Bounded(motion, data + given + 4.0 * UNIT_ROUNDOFF * moving)


def _apart(modal: _Parts, uncertainty: _Parts) -> np.ndarray:
    """Pairs of modes (..., 6, 6) that no matrix couples beyond its error; the diagonal included."""
    each = zip(modal, uncertainty, strict=True)
    coupled = functools.reduce(np.logical_or, (np.abs(value) > error for value, error in each))
    return np.asarray(np.eye(6, dtype=bool) | ~coupled)


def _diagonals(parts: _Parts) -> _Parts:
    """Diagonals (..., 1, 6) for all orders."""
    return _Parts(*(np.linalg.diagonal(part)[..., None, :] for part in parts))


def _at(parts: _Parts, rate: np.ndarray) -> np.ndarray:
    """K + iH + iWC - W^2 M of whatever stands for the four."""
    k, h, c, m = parts
    total: np.ndarray = (k - np.square(rate) * m) + 1j * (h + rate * c)
    return total


def _uncertainty_at(parts: _Parts, rate: np.ndarray) -> np.ndarray:
    k, h, c, m = parts
    total: np.ndarray = k + h + rate * c + np.square(rate) * m
    return total


class _Solver(NamedTuple):
    """Inverse of the modal equations: (..., orders, 6) of the modes by themselves, and blocks.

    A block (..., orders, n, n) has the numbers (n,) of modes that are coupled among each other,
    whose entries by themselves are zero.
    """

    alone: np.ndarray
    blocks: tuple[tuple[np.ndarray, np.ndarray], ...]

    def __call__(self, drive: np.ndarray) -> np.ndarray:
        result: np.ndarray = self.alone * drive
        for number, inverse in self.blocks:
            result[..., number] = (inverse @ drive[..., number, None])[..., 0]
        return result

    def magnitudes(self) -> "_Solver":
        blocks = tuple((number, np.abs(inverse)) for number, inverse in self.blocks)
        return _Solver(np.abs(self.alone), blocks)


def _solver(modal: _Parts, diagonal: np.ndarray, apart: np.ndarray, rate: np.ndarray) -> _Solver:
    blocks = _coupled(apart)
    if not blocks:
        return _Solver(1.0 / diagonal, ())
    alone = np.ones(6, dtype=bool)
    alone[np.concatenate(blocks)] = False
    inverses = []
    for number in blocks:
        rows, columns = number[:, None], number
        links = (np.where(apart, 0.0, part)[..., None, rows, columns] for part in modal)
        shape = (*diagonal.shape[:-1], len(number), len(number))
        system = np.broadcast_to(_at(_Parts(*links), rate[..., None]), shape).copy()
        places = np.arange(len(number))
        system[..., places, places] = diagonal[..., number]
        try:
            inverses.append((number, np.linalg.inv(system)))
        except np.linalg.LinAlgError:
            _refuse(np.ones(rate.shape[:-1], dtype=bool), rate)
            raise
    by_itself = np.zeros_like(diagonal)
    np.divide(1.0, diagonal, out=by_itself, where=alone)
    return _Solver(by_itself, tuple(inverses))


def _coupled(apart: np.ndarray) -> list[np.ndarray]:
    """Numbers of modes that hang together, from pairs (..., 6, 6) that are apart or not."""
    reached = np.eye(6, dtype=bool) | np.any(~apart.reshape(-1, 6, 6), axis=0)
    for _ in range(3):  # ways over 2, 4 and 8 pairs
        reached = reached @ reached
    first = np.argmax(reached, axis=1)
    groups = [np.flatnonzero(first == number) for number in range(6)]
    return [group for group in groups if len(group) > 1]


def _uncertain(
    matrices: Linear,
    force: np.ndarray,
    force_error: np.ndarray,
    uncertainty: np.ndarray,
    moving: np.ndarray,
) -> np.ndarray:
    """Orders (..., orders) that drive the body, of whose response four digits are not certain."""
    weight = np.sqrt(np.linalg.diagonal(matrices.mass))[..., None, :]
    driven = np.any(np.abs(force) > 4.0 * force_error, axis=-1)
    certain = np.max(weight * uncertainty, axis=-1) < SINGULAR * np.max(weight * moving, axis=-1)
    return np.asarray(driven & ~certain)


def _refuse(which: np.ndarray, rate: np.ndarray) -> None:
    if np.any(which):
        met = np.broadcast_to(rate[..., 0], which.shape)[which].flat[0]
        raise NumericalFailure(
            f"an excitation at {met:.9g} rad/s drives a mode without damping at its natural "
            "frequency: of the response fewer than four digits would be certain. Give the mounts "
            "damping or a loss factor, or move the speed or the stiffness"
        )
