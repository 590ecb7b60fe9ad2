"""How the cylinders of an engine add up in each mode, order by order."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.excitation.cylinder_torque import phasor
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import BoolArray, ComplexArray, FloatArray

#: a sum that lacks less than this of all vectors in line counts as major
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

    `shape` (k, c) is the amplitude of every mode at each cylinder's station, times what scales the
    cylinder if it is not one of equals.
    """
    amplitude = np.asarray(shape, dtype=float)
    turned = phasor(order, firing_angle)
    value = amplitude @ turned.T
    size = np.abs(amplitude).sum(axis=-1, keepdims=True)
    error = np.broadcast_to((3.0 + amplitude.shape[-1]) * EPSILON * size, value.shape)
    relative = np.abs(value) / np.where(size > 0.0, size, 1.0)
    return PhaseSums(value, np.minimum(relative, 1.0), error)


def major_orders(firing_angle: ArrayLike, order: ArrayLike) -> BoolArray:
    """Which orders (m,) find all cylinders in phase: the sum for a rigid mode has no loss.

    With even firing these are the multiples of the firings in one turn: 3, 6, 9 ... for six
    cylinders in four-stroke. Two banks that fire unevenly may have none.
    """
    firing = np.asarray(firing_angle, dtype=float)
    sums = phase_sums(np.ones((1, len(firing))), firing, order)
    return np.asarray(sums.relative[0] > 1.0 - IN_LINE)
