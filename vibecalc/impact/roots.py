"""Roots of batches of polynomials on [0, 1], and the first time at which a gap leaves its side."""

from functools import cache
from math import comb
from typing import NamedTuple

import numpy as np

from vibecalc.impact.linkage import Law
from vibecalc.numerics.rounding import EPSILON, UNIT_ROUNDOFF, BoolArray, FloatArray, IntArray

# ----------------------------------------------------------------------------
# Roots of batches of polynomials on [0, 1], with a certificate of how many there are.
#
# The coefficients of a polynomial in the Bernstein basis change sign at least as often as the
# polynomial has roots in (0, 1), and the two numbers differ by an even one (G. Farin, Curves and
# Surfaces for CAGD, variation diminishing). So no change means no root, one change exactly one.
# ----------------------------------------------------------------------------

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


# ----------------------------------------------------------------------------
# When a gap leaves its side within a step: found for every run of a batch at once.
#
# The certificate of `roots.py` tells for each face whether the series crosses it never, once, or
# perhaps more often; in the last case the step is halved until it knows. So two crossings inside
# one step, or a graze, cannot be passed over.
# ----------------------------------------------------------------------------

#: halvings after which two crossings are closer together than rounding can tell
DEEPEST = 40


class Crossing(NamedTuple):
    """What happens in a step, for each run (A,).

    `fraction` of the step that is taken, (0, 1], or 0; `gap` the index of the gap that crosses a
    face at its end and `direction` -1 (its lower face), +1 (its upper) or 0 (no event); `halve` the
    runs whose step has to be halved first.
    """

    fraction: FloatArray
    gap: IntArray
    direction: IntArray
    halve: BoolArray


def first_crossing(series: FloatArray, law: Law, on_face: IntArray, level: IntArray) -> Crossing:
    """First face crossed by the gaps' series (terms, G, A).

    `on_face` (G, A) is -1 or +1 where a gap starts on its lower or upper face (the root at s = 0
    is then divided out), else 0. `level` (A,) counts the halvings so far. A gap that starts on
    the wrong side, or on its face and moving out, crosses at once: fraction 0.
    """
    shape = bernstein(series)
    # z = face + s q(s): q has the power coefficients 1, 2, .. of z
    leaving = bernstein(series[1:])
    leaving = np.concatenate([leaving, leaving[-1:]])
    inside_lower = np.where(on_face == -1, leaving > 0.0, shape > law.lower)
    inside_upper = np.where(on_face == 1, leaving < 0.0, shape < law.upper)
    # at rest on a face the second coefficient decides
    at_standstill = (on_face != 0) & (series[1] == 0.0)
    inside_lower[0] = np.where(at_standstill, inside_lower[1], inside_lower[0])
    inside_upper[0] = np.where(at_standstill, inside_upper[1], inside_upper[0])

    outside = np.where(inside_lower[0], 0, -1) + np.where(inside_upper[0], 0, 1)
    changes = np.stack([sign_changes(inside_lower), sign_changes(inside_upper)])
    at_once = np.any(outside != 0, axis=0)
    unclear = np.any(changes > 1, axis=(0, 1)) & ~at_once
    halve = unclear & (level < DEEPEST)
    runs = series.shape[2]
    fraction = np.where(halve | at_once, 0.0, 1.0)
    gap = np.argmax(outside != 0, axis=0)
    direction = np.where(at_once, outside[gap, np.arange(runs)], 0)

    # crossings of a face: one change, or (deepest level) a last value outside
    ends_out = np.stack([~inside_lower[-1], ~inside_upper[-1]])
    crosses = ends_out & ~(halve | at_once)
    face, which, run = np.nonzero(crosses)
    if len(run):
        coefficients = series[:, which, run].copy()
        coefficients[0] -= np.where(face == 0, law.lower[which, run], law.upper[which, run])
        started = on_face[which, run] == np.where(face == 0, -1, 1)
        coefficients[:-1, started] = coefficients[1:, started]
        coefficients[-1, started] = 0.0
        root = single_root(coefficients, np.zeros(len(run)), np.ones(len(run)))
        # of several crossings of one run the first wins: it is assigned last
        order = np.argsort(-root, kind="stable")
        face, which, run = face[order], which[order], run[order]
        fraction[run], gap[run], direction[run] = root[order], which, np.where(face == 0, -1, 1)
    return Crossing(fraction, gap, direction, halve)
