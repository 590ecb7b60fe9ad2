"""Roots of batches of polynomials on [0, 1], and the first time at which a gap leaves its side."""

from functools import cache
from itertools import pairwise
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
#: points up to which one call takes less time than one for each power; the products are the same
_FEW = 80


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
    """Number of changes along the first axis, of at most 128 entries."""
    changed = (positive[1:] != positive[:-1]).view(np.int8)
    return np.asarray(np.add.reduce(changed, axis=0, dtype=np.int8))


def in_order(terms: FloatArray) -> FloatArray:
    """Sum over the first axis, term after term whatever the shape or the layout."""
    if terms[0].size > 1 and terms.flags.c_contiguous:
        return np.asarray(np.add.reduce(terms, axis=0))  # row after row
    # here `np.sum` may pair some up
    return np.asarray(np.add.accumulate(terms, axis=0)[-1])


def powers(at: FloatArray, terms: int) -> FloatArray:
    """Powers 0 to `terms` - 1 (terms, n) of points (n,), each the one before times the point."""
    power = np.empty((terms, len(at)))
    power[0] = 1.0
    if len(at) <= _FEW:
        power[1:] = at
        return np.multiply.accumulate(power, axis=0, out=power)
    for before, now in pairwise(power):
        np.multiply(before, at, out=now)
    return power


def evaluate(coefficients: FloatArray, at: FloatArray) -> FloatArray:
    """Values of polynomials (terms, n) at points (n,)."""
    return in_order(np.ascontiguousarray(coefficients * powers(at, len(coefficients))))


def single_root(coefficients: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """The root of each polynomial (terms, n) in (start, end), where it changes sign once.

    Newton steps, with a bisection wherever one would leave the bracket or shrinks too slowly, to
    the last places of s or until the value is rounding. Each polynomial stops by itself, so that
    a root does not depend on its company. A polynomial whose values at both ends have one sign,
    by rounding, gives a point at one of the ends.
    """
    low, high = start.astype(np.float64), end.astype(np.float64)
    coefficients = np.ascontiguousarray(coefficients)
    sign = np.where(evaluate(coefficients, high) > 0.0, 1.0, -1.0)
    at, last = _guess(coefficients, low, high), high - low
    result, left = at.copy(), np.arange(len(at))
    terms = len(coefficients)
    # value, slope and sum of sizes are sums over one axis of these times the powers
    table = np.zeros((terms, 3, len(at)))
    table[:, 0] = coefficients
    np.multiply(np.arange(1.0, terms)[:, None], coefficients[1:], out=table[:-1, 1])
    np.abs(coefficients, out=table[:, 2])
    for _ in range(_MOST_ITERATIONS):
        value, slope, size = np.add.reduce(table * powers(at, terms)[:, None], axis=0)
        beyond = sign * value > 0.0
        low, high = np.where(beyond, low, at), np.where(beyond, at, high)
        with np.errstate(divide="ignore", invalid="ignore"):
            newton = at - value / slope
        good = (newton >= low) & (newton <= high) & (np.abs(newton - at) <= 0.5 * last)
        following = np.where(good, newton, 0.5 * (low + high))
        last = np.abs(following - at)
        rounding = np.abs(value) <= 4.0 * UNIT_ROUNDOFF * size
        done = rounding | (last <= 2.0 * EPSILON * at) | (high - low <= 2.0 * EPSILON * high)
        # a value that is all rounding says nothing of where to go next
        at = np.where(rounding, at, following)
        result[left] = at
        more = np.flatnonzero(~done)
        if not len(more):
            break
        if len(more) < len(left):
            left, table = left[more], table.take(more, axis=2)
            at, last, sign, low, high = (one[more] for one in (at, last, sign, low, high))
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
    inside = np.empty((len(shape), 2, *shape.shape[1:]), dtype=np.bool_)
    np.greater(shape, law.lower, out=inside[:, 0])
    np.less(shape, law.upper, out=inside[:, 1])
    which, run = np.nonzero(on_face)
    if len(run):
        # z = face + s q(s): q has the power coefficients 1, 2, .. of z
        above = on_face[which, run] > 0
        leaving = bernstein(series[1:, which, run])
        moving = np.where(above, leaving < 0.0, leaving > 0.0)
        moving = np.concatenate([moving, moving[-1:]])
        # at rest on a face the second coefficient decides
        moving[0] = np.where(series[1, which, run] == 0.0, moving[1], moving[0])
        inside[:, above.astype(np.int64), which, run] = moving

    # -1 beyond the lower face, 1 beyond the upper
    outside = inside[0, 0].view(np.int8) - inside[0, 1].view(np.int8)
    changes = sign_changes(inside)
    at_once = np.any(outside != 0, axis=0)
    unclear = np.any(changes > 1, axis=(0, 1)) & ~at_once
    halve = unclear & (level < DEEPEST)
    runs = series.shape[2]
    fraction = np.where(halve | at_once, 0.0, 1.0)
    gap = np.argmax(outside != 0, axis=0)
    direction = np.where(at_once, outside[gap, np.arange(runs)], 0)

    # crossings of a face: one change, or (deepest level) a last value outside
    crosses = ~(inside[-1] | halve | at_once)
    face, which, run = np.nonzero(crosses)
    if len(run):
        coefficients = np.array(series[:, which, run], order="C")
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
