"""Roots of batches of polynomials on [0, 1], with a certificate of how many there are.

The coefficients of a polynomial in the Bernstein basis change sign at least as often as the
polynomial has roots in (0, 1), and the two numbers differ by an even one (G. Farin, Curves and
Surfaces for CAGD, variation diminishing). So no change means no root, one change exactly one.
"""

from functools import cache
from math import comb

import numpy as np

from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF
from vibecalc.numerics.typing import BoolArray, FloatArray, IntArray

_MOST_ITERATIONS = 200


@cache
def _bernstein_matrix(terms: int) -> FloatArray:
    degree = terms - 1
    matrix = [
        [comb(i, k) / comb(degree, k) if k <= i else 0.0 for k in range(terms)]
        for i in range(terms)
    ]
    return np.array(matrix)


@cache
def _half_matrices(terms: int) -> tuple[FloatArray, FloatArray]:
    """Matrices that take the coefficients of p(s) to those of p(s/2) and of p((1 + s)/2)."""
    first = np.diag(0.5 ** np.arange(terms))
    shift = np.array([[float(comb(k, j)) for k in range(terms)] for j in range(terms)])
    return first, shift @ first


def bernstein(coefficients: FloatArray) -> FloatArray:
    """Bernstein coefficients on [0, 1] of polynomials with power coefficients (terms, ...)."""
    terms = len(coefficients)
    flat = _bernstein_matrix(terms) @ coefficients.reshape(terms, -1)
    return flat.reshape(coefficients.shape)


def halves(coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Power coefficients (terms, n) of the two halves of [0, 1], each on [0, 1] again."""
    first, second = _half_matrices(len(coefficients))
    return first @ coefficients, second @ coefficients


def sign_changes(positive: BoolArray) -> IntArray:
    """Number of changes along the first axis."""
    return np.asarray(np.count_nonzero(positive[1:] != positive[:-1], axis=0))


def in_order(terms: FloatArray) -> FloatArray:
    """Sum over the first axis, term after term whatever the shape (`np.sum` pairs some up)."""
    return np.asarray(np.add.accumulate(terms, axis=0)[-1])


def evaluate(coefficients: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values and derivatives of polynomials (terms, n) at points (n,)."""
    power = np.ones_like(coefficients)
    power[1:] = at
    np.cumprod(power, axis=0, out=power)
    rank = np.arange(1.0, len(coefficients))[:, None]
    value = in_order(coefficients * power)
    slope = in_order(rank * coefficients[1:] * power[:-1])
    return value, slope


def single_root(coefficients: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """The root of each polynomial (terms, n) in (start, end), where it changes sign once.

    Newton steps, with a bisection wherever one would leave the bracket or shrinks too slowly, to
    the last places of s or until the value is rounding. Each polynomial stops by itself, so that
    a root does not depend on its company. A polynomial whose values at both ends have one sign,
    by rounding, gives a point at one of the ends.
    """
    low, high = start.astype(np.float64), end.astype(np.float64)
    sign = np.where(evaluate(coefficients, high)[0] > 0.0, 1.0, -1.0)
    at, last = _guess(coefficients, low, high), high - low
    result, left = at.copy(), np.arange(len(at))
    rank = np.arange(1.0, len(coefficients))[:, None]
    for _ in range(_MOST_ITERATIONS):
        power = np.ones_like(coefficients)
        power[1:] = at
        np.cumprod(power, axis=0, out=power)
        terms = coefficients * power
        value = in_order(terms)
        slope = in_order(rank * coefficients[1:] * power[:-1])
        beyond = sign * value > 0.0
        low, high = np.where(beyond, low, at), np.where(beyond, at, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = at - value / slope
        good = (newton >= low) & (newton <= high) & (np.abs(newton - at) <= 0.5 * last)
        following = np.where(good, newton, 0.5 * (low + high))
        last = np.abs(following - at)
        rounding = np.abs(value) <= 4.0 * UNIT_ROUNDOFF * in_order(np.abs(terms))
        done = rounding | (last <= 2.0 * EPSILON * at) | (high - low <= 2.0 * EPSILON * high)
        # a value that is all rounding says nothing of where to go next
        at = np.where(rounding, at, following)
        result[left] = at
        if np.all(done):
            break
        if np.any(done):
            more = ~done
            left, at, last, sign = left[more], at[more], last[more], sign[more]
            low, high, coefficients = low[more], high[more], coefficients[:, more]
    return result


def _guess(coefficients: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Where the Bernstein polygon crosses zero, if within (low, high), else the middle.

    Rounded to a few digits, so that the rounding of a matrix product leaves no trace in a root.
    """
    shape = bernstein(coefficients)
    positive = shape > 0.0
    rank = np.argmax(positive[1:] != positive[:-1], axis=0)
    run = np.arange(shape.shape[1])
    before, after = shape[rank, run], shape[rank + 1, run]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = before / (before - after)
    at = np.round((rank + part) / (len(shape) - 1) * 1024.0) / 1024.0
    return np.where((at > low) & (at < high), at, 0.5 * (low + high))
