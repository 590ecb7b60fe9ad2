"""Floquet multipliers of a periodic solution, with how far rounding moves them."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.gauss import between_rules, gauss_rule
from vibecalc.numerics.periodic.panels import (
    PeriodicProblem,
    PeriodicSolution,
    gaps,
    newton_step,
    panel_nodes,
    solve_or_nan,
)
from vibecalc.numerics.rounding import EPSILON, ComplexArray, FloatArray

# ----------------------------------------------------------------------------
# How far rounding moves the eigenvalues of a product of matrices that is kept as triangles.
#
# An error E in panel p moves an eigenvalue by y' E x / (y' x): x is its right eigenvector on the
# way into the panel, y its left one on the way out, and y' x that of the whole product. Far from
# normal, y' x is small.
#
# Source: first-order perturbation, Golub and Van Loan, Matrix Computations, sec. 7.2, panel by
# panel.
# ----------------------------------------------------------------------------

#: turns after which the eigenvectors repeat well enough for an estimate
_TURNS = 4


def product_condition(
    triangles: FloatArray, sizes: FloatArray, turn: FloatArray, cuts: list[list[int]]
) -> FloatArray:
    """Relative change (B, n) of the eigenvalues of turn @ triangles[P - 1] ... triangles[0].

    Meant are errors, in every panel, of one part of `sizes` (B, P, n) in each column of `triangles`
    (B, P, n, n), which have to be upper triangular. `turn` (B, n, n) is orthogonal and couples only
    the groups that `cuts` tells for each member (their first places, in order); the eigenvalues of
    a group come by falling modulus. Infinite where the eigenvectors of a group fall together.
    """
    members, states = len(triangles), triangles.shape[-1]
    joined, inner = np.zeros((members, states, states)), np.ones((members, states))
    right = np.zeros(joined.shape, dtype=np.complex128)
    left = right.copy()
    whole = np.broadcast_to(np.eye(states), joined.shape)
    for panel in range(triangles.shape[1]):
        whole = triangles[:, panel] @ whole
    for member in range(members):
        for low, high in zip(cuts[member], [*cuts[member][1:], states], strict=True):
            block = member, slice(low, high), slice(low, high)
            joined[block] = turn[block]
            right[block], left[block], inner[member, low:high] = _of_group(
                turn[block] @ whole[block]
            )
    cost = inner + _round(triangles, sizes, joined, right, left)
    # vectors that overflow, or a panel that takes a direction away
    return np.where(np.isfinite(cost), cost, np.inf)


def _of_group(part: FloatArray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right and left eigenvectors (columns) of a dense matrix, and what its rounding counts."""
    values, right = np.linalg.eig(part)
    order = np.lexsort((-values.imag, -np.abs(values)))
    right = right[:, order].astype(np.complex128)
    rows = solve_or_nan(right, np.eye(len(part), dtype=np.complex128))
    length = np.linalg.norm(right, axis=0) * np.linalg.norm(rows, axis=1)
    count = length * np.linalg.norm(part) / np.abs(values[order])
    return right, rows.conj().T, count


def _round(
    triangles: FloatArray, sizes: FloatArray, turn: FloatArray, right: np.ndarray, left: np.ndarray
) -> np.ndarray:
    """Sum over the panels of |y| sum |size x| / |y' T x|, going backwards.

    That way the shares of other groups in the eigenvectors die out from turn to turn.
    """
    total, back = np.zeros(turn.shape[:2]), turn.swapaxes(1, 2)
    for _ in range(_TURNS):
        right, left = back @ right, back @ left
        total = np.zeros(turn.shape[:2])
        for panel in reversed(range(triangles.shape[1])):
            triangle = triangles[:, panel]
            before = solve_or_nan(triangle, right)
            before /= np.linalg.norm(before, axis=1, keepdims=True)
            left /= np.linalg.norm(left, axis=1, keepdims=True)
            through = np.abs(np.sum(left.conj() * (triangle @ before), axis=1))
            total += (sizes[:, panel, None] @ np.abs(before))[:, 0] / through
            right, left = before, triangle.swapaxes(1, 2) @ left
    return total


# ----------------------------------------------------------------------------
# Floquet multipliers of a periodic solution from the transfers of its panels.
#
# The product of the transfers is never formed for more than one state: it would lose multipliers
# that are smaller than round-off times the largest. Orthogonal iteration around the turn keeps
# every factor triangular, so that small multipliers are products of small factors.
#
# Source: Bojanczyk, Golub and Van Dooren (1992), The periodic Schur decomposition; here by
# simultaneous iteration, which needs no shifts because multipliers differ much or are taken
# together.
# ----------------------------------------------------------------------------

_SWEEPS = 24
#: neighbours whose moduli differ by less than this factor are taken together
_APART = 8.0
#: part of the off-diagonal left when a group counts as split off
_SPLIT_OFF = 1e-14


class Multipliers(NamedTuple):
    """Multipliers (B, n) by falling modulus, and the absolute error of each (B, n)."""

    value: ComplexArray
    error: FloatArray


def floquet_multipliers(problem: PeriodicProblem, solution: PeriodicSolution) -> Multipliers:
    """Multipliers of a converged solution; the error compares them with one more Gauss point.

    The error counts discretisation of the linearised problem and round-off.
    """
    computed = [
        product_multipliers(_transfers(problem, solution, points))
        for points in (solution.points + 1, solution.points)
    ]
    finer, plain = computed
    error = np.abs(plain.value - finer.value) + finer.error
    return Multipliers(finer.value, error)


def product_multipliers(transfer: FloatArray) -> Multipliers:
    """Eigenvalues of transfer[P - 1] ... transfer[0], (B, P, n, n), small ones to full precision.

    `error` is of round-off alone, to first order: what the roundings of every panel do to each
    multiplier (see `product_condition`), and what the last two sweeps differ by. It is relative to
    each multiplier; directions that fall together in a panel, or left and right eigenvectors that
    are almost at right angles, cost as many digits as their angle says.
    """
    members, panels, states = transfer.shape[:3]
    if states == 1:
        value = np.prod(transfer[..., 0, 0], axis=1)[:, None].astype(np.complex128)
        return Multipliers(value, 2.0 * panels * EPSILON * np.abs(value))
    basis = np.broadcast_to(np.eye(states), (members, states, states))
    older = np.full((members, states), np.inf, dtype=np.complex128)
    value, change = older, np.full((members, states), np.inf)
    triangles, sizes = np.empty_like(transfer), np.empty(transfer.shape[:3])
    turn, cuts = basis, [[0] for _ in range(members)]
    for _ in range(_SWEEPS):
        start, triangle = basis, np.broadcast_to(np.eye(states), basis.shape)
        lost = np.zeros((members, states))
        for panel in range(panels):
            rounded = np.abs(transfer[:, panel]) @ np.abs(basis)
            basis, factor = np.linalg.qr(transfer[:, panel] @ basis)
            triangle = factor @ triangle
            triangles[:, panel] = np.triu(factor)
            sizes[:, panel] = np.sqrt(np.sum(np.square(rounded), axis=1))
            lost = lost + _lost_length(factor)
        turn = start.swapaxes(1, 2) @ basis
        value, settled, cuts = _eigenvalues(turn, triangle)
        change = np.abs(value - older)
        if settled and (change <= 4.0 * states * EPSILON * lost * np.abs(value)).all():
            break
        older = value
    with np.errstate(all="ignore"):
        cost = product_condition(triangles, sizes, turn, cuts)
        # a multiplier of 0 is below every double; subnormal ones have few digits
        uncertainty = np.where(value == 0.0, 0.0, 2.0 * states * EPSILON * cost * np.abs(value))
        uncertainty += np.finfo(float).tiny
    return Multipliers(value, change + uncertainty)


def _lost_length(factor: FloatArray) -> FloatArray:
    """Length of each column (B, n) of a triangle over its diagonal entry; 1 if nothing is lost."""
    diagonal = np.abs(np.diagonal(factor, axis1=1, axis2=2))
    there = diagonal > 0.0
    length = np.sqrt(np.sum(np.square(factor), axis=1))
    return np.asarray(np.where(there, length / np.where(there, diagonal, 1.0), 1.0))


def _transfers(problem: PeriodicProblem, solution: PeriodicSolution, points: int) -> FloatArray:
    rule, widths = gauss_rule(points), np.diff(solution.edges)
    values = np.concatenate([solution.left[:, :, None], solution.stages], axis=2)
    stages = solution.stages
    if points != solution.points:
        stages = between_rules(solution.points, points) @ values
    x = panel_nodes(solution.edges, points)
    with np.errstate(all="ignore"):
        f, jacobian = problem.rhs(x, stages, solution.interval)
        missed = gaps(rule, widths, solution.left, stages, f)
        return newton_step(rule, widths, jacobian, missed).transfer


def _eigenvalues(
    turn: FloatArray, triangle: FloatArray
) -> tuple[ComplexArray, bool, list[list[int]]]:
    """Eigenvalues of turn @ triangle by groups that are split off; whether all could be.

    Last, the first place of every group of each member.
    """
    members, states = turn.shape[:2]
    multipliers = np.empty((members, states), dtype=np.complex128)
    settled, groups = True, []
    for member in range(members):
        size = np.abs(np.diagonal(triangle[member]))
        cuts = [0]
        for place in range(1, states):
            apart = size[place] * _APART < size[place - 1]
            loose = np.abs(turn[member, place:, :place]).max() <= _SPLIT_OFF * states
            settled &= loose or not apart
            if loose:
                cuts.append(place)
        groups.append(cuts)
        for low, high in zip(cuts, [*cuts[1:], states], strict=True):
            block = slice(low, high)
            part = turn[member, block, block] @ triangle[member, block, block]
            values = np.linalg.eigvals(part).astype(np.complex128)
            multipliers[member, block] = values[np.lexsort((-values.imag, -np.abs(values)))]
    return multipliers, bool(settled), groups
