"""Highest values of many signals over a cycle, where a look at few places settles it.

Signals are sampled in single precision: that tells which samples can be next to the maximum. About
those the signal is a Taylor polynomial in double precision. Where its second derivative is below
zero all over the cell, Newton's method on the slope finds the one maximum that the cell has. Rows
in which some cell is not so simple are named, for a search by branch and bound.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray, IntArray

#: least number of samples in a period of the highest order, and degree that is exact within a cell
SAMPLES_PER_ORDER = 8
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
    samples = even_smooth(SAMPLES_PER_ORDER * top)
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
