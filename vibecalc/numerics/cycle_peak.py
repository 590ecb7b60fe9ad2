"""Largest value of a periodic signal over its cycle, from its harmonics."""

import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import (
    EPSILON,
    UNIT_ROUNDOFF,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
)

# ----------------------------------------------------------------------------
# Which orders of a periodic signal its peak cannot tell from rounding.
# ----------------------------------------------------------------------------

#: highest orders kept are 2^k or 3 2^k, so that rows fall into few groups
_STEPS = np.sort(np.concatenate([2 ** np.arange(40), 3 * 2 ** np.arange(39)]))


def needed_orders(rows: ComplexArray, orders: IntArray) -> tuple[IntArray, FloatArray]:
    """Highest order to keep of each row (r, component, n), and the sum (r,) of those above it.

    The sum stays below the unit roundoff of the row's largest harmonic, and so of its peak. What
    is kept follows from the row and the largest of `orders` alone; one order above zero stays.
    """
    size = np.abs(rows).sum(axis=1)
    below = UNIT_ROUNDOFF * size.max(axis=-1)
    highest = int(orders.max())
    if np.all(size[:, orders == highest].sum(axis=-1) > below):
        return np.full(len(rows), highest), np.zeros(len(rows))
    rank = np.argsort(orders, kind="stable")
    onwards = np.cumsum(size[:, rank[::-1]], axis=1)[:, ::-1]
    needed = np.max(np.where(onwards > below[:, None], orders[rank], 0), axis=1)
    needed = np.maximum(needed, int(orders[orders > 0].min()))
    retained = np.minimum(_STEPS[np.searchsorted(_STEPS, needed)], highest)
    return retained, np.sum(np.where(orders > retained[:, None], size, 0.0), axis=1)


# ----------------------------------------------------------------------------
# Branch and bound for the largest length of a vector of smooth signals, on Taylor polynomials.
#
# Lengths are scaled to about 1 and the variable is N times the angle, N the highest order, so that
# a signal and its derivatives have about the same size.
# ----------------------------------------------------------------------------

#: exact to rounding within a half-width of pi / 12, for the square of the signal too
DEGREE = 14
PARTS = 8
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
        """Every cell in `PARTS` equal ones."""
        power = np.arange(DEGREE + 1)
        choose = np.array([[math.comb(m, n) for n in power] for m in power], dtype=np.float64)
        step = np.maximum(power - power[:, None], 0)
        shifts = half_width * ((2.0 * np.arange(PARTS) + 1.0) / PARTS - 1.0)
        flat = self.signal.reshape(DEGREE + 1, -1)
        moved = [(choose.T * shift**step) @ flat for shift in shifts.tolist()]
        signal = np.concatenate([one.reshape(self.signal.shape) for one in moved], axis=-1)
        centre = np.concatenate([self.centre + shift for shift in shifts.tolist()])
        return self.of(np.tile(self.row, PARTS), centre, signal)


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
        at, slack = _peaks(done.square, half_width, concave[possible & settled])
        length = np.sqrt(np.sum(horner(done.signal, at) ** 2, axis=0))
        position = done.centre + at
        # a peak at zero may come out as a rounding below it
        position = np.where((position < 0.0) & (position > -slack), 0.0, position)
        rows.append(done.row)
        positions.append(np.where(position < 0.0, position + cycle, position))
        lengths.append(length)
        np.maximum.at(best, done.row, length**2)
        open_ = possible & ~settled
        if not np.any(open_):
            break
        cells = cells.take(open_).divided(half_width)
        half_width /= PARTS
    joined = (np.concatenate(part) for part in (rows, positions, lengths))
    return _first(len(best), *joined)


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


def _peaks(
    square: FloatArray, half_width: float, concave: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Where concave squares are largest within their cells (0 for the others), and how surely."""
    power = np.arange(1, DEGREE + 1)[:, None]
    slope = square[1:] * power
    bend = slope[1:] * power[:-1]
    ends = np.full(square.shape[1], half_width)
    rises, sinks = horner(slope, ends) >= 0.0, horner(slope, -ends) <= 0.0
    at = np.where(concave, ends * rises - ends * sinks, 0.0)
    inside = np.nonzero(concave & ~rises & ~sinks)[0]
    at[inside] = _roots(slope[:, inside], bend[:, inside], half_width)
    curvature = np.where(concave, np.abs(horner(bend, at)), 1.0)
    return at, np.minimum(16.0 * EPSILON / np.maximum(curvature, EPSILON), half_width)


def _roots(slope: FloatArray, bend: FloatArray, half_width: float) -> FloatArray:
    """Zero of each falling slope between the cell's ends: Newton, else bisection."""
    high = np.full(slope.shape[1], half_width)
    low = -high
    at: FloatArray = np.clip(-slope[0] / bend[0], low, high)
    for _ in range(60):
        value = horner(slope, at)
        low, high = np.where(value > 0.0, at, low), np.where(value > 0.0, high, at)
        target = at - value / horner(bend, at)
        target = np.where((target >= low) & (target <= high), target, 0.5 * (low + high))
        moved, at = np.max(np.abs(target - at), initial=0.0), target
        if moved <= EPSILON:
            break
    return at


def horner(coefficients: FloatArray, at: FloatArray) -> FloatArray:
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


# ----------------------------------------------------------------------------
# Largest value of a periodic signal over its cycle, from its harmonics.
#
# A signal of highest order N is sampled at M = 12 N angles. A sample nearest to the maximum cannot
# lie below cos^2(pi N / M) times it (squares of the signal; M. Riesz 1914; Ehlich and Zeller 1964),
# nor farther below it than the curvature allows. What is left, about two samples for each row, is
# turned into Taylor polynomials about the sample, exact to rounding within the sample's cell. Cells
# that cannot hold the maximum are dropped, in concave ones Newton finds it, the rest is divided
# (branch and bound), so that no maximum is missed. N is of each row the highest order that, with
# those above it, is more than rounding; what is left out counts as error.
# ----------------------------------------------------------------------------

SAMPLES_PER_ORDER = 12
#: rows are taken in blocks of about this many samples, so that memory stays small
BLOCK = 1 << 18
#: orders times samples up to which a table of their waves is quicker than a Fourier transform
TABLE = 1 << 15


class Peak(NamedTuple):
    """Largest magnitude over a cycle, the first angle in [0, 2 pi) where it is reached, its error.

    `error` is absolute and bounds the round-off of `value` for harmonics taken as exact.
    """

    value: FloatArray
    angle: FloatArray
    error: FloatArray


def numbered(order: FloatArray) -> IntArray:
    """Orders (m,) as whole numbers, twice as much where some are halves: of two turns."""
    doubled = np.rint(2.0 * order).astype(np.int64)
    return np.asarray(doubled if np.any(doubled % 2) else doubled // 2)


def cycle_peak(harmonics: ArrayLike, orders: ArrayLike) -> Peak:
    """Largest |x(a)| over a cycle, x(a) = Re sum_n X_n exp(i n a).

    Parameters
    ----------
    harmonics : complex array (..., n)
        X_n, 0-to-peak; of order 0 the real part counts.
    orders : int array (n,)
        Orders, 0 or above, in any sequence.

    Returns
    -------
    Peak
        Arrays (...,). All-zero harmonics have the peak 0 at angle 0. Maxima that agree to
        round-off count as equal, and the first of them is reported.

    Raises
    ------
    NumericalFailure
        A harmonic is not finite.
    """
    return vector_cycle_peak(np.asarray(harmonics)[..., None, :], orders)


def vector_cycle_peak(harmonics: ArrayLike, orders: ArrayLike) -> Peak:
    """Largest length of a vector over a cycle; harmonics have shape (..., component, n).

    Otherwise as `cycle_peak`.
    """
    values = np.asarray(harmonics, dtype=np.complex128)
    order = np.asarray(orders, dtype=np.int64)
    if not np.all(np.isfinite(values)):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(values))[0])
        raise NumericalFailure(
            f"peak over a cycle: harmonic {where} of {values.shape} is {values[where]}, not a "
            "finite number; leave that row out before asking for its peak"
        )
    shape, components, count = values.shape[:-2], *values.shape[-2:]
    rows = values.reshape(-1, components, count)
    if np.any(order == 0):
        rows = np.where(order == 0, rows.real, rows)
    used = np.any(rows != 0.0, axis=(0, 1))
    rows, order = rows[..., used], order[used]
    size = np.sum(np.abs(rows), axis=(1, 2))
    step = math.gcd(*order.tolist())
    if step == 0:
        value, angle = np.hypot.reduce(rows.real.sum(axis=-1), axis=-1), np.zeros(len(rows))
    elif np.all(order == order[0]):
        value, angle = _ellipse(rows.sum(axis=-1), step)
    else:
        retained, left_out = needed_orders(rows, order // step)
        value, angle = _by_highest(rows, order // step, size, retained)
        angle = angle / step
        return _peak(value, angle, 2.0 * EPSILON * size + left_out, shape)
    return _peak(value, angle, 2.0 * EPSILON * size, shape)


def _peak(value: FloatArray, angle: FloatArray, error: FloatArray, shape: tuple[int, ...]) -> Peak:
    return Peak(value.reshape(shape), angle.reshape(shape), error.reshape(shape))


def _ellipse(amplitude: ComplexArray, order: int) -> tuple[FloatArray, FloatArray]:
    """One order only: half the major axis of the ellipse that the vector's tip describes."""
    scale = _power_of_two(np.max(np.abs(amplitude), axis=-1))
    square = (amplitude / scale[:, None]) ** 2
    turning = np.sum(square, axis=-1)
    value = scale * np.sqrt(0.5 * (np.sum(np.abs(square), axis=-1) + np.abs(turning)))
    angle = 0.5 * np.mod(-np.angle(turning), 2.0 * np.pi) / order
    # a circle has no first maximum, and its phase would be that of round-off
    round_ = np.abs(turning) <= 4.0 * EPSILON * np.sum(np.abs(square), axis=-1)
    return value, np.where(round_ | (angle >= np.pi / order), 0.0, angle)


def _by_highest(
    rows: ComplexArray, orders: IntArray, size: FloatArray, retained: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Peaks of rows (r, component, n), those with the same highest order together."""
    value, angle = np.zeros(len(rows)), np.zeros(len(rows))
    for highest in sorted(set(retained.tolist())):
        mine, used = np.flatnonzero(retained == highest), orders <= highest
        value[mine], angle[mine] = _general(rows[mine][..., used], orders[used], size[mine])
    return value, angle


def _general(
    rows: ComplexArray, orders: IntArray, size: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Peaks of rows (r, component, n), in blocks."""
    samples = SAMPLES_PER_ORDER * int(orders.max())
    roots = np.exp(2.0j * np.pi * np.arange(samples) / samples)
    waves = None
    if len(orders) * samples <= TABLE:
        waves = roots[(orders[:, None] * np.arange(samples)) % samples]
    scale = _power_of_two(size)
    value, angle = np.empty(len(rows)), np.empty(len(rows))
    block = max(1, BLOCK // (samples * rows.shape[1]))
    for start in range(0, len(rows), block):
        part = slice(start, start + block)
        scaled = rows[part] * (1.0 / scale[part, None, None])
        value[part], angle[part] = _block(scaled, orders, roots, waves)
    return value * scale, angle


def _by_products(rows: ComplexArray, waves: ComplexArray) -> FloatArray:
    """Samples (r, component, samples) from a table of all orders: the fastest way for few."""
    parts = np.concatenate([rows.real, rows.imag], axis=-1)
    basis = np.concatenate([waves.real, -waves.imag])
    found = parts.reshape(-1, parts.shape[-1]) @ basis
    return np.asarray(found.reshape(*rows.shape[:-1], waves.shape[1]))


def _by_transform(rows: ComplexArray, orders: IntArray, samples: int) -> FloatArray:
    """The same by a Fourier transform, without a table that grows with the square of the orders."""
    spectrum = np.zeros((samples // 2 + 1, *rows.shape[:-1]), dtype=np.complex128)
    weight = np.where(orders == 0, float(samples), 0.5 * samples)
    np.add.at(spectrum, orders, np.moveaxis(rows * weight, -1, 0))
    return np.asarray(np.fft.irfft(np.moveaxis(spectrum, 0, -1), samples))


def _block(
    rows: ComplexArray, orders: IntArray, roots: ComplexArray, waves: ComplexArray | None
) -> tuple[FloatArray, FloatArray]:
    """Peaks of rows whose size is about 1; `waves` (n, samples) are powers of the `roots`."""
    highest, samples = int(orders.max()), len(roots)
    square = _by_transform(rows, orders, samples) if waves is None else _by_products(rows, waves)
    square = np.sum(np.square(square, out=square), axis=1)
    best = square.max(axis=1)

    # how far below the maximum the sample nearest to it can lie
    magnitude = np.abs(rows)
    speed, bend = magnitude @ orders, magnitude @ orders**2
    curvature = 2.0 * np.sum(speed**2 + magnitude.sum(axis=-1) * bend, axis=-1)
    nearest = math.cos(math.pi * highest / samples) ** 2
    lowest = np.maximum(best * nearest, best - 0.5 * curvature * (math.pi / samples) ** 2)
    chosen = np.flatnonzero(square >= (lowest * (1.0 - 8.0 * EPSILON))[:, None])
    row, sample = np.divmod(chosen, samples)

    turn = roots[(orders[:, None] * sample) % samples] if waves is None else waves[:, sample]
    local = np.moveaxis(rows, 0, -1)[:, :, row].swapaxes(0, 1) * turn[:, None]
    centre = sample * (2.0 * math.pi * highest / samples)
    cells = Cells.about(local, orders / highest, row, centre)
    half_width = math.pi * highest / samples
    length, position = search(cells, best, half_width, 2.0 * math.pi * highest)
    return length, position / highest


def _power_of_two(size: FloatArray) -> FloatArray:
    """Power of two next to each size, so that scaling rounds nothing; 1 for zero."""
    return np.where(size > 0.0, np.ldexp(1.0, np.clip(np.frexp(size)[1], -1000, 1000)), 1.0)
