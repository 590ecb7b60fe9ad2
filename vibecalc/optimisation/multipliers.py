"""Which entries, limits and bounds hold a point in place, and how hard each of them pulls."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.nonnegative import nonnegative_least_squares


class Active(NamedTuple):
    """What is taken to hold with equality: indices of entries and margins, and bound sides (n,)."""

    entries: tuple[int, ...]
    margins: tuple[int, ...]
    sides: np.ndarray


class Pulls(NamedTuple):
    """Weights of the entries (sum 1) and multipliers of margins (m,) and bounds (n,).

    `left` (n,) is what remains of the sum of gradients, `residual` its size relative to the sum
    of magnitudes or to 1, the usual slope of a scaled objective, whichever is larger.
    """

    entries: np.ndarray
    margins: np.ndarray
    bounds: np.ndarray
    left: np.ndarray
    residual: float

    @property
    def weights(self) -> np.ndarray:
        """Weights of entries and margins in the Lagrangian, (p + m,)."""
        return np.concatenate([self.entries, -self.margins])


def identify(
    vector: np.ndarray, first: np.ndarray, entries: int, unit: np.ndarray, closeness: float
) -> tuple[Active, Pulls]:
    """Find the smallest set of near-active conditions whose gradients balance.

    Parameters
    ----------
    vector : (p + m,) array
        Entries and margins at the point.
    first : (p + m, n) array
        Their gradients on the unit cube.
    entries : int
        p.
    unit : (n,) array
        The point.
    closeness : float
        Distance on the unit cube within which a condition counts as a candidate.

    Notes
    -----
    Non-negative least squares over the candidates (Lawson and Hanson, 1974): it picks linearly
    independent ones, so that equal mounts or repeated limits do no harm.
    """
    reach = closeness * (np.linalg.norm(first, axis=1) + 1e-12)
    top = np.max(vector[:entries])
    near_entries = np.flatnonzero(vector[:entries] >= top - 2 * reach[:entries])
    near_margins = np.flatnonzero(vector[entries:] <= reach[entries:])
    lower = np.flatnonzero(unit <= closeness)
    upper = np.flatnonzero(unit >= 1 - closeness)
    axes = np.eye(unit.size)
    columns = np.concatenate(
        [first[near_entries], -first[entries + near_margins], -axes[lower], axes[upper]]
    ).T
    length = np.linalg.norm(columns, axis=0)
    length = np.where(length > 0, length, 1.0)
    size = max(float(np.max(length[: near_entries.size])), 1e-300)
    lengths = np.concatenate([np.full(near_entries.size, size), length[near_entries.size :]])
    is_entry = np.arange(lengths.size) < near_entries.size
    # a heavy last row makes the weights of the entries add up to one
    table = np.vstack([columns / lengths, 1e3 * is_entry])
    goal = np.append(np.zeros(unit.size), 1e3)
    weights = nonnegative_least_squares(table, goal)
    chosen = weights > 1e-9
    split = np.cumsum([near_entries.size, near_margins.size, lower.size])
    pick_entry, pick_margin, pick_lower, pick_upper = np.split(chosen, split)
    sides = np.zeros(unit.size, dtype=int)
    sides[lower[pick_lower]] = -1
    sides[upper[pick_upper]] = 1
    active = Active(
        tuple(int(i) for i in near_entries[pick_entry]),
        tuple(int(i) for i in near_margins[pick_margin]),
        sides,
    )
    return active, balance(first, entries, active)


def balance(first: np.ndarray, entries: int, active: Active) -> Pulls:
    """Multipliers of a given active set: least squares, signs as they come out.

    Parameters
    ----------
    first : (p + m, n) array
        Gradients of entries and margins.
    entries : int
        p.
    active : Active
    """
    size = first.shape[1]
    free = active.sides == 0
    base, others = active.entries[0], active.entries[1:]
    spread = first[list(others)] - first[base] if others else np.zeros((0, size))
    holding = -first[[entries + index for index in active.margins]]
    columns = np.concatenate([spread, holding.reshape(-1, size)])[:, free].T
    length = np.linalg.norm(columns, axis=0)
    length = np.where(length > 0, length, 1.0)
    solved = np.linalg.lstsq(columns / length, -first[base][free], rcond=1e-10)[0] / length
    weights = np.zeros(entries)
    weights[list(others)] = solved[: len(others)]
    weights[base] = 1.0 - np.sum(solved[: len(others)])
    margins = np.zeros(first.shape[0] - entries)
    margins[list(active.margins)] = solved[len(others) :]
    total = weights @ first[:entries] - margins @ first[entries:]
    bounds = np.where(free, 0.0, total)
    left = np.where(free, total, 0.0)
    pull = np.linalg.norm(np.abs(weights) @ np.abs(first[:entries]))
    hold = np.linalg.norm(np.abs(margins) @ np.abs(first[entries:]))
    residual = float(np.linalg.norm(left) / max(1.0, float(pull + hold)))
    return Pulls(weights, margins, bounds, left, residual)
