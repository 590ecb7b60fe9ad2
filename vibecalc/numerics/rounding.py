"""Types of arrays, and what rounding does to the numbers in them."""

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

# ----------------------------------------------------------------------------
# Names for the arrays that numerical functions take and return.
# ----------------------------------------------------------------------------

FloatArray: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]

# ----------------------------------------------------------------------------
# Values with their errors, how much a double-precision sum may be off, and what is too much.
# ----------------------------------------------------------------------------

#: largest relative error of one rounded operation
UNIT_ROUNDOFF = 2.0**-53

#: distance from 1 to the next double: twice that
EPSILON = 2.0 * UNIT_ROUNDOFF

#: roundings granted to data that an earlier stage formed (a moment of inertia from a box, say)
DATA_ROUNDINGS = 8

#: a response whose relative error estimate reaches this is refused: fewer than four digits remain
SINGULAR = 1e-4


def distinct(values: ArrayLike) -> FloatArray:
    """The values that differ, rising; `numpy.unique` by itself imports numpy's masked arrays."""
    return np.asarray(np.unique(np.asarray(values, dtype=float), return_index=True)[0])


#: shares of the largest up to which two results are equal: which of them comes first is no matter
#: of their last digits
_EQUAL = 1e-9


def first_of_largest(values: ArrayLike) -> int:
    """Place of the largest of values (n,), of those equal but for rounding the first one."""
    return int(firsts_of_largest(values, axis=0))


def firsts_of_largest(values: ArrayLike, axis: int) -> IntArray:
    """The same along an axis of values (...)."""
    size = np.asarray(values, dtype=float)
    largest = np.max(size, axis=axis, keepdims=True)
    slack = np.where(np.isfinite(largest), _EQUAL * np.abs(largest), 0.0)
    return np.asarray(np.argmax(size >= largest - slack, axis=axis))


def ranked(values: ArrayLike) -> IntArray:
    """Places of values (n,), the largest first; those equal but for rounding in their order."""
    size = np.asarray(values, dtype=float)
    order = np.argsort(-size, kind="stable")
    with np.errstate(invalid="ignore"):  # of two that have no end
        apart = -np.diff(size[order]) > _EQUAL * np.abs(size[order][:-1])
    group = np.cumsum(np.append(False, apart))[: order.size]  # none of no values
    return np.asarray(order[np.lexsort((order, group))])


def floats(*values: ArrayLike) -> tuple[FloatArray, ...]:
    """All values as arrays of doubles, of their own shapes."""
    return tuple(np.asarray(value, dtype=float) for value in values)


# ----------------------------------------------------------------------------
# Error-free transformations: a sum or product of doubles as a double plus its exact rounding.
#
# They cost a few operations and carry a result to about twice the working precision where one
# number is raised to a high power later on. Inputs must lie within 1e-140 and 1e300 in magnitude
# (zero is fine), or the low part loses its meaning to underflow or overflow.
# ----------------------------------------------------------------------------

_SPLITTER = 134217729.0  # 2**27 + 1


def two_sum(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sum and its rounding error; `first + second` equals the two results exactly.

    Source: Knuth, The Art of Computer Programming 2, section 4.2.2, theorem B.
    """
    total = first + second
    partner = total - first
    return total, (first - (total - partner)) + (second - partner)


def two_product(first: FloatArray, second: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Product and its rounding error; `first * second` equals the sum of the two exactly.

    Source: Dekker (1971), A floating-point technique for extending the available precision.
    """
    product = first * second
    first_high, first_low = _split(first)
    second_high, second_low = _split(second)
    rounding = first_high * second_high - product
    rounding = rounding + first_high * second_low + first_low * second_high
    return product, rounding + first_low * second_low


def compensated_sum(terms: Iterable[FloatArray]) -> FloatArray:
    """Sum as if taken in twice the working precision and rounded once.

    Source: Ogita, Rump and Oishi (2005), Accurate sum and dot product, algorithm 4.4.
    """
    total = lost = np.zeros(())
    for term in terms:
        total, rounding = two_sum(total, term)
        lost = lost + rounding
    return np.asarray(total + lost)


def _split(value: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two halves of 26 bits each, so that products of halves are exact."""
    scaled = _SPLITTER * value
    high = scaled - (scaled - value)
    return high, value - high
