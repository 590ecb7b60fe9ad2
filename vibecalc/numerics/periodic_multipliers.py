"""Floquet multipliers of a periodic solution from the transfers of its panels.

The product of the transfers is never formed for more than one state: it would lose multipliers that
are smaller than round-off times the largest. Orthogonal iteration around the turn keeps every
factor triangular, so that small multipliers are products of small factors.

Source: Bojanczyk, Golub and Van Dooren (1992), The periodic Schur decomposition; here by
simultaneous iteration, which needs no shifts because multipliers differ much or are taken together.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.gauss import between_rules, gauss_rule
from vibecalc.numerics.periodic_condense import gaps, newton_step
from vibecalc.numerics.periodic_condition import product_condition
from vibecalc.numerics.periodic_panels import PeriodicProblem, PeriodicSolution, panel_nodes
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import ComplexArray, FloatArray

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
    found = [
        product_multipliers(_transfers(problem, solution, points))
        for points in (solution.points + 1, solution.points)
    ]
    finer, own = found
    error = np.abs(own.value - finer.value) + finer.error
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
        doubt = np.where(value == 0.0, 0.0, 2.0 * states * EPSILON * cost * np.abs(value))
        doubt += np.finfo(float).tiny
    return Multipliers(value, change + doubt)


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
        f, jacobian = problem.rhs(x, stages, solution.piece)
        missed = gaps(rule, widths, solution.left, stages, f)
        return newton_step(rule, widths, jacobian, missed).transfer


def _eigenvalues(
    turn: FloatArray, triangle: FloatArray
) -> tuple[ComplexArray, bool, list[list[int]]]:
    """Eigenvalues of turn @ triangle by groups that are split off; whether all could be.

    Last, the first place of every group of each member.
    """
    members, states = turn.shape[:2]
    found = np.empty((members, states), dtype=np.complex128)
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
            found[member, block] = values[np.lexsort((-values.imag, -np.abs(values)))]
    return found, bool(settled), groups
