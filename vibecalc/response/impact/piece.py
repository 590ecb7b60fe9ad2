"""Integrals and the highest force of one smooth piece of motion, from its power series."""

import numpy as np

from vibecalc.numerics.typing import FloatArray
from vibecalc.response.impact.panels import DEGREE
from vibecalc.response.impact.roots import bernstein, evaluate, halves, sign_changes, single_root

#: halvings to tell apart the changes of sign of a force; what is left is 2^-20 of a piece
_DEEPEST = 20
#: points that bracket the extremes of a force
_SAMPLES = 33

_nodes, _weights = np.polynomial.legendre.leggauss(DEGREE + 1)
#: a Gauss rule on [0, 1] that is exact for products of two series
POINTS = 0.5 * (1.0 + _nodes)
WEIGHTS = 0.5 * _weights
_POWERS = POINTS[:, None] ** np.arange(DEGREE + 1)
_RANK = np.arange(1.0, DEGREE + 2.0)


def at_points(series: FloatArray) -> FloatArray:
    """Values (points, ...) of series (terms, ...) at POINTS."""
    terms = len(series)
    flat = _POWERS[:, :terms] @ series.reshape(terms, -1)
    return flat.reshape(len(POINTS), *series.shape[1:])


def mean(values: FloatArray) -> FloatArray:
    """Mean over the piece of values (points, ...) at POINTS."""
    return np.asarray(np.tensordot(WEIGHTS, values, axes=1))


def derivative(series: FloatArray) -> FloatArray:
    """Series (terms - 1, ...) of the derivative by s."""
    rank = _RANK[: len(series) - 1].reshape(-1, *([1] * (series.ndim - 1)))
    return np.asarray(series[1:] * rank)


def primitive(series: FloatArray) -> FloatArray:
    """Series (terms + 1, ...) of the integral from s = 0."""
    rank = _RANK[: len(series)].reshape(-1, *([1] * (series.ndim - 1)))
    return np.concatenate([np.zeros_like(series[:1]), series / rank])


def absolute_mean(force: FloatArray) -> FloatArray:
    """Mean of |F| over pieces (terms, n), with each change of sign found."""
    total = np.zeros(force.shape[1])
    owner, weight = np.arange(force.shape[1]), 1.0
    for _ in range(_DEEPEST):
        changes = sign_changes(bernstein(force) > 0.0)
        area = primitive(force)
        whole = np.sum(area, axis=0)
        plain, once = changes == 0, changes == 1
        np.add.at(total, owner[plain], weight * np.abs(whole[plain]))
        if np.any(once):
            count = int(np.count_nonzero(once))
            root = single_root(force[:, once], np.zeros(count), np.ones(count))
            before = evaluate(area[:, once], root)[0]
            parts = np.abs(before) + np.abs(whole[once] - before)
            np.add.at(total, owner[once], weight * parts)
        rest = changes > 1
        if not np.any(rest):
            return total
        first, second = halves(force[:, rest])
        force = np.concatenate([first, second], axis=1)
        owner, weight = np.concatenate([owner[rest], owner[rest]]), 0.5 * weight
    np.add.at(total, owner, weight * np.abs(np.sum(primitive(force), axis=0)))
    return total


def highest(force: FloatArray, floor: FloatArray) -> FloatArray:
    """max(floor, max |F|) over pieces (terms, n); `floor` (n,).

    Only pieces whose Bernstein coefficients, a bound, exceed the floor are searched: between
    points so close that a force has one extreme there, its derivative's root is found.
    """
    result = floor.copy()
    worth = np.flatnonzero(np.max(np.abs(bernstein(force)), axis=0) > floor)
    if not len(worth):
        return result
    part = force[:, worth]
    grid = np.linspace(0.0, 1.0, _SAMPLES)
    size = np.abs((grid[:, None] ** np.arange(len(part))) @ part)
    best = np.argmax(size, axis=0)
    top = size[best, np.arange(len(worth))]
    slope = derivative(part)
    low, high = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, _SAMPLES - 1)]
    turns = evaluate(slope, low)[0] * evaluate(slope, high)[0] < 0.0
    if np.any(turns):
        at = single_root(slope[:, turns], low[turns], high[turns])
        top[turns] = np.maximum(top[turns], np.abs(evaluate(part[:, turns], at)[0]))
    result[worth] = np.maximum(floor[worth], top)
    return result
