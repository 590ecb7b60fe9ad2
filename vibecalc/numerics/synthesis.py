"""Sum of all orders with their phases over a cycle: highest and lowest value to rounding."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.cycle_peak import cycle_peak, horner
from vibecalc.numerics.rounding import (
    EPSILON,
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    distinct,
)

# ----------------------------------------------------------------------------
# Sum of all orders with their phases over one cycle: highest and lowest value, exact to rounding.
#
# The orders are sampled by a Fourier transform. Between its samples a signal cannot rise by more
# than its largest curvature allows, so that only the few samples within that of the highest one can
# be next to the maximum; about them the signal is searched as Taylor polynomials: by Newton's
# method where a peak is simple, else by branch and bound (`cycle_peak`).
# ----------------------------------------------------------------------------

#: rows that are worked on at once, and samples of them: these stay in the cache
ROWS, BLOCK = 1 << 12, 1 << 17


class Synthesis(NamedTuple):
    """Of x(theta) = Re sum_q X_q exp(i q theta), arrays (...).

    `peak` is the largest |x|; `half_range` is (highest - lowest) / 2, what class rules call the
    vibratory amplitude; `highest` and `lowest` are values with sign, at the crank angles
    `highest_angle` and `lowest_angle` in [0, cycle); `upper_bound` is the sum of magnitudes, which
    bounds the peak for any phases; `error` is the rounding of peak, half range, highest and lowest.
    """

    peak: FloatArray
    half_range: FloatArray
    highest: FloatArray
    highest_angle: FloatArray
    lowest: FloatArray
    lowest_angle: FloatArray
    upper_bound: FloatArray
    error: FloatArray


class Cycles(NamedTuple):
    """Orders (m,) by the cycle that each repeats in.

    `group` (m,) counts the cycles from 0, that of the crank; `own` (m,) are the multiples of 1/2
    in the turns of the group. A shaft behind a gear has a cycle of its own, which meets that of
    the crank in every phase after turns enough.
    """

    own: FloatArray
    group: IntArray

    def some(self, chosen: BoolArray) -> "Cycles":
        """Of some of the orders."""
        return Cycles(self.own[chosen], self.group[chosen])


def synthesis(order: ArrayLike | Cycles, amplitude: ArrayLike) -> Synthesis:
    """Highest and lowest value over the cycle of all orders.

    Parameters
    ----------
    order : array (m,), or Cycles
        Whole or half orders, 0 or above, in any sequence; the cycle is two turns if any is half.
        Of order 0, the mean, the real part counts. Of several cycles the highest values meet, and
        so do the lowest; the angles are those of the first.
    amplitude : complex array (..., m)
        0-to-peak.

    Raises
    ------
    NumericalFailure
        An amplitude is not finite, or an order is not a multiple of 1/2.
    """
    values = np.asarray(amplitude, dtype=np.complex128)
    if not isinstance(order, Cycles):
        return _one_cycle(np.asarray(order, dtype=float), values)
    groups = distinct(order.group)
    if len(groups) < 2:
        return _one_cycle(order.own, values)
    first, *others = (
        _one_cycle(order.own[order.group == one], values[..., order.group == one]) for one in groups
    )
    for one in others:
        highest, lowest = first.highest + one.highest, first.lowest + one.lowest
        first = first._replace(
            peak=np.maximum(np.abs(highest), np.abs(lowest)),
            half_range=first.half_range + one.half_range,
            highest=highest,
            lowest=lowest,
            upper_bound=first.upper_bound + one.upper_bound,
            error=first.error + one.error,
        )
    return first


def _one_cycle(orders: FloatArray, values: ComplexArray) -> Synthesis:
    """Of orders (m,) that repeat together."""
    doubled = np.rint(2.0 * orders).astype(np.int64)
    if np.any(doubled != 2.0 * orders) or np.any(orders < 0.0):
        raise NumericalFailure("sum over orders: an order is not a multiple of 1/2, 0 or above")
    shape = values.shape[:-1]
    if not np.all(doubled):
        values = np.where(doubled == 0, values.real, values)
    rows = np.ascontiguousarray(values.reshape(-1, len(orders)))
    turns = 2 if np.any(doubled % 2) else 1
    number = doubled * turns // 2
    size = np.abs(rows)
    bound = np.sum(size, axis=-1)
    if not np.all(np.isfinite(bound)):
        raise NumericalFailure("sum over orders: an amplitude is not a finite number")
    scale = np.where(bound > 0.0, np.ldexp(1.0, np.clip(np.frexp(bound)[1], -1000, 1000)), 1.0)
    top = int(number.max(initial=0))
    # of the signals and of their negatives
    value, place = np.zeros((2, len(rows))), np.zeros((2, len(rows)))
    left = np.flatnonzero(bound > 0.0) if top else np.zeros(0, dtype=np.int64)
    if len(left):
        cycle = cycle_of(tuple(number.tolist()))
        certain = np.ones((2, len(rows)), dtype=bool)
        for start in range(0, len(left), ROWS):
            # without a row that is zero, none has to be copied
            every = len(left) == len(rows)
            part = slice(start, start + ROWS) if every else left[start : start + ROWS]
            # a power of two: its reciprocal is exact
            less = 1.0 / scale[part, None]
            highest_of = settled(rows[part] * less, size[part] * less, cycle)
            value[:, part], place[:, part], certain[:, part] = highest_of
        sign, part = np.nonzero(~certain)
        if len(part):
            less = (1.0 - 2.0 * sign[:, None]) / scale[part, None]
            value[sign, part], place[sign, part] = _raised(rows[part] * less, number)
    highest, lowest = value * scale
    at_highest, at_lowest = place * turns
    lowest = -lowest
    if not top:
        highest = lowest = np.sum(rows.real, axis=-1)
    peak = np.maximum(np.abs(highest), np.abs(lowest))
    parts = (
        peak, 0.5 * (highest - lowest), highest, at_highest, lowest, at_lowest, bound,
        8.0 * EPSILON * bound,
    )  # fmt: skip
    return Synthesis(*(np.reshape(one, shape) for one in parts))


def sum_error(amplitude: Bounded, axis: int = -1) -> FloatArray:
    """Of a sum of all orders: their errors have no common sign."""
    whole = np.sqrt(np.sum(np.square(amplitude.error), axis=axis))
    return np.asarray(whole + 8.0 * EPSILON * np.abs(amplitude.value).sum(axis=axis))


class OverCycle(NamedTuple):
    """Of all orders together, with their phases, over the cycle; `bound` for any phases."""

    peak: Bounded
    half_range: Bounded
    highest: Bounded
    lowest: Bounded
    bound: Bounded


def over_cycle(order: FloatArray | Cycles, amplitude: Bounded) -> OverCycle:
    """Of amplitudes (..., m)."""
    found, error = synthesis(order, amplitude.value), sum_error(amplitude)
    values = (found.peak, found.half_range, found.highest, found.lowest, found.upper_bound)
    return OverCycle(*(Bounded(value, error) for value in values))


def _raised(rows: ComplexArray, number: IntArray) -> tuple[FloatArray, FloatArray]:
    """Highest values of signals whose size is below 1, as peaks of positive ones, and where."""
    raised = np.concatenate([rows, np.ones((len(rows), 1))], axis=1)
    found = cycle_peak(raised, np.append(number, 0))
    return found.value - 1.0, found.angle


# ----------------------------------------------------------------------------
# Highest values of many signals over a cycle, where samples at few places settle it.
#
# Signals are sampled in single precision: that tells which samples can be next to the maximum.
# Where these stand about one that is higher than its neighbours, a Taylor polynomial in double
# precision, about a place next to that peak, tells it. Where the second derivative is below zero
# all over what is examined, Newton's method on the slope finds the one maximum that it has. Rows
# that are not so simple are named, for a search by branch and bound.
# ----------------------------------------------------------------------------

#: least number of samples in a period of the highest order
SAMPLES_PER_ORDER = 8
#: degree of polynomials about places next to a peak, and number of these in a step of the samples
DEGREE, PLACES = 7, 32
#: harmonics times samples up to which a product with a matrix takes less time than a transform
WAVES = 1 << 14
#: rounding of a sample in single precision, for a signal whose amplitudes sum up to 1
SINGLE = 1e-5
NEWTON, ENOUGH = 2, 1e-8
#: distance below zero, of the highest order's angle, at which a peak counts as at zero
HARDLY = 1e-7


class SignalPeak(NamedTuple):
    """Of signals (..., r): highest value, its place in [0, 2 pi), and whether that is certain.

    The axis in front, where there is one, is that of the signals and of their negatives.
    """

    value: FloatArray
    place: FloatArray
    certain: BoolArray


class Cycle(NamedTuple):
    """Harmonics (m,) of a cycle of 2 pi, the highest of them, the number of samples.

    `in_sequence`: each harmonic is one above the one before it.
    `waves` (2 m, samples) makes samples in single precision from real and imaginary parts; None
    where a Fourier transform does it in less time.

    `turned` (samples, m) brings a sample to the angle zero, `powers` (2 m, degree + 1) makes Taylor
    coefficients there from real and imaginary parts. `nearby` (`PLACES` + 1, m) brings places about
    a sample, from half a step before it on, to it; `moments` (m, 2) are the harmonics, over the
    highest, to the power of two and of the first degree that is left out about peaks.
    """

    number: IntArray
    top: int
    samples: int
    in_sequence: bool
    waves: FloatArray | None
    turned: ComplexArray
    powers: FloatArray
    nearby: ComplexArray
    moments: FloatArray


@lru_cache(maxsize=8)
def cycle_of(number: tuple[int, ...]) -> Cycle:
    """For harmonics whose highest is above zero."""
    numbers, top = np.array(number), max(number)
    samples = even_smooth(SAMPLES_PER_ORDER * top)
    roots = np.exp(2.0j * math.pi * np.arange(samples) / samples)
    turned = roots[(np.arange(samples)[:, None] * numbers) % samples]
    power = np.arange(DEGREE + 1)
    factorial = np.array([float(math.factorial(m)) for m in power.tolist()])
    scaled = numbers / top
    weight = (1j ** (power % 4) / factorial) * scaled[:, None] ** power
    powers = np.stack([weight.real, -weight.imag], axis=1).reshape(2 * len(numbers), -1)
    in_sequence = bool(np.all(np.diff(numbers) == 1))
    waves = None
    if len(numbers) * samples <= WAVES:
        waves = np.stack([turned.real.T, -turned.imag.T], axis=1).reshape(-1, samples)
        waves = waves.astype(np.float32)
    offset = (np.arange(PLACES + 1) / PLACES - 0.5) * (2.0 * math.pi / samples)
    nearby = np.exp(1j * offset[:, None] * numbers)
    moments = np.stack([scaled**2, scaled ** (DEGREE + 1)], axis=1)
    return Cycle(numbers, top, samples, in_sequence, waves, turned, powers, nearby, moments)


def even_smooth(least: int) -> int:
    """The first even number from `least` on whose prime factors are 2, 3 and 5."""
    count = max(2, least + least % 2)
    while True:
        cofactor = count
        for prime in (2, 3, 5):
            while cofactor % prime == 0:
                cofactor //= prime
        if cofactor == 1:
            return count
        count += 2


def settled(rows: ComplexArray, size: FloatArray, cycle: Cycle) -> SignalPeak:
    """Highest values of the signals (r, m) and of their negatives, from the peaks of samples.

    `size` (r, m) are the magnitudes, which sum up to below 1.
    """
    bend, beyond = (size @ cycle.moments).T
    block = max(1, BLOCK // cycle.samples)
    parts = []
    for start in range(0, len(rows), block):
        part = slice(start, start + block)
        parts.append(_peaks(start, *_single(rows[part], bend[part], cycle)))
    peaks = _Peaks(*(np.concatenate(one, axis=-1) for one in zip(*parts, strict=True)))
    return _about(rows, cycle, peaks, beyond)


def sampled_roughly(rows: ComplexArray, cycle: Cycle) -> FloatArray:
    """Samples (r, s) in single precision of signals whose amplitudes sum up to about 1."""
    if cycle.waves is not None:
        return np.asarray(rows.astype(np.complex64).view(np.float32) @ cycle.waves)
    spectrum = np.zeros((len(rows), cycle.top + 1), dtype=np.complex64)
    if cycle.in_sequence:
        part = spectrum[:, int(cycle.number[0]) :]
        np.multiply(rows, 0.5 * cycle.samples, out=part, casting="same_kind")
    else:
        for place, one in enumerate(cycle.number.tolist()):
            spectrum[:, one] += rows[:, place] * (0.5 * cycle.samples)
    spectrum[:, 0] *= 2.0
    return np.asarray(np.fft.irfft(spectrum, cycle.samples, axis=-1))


def _single(
    rows: ComplexArray, bend: FloatArray, cycle: Cycle
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Samples (r, s) in single precision, and next to which of them the extremes can be.

    `bend` (r,) bounds the second derivatives. Values (2, r) of signals and of negatives that those
    samples are not below, and the places of both kinds in the flat samples.
    """
    sampled = sampled_roughly(rows, cycle)
    # of the variable top times angle: derivatives have about the size of the signal
    half = math.pi * cycle.top / cycle.samples
    slack = (0.5 * half**2 * bend + 2.0 * SINGLE).astype(sampled.dtype)
    least, most = sampled.max(axis=1) - slack, sampled.min(axis=1) + slack
    high = np.flatnonzero(sampled >= least[:, None])
    low = np.flatnonzero(sampled <= most[:, None])
    return sampled, np.stack([least, -most]), high, low


class _Peaks(NamedTuple):
    """Samples (k,) that are higher than their neighbours, of signals and of their negatives.

    Row, number in it, 1 or -1 for a negative, vertex of the parabola through the sample and its
    neighbours, in steps; steps that have to be examined on both sides. `alone` (2, r): no sample
    of the signal, or of its negative, matters that is not within those.
    """

    row: IntArray
    sample: IntArray
    sign: FloatArray
    vertex: FloatArray
    before: FloatArray
    after: FloatArray
    alone: BoolArray


def _peaks(
    start: int, sampled: FloatArray, bound: FloatArray, high: IntArray, low: IntArray
) -> _Peaks:
    """Of samples (r, s) of rows from `start` on; the others are those of `_single`."""
    count, samples = sampled.shape
    chosen = np.concatenate([high, low])
    row = chosen // samples
    begin = row * samples
    sample = chosen - begin
    down = np.zeros(len(chosen), dtype=np.int64)
    down[len(high) :] = 1
    sign = (1 - 2 * down).astype(sampled.dtype)
    flat, round_about = sampled.reshape(-1), np.arange(-2, samples + 2) % samples

    def neighbour(which: IntArray | slice, steps: int) -> FloatArray:
        at = round_about[sample[which] + (steps + 2)]
        at += begin[which]
        return np.asarray(flat[at] * sign[which])

    here, before, after = flat[chosen] * sign, neighbour(np.s_[:], -1), neighbour(np.s_[:], 1)
    is_peak = (here > before) & (here >= after)
    top, others = np.flatnonzero(is_peak), np.flatnonzero(~is_peak)
    alone = np.zeros((2, count), dtype=bool)
    alone[down[top], row[top]] = True
    # what is no peak itself is next to one, and so within what is examined there
    nearby = (before[others] > neighbour(others, -2)) & (before[others] >= here[others])
    nearby |= (after[others] > here[others]) & (after[others] >= neighbour(others, 2))
    far = others[~nearby]
    alone[down[far], row[far]] = False
    here, before, after = here[top], before[top], after[top]
    bend = (before - here) + (after - here)
    vertex = 0.5 * (before - after) / np.where(bend < 0.0, bend, -np.inf)
    # rounding may put it further away where the samples are nearly alike
    vertex = np.clip(vertex, -0.5, 0.5)
    least = bound[down[top], row[top]]
    to_left, to_right = (np.where(one >= least, 1.5, 0.5) for one in (before, after))
    return _Peaks(row[top] + start, sample[top], sign[top], vertex, to_left, to_right, alone)


def _about(rows: ComplexArray, cycle: Cycle, peaks: _Peaks, left_out: FloatArray) -> SignalPeak:
    """Highest values of signals (r, m) and of their negatives, where their peaks settle them.

    `left_out` (r,) bounds the first derivative that the polynomials have no more.
    """
    row, whole = peaks.row, 2.0 * math.pi * cycle.top
    # signals of a block, then their negatives, and so on: of each all peaks in sequence
    group = np.where(peaks.sign < 0.0, row + len(rows), row)
    place = np.rint((peaks.vertex + 0.5) * PLACES).astype(np.int64)
    powers = np.ascontiguousarray(cycle.powers.T)
    taylor = np.empty((DEGREE + 1, len(row)))
    block = max(1, BLOCK // cycle.powers.size)
    for start in range(0, len(row), block):
        part = slice(start, start + block)
        local = rows[row[part]]
        local *= cycle.turned[peaks.sample[part]]
        local *= cycle.nearby[place[part]]
        np.matmul(powers, local.view(np.float64).T, out=taylor[:, part])
    taylor *= peaks.sign
    step = whole / cycle.samples
    offset = (place / PLACES - 0.5) * step
    begin, end = -peaks.before * step - offset, peaks.after * step - offset
    at, converged = _newton(taylor, begin, end)
    value = horner(taylor, at)
    power = np.arange(2, DEGREE + 2)
    tail = left_out[row] / math.factorial(DEGREE + 1)
    far = np.maximum(-begin, end)
    size = np.concatenate([taylor[2:3], np.abs(taylor[3:]), tail[None]])
    converged &= tail * np.abs(at) ** (DEGREE + 1) <= 0.25 * EPSILON
    converged &= horner(size * (power * (power - 1))[:, None], far) < 0.0
    first = np.flatnonzero(np.diff(group, prepend=-1))
    value = np.where(converged, value, -np.inf)
    highest = np.full(2 * len(rows), -np.inf)
    highest[group[first]] = np.maximum.reduceat(value, first) if len(first) else 0.0
    certain = peaks.alone.reshape(-1) & np.isfinite(highest)
    open_ = np.flatnonzero(~converged)
    size[0] = np.maximum(size[0], 0.0)
    reach = np.abs(taylor[1, open_]) + far[open_] * horner(size[:, open_], far[open_])
    reach = taylor[0, open_] + far[open_] * reach
    certain[group[open_[reach >= highest[group[open_]] - 4.0 * EPSILON]]] = False
    spot = peaks.sample * step + (offset + at)
    spot += np.where(spot < -HARDLY, whole, 0.0)
    spot -= np.where(spot >= whole - HARDLY, whole, 0.0)
    reached = value >= highest[group] - 8.0 * EPSILON
    nearest = np.zeros(len(highest))
    if len(first):
        spot = np.where(reached, np.maximum(spot, 0.0), np.inf)
        nearest[group[first]] = np.minimum.reduceat(spot, first)
    nearest /= cycle.top
    return SignalPeak(highest.reshape(2, -1), nearest.reshape(2, -1), certain.reshape(2, -1))


def _newton(taylor: FloatArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Where the slopes (k,) of concave polynomials vanish, or the end to which they rise."""
    power = np.arange(1, len(taylor))[:, None]
    slope = taylor[1:] * power
    bend = slope[1:] * power[:-1]
    falls = np.where(bend[0] < 0.0, bend[0], -1.0)
    at = np.clip(-slope[0] / falls, low, high)
    at = np.clip(at - at * at * (slope[2] + at * slope[3]) / falls, low, high)
    moved = np.full(at.shape, np.inf)
    for _ in range(NEWTON):
        curvature = horner(bend, at)
        step = horner(slope, at) / np.where(curvature < 0.0, curvature, -1.0)
        target = np.clip(at - step, low, high)
        moved, at = np.abs(target - at), target
        # the next step would be of the square of this one
        if float(np.max(moved, initial=0.0)) <= ENOUGH:
            break
    return at, moved <= ENOUGH
