"""Lowest and highest peak energy over all phases of a balance weight, by branch and bound.

The peak over the cycle is a function P of the phase p without a closed form, with kinks where one
instant of the cycle takes over from another. But P is the largest of many smooth functions, one
for each instant, and none of them bends down by more than some B: P + B p^2 / 2 is convex. So

- between two phases h apart, P stays below the higher end plus B h^2 / 8;
- P stays above the parabolas that leave each end along the slope of the instant that is largest
  there, with the curvature -B.

Both gaps shrink as h^2, and the intervals that can hold neither the lowest nor the highest value
are dropped. An instant may turn along with the phase by any share of it, which leaves P as it is;
the share that gives the smallest B is taken.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.cycle_peak import vector_cycle_peak
from vibecalc.numerics.rounding import EPSILON

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


class Found(NamedTuple):
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


def search_phases(rows: Rows, rtol: float) -> Found:
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
    return Found(
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
