"""All natural frequencies of a tree of shafts by counting modes and halving brackets.

A bracket holds by its counts, so that no mode is missed however close two of them are. Halving
the stored numbers instead of their values reaches neighbouring doubles in some 60 steps for
frequencies of any size.
"""

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.count import Tree, modes_below

#: no natural frequency is sought below this share of the upper bound
_LOWEST = 1e-100


def highest(tree: Tree) -> float:
    """An upper bound (rad/s) of all frequencies: w^2 <= 2 max(K_ii / J_i) (Gershgorin)."""
    diagonal = tree.ground.copy()
    for index in range(1, len(tree.station)):
        diagonal[index] += tree.stiffness[index]
        diagonal[tree.parent[index]] += tree.stiffness[index]
    heavy = tree.inertia > 0.0
    return float(np.sqrt(2.0 * np.max(diagonal[heavy] / tree.inertia[heavy])) * 1.001)


def tree_frequencies(
    tree: Tree, start: FloatArray | None = None, start_error: float = 0.0
) -> FloatArray:
    """Natural frequencies (m,) in rad/s, ascending, of m stations with inertia; rigid exactly 0.

    `start` (m,) with an absolute `start_error` shortens the search where its brackets hold.
    Relative error: some roundings (see `relative_error`). Raises `NumericalFailure` if the counts
    contradict the number of modes, which only a range of values beyond 1e100 can do.
    """
    modes = int(np.count_nonzero(tree.inertia))
    rigid = 0 if np.any(tree.ground) else 1
    wanted = np.arange(rigid, modes)
    if not wanted.size:
        return np.zeros(modes)
    top = highest(tree)
    low, high = np.full(wanted.shape, top * _LOWEST), np.full(wanted.shape, top)
    if start is not None:
        below = np.maximum(start[rigid:] - start_error, low)
        above = np.minimum(start[rigid:] + start_error, high)
        low = np.where(modes_below(tree, below) <= wanted, below, low)
        high = np.where(modes_below(tree, above) > wanted, above, high)
    elif np.any(modes_below(tree, low[:1]) != rigid) or np.any(modes_below(tree, high[:1]) < modes):
        raise NumericalFailure(
            "the modes of the shaft line cannot be counted: its stiffnesses and inertias span "
            "too wide a range"
        )
    left, right = low.view(np.int64), high.view(np.int64)
    while np.any(right - left > 1):
        middle = left + (right - left) // 2
        under = modes_below(tree, middle.view(np.float64)) > wanted
        left, right = np.where(under, left, middle), np.where(under, middle, right)
    return np.concatenate([np.zeros(rigid), right.view(np.float64)])


def relative_error(count: int) -> float:
    """Roundings of a frequency: that of each of `count` stations adds up like a random walk."""
    return float((40.0 + 2.0 * np.sqrt(count)) * EPSILON)
