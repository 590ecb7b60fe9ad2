"""Operations combined with balances, and their energies over all angles of a balance weight."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.bounded import Bounded, reshaped
from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.linear import Dynamics, response
from vibecalc.numerics.rounding import EPSILON
from vibecalc.response.energies import energy_by_order, energy_signal

# ----------------------------------------------------------------------------
# Operating modes combined with balances: motions add as phasors, and only then become energies.
#
# Two forces of one frequency do not have energies that add: what counts is how one leads the other.
# So each pair of an operation and a balance is one motion, and turning the balance weight against
# the crank by an angle p turns the phasors of its residual force by exp(i p).
# ----------------------------------------------------------------------------


class Parts(NamedTuple):
    """Loads in N and N m, or motions in m and rad, complex amplitudes of two causes.

    `shaking` (..., operations, orders, 6) by pistons, weights and shafts, order 1 first; `residual`
    (..., operations, balances, 6) of order 1 by what turns and is not balanced, its weight at the
    nominal phase.
    """

    shaking: Bounded
    residual: Bounded

    def times(self, factor: np.ndarray) -> "Parts":
        """Times a `factor` (..., orders): i n w makes velocities of motions."""
        factor = factor[..., None, :, None]
        return Parts(self.shaking * factor, self.residual * factor[..., :1, :])


def superpose(system: Dynamics, loads: Parts) -> Parts:
    """Motions of a body with a dynamic stiffness (..., orders, 6, 6), all of them at once."""
    every = Dynamics(*(part[..., None, :, :, :] for part in system))
    first = Dynamics(*(part[..., :1, :, :] for part in every))
    return Parts(response(every, *loads.shaking), response(first, *loads.residual))


def at_phase(parts: Parts, phase: np.ndarray | float = 0.0) -> Bounded:
    """Both causes (..., operations, balances, orders, 6), the weights turned by a phase in rad.

    `phase` broadcasts with (..., operations, balances).
    """
    angle = np.asarray(phase, dtype=float)[..., None]
    turned = parts.residual * (np.cos(angle) + 1j * np.sin(angle))
    first: Bounded = turned[..., None, :] * np.eye(parts.shaking.shape[-2], 1)
    return parts.shaking[..., None, :, :] + first


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


class PhaseRange(NamedTuple):
    """Lowest and highest energy (...) in J over all phases of the balance weight.

    Phases in [0, 2 pi) rad, counted from the nominal one in the sense of rotation; at these the
    energy is what is said, to within its error.
    """

    low: Bounded
    high: Bounded
    low_phase: np.ndarray
    high_phase: np.ndarray


def search_phases(
    harmonics: np.ndarray, orders: np.ndarray, turned: np.ndarray, rtol: float
) -> tuple[PhaseRange, np.ndarray]:
    """Range (...) of the peak of y.y / 2, y(a) = Re sum y_n exp(i n a) + Re(exp(i (a + p)) r).

    Each search ends when what it may have missed is below `rtol` times the values found, or
    rounding. Where many thousands of intervals would be needed, the peak being nearly the same at
    all phases, it is broken off, which the errors tell. Also how many peaks (...) were sought.

    Parameters
    ----------
    harmonics, turned : y_n (..., components, n) and r (..., components).
    orders : (n,), the first of them 1.

    Raises
    ------
    NumericalFailure
        A signal is not finite.
    """
    shape = turned.shape[:-1]
    harmonics = np.broadcast_to(harmonics, (*turned.shape, len(orders)))
    harmonics = harmonics.reshape(-1, *harmonics.shape[-2:])
    turned = turned.reshape(-1, turned.shape[-1])
    count, width = len(turned), 2.0 * np.pi / _START
    bend, rounding = _limits(harmonics, orders, turned)
    row, left = np.repeat(np.arange(count), _START), np.tile(width * np.arange(_START), count)
    value, slope = _peaks(harmonics, orders, turned, row, left)
    after = _START * row + (np.arange(len(row)) + 1) % _START
    ends = np.array([left, value, slope, value[after], slope[after]])
    met = [(row, left, value)]
    # of values and of what lies below them: the highest met, and what the intervals put aside hold
    best, ceiling = np.full((2, count, 2), -np.inf)
    for level in range(_LEVELS):
        at, _, reached = met[-1]
        np.maximum.at(best, at, np.stack([reached, -reached], axis=-1))
        bounds = _bounds(ends, bend[row], width)
        crowded = np.bincount(row, minlength=count) > _MOST_INTERVALS
        enough = best + 0.5 * rtol * np.abs(best) + rounding[:, None]
        open_ = np.any(bounds > enough[row], axis=-1) & ~crowded[row] & (level < _LEVELS - 1)
        np.maximum.at(ceiling, row[~open_], bounds[~open_])
        if not np.any(open_):
            break
        row, (left, *near), far = row[open_], ends[:3, open_], ends[3:, open_]
        width *= 0.5
        middle = left + width
        here = _peaks(harmonics, orders, turned, row, middle)
        met.append((row, middle, here[0]))
        ends = np.concatenate([[left, *near, *here], [middle, *here, *far]], axis=1)
        row = np.tile(row, 2)
    row, phase, value = (np.concatenate(part) for part in zip(*met, strict=True))
    # of equal ones the first
    rank = [np.lexsort((sign * value, row)) for sign in (1.0, -1.0)]
    first = np.searchsorted(row[rank[0]], np.arange(count))
    phases = (phase[one[first]].reshape(shape) for one in rank)
    found = best * [1.0, -1.0], np.maximum(ceiling - best, 0.0) + rounding[:, None]
    high, low = (Bounded(*(part[:, k].reshape(shape) for part in found)) for k in (0, 1))
    return PhaseRange(low, high, *phases), np.bincount(row, minlength=count).reshape(shape)


def _limits(
    harmonics: np.ndarray, orders: np.ndarray, turned: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """B of each row, and the round-off of its peaks."""
    reach = np.hypot.reduce(np.abs(harmonics), axis=1)
    radius = np.hypot.reduce(np.abs(turned), axis=1)
    pace = reach @ np.square(orders).astype(float)
    both = radius + pace
    length = reach.sum(axis=1) + radius
    bend = length * radius * np.divide(pace, both, out=np.zeros_like(both), where=both > 0.0)
    return bend, 8.0 * EPSILON * np.square(length)


def _peaks(
    harmonics: np.ndarray,
    orders: np.ndarray,
    turned: np.ndarray,
    row: np.ndarray,
    phase: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Peak energies (k,) at phases (k,) of rows (k,), and their slopes by the phase."""
    moved = turned[row] * np.exp(1j * phase)[:, None]
    signal = harmonics[row]
    signal[..., 0] += moved
    peak = vector_cycle_peak(signal, orders)
    wave = np.exp(1j * np.multiply.outer(peak.angle, orders))
    there = np.sum(signal * wave[:, None, :], axis=-1).real
    moves = (1j * moved * np.exp(1j * peak.angle)[:, None]).real
    return 0.5 * np.square(peak.value), np.sum(there * moves, axis=-1)


def _bounds(ends: np.ndarray, bend: np.ndarray, width: float) -> np.ndarray:
    """Upper bounds (intervals, 2) within each interval of the peak, and of its negative."""
    _, a, slope, b, right_slope = ends
    lift = 0.5 * bend * width**2
    # with B p^2 / 2 added the parabolas are lines; they meet where the bound is lowest
    opening = right_slope + bend * width - slope
    meeting = (a - b + right_slope * width + lift) / np.where(opening > 0.0, opening, 1.0)
    at = np.clip(np.where(opening > 0.0, meeting, 0.0), 0.0, width)
    valley = a + slope * at - 0.5 * bend * at * at
    below = np.minimum(np.minimum(a, b), valley)
    return np.stack([np.maximum(a, b) + 0.25 * lift, -np.maximum(below, 0.0)], axis=-1)


# ----------------------------------------------------------------------------
# Range of the energy of each operation and balance, over all phases of the balance weight.
# ----------------------------------------------------------------------------


def mean_energy_range(
    weight: Bounded, state: Parts, left_out: np.ndarray | float = 0.0
) -> tuple[Bounded, Bounded]:
    """Lowest and highest (..., operations, balances) mean over the cycle: a + b cos(p - p0).

    With states S and R of order 1, the mean at phase p is (S* A S + R* A R) / 4 plus
    Re(exp(i p) S* A R) / 2 plus what the other orders have, which no phase changes.

    Parameters
    ----------
    weight : (..., 1 or operations, 6, 6), mass matrix for velocities or stiffness matrix for
        displacements in `state`.
    state : the orders that count, guard orders taken off.
    left_out : (..., operations) in J, what dropped orders may add (`energies.dropped_mean`); it
        enters the errors.
    """
    shaking, residual = (energy_by_order(weight, part).mean for part in state)
    dropped = np.asarray(left_out)[..., None]
    still = shaking.sum()[..., None] + residual + Bounded(np.zeros(dropped.shape), dropped)
    start = reshaped(state.shaking[..., None, 0, :], np.conj)
    swing = abs(0.5 * (start * (state.residual @ weight)).sum())
    low = still - swing
    return Bounded(np.maximum(low.value, 0.0), low.error), still + swing


def peak_energy_range(
    weight: Bounded,
    state: Parts,
    orders: np.ndarray,
    retained: int | None = None,
    tail: float = 0.0,
    rtol: float = 1e-9,
) -> PhaseRange:
    """Range of the peak over the cycle, searched safely: no phase is left out.

    Parameters
    ----------
    weight, state : of one machine: (6, 6), positive semidefinite, and the motion.
    orders, retained, tail : as for `energies.peak_over_cycle`, the first order being 1.
    rtol : the search ends when what it may have missed is below this share of the value; what
        is left is in the errors.

    Raises
    ------
    NumericalFailure
        The weight is not positive semidefinite, or an amplitude is not finite.
    """
    shaking, spread, form = energy_signal(weight, state.shaking, retained, tail)
    residual, its_spread, its_form = energy_signal(weight, state.residual[..., None, :])
    numbers = np.asarray(orders)[:retained]
    found, _ = search_phases(shaking[..., None, :, :], numbers, residual[..., 0], rtol)
    spread, form = spread[..., None] + its_spread, 2.0 * (form[..., None] + its_form)
    low, high = (
        Bounded(end.value, end.error + spread * (np.sqrt(2.0 * end.value) + 0.5 * spread) + form)
        for end in found[:2]
    )
    return found._replace(low=low, high=high)
