"""Harmonics of a force over one revolution from its moments on panels.

On a panel of half width h around m, exp(-i n theta) is exp(-i n m) times a series of Legendre
polynomials whose coefficients die out faster than any power beyond n h. So the integrals of the
force times the first MOMENTS Legendre polynomials, summed up while a run passes the panel, hold
every harmonic to rounding, and the cost of a step does not depend on the number of orders.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import ComplexArray, FloatArray, IntArray
from vibecalc.response.impact.panels import DEGREE, Panels

#: Legendre polynomials kept: 5^28 / 57!! is below 1e-16, see the width in `panels.py`
MOMENTS = 28
#: points of a Gauss rule that integrates force series times Legendre polynomials exactly
_POINTS = (DEGREE + MOMENTS) // 2 + 1

_nodes, _weights = np.polynomial.legendre.leggauss(_POINTS)
#: the rule on [0, 1], and the powers of its points (points, DEGREE)
_AT = 0.5 * (1.0 + _nodes)
_WEIGHT = 0.5 * _weights
_POWERS = _AT[:, None] ** np.arange(DEGREE)


class Transform(NamedTuple):
    """`phase` (p, N + 1), `shape` (distinct widths, MOMENTS, N + 1), `kind` (p,) which width."""

    phase: ComplexArray
    shape: ComplexArray
    kind: IntArray


def make_transform(panels: Panels, highest_order: int) -> Transform:
    """Tables that take moments to harmonics of order 0 to `highest_order`."""
    orders = np.arange(highest_order + 1)
    middle = panels.start + 0.5 * panels.width
    phase = np.exp(-1j * np.outer(middle, orders)) / np.pi
    phase[:, 0] *= 0.5
    widths, kind = np.unique(np.round(panels.width, 13), return_inverse=True)
    node, weight = np.polynomial.legendre.leggauss(MOMENTS + 24)
    rows = np.array(list(_legendre(node)))
    rank = (2.0 * np.arange(MOMENTS) + 1.0) * 0.5
    shape = []
    for each in range(len(widths)):
        # panels of one kind differ by rounding; their moments count from the mean width
        half = 0.5 * np.mean(panels.width[kind == each])
        wave = np.exp(-1j * half * np.outer(node, orders)) * weight[:, None]
        shape.append(rank[:, None] * (rows @ wave))
    return Transform(phase, np.array(shape), np.asarray(kind.reshape(-1), dtype=np.int64))


def moments(
    force: FloatArray, offset: FloatArray, length: FloatArray, width: FloatArray
) -> FloatArray:
    """Moments (MOMENTS, n) of pieces of force series (DEGREE, n), in N rad.

    A piece begins at `offset` (n,) from the start of its panel and is `length` (n,) long, the
    panel is `width` (n,) wide, all in rad.
    """
    pull = (_POWERS @ force) * (_WEIGHT[:, None] * length)
    place = (offset + length * _AT[:, None]) / (0.5 * width) - 1.0
    return np.array([np.einsum("qn,qn->n", row, pull) for row in _legendre(place)])


def harmonics(values: FloatArray, transform: Transform) -> ComplexArray:
    """One-sided 0-to-peak harmonics (n, N + 1) of order 0 (the mean) to N, in N.

    `values` (n, p, MOMENTS) are the moments over one revolution, already in N rad.
    """
    total = np.zeros((len(values), transform.phase.shape[1]), dtype=np.complex128)
    for each in range(len(transform.shape)):
        mine = transform.kind == each
        turned = np.swapaxes(values[:, mine], 1, 2) @ transform.phase[mine]
        total += np.sum(turned * transform.shape[each], axis=1)
    return total


def _legendre(at: FloatArray) -> Iterator[FloatArray]:
    """Legendre polynomials 0 to MOMENTS - 1 at the given points, one after the other."""
    before, now = np.ones_like(at), at
    yield before
    for rank in range(1, MOMENTS):
        yield now
        before, now = now, ((2 * rank + 1) * at * now - rank * before) / (rank + 1)
