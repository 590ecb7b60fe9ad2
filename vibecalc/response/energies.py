"""Kinetic and potential energy of harmonic motion: of each order, and over a cycle."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, quadratic
from vibecalc.numerics.cycle_peak import numbered, vector_cycle_peak
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Harmonic motion as a signal whose squared length is twice an energy, with what it leaves out.
# ----------------------------------------------------------------------------


def energy_signal(
    weight: Bounded,
    state: Bounded,
    retained: int | None = None,
    tail: ArrayLike = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vector signals y(a) = Re sum y_n exp(i n a) of which y.y / 2 is the energy of `weight`.

    Of velocities or displacements (..., orders, 6); `weight` (..., 6, 6), `retained` and `tail`
    (...) as for `peak_over_cycle`. Returns y_n (..., 6, retained), a bound (...) of the error of
    the length of y(a) at any angle, with what dropped orders may add, and the error (...) of the
    energy, in J, that comes from the weight itself. Raises NumericalFailure if the weight is not
    positive semidefinite.
    """
    half = square_root(weight)
    signal = state @ half.value.mT
    kept, guards = signal[..., :retained, :], signal[..., retained:, :]
    left_out = tail * np.sum(np.hypot.reduce(np.abs(guards.value), axis=-1), axis=-1)
    noise = np.linalg.norm(np.sum(kept.error, axis=-2), axis=-1)
    total = np.sum(np.abs(state.value[..., :retained, :]), axis=-2)[..., None, :]
    form = 0.5 * np.sum(total @ half.error * total, axis=(-2, -1))
    return kept.value.mT, noise + left_out, form


def half_square(length: Bounded, off: np.ndarray | float) -> Bounded:
    """Energy in J of the length of a signal that may be `off` by more than its error."""
    error = length.error + off
    return Bounded(0.5 * np.square(length.value), error * (length.value + 0.5 * error))


def square_root(weight: Bounded) -> Bounded:
    """F (..., 6, 6) with F^T F = A for symmetric semidefinite A, and the error of that product.

    The coordinates are scaled to a unit diagonal first, so that metres and radians may differ by
    any factor.

    Raises
    ------
    NumericalFailure
        A has a negative eigenvalue that rounding cannot account for: energy without a lower bound.
    """
    matrix = weight.value
    diagonal = np.linalg.diagonal(matrix)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    pair = scale[..., :, None] * scale[..., None, :]
    values, vectors = np.linalg.eigh(matrix / pair)
    allowed = np.max(np.sum(weight.error / pair, axis=-1), axis=-1)
    least = values[..., 0] + allowed + 64.0 * UNIT_ROUNDOFF * values[..., -1]
    if np.any(least < 0.0):
        raise NumericalFailure(
            "the energy of the machine has no lower bound: its mass or stiffness matrix has the "
            f"negative eigenvalue {np.min(values):.3g}, the diagonal being scaled to 1; check its "
            "entries, or give the mounts stiffness in that direction"
        )
    roots = np.sqrt(np.maximum(values, 0.0))
    half = roots[..., :, None] * vectors.mT * scale[..., None, :]
    size = np.abs(half)
    apart = np.abs(half.mT @ half - matrix) + 8.0 * UNIT_ROUNDOFF * (size.mT @ size)
    return Bounded(half, weight.error + apart)


# ----------------------------------------------------------------------------
# Kinetic and potential energy of harmonic motion: of each order, and of all of them together.
#
# An energy is q(t) A q(t) / 2 with a symmetric weight A: the mass matrix and velocities, or the
# stiffness matrix and displacements. Of one order, q(t) = Re(Q exp(i n a)),
#
#     energy(a) = (Q* A Q + Re(Q A Q exp(2 i n a))) / 4,
#
# so that its mean over the cycle is Q* A Q / 4 and its peak is higher by |Q A Q| / 4: by nothing if
# the state turns on a circle, by as much again if all coordinates are in phase. Orders are
# orthogonal over the cycle, so their means add. Their peaks do not: that of the sum is sought over
# the cycle.
# ----------------------------------------------------------------------------

#: more than underflow takes from a sum of products
_LOST = 64.0 * float(np.finfo(np.float64).smallest_subnormal)


class Energy(NamedTuple):
    """Mean over the cycle and largest value within it, in J."""

    mean: Bounded
    peak: Bounded


def velocity(motion: Bounded, frequency: np.ndarray) -> Bounded:
    """Complex velocities i w X (..., orders, 6) of amplitudes X at frequencies (..., orders)."""
    return 1j * np.asarray(frequency)[..., None] * motion


def mass_of(matrices: Linear) -> Bounded:
    """Weight of the kinetic energy."""
    return Bounded(matrices.mass, matrices.mass_error)


def stiffness_of(matrices: Linear) -> Bounded:
    """Weight of the potential energy: what springs store, no part of a loss factor."""
    return Bounded(matrices.stiffness, matrices.stiffness_error)


def energy_by_order(weight: Bounded, state: Bounded) -> Energy:
    """Energy of each order by itself, of velocities or displacements (..., orders, 6).

    `weight` (..., 6, 6) is symmetric. A mean that rounding leaves below zero is zero.
    """
    form = 0.25 * quadratic(state, weight)
    turning = 0.25 * np.abs(np.sum(state.value * (state.value @ weight.value), axis=-1))
    mean = np.where((form.value < 0.0) & (form.value >= -form.error), 0.0, form.value)
    lost = np.where(np.any(state.value != 0.0, axis=-1), _LOST, 0.0)
    return Energy(
        Bounded(mean, form.error + lost), Bounded(mean + turning, 2.0 * form.error + lost)
    )


def dropped_mean(weight: Bounded, guards: Bounded, tail: ArrayLike) -> np.ndarray:
    """Most that dropped orders may add to a mean energy (...), in J, from guards (..., orders, 6).

    Together their states are at most `tail` times the sum of the magnitudes of the guards. The
    mean of a sum of orders is the sum of squares, which the square of that sum bounds.
    """
    each = energy_by_order(weight, guards).mean
    return np.asarray(np.square(tail * np.sum(np.sqrt(each.value + each.error), axis=-1)))


def mean_over_cycle(
    weight: Bounded, state: Bounded, retained: int | None = None, tail: ArrayLike = 0.0
) -> Bounded:
    """Mean over the cycle (...) of the energy of all orders, in J; as for `peak_over_cycle`.

    Means add, so that no peak is sought.
    """
    total = energy_by_order(weight, state[..., :retained, :]).mean.sum()
    return total + Bounded(np.zeros(()), dropped_mean(weight, state[..., retained:, :], tail))


def peak_over_cycle(
    weight: Bounded,
    state: Bounded,
    orders: np.ndarray,
    retained: int | None = None,
    tail: ArrayLike = 0.0,
) -> Bounded:
    """True peak over the cycle (...) of the energy of all orders together, in J.

    Parameters
    ----------
    weight : (..., 6, 6) symmetric, positive semidefinite.
    state : (..., orders, 6) velocities or displacements, 0-to-peak.
    orders : (orders,) integers from 1 on, each once; halves where a cycle is two turns.
    retained : how many of them, from the first on, count; all by default. The others are guard
        orders.
    tail : of every quantity that is linear in the motion, all dropped orders together add at most
        `tail` times the sum of the magnitudes of the guard orders; this enters the errors.

    Raises
    ------
    NumericalFailure
        The weight is not positive semidefinite, or an amplitude is not finite.
    """
    harmonics, spread, form = energy_signal(weight, state, retained, tail)
    peak = vector_cycle_peak(harmonics, numbered(orders[:retained]))
    energy = half_square(Bounded(peak.value, peak.error), spread)
    return Bounded(energy.value, energy.error + form)
