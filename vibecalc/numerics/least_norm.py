"""The least norm of what is linear in unknowns of limited length, with the proof of it.

Minimise |constant + columns x| where every block of x, one number or a pair, is no longer than its
radius: linear least squares, and discs in place of bounds on single numbers. It is convex. Where
the bounds have no part in it, Newton's method on the multipliers of a linear system gives the
least x; else steps of a proximal point method find which bounds hold (R. T. Rockafellar, SIAM J.
Control Optim. 14, 1976, p. 877), and Newton's method on the conditions of these the rest.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON, BoolArray, FloatArray

MOST_STEPS = 200
#: share of a bound that rounding may pass it by
_WITHIN = 1e-12
#: times the constant, what a block does at its bound from which on that is a loose one
_LOOSE = 1e3
#: share of a column that rounding leaves of its product with what is orthogonal to it
_ORTHOGONAL = 64.0 * EPSILON
#: of the largest singular value, below which one counts as zero
_RANK = 1e-12
#: of the largest singular value: pulls of proximal steps towards where each began, so many of each
_PULLS = (1e-1, 1e-2, 1e-3, 1e-4)
_PROXIMAL_STEPS = 10
#: a minimum within this share of its lower bound counts as settled
_SETTLED = 1e-9


class LeastNorm(NamedTuple):
    """The minimum and its proof.

    `unknowns` (n,); `value` the norm there, and no unknowns within the bounds give less than
    `lower_bound`; `held` (m,) tells which bounds hold it; `free_directions` counts those in which
    the norm does not change.
    """

    unknowns: FloatArray
    value: float
    lower_bound: float
    held: BoolArray
    free_directions: int


def least_norm(
    constant: FloatArray, columns: FloatArray, block: np.ndarray, radius: FloatArray
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
        Largest length of each block, > 0; inf for one without a bound.

    Raises
    ------
    NumericalFailure
        If the iteration does not end, which a convex problem gives no reason for.

    Notes
    -----
    Of several solutions that of least length counts, each block as a share of its radius, one
    without a bound as a share of the largest radius. Any y with |y| <= 1 that no block without a
    bound acts on proves a lower bound (S. Boyd and L. Vandenberghe, Convex Optimization, 2004,
    ch. 5),

        |c + A x| >= y.(c + A x) >= y.c - sum_j r_j |(A^T y)_j|,

    and that of the residual's own direction meets the minimum. A bound at which a block would pull
    many times as much as there is counts as none, unless the minimum without it passes it.
    """
    strength = np.sqrt(np.bincount(block, np.sum(columns**2, axis=0), radius.size))
    loose = np.isfinite(radius) & (radius * strength > _LOOSE * np.linalg.norm(constant))
    if loose.any() and np.any(constant):
        found = _least(constant, columns, block, np.where(loose, np.inf, radius))
        if np.all(np.bincount(block, found.unknowns**2, radius.size) <= radius**2):
            return found
    return _least(constant, columns, block, radius)


def _least(
    constant: FloatArray, columns: FloatArray, block: np.ndarray, radius: FloatArray
) -> LeastNorm:
    bounded = np.isfinite(radius)
    usual = float(np.max(radius, where=bounded, initial=0.0)) or 1.0
    scale = np.where(bounded, radius, usual)[block]
    size = float(np.linalg.norm(columns * scale, 2)) or 1.0
    blocks = Blocks(columns * (scale / size), block, bounded)
    solution, held, freedom = _solved(constant / size, blocks)
    residual = constant / size + blocks.columns @ solution
    return LeastNorm(
        unknowns=solution * scale,
        value=size * float(np.linalg.norm(residual)),
        lower_bound=size * _lower_bound(constant / size, blocks, residual, held),
        held=held,
        free_directions=freedom,
    )


class Blocks(NamedTuple):
    """Columns (k, n) of the norm one, the block (n,) of each, and which blocks are bounded by 1."""

    columns: FloatArray
    block: np.ndarray
    bounded: BoolArray

    def lengths(self, unknowns: FloatArray) -> FloatArray:
        """Length (m,) of each block."""
        return np.asarray(np.sqrt(np.bincount(self.block, unknowns**2, self.bounded.size)))

    def where(self, chosen: BoolArray) -> "Blocks":
        """Some of the blocks."""
        inside = chosen[self.block]
        place = np.cumsum(chosen) - 1
        return Blocks(self.columns[:, inside], place[self.block[inside]], self.bounded[chosen])

    def nearest(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The nearest point within the bounds, and what each block (m,) was divided by for it."""
        length = np.where(self.bounded, np.maximum(self.lengths(point), 1.0), 1.0)
        return point / length[self.block], length


def range_of(columns: FloatArray) -> FloatArray:
    """Orthonormal basis (k, r) of what columns (k, n) span."""
    if not columns.size:
        return np.zeros((columns.shape[0], 0))
    left, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, size > _RANK * max(float(size[0]), np.finfo(float).tiny)])


def _solved(constant: FloatArray, blocks: Blocks) -> tuple[FloatArray, BoolArray, int]:
    """Unknowns, the bounds that hold, and in how many directions nothing changes."""
    held = np.zeros(blocks.bounded.size, dtype=bool)
    found = np.asarray(np.linalg.lstsq(blocks.columns, -constant, rcond=_RANK)[0], dtype=float)
    if np.any(blocks.lengths(found)[blocks.bounded] > 1.0):
        reached = reach(blocks.columns @ found, blocks)
        if reached is None:
            found, held = _held(constant, blocks)
        else:
            found = reached
    # discs are strictly convex: what its bound holds is the same in all solutions
    open_ = blocks.where(~held)
    freedom = open_.columns.shape[1] - range_of(open_.columns).shape[1]
    if held.any() and freedom:
        inside = ~held[blocks.block]
        least = reach(open_.columns @ found[inside], open_)
        found[inside] = found[inside] if least is None else least
    return found, held, freedom


def _lower_bound(
    constant: FloatArray, blocks: Blocks, residual: FloatArray, held: BoolArray
) -> float:
    """What no unknowns within the bounds leave less than, but for rounding: the better of two.

    The direction of the proof is orthogonal to blocks without a bound, or to all that their bounds
    do not hold, of which a loose bound would multiply what rounding leaves of their pull.
    """
    length = np.linalg.norm(blocks.columns, axis=0)
    unit = blocks.columns / np.where(length > 0.0, length, 1.0)
    whole = blocks.lengths(length)
    best = 0.0
    for open_ in (~blocks.bounded, ~held):
        basis = range_of(unit[:, open_[blocks.block]])
        direction = residual - basis @ (basis.T @ residual)
        direction = direction - basis @ (basis.T @ direction)
        size = float(np.linalg.norm(direction))
        if size == 0.0:
            continue
        direction = direction / size
        pulls = blocks.lengths(blocks.columns.T @ direction)
        counts = blocks.bounded & ~(open_ & (pulls <= _ORTHOGONAL * whole))
        best = max(best, float(direction @ constant - pulls[counts].sum()))
    return best


# ----------------------------------------------------------------------------
# Newton's method on multipliers: the slope of a convex function is to be zero.
# ----------------------------------------------------------------------------


def reach(
    target: FloatArray,
    blocks: Blocks,
    pull: float = 0.0,
    near: FloatArray | None = None,
) -> FloatArray | None:
    """The x within its bounds, least or `near` a point, with columns x = target; None: no such x.

    With y the multipliers, x is the point within the bounds that is nearest to near + columns^T y,
    and columns x + pull^2 y = target. A pull above zero makes that the minimum of
    |target - columns x|^2 + pull^2 |x - near|^2, which always exists. Without one there may be no
    x, of which any y is the proof whose product with the target is more than x can make it.
    """
    near = np.zeros(blocks.block.size) if near is None else near
    basis = range_of(blocks.columns)
    columns, goal = basis.T @ blocks.columns, basis.T @ target
    size = float(np.linalg.norm(goal)) + float(np.linalg.norm(columns @ near))
    point = np.zeros(goal.size)
    if size == 0.0:
        return near

    def state(at: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, float, float]:
        """Unknowns, what their blocks were divided by, slope, height of the function, rounding."""
        ahead = near + columns.T @ at
        found, length = blocks.nearest(ahead)
        full = blocks.lengths(ahead)
        linear = blocks.bounded & (full > 1.0)
        of_blocks = np.where(linear, full - 0.5, 0.5 * full**2).sum()
        value = 0.5 * pull**2 * (at @ at) + of_blocks - goal @ at
        terms = 0.5 * pull**2 * (at @ at) + of_blocks + np.abs(goal) @ np.abs(at)
        slope = columns @ found + pull**2 * at - goal
        return found, length, slope, float(value), 64.0 * EPSILON * float(terms)

    found, length, slope, here, _ = state(point)
    for _ in range(MOST_STEPS):
        off = float(np.linalg.norm(slope))
        # what the sums of found are off by, and the sums of these; without a pull they may not end
        sums = np.abs(found)
        if pull:
            sums = sums + (np.abs(columns.T) @ np.abs(point)) / length[blocks.block]
        if off <= 4.0 * EPSILON * (np.linalg.norm(np.abs(columns) @ sums) + size):
            return found
        curvature = (columns / length[blocks.block]) @ columns.T + pull**2 * np.eye(goal.size)
        for i in np.flatnonzero(length > 1.0):
            mine = blocks.block == i
            radial = columns[:, mine] @ found[mine]
            curvature -= np.outer(radial, radial) / length[i]
        least = 1e-14 * max(float(np.trace(curvature)), np.finfo(float).tiny)
        step = -np.linalg.solve(curvature + least * np.eye(goal.size), slope)
        fall, part = float(slope @ step), 1.0
        while part > 1e-9:
            ahead = state(point + part * step)
            # close to the end rounding hides the height, but not the slope
            better = ahead[3] <= here + ahead[4] and np.linalg.norm(ahead[2]) < off
            if better or ahead[3] <= here + 1e-4 * part * fall:
                break
            part *= 0.5
        else:
            return found if off <= 1e-11 * size else None
        point = point + part * step
        found, length, slope, here, _ = ahead
        if pull == 0.0 and _beyond(point, columns, goal, blocks):
            return None
    return None


def _beyond(point: FloatArray, columns: FloatArray, goal: FloatArray, blocks: Blocks) -> bool:
    """Whether multipliers prove that nothing within the bounds gets to the goal."""
    free, whole = range_of(columns[:, ~blocks.bounded[blocks.block]]), point
    point = point - free @ (free.T @ point)
    if np.linalg.norm(point) <= _SETTLED * np.linalg.norm(whole):
        return False
    pulls = blocks.lengths(columns.T @ point)[blocks.bounded]
    return bool(goal @ point > pulls.sum() * (1.0 + _WITHIN))


# ----------------------------------------------------------------------------
# Where bounds hold: which, by proximal steps, then Newton's method on their conditions.
# ----------------------------------------------------------------------------


def _held(constant: FloatArray, blocks: Blocks) -> tuple[FloatArray, BoolArray]:
    """Unknowns of the least norm where bounds have a part in it, and which of them hold."""
    basis = range_of(blocks.where(~blocks.bounded).columns)
    left = constant - basis @ (basis.T @ constant)
    inside = blocks.where(blocks.bounded)
    inside = inside._replace(columns=inside.columns - basis @ (basis.T @ inside.columns))
    if float(np.max(np.abs(inside.columns), initial=0.0)) <= _RANK:
        inside = inside._replace(columns=np.zeros_like(inside.columns))
    found, held = _within(left, inside)
    solution, holds = np.zeros(blocks.block.size), np.zeros(blocks.bounded.size, dtype=bool)
    bounded = blocks.bounded[blocks.block]
    solution[bounded], holds[blocks.bounded] = found, held
    rest = constant + blocks.columns @ solution
    solution[~bounded] = np.linalg.lstsq(blocks.columns[:, ~bounded], -rest, rcond=_RANK)[0]
    return solution, holds


def _within(constant: FloatArray, blocks: Blocks) -> tuple[FloatArray, BoolArray]:
    """The same where every block is bounded."""
    start, best = np.zeros(blocks.block.size), None
    size, least = float(np.linalg.norm(constant)), np.inf
    for pull in _PULLS:
        for _ in range(_PROXIMAL_STEPS):
            moved = reach(-constant, blocks, pull, start)
            if moved is None:
                break
            step = float(np.max(np.abs(moved - start)))
            start = moved
            if step <= 16.0 * EPSILON:
                break
        for found, held in _candidates(constant, blocks, start):
            residual = constant + blocks.columns @ found
            proven = _lower_bound(constant, blocks, residual, held)
            gap = float(np.linalg.norm(residual)) - proven
            if gap < least:
                least, best = gap, (found, held)
        if least <= 1e-2 * _SETTLED * size:
            break
    if best is None or least > _SETTLED * size:
        raise NumericalFailure(
            "the least residual within the bounds of the weights was not settled"
        )
    return best


def _candidates(
    constant: FloatArray, blocks: Blocks, start: FloatArray
) -> Iterator[tuple[FloatArray, BoolArray]]:
    """What Newton's method makes of a point close to the minimum, and the point as it is."""
    slope = blocks.columns.T @ (constant + blocks.columns @ start)
    pull, length = blocks.lengths(slope), blocks.lengths(start)
    outwards = -np.bincount(blocks.block, slope * start, length.size)
    held = (length >= 1.0 - 1e-6) & (outwards > 1e-9 * float(np.max(pull, initial=0.0)))
    sharp = _sharpened(constant, blocks, start, held, pull)
    if sharp is not None:
        yield sharp
    yield start, held


def _sharpened(
    constant: FloatArray, blocks: Blocks, start: FloatArray, held: BoolArray, pull: FloatArray
) -> tuple[FloatArray, BoolArray] | None:
    """Newton's method on the conditions of the minimum: unknowns, and which bounds hold."""
    columns, block = blocks.columns, blocks.block
    member = (block[None, :] == np.arange(blocks.bounded.size)[:, None]).astype(float)
    gram, slope = columns.T @ columns, columns.T @ constant
    for _ in range(2 * held.size + 1):
        point, price, last = start.copy(), np.where(held, pull, 0.0), np.inf
        for _ in range(MOST_STEPS):
            outwards = (member[held] * point).T
            first = gram @ point + slope + price[block] * point
            second = 0.5 * (member[held] @ point**2 - 1.0)
            size = outwards.shape[1]
            matrix = np.block(
                [[gram + np.diag(price[block]), outwards], [outwards.T, np.zeros((size, size))]]
            )
            step = -np.linalg.lstsq(matrix, np.concatenate([first, second]), rcond=None)[0]
            point = point + step[: point.size]
            price[held] += step[point.size :]
            moved = float(np.max(np.abs(step[: point.size])))
            if moved <= 8.0 * EPSILON or (moved <= 1e-10 and moved >= 0.5 * last):
                break
            last = moved
        over = member @ point**2 > 1.0 + _WITHIN
        negative = price < -_WITHIN * max(float(np.max(np.abs(price))), np.finfo(float).tiny)
        if not np.any(over | negative):
            length = np.sqrt(member @ point**2)
            return point / np.maximum(length, 1.0)[block], held & (price > 0.0)
        held = (held | over) & ~negative
    return None


# ----------------------------------------------------------------------------
# Least squares with weights that are not negative, for the multipliers of a constrained search.
# ----------------------------------------------------------------------------

#: rounds for each unknown; a basis is usually found after two or three
_ROUNDS = 50


def nonnegative_least_squares(table: FloatArray, right: FloatArray) -> FloatArray:
    """Weights (n,) >= 0 that bring `table` (m, n) times the weights nearest to `right` (m,).

    Lawson and Hanson (1974), as scipy has it. Raises NumericalFailure where it does not end.
    """
    from scipy.optimize import nnls

    try:
        weights, _ = nnls(table, right, maxiter=_ROUNDS * table.shape[1])
    except RuntimeError as error:
        raise NumericalFailure(
            "least squares with weights that are not negative finds no end: "
            f"{table.shape[1]} conditions on {table.shape[0] - 1} variables are nearly dependent"
        ) from error
    return np.asarray(weights, dtype=float)
