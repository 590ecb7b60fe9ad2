"""How the cylinders of an engine add up in each mode, order by order."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.cylinder_torque import phasor
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray, IntArray

#: a sum that lacks less than this of all vectors in line counts as one of all in line
IN_LINE = 1e-9


class PhaseSums(NamedTuple):
    """Sums over the cylinders of shape times exp(-i q firing angle), per mode and order (k, m).

    `relative` is their size over the sum of all magnitudes: 1 for vectors in line, 0 where they
    cancel (and where no cylinder moves). `error` is that of `value`.
    """

    value: ComplexArray
    relative: FloatArray
    error: FloatArray


def phase_sums(shape: ArrayLike, firing_angle: ArrayLike, order: ArrayLike) -> PhaseSums:
    """Vector sums of c cylinders that fire at the angles (c,), in rad, at the orders (m,).

    `shape` (k, c) is the amplitude of every mode at each cylinder's station, real or complex, times
    what scales the cylinder if it is not one of equals.
    """
    amplitude = np.asarray(shape)
    turned = phasor(order, firing_angle)
    value = amplitude @ turned.T
    size = np.abs(amplitude).sum(axis=-1, keepdims=True)
    error = np.broadcast_to((3.0 + amplitude.shape[-1]) * EPSILON * size, value.shape)
    relative = np.abs(value) / np.where(size > 0.0, size, 1.0)
    return PhaseSums(value, np.minimum(relative, 1.0), error)


def bank_sums(firing_angle: ArrayLike, order: ArrayLike, bank: ArrayLike) -> ComplexArray:
    """Phase vectors of the c cylinders of each of b banks added up, (b, m); `bank` (c,) says which.

    Angles in rad; cylinders are of one bank where `bank`, as their bank angle, is the same.
    """
    banks = np.broadcast_to(np.asarray(bank, dtype=float), np.shape(firing_angle))
    own = banks == np.unique(banks)[:, None]
    return np.asarray(own.astype(float) @ phasor(order, firing_angle).T)


def bank_factor(
    firing_angle: ArrayLike, order: ArrayLike, bank: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """What the bank angle leaves of an order (m,): sum of the banks over that of their magnitudes.

    For two banks of even firing |cos(q d / 2)|, with d the angle between the firings of the two; 1
    for one bank, 0 where each bank cancels in itself. The second value is its error.
    """
    sums = bank_sums(firing_angle, order, bank)
    count = np.size(firing_angle)
    whole = np.abs(sums).sum(axis=0)
    some = whole > IN_LINE * count
    safe = np.where(some, whole, 1.0)
    found = np.where(some, np.abs(sums.sum(axis=0)) / safe, 0.0)
    error = np.where(some, 2.0 * (3.0 + count) * EPSILON * count / safe, 0.0)
    return np.minimum(found, 1.0), error


def major_orders(firing_angle: ArrayLike, order: ArrayLike, bank: ArrayLike = 0.0) -> BoolArray:
    """Which orders (m,) find the cylinders of each bank in phase, and the banks not against it.

    With even firing these are the multiples of the firings of a bank in one turn, 3, 6, 9 ... for
    six cylinders in four-stroke, but for those that the bank angle cancels (`bank_factor` 0).
    """
    banks = np.broadcast_to(np.asarray(bank, dtype=float), np.shape(firing_angle))
    count = np.array([np.count_nonzero(banks == one) for one in np.unique(banks)])
    sums = np.abs(bank_sums(firing_angle, order, banks))
    in_phase = np.all(sums > (1.0 - IN_LINE) * count[:, None], axis=0)
    return np.asarray(in_phase & (bank_factor(firing_angle, order, banks)[0] > IN_LINE))


def order_ranks(vector_sum: ArrayLike, error: ArrayLike) -> IntArray:
    """Place of each order (k, m) in its mode by the size of its vector sum, 1 for the largest.

    Sums that differ by no more than `IN_LINE` and their errors share a place; where a sum is zero
    to within that the place is 0.
    """
    size = np.abs(np.asarray(vector_sum))
    off = np.broadcast_to(error, size.shape) + IN_LINE
    rank = np.zeros(size.shape, dtype=np.int64)
    for own, doubt, places in zip(size, off, rank, strict=True):
        last, number = np.inf, 0
        for count, place in enumerate(np.argsort(-own, kind="stable").tolist(), start=1):
            if own[place] <= doubt[place]:
                break
            if own[place] < last - doubt[place]:
                last, number = own[place], count
            places[place] = number
    return rank
