"""Harmonic motion as a signal whose squared length is twice an energy, with what it leaves out."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError


class Signal(NamedTuple):
    """Vector signals y(a) = Re sum y_n exp(i n a); the energy is y.y / 2.

    `harmonics` (..., 6, kept). `used` (kept,): the others together are below rounding everywhere
    and are counted in `spread` (...), a bound of the error of the length of y(a) at any angle.
    `left_out` (...) is the part of it that the dropped orders may add. `form_error` (...) is the
    error of the energy, in J, that comes from the weight itself.
    """

    harmonics: np.ndarray
    used: np.ndarray
    spread: np.ndarray
    left_out: np.ndarray
    form_error: np.ndarray


def energy_signal(
    weight: WithError,
    state: WithError,
    kept: int | None = None,
    tail: float = 0.0,
) -> Signal:
    """Velocities or displacements (..., orders, 6) as a signal for the energy of `weight` (6, 6).

    `kept` and `tail` as for `energies.energy_over_cycle`. Raises NumericalFailure if the weight is
    not positive semidefinite.
    """
    half = square_root(weight)
    value = state.value @ half.value.T
    size = np.abs(half.value)
    reach = np.hypot.reduce(np.abs(value), axis=-1)
    used = _noticeable(reach[..., :kept])
    left_out = tail * np.sum(reach[..., len(used) :], axis=-1)
    unused = np.sum(reach[..., :kept][..., ~used], axis=-1)

    total = np.sum(np.abs(state.value[..., :kept, :]), axis=-2)
    doubt = np.sum(state.error[..., :kept, :], axis=-2) + 8.0 * UNIT_ROUNDOFF * total
    noise = np.sqrt(np.sum(np.square(doubt @ size.T), axis=-1))
    form = 0.5 * np.sum(total * (total @ half.error), axis=-1)
    harmonics = np.swapaxes(value[..., :kept, :], -1, -2)
    return Signal(harmonics, used, noise + left_out + unused, left_out, form)


def square_root(weight: WithError) -> WithError:
    """F (6, 6) with F^T F = A for a symmetric semidefinite A, and the error (6, 6) of that product.

    The coordinates are scaled to a unit diagonal first, so that metres and radians may differ by
    any factor.

    Raises
    ------
    NumericalFailure
        A has a negative eigenvalue that rounding cannot account for: energy without a lower bound.
    """
    matrix = weight.value
    diagonal = np.diagonal(matrix)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    pair = np.outer(scale, scale)
    values, vectors = np.linalg.eigh(matrix / pair)
    allowed = np.max(np.sum(weight.error / pair, axis=1)) + 64.0 * UNIT_ROUNDOFF * values[-1]
    if values[0] < -allowed:
        raise NumericalFailure(
            "the energy of the machine has no lower bound: its mass or stiffness matrix has the "
            f"negative eigenvalue {values[0]:.3g}, the diagonal being scaled to 1; check its "
            "entries, or give the mounts stiffness in that direction"
        )
    half = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T * scale
    size = np.abs(half)
    apart = np.abs(half.T @ half - matrix) + 8.0 * UNIT_ROUNDOFF * (size.T @ size)
    return WithError(half, weight.error + apart)


def smallest_exponent(size: np.ndarray) -> np.ndarray:
    """Powers of two next to magnitudes, within the range in which their inverses exist."""
    exponent: np.ndarray = np.clip(np.frexp(size)[1], -1000, 1000)
    return exponent


def _noticeable(reach: np.ndarray) -> np.ndarray:
    """Orders (n,), at least one, to look at: the others of (..., n) add less than rounding."""
    total = np.sum(reach, axis=-1, keepdims=True)
    share = reach / np.where(total > 0.0, total, 1.0)
    largest = np.max(share.reshape(-1, reach.shape[-1]), axis=0, initial=0.0)
    ascending = np.argsort(largest, kind="stable")
    used = np.ones(len(largest), dtype=bool)
    used[ascending] = np.cumsum(largest[ascending]) > 0.5 * UNIT_ROUNDOFF
    used[ascending[-1:]] = True
    return used
