"""Sum of all orders with their phases over a cycle: highest and lowest value to rounding."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.cycle_peak import Cells, search
from vibecalc.numerics.rounding import EPSILON, BoolArray, ComplexArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Sum of all orders with their phases over one cycle: highest and lowest value, exact to rounding.
#
# The orders are sampled by a Fourier transform. Between its samples a signal cannot rise by more
# than its largest curvature allows, so that only the few samples within that of the highest one can
# be next to the maximum; about them the signal is searched as Taylor polynomials: by Newton's
# method where a cell is simple (`synthesis_cells.py`), else by branch and bound.
# ----------------------------------------------------------------------------

#: least number of samples in a period of the highest order, for branch and bound
SAMPLES_PER_ORDER = 16
#: samples of one block of rows
BLOCK = 1 << 18


class Synthesis(NamedTuple):
    """Of x(theta) = Re sum_q X_q exp(i q theta), arrays (...).

    `peak` is the largest |x|; `half_range` is (highest - lowest) / 2, what class rules call the
    vibratory amplitude; `highest` and `lowest` are values with sign, at the crank angles
    `highest_angle` and `lowest_angle` in [0, cycle); `upper_bound` is the sum of magnitudes, which
    bounds the peak for any phases; `error` is absolute, of peak, half range, highest and lowest.
    """

    peak: FloatArray
    half_range: FloatArray
    highest: FloatArray
    highest_angle: FloatArray
    lowest: FloatArray
    lowest_angle: FloatArray
    upper_bound: FloatArray
    error: FloatArray


def synthesis(order: ArrayLike, amplitude: ArrayLike, error: ArrayLike = 0.0) -> Synthesis:
    """Highest and lowest value over the cycle of all orders.

    Parameters
    ----------
    order : array (m,)
        Whole or half orders, 0 or above, in any sequence; the cycle is two turns if any is half.
        Of order 0, the mean, the real part counts.
    amplitude : complex array (..., m)
        0-to-peak.
    error : array (..., m)
        Absolute errors of the amplitudes; they add up in `error`.

    Raises
    ------
    NumericalFailure
        An amplitude is not finite, or an order is not a multiple of 1/2.
    """
    orders, values = np.asarray(order, dtype=float), np.asarray(amplitude, dtype=np.complex128)
    doubled = np.rint(2.0 * orders).astype(np.int64)
    if np.any(doubled != 2.0 * orders) or np.any(orders < 0.0):
        raise NumericalFailure("sum over orders: an order is not a multiple of 1/2, 0 or above")
    shape = values.shape[:-1]
    if not np.all(doubled):
        values = np.where(doubled == 0, values.real, values)
    rows = values.reshape(-1, len(orders))
    turns = 2 if np.any(doubled % 2) else 1
    number = doubled * turns // 2
    size = np.abs(rows)
    bound = np.sum(size, axis=-1)
    if not np.all(np.isfinite(bound)):
        raise NumericalFailure("sum over orders: an amplitude is not a finite number")
    scale = np.where(bound > 0.0, np.ldexp(1.0, np.clip(np.frexp(bound)[1], -1000, 1000)), 1.0)
    highest, lowest = np.zeros(len(rows)), np.zeros(len(rows))
    at_highest, at_lowest = np.zeros(len(rows)), np.zeros(len(rows))
    top = int(number.max(initial=0))
    moving = np.flatnonzero(bound > 0.0) if top else np.zeros(0, dtype=np.int64)
    if len(moving):
        cycle = cycle_of(tuple(number.tolist()))
        block = max(1, BLOCK // cycle.samples)
        open_rows: dict[float, list[IntArray]] = {1.0: [], -1.0: []}
        for start in range(0, len(moving), block):
            part = moving[start : start + block]
            # a power of two: its reciprocal is exact
            less = 1.0 / scale[part, None]
            scaled = rows[part] * less
            up, down = settled(scaled, size[part] * less, cycle)
            for one, sign, value, place in (
                (up, 1.0, highest, at_highest),
                (down, -1.0, lowest, at_lowest),
            ):
                value[part], place[part] = one.value, one.place
                rest = np.flatnonzero(~one.certain)
                if len(rest):
                    open_rows[sign].append(part[rest])
        for sign, value, place in ((1.0, highest, at_highest), (-1.0, lowest, at_lowest)):
            if open_rows[sign]:
                rest = np.concatenate(open_rows[sign])
                scaled = sign * rows[rest] / scale[rest, None]
                value[rest], place[rest] = _searched(scaled, number, top)
    if top:
        highest, lowest = highest * scale, -lowest * scale
    else:
        highest = lowest = np.sum(rows.real, axis=-1)
    peak = np.maximum(np.abs(highest), np.abs(lowest))
    doubt = np.broadcast_to(error, values.shape).reshape(rows.shape).sum(axis=-1)
    parts = (
        peak, 0.5 * (highest - lowest), highest, at_highest * turns, lowest, at_lowest * turns,
        bound, doubt + 8.0 * EPSILON * bound,
    )  # fmt: skip
    return Synthesis(*(np.reshape(one, shape) for one in parts))


def _searched(rows: ComplexArray, number: IntArray, top: int) -> tuple[FloatArray, FloatArray]:
    """Highest values by branch and bound, where a look at the cells does not settle them."""
    samples = 1 << math.ceil(math.log2(SAMPLES_PER_ORDER * top))
    return _highest(rows, number, top, _sampled(rows, number, top, samples))


def _sampled(rows: ComplexArray, number: IntArray, top: int, samples: int) -> FloatArray:
    """The signals at `samples` equal steps of the cycle, (r, samples)."""
    spectrum = np.zeros((len(rows), top + 1), dtype=np.complex128)
    for place, one in enumerate(number.tolist()):
        spectrum[:, one] += rows[:, place] * (1.0 if one == 0 else 0.5)
    return np.asarray(np.fft.irfft(spectrum, samples, axis=-1) * samples)


def _highest(
    rows: ComplexArray, number: IntArray, top: int, sampled: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Highest values of signals whose size is below 1, and where in a cycle of 2 pi."""
    samples = sampled.shape[1]
    half = math.pi / samples
    best = sampled.max(axis=1)
    bend = np.abs(rows) @ (number.astype(float) ** 2)
    lowest = best - 0.5 * half**2 * bend - 16.0 * EPSILON
    row, sample = np.divmod(np.flatnonzero(sampled >= lowest[:, None]), samples)
    roots = np.exp(2.0j * math.pi * np.arange(samples) / samples)
    local = rows[row].T * roots[(number[:, None] * sample) % samples]
    # a constant of 1 makes the signal positive, so that the longest length is the highest value
    local = np.concatenate([local, np.ones((1, len(row)))])[:, None, :]
    ratios = np.append(number / top, 0.0)
    centre = sample * (2.0 * math.pi * top / samples)
    cells = Cells.about(local, ratios, row, centre)
    length, position = search(cells, (1.0 + best) ** 2, half * top, 2.0 * math.pi * top)
    return length - 1.0, position / top


# ----------------------------------------------------------------------------
# Highest values of many signals over a cycle, where a look at few places settles it.
#
# Signals are sampled in single precision: that tells which samples can be next to the maximum.
# About those the signal is a Taylor polynomial in double precision. Where its second derivative is
# below zero all over the cell, Newton's method on the slope finds the one maximum that the cell
# has. Rows in which some cell is not so simple are named, for a search by branch and bound.
# ----------------------------------------------------------------------------

#: least number of samples in a period of the highest order, and degree that is exact within a cell
CELL_SAMPLES_PER_ORDER = 8
DEGREE = 14
#: rounding of a sample in single precision, for a signal whose amplitudes sum up to 1
SINGLE = 1e-5
NEWTON, ENOUGH = 12, 1e-8


class Settled(NamedTuple):
    """Of rows (r,): highest value, its place in [0, 2 pi), and whether that is certain."""

    value: FloatArray
    place: FloatArray
    certain: BoolArray


class Cycle(NamedTuple):
    """Harmonics (m,) of a cycle of 2 pi, the highest of them, the number of samples.

    `in_sequence`: each harmonic is one above the one before it.

    `turned` (samples, m) brings a sample to the angle zero, `powers` (2 m, degree + 1) makes Taylor
    coefficients there from real and imaginary parts.
    """

    number: IntArray
    top: int
    samples: int
    in_sequence: bool
    turned: ComplexArray
    powers: FloatArray


@lru_cache(maxsize=8)
def cycle_of(number: tuple[int, ...]) -> Cycle:
    """For harmonics whose highest is above zero."""
    numbers, top = np.array(number), max(number)
    samples = even_smooth(CELL_SAMPLES_PER_ORDER * top)
    roots = np.exp(2.0j * math.pi * np.arange(samples) / samples)
    turned = roots[(np.arange(samples)[:, None] * numbers) % samples]
    power = np.arange(DEGREE + 1)
    factorial = np.array([float(math.factorial(m)) for m in power.tolist()])
    weight = (1j ** (power % 4) / factorial) * (numbers / top)[:, None] ** power
    powers = np.stack([weight.real, -weight.imag], axis=1).reshape(2 * len(numbers), -1)
    in_sequence = bool(np.all(np.diff(numbers) == 1))
    return Cycle(numbers, top, samples, in_sequence, turned, powers)


def even_smooth(least: int) -> int:
    """The first even number from `least` on whose prime factors are 2, 3 and 5."""
    count = max(2, least + least % 2)
    while True:
        rest = count
        for prime in (2, 3, 5):
            while rest % prime == 0:
                rest //= prime
        if rest == 1:
            return count
        count += 2


def settled(rows: ComplexArray, size: FloatArray, cycle: Cycle) -> tuple[Settled, Settled]:
    """Highest values of the signals (r, m) and of their negatives.

    `size` (r, m) are the magnitudes, which sum up to below 1.
    """
    spectrum = np.zeros((len(rows), cycle.top + 1), dtype=np.complex64)
    if cycle.in_sequence:
        first = int(cycle.number[0])
        np.multiply(rows, 0.5 * cycle.samples, out=spectrum[:, first:], casting="same_kind")
    else:
        for place, one in enumerate(cycle.number.tolist()):
            spectrum[:, one] += rows[:, place] * (0.5 * cycle.samples)
    spectrum[:, 0] *= 2.0
    sampled = np.fft.irfft(spectrum, cycle.samples, axis=-1)
    scaled = cycle.number / cycle.top
    # of the variable top times angle: derivatives have about the size of the signal
    bend = size @ scaled**2
    half = math.pi * cycle.top / cycle.samples
    slack = 0.5 * half**2 * bend + 2.0 * SINGLE
    high = sampled >= (sampled.max(axis=1) - slack)[:, None]
    low = sampled <= (sampled.min(axis=1) + slack)[:, None]
    return (
        _tops(rows, cycle, np.flatnonzero(high), half, 1.0),
        _tops(rows, cycle, np.flatnonzero(low), half, -1.0),
    )


def _tops(
    rows: ComplexArray,
    cycle: Cycle,
    chosen: IntArray,
    half: float,
    sign: float,
) -> Settled:
    """Highest values from the cells about `chosen` samples, in the sequence of the rows."""
    row, sample = np.divmod(chosen, cycle.samples)
    local = rows[row]
    local *= cycle.turned[sample]
    taylor = (sign * cycle.powers).T @ local.view(np.float64).T
    start = np.searchsorted(row, np.arange(len(rows)))
    best = np.maximum.reduceat(taylor[0], start)
    power = np.arange(3, DEGREE + 1)
    reach = np.maximum(taylor[2], 0.0) * half**2 + half**power @ np.abs(taylor[3:])
    possible = taylor[0] + half * np.abs(taylor[1]) + reach >= best[row] - 4.0 * EPSILON
    taylor, row, sample = taylor[:, possible], row[possible], sample[possible]
    bend = (power * (power - 1) * half ** (power - 2)) @ np.abs(taylor[3:])
    concave = 2.0 * taylor[2] + bend < 0.0
    at, found = _newton(taylor, half)
    simple = concave & found
    certain = np.ones(len(rows), dtype=bool)
    certain[row[~simple]] = False
    value = _at(taylor, at)
    start = np.searchsorted(row, np.arange(len(rows)))
    highest = np.maximum.reduceat(value, start)
    centre = sample * (2.0 * math.pi * cycle.top / cycle.samples)
    place = centre + at
    # a summit at zero may come out as a rounding below it
    place = np.where((place < 0.0) & (place > -1e-7), 0.0, place)
    place = np.where(place < 0.0, place + 2.0 * math.pi * cycle.top, place)
    reached = value >= highest[row] - 8.0 * EPSILON
    first = np.minimum.reduceat(np.where(reached, place, np.inf), start)
    return Settled(highest, first / cycle.top, certain)


def _newton(taylor: FloatArray, half: float) -> tuple[FloatArray, BoolArray]:
    """Where the slopes (k,) of concave polynomials vanish, or the end to which they rise."""
    power = np.arange(1, DEGREE + 1)[:, None]
    slope = taylor[1:] * power
    bend = slope[1:] * power[:-1]
    falls = np.where(bend[0] < 0.0, bend[0], -1.0)
    at = np.clip(-slope[0] / falls, -half, half)
    moved = np.full(at.shape, np.inf)
    for _ in range(NEWTON):
        curvature = _at(bend, at)
        step = _at(slope, at) / np.where(curvature < 0.0, curvature, -1.0)
        target = np.clip(at - step, -half, half)
        moved, at = np.abs(target - at), target
        # the next step would be of the square of this one
        if float(np.max(moved, initial=0.0)) <= ENOUGH:
            break
    return at, moved <= ENOUGH


def _at(coefficients: FloatArray, place: FloatArray) -> FloatArray:
    """Polynomials (degree + 1, k) at one place (k,) each."""
    value = coefficients[-1] * place
    for one in coefficients[-2:0:-1]:
        value += one
        value *= place
    value += coefficients[0]
    return np.asarray(value)
