"""Gauss-Legendre points on [0, 1] with the matrices that collocation needs.

All matrices come from sums over Legendre polynomials or from barycentric weights, which keep full
precision for the numbers of points used here (up to about 30).
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded
from vibecalc.numerics.rounding import EPSILON, FloatArray

#: a distance to a node that is none
_HIT = 1e-150


class GaussRule(NamedTuple):
    """s points on [0, 1]; `integration[i, j]` is the integral of the j-th Lagrange basis to node i.

    `dense_...` are the nodes with 0 in front (s + 1), `closed_...` those with 0 and 1 (s + 2), each
    with barycentric weights.
    """

    nodes: FloatArray
    weights: FloatArray
    integration: FloatArray
    dense_nodes: FloatArray
    dense_weights: FloatArray
    closed_nodes: FloatArray
    closed_weights: FloatArray


@lru_cache(maxsize=64)
def gauss_rule(points: int) -> GaussRule:
    """Rule with that many points, exact for polynomials up to degree 2 points - 1."""
    position, weight = np.polynomial.legendre.leggauss(points)
    nodes, weights = 0.5 * (1.0 + position), 0.5 * weight
    dense, closed = np.concatenate([[0.0], nodes]), np.concatenate([[0.0], nodes, [1.0]])
    rule = GaussRule(
        nodes, weights, integration_matrix(nodes, weights, nodes),
        dense, barycentric_weights(dense), closed, barycentric_weights(closed),
    )  # fmt: skip
    for array in rule:
        array.flags.writeable = False  # the rule is shared by all callers
    return rule


def integration_matrix(nodes: FloatArray, weights: FloatArray, at: FloatArray) -> FloatArray:
    """Integrals from 0 to each of `at` (k,) of the Lagrange basis on Gauss nodes: (k, s).

    The basis is expanded in Legendre polynomials, whose integrals have a closed form.
    """
    points = len(nodes)
    degree = np.arange(1, points)
    values = np.polynomial.legendre.legvander(2.0 * nodes - 1.0, points - 1)
    ends = np.polynomial.legendre.legvander(2.0 * np.asarray(at) - 1.0, points)
    integrals = np.empty((len(ends), points))
    integrals[:, 0] = at
    integrals[:, 1:] = (ends[:, 2:] - ends[:, :-2]) / (2.0 * (2.0 * degree + 1.0))
    expansion = (2.0 * np.arange(points) + 1.0)[:, None] * (weights[:, None] * values).T
    return np.asarray(integrals @ expansion)


def barycentric_weights(nodes: FloatArray) -> FloatArray:
    """Weights of the barycentric formula for distinct nodes on [0, 1]."""
    distance = 4.0 * (nodes[:, None] - nodes)
    np.fill_diagonal(distance, 1.0)
    return np.asarray(1.0 / np.prod(distance, axis=1))


def interpolation_rows(nodes: FloatArray, weights: FloatArray, at: FloatArray) -> FloatArray:
    """Values of the Lagrange basis at `at` (...): array (..., nodes).

    Source: Berrut and Trefethen (2004), Barycentric Lagrange interpolation, eq. 4.2.
    """
    distance = np.asarray(at)[..., None] - nodes
    with np.errstate(all="ignore"):
        share = weights / distance
        total = np.add.reduce(share, axis=-1, keepdims=True)
        share /= total
    on_node = ~np.isfinite(total[..., 0])
    if on_node.any():
        share[on_node] = np.abs(distance[on_node]) < _HIT
    return np.asarray(share)


@lru_cache(maxsize=256)
def between_rules(points: int, other: int) -> FloatArray:
    """From values at 0 and the nodes of one rule to the nodes of another: (other, points + 1)."""
    rule = gauss_rule(points)
    return interpolation_rows(rule.dense_nodes, rule.dense_weights, gauss_rule(other).nodes)


@lru_cache(maxsize=64)
def differentiation_matrix(points: int) -> FloatArray:
    """Derivatives at 0, the nodes and 1 from the values there: (points + 2, points + 2)."""
    rule = gauss_rule(points)
    nodes, weights = rule.closed_nodes, rule.closed_weights
    distance = nodes[:, None] - nodes
    np.fill_diagonal(distance, 1.0)
    matrix = weights / weights[:, None] / distance
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return np.asarray(matrix)


# ----------------------------------------------------------------------------
# Integrals of what is smooth within panels, or nearly so.
# ----------------------------------------------------------------------------

#: points of the two rules that are held against each other
FEW, MANY = 12, 20
_ROUNDS, _PANELS = 60, 20_000


def integral(
    values_at: Callable[[FloatArray], Any],
    ends: FloatArray,
    allowed: Callable[[Any], FloatArray],
    failure: str,
) -> Bounded:
    """Integrals (r,) of values (n, r) at places (n,) from the first to the last of `ends` (k + 1,).

    Two rules on the panels between the ends; a panel is cut in halves where they differ by more
    than its share of what is `allowed` (r,), which follows from the integrals (r,). The difference
    that is left is the error.

    Raises NumericalFailure with the words `failure` where that takes too many panels.
    """
    low, high = ends[:-1], ends[1:]
    total, lost = np.zeros(()), np.zeros(())
    for _ in range(_ROUNDS):
        rough, fine = (_on_panels(values_at, gauss_rule(n), low, high) for n in (FEW, MANY))
        off, most = np.abs(fine - rough), allowed(total + fine.sum(axis=0))
        poor = np.any(off > most / len(ends) ** 0.5, axis=1) & (high - low > 1e-13 * abs(high))
        total = total + fine[~poor].sum(axis=0)
        lost = lost + off[~poor].sum(axis=0)
        if not np.any(poor):
            return Bounded(total, lost + 64.0 * EPSILON * np.abs(total))
        middle = 0.5 * (low[poor] + high[poor])
        low, high = np.concatenate([low[poor], middle]), np.concatenate([middle, high[poor]])
        if len(low) > _PANELS:
            break
    raise NumericalFailure(failure)


def _on_panels(
    values_at: Callable[[FloatArray], Any], rule: GaussRule, low: FloatArray, high: FloatArray
) -> Any:
    """Integrals (panels, r) over each panel."""
    width = (high - low)[:, None]
    found = values_at((low[:, None] + width * rule.nodes).ravel())
    each = np.reshape(found, (len(low), len(rule.nodes), -1))
    return np.einsum("pqr,q->pr", each, rule.weights) * width
