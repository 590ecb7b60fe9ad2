"""Operations combined with balances, and their energies over all angles of a balance weight."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import Dynamics, Linear, UndrivenModes, dynamics, each_order, response
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.response.energies import energy_by_order, energy_signal

# ----------------------------------------------------------------------------
# Operating modes combined with balances: motions add as phasors, and only then become energies.
#
# Two forces of one frequency do not have energies that add: what counts is how one leads the other.
# So each pair of an operation and a balance is one motion, and turning the balance weight against
# the crank by an angle p turns the phasors of its residual force by exp(i p).
# ----------------------------------------------------------------------------


class SuperposedMotion(NamedTuple):
    """Motions of the parts, complex amplitudes in m and rad.

    `shaking` (..., operations, orders, 6) by the pistons; `residual` (..., operations, balances, 6)
    of order 1 by what turns and is not balanced, its weight at the nominal phase; `first` is the
    place of order 1 among the orders.
    """

    shaking: Bounded
    residual: Bounded
    first: int


def superpose(
    matrices: Linear,
    orders: np.ndarray,
    speed: ArrayLike,
    shaking: Bounded,
    residual: Bounded,
    undriven: UndrivenModes | None = None,
) -> SuperposedMotion:
    """Respond to the loads of all operations and balances at once.

    Parameters
    ----------
    matrices, speed : (..., 6, 6) each, and (...) in rad/s.
    orders : (orders,) with 1 among them.
    shaking : (..., operations, orders, 6) forces and couples on the body in N and N m, at speed.
    residual : (..., operations, balances, 6) rotating ones of order 1, about the same point.
    undriven : pairs (..., orders, modes) that no load drives, to leave out; as for `dynamics`.

    Raises
    ------
    NumericalFailure
        An order is exactly on an undamped natural frequency. Close to one, the errors grow;
        `singular.check_operating_point` and `trust.require_digits` say when that is too close.
    """
    first = int(np.flatnonzero(np.asarray(orders) == 1)[0])
    count, balances = len(orders), residual.value.shape[-2]
    frequency = np.asarray(orders) * np.asarray(speed)[..., None]
    if undriven is not None:
        pairs, shape, eigenvalue = undriven
        undriven = UndrivenModes(
            pairs[..., None, :, :], shape[..., None, :, :], eigenvalue[..., None, :]
        )
    system = dynamics(each_order(matrices), frequency[..., None, :], undriven)
    rows = np.concatenate([np.arange(count), np.full(balances, first)])
    repeated = Dynamics(*(part[..., rows, :, :] for part in system))
    leading = np.broadcast_shapes(shaking.value.shape[:-2], residual.value.shape[:-2])
    loads = [
        [np.broadcast_to(part, (*leading, *part.shape[-2:])) for part in load]
        for load in (shaking, residual)
    ]
    motion = response(
        repeated, *(np.concatenate(parts, axis=-2) for parts in zip(*loads, strict=True))
    )
    return SuperposedMotion(
        Bounded(motion.value[..., :count, :], motion.error[..., :count, :]),
        Bounded(motion.value[..., count:, :], motion.error[..., count:, :]),
        first,
    )


def at_phase(parts: SuperposedMotion, phase: np.ndarray | float = 0.0) -> Bounded:
    """Motion (..., operations, balances, orders, 6) with the weights turned by a phase in rad.

    `phase` broadcasts with (..., operations, balances).
    """
    angle = np.asarray(phase, dtype=float)[..., None]
    turned = parts.residual.value * (np.cos(angle) + 1j * np.sin(angle))
    shape = (*turned.shape[:-1], *parts.shaking.value.shape[-2:])
    value = np.broadcast_to(parts.shaking.value[..., None, :, :], shape).copy()
    error = np.broadcast_to(parts.shaking.error[..., None, :, :], shape).copy()
    value[..., parts.first, :] += turned
    rounding = 3.0 * EPSILON * np.abs(turned) + UNIT_ROUNDOFF * np.abs(value[..., parts.first, :])
    error[..., parts.first, :] += parts.residual.error + rounding
    return Bounded(value, error)


# ----------------------------------------------------------------------------
# Lowest and highest peak energy over all phases of a balance weight, by branch and bound.
#
# The peak over the cycle is a function P of the phase p without a closed form, with kinks where one
# instant of the cycle takes over from another. But P is the largest of many smooth functions, one
# for each instant, and none of them bends down by more than some B: P + B p^2 / 2 is convex. So
#
# - between two phases h apart, P stays below the higher end plus B h^2 / 8;
# - P stays above the parabolas that leave each end along the slope of the instant that is largest
#   there, with the curvature -B.
#
# Both gaps shrink as h^2, and the intervals that can hold neither the lowest nor the highest value
# are dropped. An instant may turn along with the phase by any share of it, which leaves P as it is;
# the share that gives the smallest B is taken.
# ----------------------------------------------------------------------------

_START = 16
#: intervals of a row at which its search is broken off
_MOST_INTERVALS = 8192
_LEVELS = 40


class Rows(NamedTuple):
    """Signals y(a) = Re sum y_n exp(i n a) + Re(exp(i (a + p)) r); the energy is y.y / 2.

    `harmonics` (rows, components, n), `orders` (n,), `turned` (rows, components).
    """

    harmonics: np.ndarray
    orders: np.ndarray
    turned: np.ndarray


class PhaseSearch(NamedTuple):
    """Lowest and highest peak (rows,) in J, phases that reach them, and gaps left by the search.

    The true lowest value is at most `low_gap` below `low`, the highest `high_gap` above `high`,
    but for `rounding` (rows,), the round-off of any of the peaks. `peaks` (rows,) counts how many
    were sought.
    """

    low: np.ndarray
    high: np.ndarray
    low_phase: np.ndarray
    high_phase: np.ndarray
    low_gap: np.ndarray
    high_gap: np.ndarray
    rounding: np.ndarray
    peaks: np.ndarray


class _Intervals(NamedTuple):
    """Rows, left ends, and peak and slope at both ends, all (intervals,)."""

    row: np.ndarray
    left: np.ndarray
    value: np.ndarray
    slope: np.ndarray
    right_value: np.ndarray
    right_slope: np.ndarray


class _Best:
    """Highest values met so far, where, and what the intervals put aside may hold."""

    def __init__(self, rows: int) -> None:
        self.value = np.full(rows, -np.inf)
        self.phase = np.zeros(rows)
        self.ceiling = np.full(rows, -np.inf)

    def meet(self, row: np.ndarray, value: np.ndarray, phase: np.ndarray) -> None:
        before = self.value.copy()
        np.maximum.at(self.value, row, value)
        new = (value == self.value[row]) & (value > before[row])
        self.phase[row[new][::-1]] = phase[new][::-1]  # of equal ones, the first

    def gap(self) -> np.ndarray:
        return np.asarray(np.maximum(self.ceiling - self.value, 0.0))


def search_phases(rows: Rows, rtol: float) -> PhaseSearch:
    """Search every row until both gaps are below `rtol` times the value found, or rounding.

    Where many thousands of intervals would be needed, the peak being nearly the same at all
    phases, the gaps reached are returned. Raises NumericalFailure if a signal is not finite.
    """
    count = len(rows.harmonics)
    bend, rounding = _limits(rows)
    width = 2.0 * np.pi / _START
    row = np.repeat(np.arange(count), _START)
    left = np.tile(width * np.arange(_START), count)
    value, slope = _peaks(rows, row, left)
    after = _START * row + (np.arange(len(row)) + 1) % _START
    cells = _Intervals(row, left, value, slope, value[after], slope[after])
    high, low = _Best(count), _Best(count)
    peaks = np.full(count, _START)
    high.meet(row, value, left)
    low.meet(row, -value, left)
    for level in range(_LEVELS):
        above, below = _bounds(cells, bend[cells.row], width)
        crowded = np.bincount(cells.row, minlength=count) > _MOST_INTERVALS
        floor = 0.5 * rtol * np.abs(low.value) + rounding
        open_ = above > (high.value + 0.5 * rtol * high.value + rounding)[cells.row]
        open_ |= below < (-low.value - floor)[cells.row]
        open_ &= ~crowded[cells.row] & (level < _LEVELS - 1)
        np.maximum.at(high.ceiling, cells.row[~open_], above[~open_])
        np.maximum.at(low.ceiling, cells.row[~open_], -below[~open_])
        if not np.any(open_):
            break
        parents = _Intervals(*(part[open_] for part in cells))
        peaks += np.bincount(parents.row, minlength=count)
        width *= 0.5
        middle = parents.left + width
        value, slope = _peaks(rows, parents.row, middle)
        high.meet(parents.row, value, middle)
        low.meet(parents.row, -value, middle)
        cells = _halved(parents, middle, value, slope)
    return PhaseSearch(
        -low.value, high.value, low.phase, high.phase, low.gap(), high.gap(), rounding, peaks
    )


def _limits(rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """B of each row, and the round-off of its peaks."""
    reach = np.hypot.reduce(np.abs(rows.harmonics), axis=1)
    radius = np.hypot.reduce(np.abs(rows.turned), axis=1)
    pace = reach @ np.square(rows.orders).astype(float)
    both = radius + pace
    length = reach.sum(axis=1) + radius
    bend = length * radius * np.divide(pace, both, out=np.zeros_like(both), where=both > 0.0)
    return bend, 8.0 * EPSILON * np.square(length)


def _peaks(rows: Rows, row: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Peak energies (k,) at phases (k,) of rows (k,), and their slopes by the phase."""
    first = int(np.flatnonzero(rows.orders == 1)[0])
    turned = rows.turned[row] * np.exp(1j * phase)[:, None]
    signal = rows.harmonics[row]
    signal[..., first] += turned
    peak = vector_cycle_peak(signal, rows.orders)
    wave = np.exp(1j * np.multiply.outer(peak.angle, rows.orders))
    there = np.sum(signal * wave[:, None, :], axis=-1).real
    moves = (1j * turned * np.exp(1j * peak.angle)[:, None]).real
    return 0.5 * np.square(peak.value), np.sum(there * moves, axis=-1)


def _bounds(cells: _Intervals, bend: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Upper and lower bounds (intervals,) of the peak within each interval."""
    a, b = cells.value, cells.right_value
    above = np.maximum(a, b) + 0.125 * bend * width**2
    # with B p^2 / 2 added the parabolas are lines; they meet where the bound is lowest
    lift = 0.5 * bend * width**2
    opening = cells.right_slope + bend * width - cells.slope
    meeting = (a - b + cells.right_slope * width + lift) / np.where(opening > 0.0, opening, 1.0)
    at = np.clip(np.where(opening > 0.0, meeting, 0.0), 0.0, width)
    valley = a + cells.slope * at - 0.5 * bend * at * at
    below = np.minimum(np.minimum(a, b), valley)
    return above, np.maximum(below, 0.0)


def _halved(
    parents: _Intervals, middle: np.ndarray, value: np.ndarray, slope: np.ndarray
) -> _Intervals:
    left = parents._replace(right_value=value, right_slope=slope)
    right = parents._replace(left=middle, value=value, slope=slope)
    return _Intervals(*(np.concatenate(pair) for pair in zip(left, right, strict=True)))


# ----------------------------------------------------------------------------
# Range of the energy of each operation and balance, over all phases of the balance weight.
# ----------------------------------------------------------------------------


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


def states(parts: SuperposedMotion, rate: np.ndarray) -> SuperposedMotion:
    """Motions of the parts times `rate` (..., orders): i n w makes velocities of them."""
    factor = np.asarray(rate)[..., None, :, None]
    return parts._replace(
        shaking=_times(parts.shaking, factor),
        residual=_times(parts.residual, factor[..., [parts.first], :]),
    )


def mean_energy_range(
    weight: Bounded, state: SuperposedMotion, left_out: np.ndarray | float = 0.0
) -> PhaseRange:
    """Range (..., operations, balances) of the mean over the cycle: a + b cos(p - p0).

    With states S and R of order 1, the mean at phase p is (S* A S + R* A R) / 4 plus
    Re(exp(i p) S* A R) / 2 plus what the other orders have, which no phase changes. The phases of
    lowest and highest mean are half a turn apart.

    Parameters
    ----------
    weight : (..., 1 or operations, 6, 6), mass matrix for velocities or stiffness matrix for
        displacements in `state`.
    state : the orders that count, guard orders taken off.
    left_out : (..., operations) in J, what dropped orders may add (`energies.dropped_mean`); it
        enters the errors.
    """
    shaking, residual = state.shaking, state.residual
    by_order, single = energy_by_order(weight, shaking), energy_by_order(weight, residual)
    still = np.sum(by_order.mean, axis=-1)[..., None] + single.mean
    uncertainty = np.sum(by_order.mean_error, axis=-1)[..., None] + single.mean_error

    start = shaking.value[..., None, state.first, :]
    spread = shaking.error[..., None, state.first, :]
    cross = 0.5 * np.sum(start.conj() * (residual.value @ weight.value), axis=-1)
    size, matrix = np.abs(residual.value), np.abs(weight.value)
    loose = weight.error + 16.0 * UNIT_ROUNDOFF * matrix
    terms = np.abs(start) * (size @ loose) + spread * (size @ matrix)
    terms = terms + (np.abs(start) + spread) * (residual.error @ matrix)
    swing = np.abs(cross)
    rounding = (by_order.mean.shape[-1] + 4) * UNIT_ROUNDOFF * (still + swing)
    error = uncertainty + 0.5 * np.sum(terms, axis=-1) + rounding
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
    weight: Bounded,
    state: SuperposedMotion,
    orders: np.ndarray,
    retained: int | None = None,
    tail: float = 0.0,
    rtol: float = 1e-9,
) -> PhaseRange:
    """Range of the peak over the cycle, searched safely: no phase is left out.

    Parameters
    ----------
    weight, state : of one machine: (6, 6), positive semidefinite, and the motion.
    orders, retained, tail : as for `energies.energy_over_cycle`, order 1 among them.
    rtol : the search ends when what it may have missed is below this share of the value; what
        is left is in the errors.

    Raises
    ------
    NumericalFailure
        The weight is not positive semidefinite, or an amplitude is not finite.
    """
    orders = np.asarray(orders)
    shaking = energy_signal(weight, state.shaking, retained, tail)
    one = Bounded(*(part[..., None, :] for part in state.residual))
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
    searched = search_phases(rows, rtol)
    low, high, low_phase, high_phase, low_gap, high_gap, rounding = (
        part.reshape(turned.shape[:-1]) for part in searched[:7]
    )
    spread = shaking.spread[..., None] + residual.spread
    weighing = 2.0 * (shaking.form_error[..., None] + residual.form_error) + rounding

    def uncertainty(energy: np.ndarray) -> np.ndarray:
        total: np.ndarray = spread * (np.sqrt(2.0 * energy) + 0.5 * spread) + weighing
        return total

    return PhaseRange(
        low, high, low_phase, high_phase, low_gap + uncertainty(low), high_gap + uncertainty(high)
    )


def _times(motion: Bounded, factor: np.ndarray) -> Bounded:
    value = motion.value * factor
    return Bounded(value, np.abs(factor) * motion.error + 3.0 * UNIT_ROUNDOFF * np.abs(value))
