"""Range of the energy of each operation and balance, over all phases of the balance weight."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.response.combination import Superposed
from vibecalc.response.energies import energy_by_order
from vibecalc.response.energy_signal import energy_signal
from vibecalc.response.phase_search import Rows, search_phases


class PhaseRange(NamedTuple):
    """Lowest and highest energy (operations, balances) over all phases of the balance weight.

    Energies in J with absolute errors. Phases in [0, 2 pi) rad, counted from the nominal one in
    the sense of rotation; at these phases the energy is what is said, to within its error.
    """

    low: np.ndarray
    high: np.ndarray
    low_phase: np.ndarray
    high_phase: np.ndarray
    low_error: np.ndarray
    high_error: np.ndarray


def states(parts: Superposed, rate: np.ndarray) -> Superposed:
    """Motions of the parts times `rate` (orders,): i n w makes velocities of them."""
    factor = np.asarray(rate)[:, None]
    return parts._replace(
        shaking=_times(parts.shaking, factor),
        residual=_times(parts.residual, factor[parts.first]),
    )


def mean_energy_range(
    weight: WithError, state: Superposed, left_out: np.ndarray | float = 0.0
) -> PhaseRange:
    """Range of the mean over the cycle, in closed form: a + b cos(p - p0).

    With states S and R of order 1, the mean at phase p is (S* A S + R* A R) / 4 plus
    Re(exp(i p) S* A R) / 2 plus what the other orders have, which no phase changes. The phases of
    lowest and highest mean are half a turn apart.

    Parameters
    ----------
    weight : (6, 6), mass matrix for velocities or stiffness matrix for displacements in `state`.
    state : the orders that count, guard orders taken off.
    left_out : (operations,) in J, what dropped orders may add (`energies.dropped_mean`); it enters
        the errors.
    """
    shaking, residual = state.shaking, state.residual
    by_order, own = energy_by_order(weight, shaking), energy_by_order(weight, residual)
    still = np.sum(by_order.mean, axis=-1)[..., None] + own.mean
    doubt = np.sum(by_order.mean_error, axis=-1)[..., None] + own.mean_error

    start = shaking.value[..., None, state.first, :]
    spread = shaking.error[..., None, state.first, :]
    cross = 0.5 * np.sum(start.conj() * (residual.value @ weight.value), axis=-1)
    size, matrix = np.abs(residual.value), np.abs(weight.value)
    loose = weight.error + 16.0 * UNIT_ROUNDOFF * matrix
    terms = np.abs(start) * (size @ loose) + spread * (size @ matrix)
    terms = terms + (np.abs(start) + spread) * (residual.error @ matrix)
    swing = np.abs(cross)
    rounding = (by_order.mean.shape[-1] + 4) * UNIT_ROUNDOFF * (still + swing)
    error = doubt + 0.5 * np.sum(terms, axis=-1) + rounding
    error = error + np.broadcast_to(left_out, still.shape[:-1])[..., None]
    high_phase = np.where(swing > 0.0, np.mod(-np.angle(cross), 2.0 * np.pi), 0.0)
    return PhaseRange(
        np.maximum(still - swing, 0.0),
        still + swing,
        np.mod(high_phase + np.pi, 2.0 * np.pi),
        high_phase,
        error,
        error,
    )


def peak_energy_range(
    weight: WithError,
    state: Superposed,
    orders: np.ndarray,
    kept: int | None = None,
    tail: float = 0.0,
    rtol: float = 1e-9,
) -> PhaseRange:
    """Range of the peak over the cycle, searched safely: no phase is left out.

    Parameters
    ----------
    weight, state : as for `mean_energy_range`, the weight positive semidefinite.
    orders, kept, tail : as for `energies.energy_over_cycle`, order 1 among those kept.
    rtol : the search ends when what it may have missed is below this share of the value; what
        is left is in the errors.

    Raises
    ------
    NumericalFailure
        The weight is not positive semidefinite, or an amplitude is not finite.
    """
    orders = np.asarray(orders)
    shaking = energy_signal(weight, state.shaking, kept, tail)
    one = WithError(*(part[..., None, :] for part in state.residual))
    residual = energy_signal(weight, one)
    used = shaking.used.copy()
    used[state.first] = True
    turned = residual.harmonics[..., 0]
    fixed = shaking.harmonics[..., None, :, used]
    fixed = np.broadcast_to(fixed, (*turned.shape, fixed.shape[-1]))
    rows = Rows(
        fixed.reshape(-1, *fixed.shape[-2:]),
        orders[: len(used)][used],
        turned.reshape(-1, turned.shape[-1]),
    )
    found = search_phases(rows, rtol)
    low, high, low_phase, high_phase, low_gap, high_gap, rounding = (
        part.reshape(turned.shape[:-1]) for part in found[:7]
    )
    spread = shaking.spread[..., None] + residual.spread
    weighing = 2.0 * (shaking.form_error[..., None] + residual.form_error) + rounding

    def doubt(energy: np.ndarray) -> np.ndarray:
        total: np.ndarray = spread * (np.sqrt(2.0 * energy) + 0.5 * spread) + weighing
        return total

    return PhaseRange(
        low, high, low_phase, high_phase, low_gap + doubt(low), high_gap + doubt(high)
    )


def _times(motion: WithError, factor: np.ndarray) -> WithError:
    value = motion.value * factor
    return WithError(value, np.abs(factor) * motion.error + 3.0 * UNIT_ROUNDOFF * np.abs(value))
