"""Sum of all orders with their phases over one cycle: highest and lowest value, exact to rounding.

The orders are sampled by a Fourier transform. Between its samples a signal cannot rise by more than
its largest curvature allows, so that only the few samples within that of the highest one can be
next to the maximum; about them the signal is searched as Taylor polynomials: by Newton's method
where a cell is simple (`synthesis_cells.py`), else by branch and bound.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.peak_cells import Cells, search
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.torsion.synthesis_cells import cycle_of, settled

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
