"""Largest value of a periodic signal over its cycle, from its harmonics.

A signal of highest order N is sampled at M = 12 N angles. A sample nearest to the maximum cannot
lie below cos^2(pi N / M) times it (squares of the signal; M. Riesz 1914; Ehlich and Zeller 1964),
nor farther below it than the curvature allows. What is left, about two samples for each row, is
turned into Taylor polynomials about the sample, exact to rounding within the sample's cell. Cells
that cannot hold the maximum are dropped, in concave ones Newton finds it, the rest is divided
(branch and bound), so that no maximum is missed. N is of each row the highest order that, with
those above it, is more than rounding; what is left out counts as error.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.peak_cells import Cells, search
from vibecalc.numerics.peak_orders import kept_orders
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray

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
        kept, left_out = kept_orders(rows, order // step)
        value, angle = _by_highest(rows, order // step, size, kept)
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
    rows: ComplexArray, orders: IntArray, size: FloatArray, kept: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Peaks of rows (r, component, n), those with the same highest order together."""
    value, angle = np.zeros(len(rows)), np.zeros(len(rows))
    for highest in sorted(set(kept.tolist())):
        mine, used = np.flatnonzero(kept == highest), orders <= highest
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
