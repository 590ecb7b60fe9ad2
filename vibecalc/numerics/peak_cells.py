"""Branch and bound for the largest length of a vector of smooth signals, on Taylor polynomials.

Lengths are scaled to about 1 and the variable is N times the angle, N the highest order, so that a
signal and its derivatives have about the same size.
"""

import math
from typing import NamedTuple, Self

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray, IntArray

#: exact to rounding within a half-width of pi / 12, for the square of the signal too
DEGREE = 14
PIECES = 8
#: squares of the length that agree to this count as equal
SLACK = 8.0 * EPSILON


class Cells(NamedTuple):
    """Intervals of one width about `centre` (k,), each belonging to a `row` (k,).

    `signal` (degree + 1, components, k) are Taylor coefficients about the centre, `square`
    (degree + 1, k) those of the squared length.
    """

    row: IntArray
    centre: FloatArray
    signal: FloatArray
    square: FloatArray

    @classmethod
    def about(
        cls, local: ComplexArray, ratios: FloatArray, row: IntArray, centre: FloatArray
    ) -> Self:
        """From harmonics (n, components, k), turned to the centre; `ratios` are orders over N."""
        power = np.arange(DEGREE + 1)
        factors = np.array([math.factorial(m) for m in power.tolist()], dtype=np.float64)
        weight = (1j ** (power % 4) / factors)[:, None] * ratios ** power[:, None]
        basis = np.concatenate([weight.real, -weight.imag], axis=1)
        parts = np.concatenate([local.real, local.imag])
        signal = basis @ parts.reshape(len(parts), -1)
        return cls.of(row, centre, signal.reshape(DEGREE + 1, *local.shape[1:]))

    @classmethod
    def of(cls, row: IntArray, centre: FloatArray, signal: FloatArray) -> Self:
        """From Taylor coefficients of the signals."""
        square = np.empty((DEGREE + 1, len(row)))
        for m in range(DEGREE + 1):
            half = (m + 1) // 2
            pairs = signal[:half] * signal[m : m - half : -1]
            square[m] = 2.0 * np.sum(pairs, axis=(0, 1))
            if m % 2 == 0:
                square[m] += np.sum(signal[half] ** 2, axis=0)
        return cls(row, centre, signal, square)

    def take(self, which: BoolArray) -> Self:
        """Some of the cells."""
        return type(self)(
            self.row[which], self.centre[which], self.signal[..., which], self.square[:, which]
        )

    def divided(self, half_width: float) -> Self:
        """Every cell in `PIECES` equal ones."""
        power = np.arange(DEGREE + 1)
        choose = np.array([[math.comb(m, n) for n in power] for m in power], dtype=np.float64)
        step = np.maximum(power - power[:, None], 0)
        shifts = half_width * ((2.0 * np.arange(PIECES) + 1.0) / PIECES - 1.0)
        flat = self.signal.reshape(DEGREE + 1, -1)
        moved = [(choose.T * shift**step) @ flat for shift in shifts.tolist()]
        signal = np.concatenate([one.reshape(self.signal.shape) for one in moved], axis=-1)
        centre = np.concatenate([self.centre + shift for shift in shifts.tolist()])
        return self.of(np.tile(self.row, PIECES), centre, signal)


def search(
    cells: Cells, best: FloatArray, half_width: float, cycle: float
) -> tuple[FloatArray, FloatArray]:
    """Largest length of every row and the first position in [0, cycle) where it is reached.

    Parameters
    ----------
    cells : Cells
        All cells that can hold the maximum; of each row at least one.
    best : array (rows,)
        Largest square of the length known so far.
    half_width, cycle : float
        Of a cell; length of the cycle.
    """
    best = best.copy()
    rows, positions, lengths = [], [], []
    while True:
        upper, concave = _bounds(cells.square, half_width)
        settled = concave | (upper <= best[cells.row] + SLACK)
        possible = upper >= best[cells.row] - SLACK
        done = cells.take(possible & settled)
        at, slack = _summits(done.square, half_width, concave[possible & settled])
        length = np.sqrt(np.sum(_horner(done.signal, at) ** 2, axis=0))
        position = done.centre + at
        # a summit at zero may come out as a rounding below it
        position = np.where((position < 0.0) & (position > -slack), 0.0, position)
        rows.append(done.row)
        positions.append(np.where(position < 0.0, position + cycle, position))
        lengths.append(length)
        np.maximum.at(best, done.row, length**2)
        open_ = possible & ~settled
        if not np.any(open_):
            break
        cells = cells.take(open_).divided(half_width)
        half_width /= PIECES
    found = (np.concatenate(part) for part in (rows, positions, lengths))
    return _first(len(best), *found)


def _bounds(square: FloatArray, half_width: float) -> tuple[FloatArray, BoolArray]:
    """Upper bound of the squares in each cell, and whether the square is concave there."""
    power = np.arange(3, DEGREE + 1)
    size = np.abs(square[3:])
    slope, bend = np.abs(square[1]), square[2]
    falls = bend < 0.0
    top = np.where(falls, slope / np.where(falls, -2.0 * bend, 1.0), half_width)
    top = np.minimum(top, half_width)
    upper = square[0] + (slope + bend * top) * top + half_width**power @ size
    return upper, 2.0 * bend + (power * (power - 1) * half_width ** (power - 2)) @ size < 0.0


def _summits(
    square: FloatArray, half_width: float, concave: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Where concave squares are largest within their cells (0 for the others), and how surely."""
    power = np.arange(1, DEGREE + 1)[:, None]
    slope = square[1:] * power
    bend = slope[1:] * power[:-1]
    ends = np.full(square.shape[1], half_width)
    rises, sinks = _horner(slope, ends) >= 0.0, _horner(slope, -ends) <= 0.0
    at = np.where(concave, ends * rises - ends * sinks, 0.0)
    inside = np.nonzero(concave & ~rises & ~sinks)[0]
    at[inside] = _roots(slope[:, inside], bend[:, inside], half_width)
    curvature = np.where(concave, np.abs(_horner(bend, at)), 1.0)
    return at, np.minimum(16.0 * EPSILON / np.maximum(curvature, EPSILON), half_width)


def _roots(slope: FloatArray, bend: FloatArray, half_width: float) -> FloatArray:
    """Zero of each falling slope between the cell's ends: Newton, else bisection."""
    high = np.full(slope.shape[1], half_width)
    low = -high
    at: FloatArray = np.clip(-slope[0] / bend[0], low, high)
    for _ in range(60):
        value = _horner(slope, at)
        low, high = np.where(value > 0.0, at, low), np.where(value > 0.0, high, at)
        target = at - value / _horner(bend, at)
        target = np.where((target >= low) & (target <= high), target, 0.5 * (low + high))
        moved, at = np.max(np.abs(target - at), initial=0.0), target
        if moved <= EPSILON:
            break
    return at


def _horner(coefficients: FloatArray, at: FloatArray) -> FloatArray:
    """Polynomials (degree + 1, ..., k) at one place (k,) each."""
    value: FloatArray = coefficients[-1] * at
    for one in coefficients[-2:0:-1]:
        value += one
        value *= at
    value += coefficients[0]
    return value


def _first(
    count: int, row: IntArray, position: FloatArray, length: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest length of every row, and the first position that reaches it."""
    largest = np.zeros(count)
    np.maximum.at(largest, row, length)
    reached = length >= largest[row] - SLACK
    first = np.full(count, np.inf)
    np.minimum.at(first, row[reached], position[reached])
    return largest, np.where(largest > 0.0, first, 0.0)
