"""The least norm of what weights leave: linear least squares with each weight within its bound."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

MOST_STEPS = 200
#: growth of the weight of the objective against the barrier, from round to round
_GROWTH = 8.0
_ROUNDS = 40
#: share of a bound that rounding may pass it by
_KEPT = 1e-12


class LeastNorm(NamedTuple):
    """The minimum and its proof.

    `unknowns` (n,); `value` the norm there, and no unknowns within the bounds give less than
    `lower_bound`; `held` (m,) tells which bounds hold it; `free_directions` counts those in which
    the norm does not change.
    """

    unknowns: np.ndarray
    value: float
    lower_bound: float
    held: np.ndarray
    free_directions: int


def least_norm(
    constant: np.ndarray, columns: np.ndarray, block: np.ndarray, radius: np.ndarray
) -> LeastNorm:
    """Minimise |constant + columns x| where every block of x is no longer than its radius.

    Parameters
    ----------
    constant : (k,) array
        What is there without the unknowns.
    columns : (k, n) array
        What a unit of each unknown adds.
    block : (n,) array of int
        The block, 0 .. m-1, that an unknown belongs to: one for a weight at a given angle, two for
        the components of a weight at any angle.
    radius : (m,) array
        Largest length of each block, > 0.

    Raises
    ------
    NumericalFailure
        If the iteration does not end, which a convex problem gives no reason for.

    Notes
    -----
    Without the bounds it is linear least squares; the solution of least length, in shares of the
    radii, counts where it keeps them. Else Newton's method follows the logarithmic barrier of the
    bounds (S. Boyd and L. Vandenberghe, Convex Optimization, 2004, ch. 11) and then solves the
    conditions of the bounds that hold. Any y with |y| <= 1 proves a lower bound (ibid., ch. 5),

        |c + A x| >= y.(c + A x) >= y.c - sum_j r_j |(A^T y)_j|,

    and that of the residual's own direction meets the minimum.
    """
    count = radius.size
    size = float(np.max(np.abs(columns * radius[block]), initial=0.0)) or 1.0
    constant, scaled = constant / size, columns * (radius[block] / size)
    member = (block[None, :] == np.arange(count)[:, None]).astype(float)
    solution, _, rank, _ = np.linalg.lstsq(scaled, -constant, rcond=1e-12)
    held = np.zeros(count, dtype=bool)
    if np.max(member @ solution**2, initial=0.0) > 1.0:
        start = _barrier(constant, scaled, member, block)
        solution, held = _sharpened(constant, scaled, member, block, start)
        outwards = _outwards(solution, member, held).T
        rank = int(np.linalg.matrix_rank(np.vstack([scaled, outwards])))
    rest = constant + scaled @ solution
    value = float(np.linalg.norm(rest))
    return LeastNorm(
        unknowns=solution * radius[block],
        value=size * value,
        lower_bound=size * _lower_bound(constant, scaled, member, rest, value),
        held=held,
        free_directions=int(solution.size - rank),
    )


def _lower_bound(
    constant: np.ndarray, columns: np.ndarray, member: np.ndarray, rest: np.ndarray, value: float
) -> float:
    if value == 0.0:
        return 0.0
    direction = rest / value
    pulls = np.sqrt(member @ (columns.T @ direction) ** 2)
    return max(0.0, float(direction @ constant - np.sum(pulls)))


def _outwards(solution: np.ndarray, member: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Gradients of the bounds that hold, (n, number of them)."""
    return np.asarray((member[held] * solution).T)


def _barrier(
    constant: np.ndarray, columns: np.ndarray, member: np.ndarray, block: np.ndarray
) -> np.ndarray:
    """A point inside all bounds, close to the minimum."""
    point = np.zeros(columns.shape[1])
    gram, slope = columns.T @ columns, columns.T @ constant
    weight = 1.0 / max(float(np.max(np.abs(slope))), np.finfo(float).tiny)
    steps = 0
    for _ in range(_ROUNDS):
        for _ in range(MOST_STEPS):
            steps += 1
            room = 1.0 - member @ point**2
            gradient = weight * (gram @ point + slope) + 2.0 * point / room[block]
            outwards = member * (2.0 * point) / room[:, None]
            curvature = weight * gram + np.diag(2.0 / room[block]) + outwards.T @ outwards
            step = -np.linalg.solve(curvature, gradient)
            decrement = float(-gradient @ step)
            length = 1.0 / (1.0 + np.sqrt(max(decrement, 0.0)))  # damped: it stays inside
            point = point + (1.0 if decrement < 0.05 else length) * step
            if decrement < 1e-9:
                break
        weight *= _GROWTH
        gap = member.shape[0] / weight
        norm = float(np.linalg.norm(constant + columns @ point))
        if gap <= 1e-9 * max(norm**2, 1e-6 * float(constant @ constant)):
            break
    return point


def _sharpened(
    constant: np.ndarray,
    columns: np.ndarray,
    member: np.ndarray,
    block: np.ndarray,
    start: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Newton's method on the conditions of the minimum: unknowns, and which bounds hold."""
    gram, slope = columns.T @ columns, columns.T @ constant
    pull = np.sqrt(member @ (gram @ start + slope) ** 2)
    room = 1.0 - member @ start**2
    # multiplier times room is the same for all on the path of the barrier: who has the larger one?
    held = pull / max(float(np.max(pull)), np.finfo(float).tiny) > room
    for _ in range(2 * held.size + 1):
        point, price = start.copy(), np.where(held, pull, 0.0)
        for _ in range(MOST_STEPS):
            outwards = _outwards(point, member, held)
            first = gram @ point + slope + price[block] * point
            second = 0.5 * (member[held] @ point**2 - 1.0)
            size = outwards.shape[1]
            matrix = np.block(
                [[gram + np.diag(price[block]), outwards], [outwards.T, np.zeros((size, size))]]
            )
            step = -np.linalg.lstsq(matrix, np.concatenate([first, second]), rcond=None)[0]
            point = point + step[: point.size]
            price[held] += step[point.size :]
            if np.max(np.abs(step[: point.size])) <= 8.0 * EPSILON:
                break
        over = member @ point**2 > 1.0 + _KEPT
        negative = price < -_KEPT * max(float(np.max(np.abs(price))), np.finfo(float).tiny)
        if not np.any(over | negative):
            length = np.sqrt(member @ point**2)
            return point / np.maximum(length, 1.0)[block], held & (price > 0.0)
        held = (held | over) & ~negative
    raise NumericalFailure("the least residual within the bounds of the weights was not settled")
