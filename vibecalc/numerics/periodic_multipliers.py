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

    `error` is of round-off alone, and is relative to each multiplier except where several of about
    the same modulus are badly conditioned; there it is what two sweeps differ by.
    """
    members, panels, states = transfer.shape[:3]
    if states == 1:
        value = np.prod(transfer[..., 0, 0], axis=1)[:, None].astype(np.complex128)
        return Multipliers(value, 2.0 * panels * EPSILON * np.abs(value))
    basis = np.broadcast_to(np.eye(states), (members, states, states))
    older = np.full((members, states), np.inf, dtype=np.complex128)
    value, change = older, np.full((members, states), np.inf)
    for _ in range(_SWEEPS):
        start, triangle = basis, np.broadcast_to(np.eye(states), basis.shape)
        for panel in range(panels):
            basis, factor = np.linalg.qr(transfer[:, panel] @ basis)
            triangle = factor @ triangle
        turn = start.swapaxes(1, 2) @ basis
        value, settled = _eigenvalues(turn, triangle)
        change = np.abs(value - older)
        small = 4.0 * panels * states * EPSILON * np.abs(value)
        if settled and (change <= small).all():
            break
        older = value
    return Multipliers(value, change + 4.0 * panels * states * EPSILON * np.abs(value))


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


def _eigenvalues(turn: FloatArray, triangle: FloatArray) -> tuple[ComplexArray, bool]:
    """Eigenvalues of turn @ triangle by groups that are split off; whether all could be."""
    members, states = turn.shape[:2]
    found = np.empty((members, states), dtype=np.complex128)
    settled = True
    for member in range(members):
        size = np.abs(np.diagonal(triangle[member]))
        cuts = [0]
        for place in range(1, states):
            apart = size[place] * _APART < size[place - 1]
            loose = np.abs(turn[member, place:, :place]).max() <= _SPLIT_OFF * states
            settled &= loose or not apart
            if loose:
                cuts.append(place)
        for low, high in zip(cuts, [*cuts[1:], states], strict=True):
            block = slice(low, high)
            part = turn[member, block, block] @ triangle[member, block, block]
            values = np.linalg.eigvals(part).astype(np.complex128)
            found[member, block] = values[np.lexsort((-values.imag, -np.abs(values)))]
    return found, bool(settled)
