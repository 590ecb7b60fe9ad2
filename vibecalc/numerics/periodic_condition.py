"""How far rounding moves the eigenvalues of a product of matrices that is kept as triangles.

An error E in panel p moves an eigenvalue by y' E x / (y' x): x is its right eigenvector on the way
into the panel, y its left one on the way out, and y' x that of the whole product. Far from normal,
y' x is small.

Source: first-order perturbation, Golub and Van Loan, Matrix Computations, sec. 7.2, panel by panel.
"""

import numpy as np

from vibecalc.numerics.periodic_condense import solve_or_nan
from vibecalc.numerics.typing import FloatArray

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
