"""Kinetic and potential energy of harmonic motion: of each order, and over a cycle."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import Linear
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF

# ----------------------------------------------------------------------------
# Harmonic motion as a signal whose squared length is twice an energy, with what it leaves out.
# ----------------------------------------------------------------------------


class Signal(NamedTuple):
    """Vector signals y(a) = Re sum y_n exp(i n a); the energy is y.y / 2.

    `harmonics` (..., 6, retained). `used` (retained,): the others together are below rounding
    everywhere and are counted in `spread` (...), a bound of the error of the length of y(a) at any
    angle. `left_out` (...) is the part of it that the dropped orders may add. `form_error` (...) is
    the error of the energy, in J, that comes from the weight itself.
    """

    harmonics: np.ndarray
    used: np.ndarray
    spread: np.ndarray
    left_out: np.ndarray
    form_error: np.ndarray


def energy_signal(
    weight: Bounded,
    state: Bounded,
    retained: int | None = None,
    tail: ArrayLike = 0.0,
) -> Signal:
    """Velocities or displacements (..., orders, 6) as a signal for the energy of `weight`.

    `weight` (..., 6, 6), `retained` and `tail` (...) as for `energy_over_cycle`. Raises
    NumericalFailure if the weight is not positive semidefinite.
    """
    half = square_root(weight)
    value = state.value @ half.value.mT
    size = np.abs(half.value)
    reach = np.hypot.reduce(np.abs(value), axis=-1)
    used = _noticeable(reach[..., :retained])
    left_out = tail * np.sum(reach[..., len(used) :], axis=-1)
    unused = np.sum(reach[..., :retained][..., ~used], axis=-1)

    total = np.sum(np.abs(state.value[..., :retained, :]), axis=-2)
    uncertainty = np.sum(state.error[..., :retained, :], axis=-2) + 8.0 * UNIT_ROUNDOFF * total
    noise = np.sqrt(np.sum(np.square(_rows_times(uncertainty, size.mT)), axis=-1))
    form = 0.5 * np.sum(total * _rows_times(total, half.error), axis=-1)
    harmonics = np.swapaxes(value[..., :retained, :], -1, -2)
    return Signal(harmonics, used, noise + left_out + unused, left_out, form)


def _rows_times(rows: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Rows (..., n) times matrices (..., n, m)."""
    product: np.ndarray = (rows[..., None, :] @ matrix)[..., 0, :]
    return product


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


def smallest_exponent(size: np.ndarray) -> np.ndarray:
    """Powers of two next to magnitudes, within the range in which their inverses exist."""
    exponent: np.ndarray = np.clip(np.frexp(size)[1], -1000, 1000)
    return exponent


def _noticeable(reach: np.ndarray) -> np.ndarray:
    """Orders (n,), at least one, that count: the others of (..., n) add less than rounding."""
    total = np.sum(reach, axis=-1, keepdims=True)
    share = reach / np.where(total > 0.0, total, 1.0)
    largest = np.max(share.reshape(-1, reach.shape[-1]), axis=0, initial=0.0)
    ascending = np.argsort(largest, kind="stable")
    used = np.ones(len(largest), dtype=bool)
    used[ascending] = np.cumsum(largest[ascending]) > 0.5 * UNIT_ROUNDOFF
    used[ascending[-1:]] = True
    return used


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

_LOST = 8.0 * float(np.finfo(np.float64).smallest_subnormal)


class OrderEnergy(NamedTuple):
    """Energy of each order by itself, all (..., orders) in J, errors absolute.

    `mean` over the cycle, `peak` the largest value within it.
    """

    mean: np.ndarray
    peak: np.ndarray
    mean_error: np.ndarray
    peak_error: np.ndarray


class CycleEnergy(NamedTuple):
    """Energy of all orders together, all (...) in J, errors absolute, `angle` of the peak in rad.

    The errors count what the orders that were not retained may add. `angle` is the first crank
    angle in [0, 2 pi) that reaches `peak` to rounding.
    """

    mean: np.ndarray
    peak: np.ndarray
    angle: np.ndarray
    mean_error: np.ndarray
    peak_error: np.ndarray


def velocity(motion: Bounded, frequency: np.ndarray) -> Bounded:
    """Complex velocities i w X (..., orders, 6) of amplitudes X at frequencies (..., orders)."""
    return 1j * np.asarray(frequency)[..., None] * motion


def mass_of(matrices: Linear) -> Bounded:
    """Weight of the kinetic energy."""
    return Bounded(matrices.mass, matrices.mass_error)


def stiffness_of(matrices: Linear) -> Bounded:
    """Weight of the potential energy: what springs store, no part of a loss factor."""
    return Bounded(matrices.stiffness, matrices.stiffness_error)


def energy_by_order(weight: Bounded, state: Bounded) -> OrderEnergy:
    """Mean and peak of the energy of each order, for velocities or displacements (..., orders, 6).

    `weight` (..., 6, 6) is symmetric. Amplitudes are scaled before they are squared: an energy
    below the range of doubles becomes 0, any other keeps its relative accuracy. A mean that
    rounding leaves below zero is zero.
    """
    size = np.maximum(np.abs(state.value), state.error).max(axis=-1, keepdims=True)
    scale = np.ldexp(1.0, smallest_exponent(size))
    value, error = state.value / scale, state.error / scale
    magnitude = np.abs(value)
    moved = value @ weight.value
    form = 0.25 * np.sum((value.conj() * moved).real, axis=-1)
    turning = 0.25 * np.abs(np.sum(value * moved, axis=-1))
    uncertainty = weight.error + 16.0 * UNIT_ROUNDOFF * np.abs(weight.value)
    spread = 2.0 * np.abs(moved) * error + error * (error @ np.abs(weight.value))
    spread = 0.25 * np.sum(spread + magnitude * (magnitude @ uncertainty), axis=-1)
    mean = np.where((form < 0.0) & (form >= -spread), 0.0, form)
    factor = scale[..., 0]
    lost = np.where(size[..., 0] > 0.0, _LOST, 0.0)

    def unscaled(energy: np.ndarray) -> np.ndarray:
        back: np.ndarray = energy * factor * factor
        return back

    return OrderEnergy(
        unscaled(mean),
        unscaled(mean + turning),
        unscaled(spread) + lost,
        unscaled(2.0 * spread) + lost,
    )


def dropped_mean(weight: Bounded, guards: Bounded, tail: ArrayLike) -> np.ndarray:
    """Most that dropped orders may add to a mean energy (...), in J, from guards (..., orders, 6).

    Together their states are at most `tail` times the sum of the magnitudes of the guards. The
    mean of a sum of orders is the sum of squares, which the square of that sum bounds.
    """
    each = energy_by_order(weight, guards)
    reach = np.sum(np.sqrt(each.mean + each.mean_error), axis=-1)
    most: np.ndarray = np.square(tail * reach)
    return most


def mean_over_cycle(
    weight: Bounded, state: Bounded, retained: int | None = None, tail: ArrayLike = 0.0
) -> Bounded:
    """Mean over the cycle (...) of the energy of all orders, in J; as for `energy_over_cycle`.

    Means add, so that no peak is sought.
    """
    each = energy_by_order(weight, Bounded(*(part[..., :retained, :] for part in state)))
    total, count = each.mean.sum(-1), each.mean.shape[-1]
    error = each.mean_error.sum(-1) + count * EPSILON * total
    if retained is not None:
        guards = Bounded(*(part[..., retained:, :] for part in state))
        error = error + dropped_mean(weight, guards, tail)
    return Bounded(total, error)


def energy_over_cycle(
    weight: Bounded,
    state: Bounded,
    orders: np.ndarray,
    retained: int | None = None,
    tail: ArrayLike = 0.0,
) -> CycleEnergy:
    """Mean and true peak over the cycle of the energy of all orders together.

    Parameters
    ----------
    weight : (..., 6, 6) symmetric, positive semidefinite.
    state : (..., orders, 6) velocities or displacements, 0-to-peak.
    orders : (orders,) integers from 1 on, each once.
    retained : how many of them, from the first on, count; all by default. The others are guard
    orders. tail : of every quantity that is linear in the motion, all dropped orders together add
    at most
        `tail` times the sum of the magnitudes of the guard orders; this enters the errors.

    Raises
    ------
    NumericalFailure
        The weight is not positive semidefinite, or an amplitude is not finite.
    """
    return energies_over_cycle([(weight, state)], orders, retained, tail)[0]


def energies_over_cycle(
    pairs: Sequence[tuple[Bounded, Bounded]],
    orders: np.ndarray,
    retained: int | None = None,
    tail: ArrayLike = 0.0,
) -> list[CycleEnergy]:
    """`energy_over_cycle` of pairs of a weight and states of one shape.

    Their peaks are sought in one go, which costs as one does.
    """
    if not pairs:
        return []
    signals = [energy_signal(*pair, retained, tail) for pair in pairs]
    used = signals[0].used
    for signal in signals[1:]:
        used = used | signal.used
    stacked = np.stack([signal.harmonics[..., used] for signal in signals])
    peak = vector_cycle_peak(stacked, np.asarray(orders)[:retained][used])
    energies = []
    for row, (signal, pair) in enumerate(zip(signals, pairs, strict=True)):
        length = peak.value[row]
        spread = peak.error[row] + signal.spread
        mean = mean_over_cycle(*pair, retained, tail)
        energies.append(
            CycleEnergy(
                mean.value,
                0.5 * length * length,
                peak.angle[row],
                mean.error,
                spread * (length + 0.5 * spread) + signal.form_error,
            )
        )
    return energies
