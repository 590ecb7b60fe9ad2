"""One Newton step to the conditions that hold an optimum and along what they leave free."""

from typing import NamedTuple

import numpy as np

from vibecalc.optimisation.differences import Gradient, slope
from vibecalc.optimisation.multipliers import Active, Pulls
from vibecalc.optimisation.sampler import Values

#: a curvature below this share of the steepest rise, or of its own noise, is none
FLAT = 1e-7


class Step(NamedTuple):
    """The point after a step, its error (n,), and by how much the objective may be too high.

    `length` is the largest change of a coordinate; `least_curvature` that of the directions
    which are not free, infinite without any.
    """

    unit: np.ndarray
    error: np.ndarray
    rise: float
    free_directions: int
    length: float
    least_curvature: float


def newton_step(
    sampler: Values,
    unit: np.ndarray,
    slopes: Gradient,
    noise: np.ndarray,
    bias: np.ndarray,
    active: Active,
    pulls: Pulls,
) -> Step | None:
    """Step to the conditions and down the curvature of the Lagrangian; None where that fails.

    Parameters
    ----------
    sampler : Values
    unit : (n,) array
        Point of the unit cube, with derivatives `slopes`.
    noise, bias : (p + m,) arrays
        Noise of the values, and a systematic error that a smooth method cannot see.
    active, pulls : Active, Pulls
        What is taken to hold, and the multipliers at the point.

    Notes
    -----
    None is returned at a saddle, on a slope without curvature, and where the step leaves the
    points that can be evaluated.
    """
    entries = sampler.entries
    free = active.sides == 0
    size = int(np.sum(free))
    unit = np.where(active.sides < 0, 0.0, np.where(active.sides > 0, 1.0, unit))
    rows = [*active.entries[1:], *(entries + index for index in active.margins)]
    base = active.entries[0]
    equal = len(active.entries) - 1
    jacobian = slopes.first[rows][:, free]
    jacobian[:equal] -= slopes.first[base, free]
    scatter = noise[rows].copy()
    scatter[:equal] += noise[base]
    unseen = bias[rows]
    unseen[:equal] += bias[base]
    left, singular, right = np.linalg.svd(jacobian, full_matrices=True)
    rank = int(np.sum(singular > 1e-8 * max(float(np.max(singular, initial=0.0)), 1e-300)))
    inverse = right[:rank].T @ (left[:, :rank] / singular[:rank]).T
    along = np.zeros((unit.size, size - rank))
    along[free] = right[rank:].T
    weights = pulls.weights

    step = np.zeros(unit.size)
    error = np.zeros(unit.size)
    rise = 0.0
    free_directions = 0
    least_curvature = np.inf
    if along.shape[1]:
        curvature, unsure = _curvature(sampler, unit, along, weights, noise)
        steepness = along.T @ pulls.left
        blur = np.abs(along).T @ (np.abs(weights) @ slopes.error + np.abs(weights) @ bias)
        values, vectors = np.linalg.eigh(curvature)
        scale = max(
            float(np.max(np.abs(values), initial=0.0)),
            float(np.abs(weights) @ np.linalg.norm(slopes.first, axis=1)),
        )
        bent = values > FLAT * scale + 2 * unsure
        if np.any(values < -(1e-4 * scale + 2 * unsure)):
            return None  # a saddle
        free_directions = int(np.sum(~bent))
        least_curvature = float(np.min(values[bent], initial=np.inf))
        soft = vectors[:, bent] / np.where(bent, values, 1.0)[bent]
        move = -soft @ (vectors[:, bent].T @ steepness)
        if np.max(np.abs(vectors[:, ~bent].T @ steepness), initial=0.0) > (
            1e-5 * scale + 4 * float(np.max(blur))
        ):
            return None  # still falling in a direction without curvature
        spread = np.abs(soft) @ (np.abs(vectors[:, bent]).T @ blur)
        limit = 0.1 / max(0.1, float(np.max(np.abs(move))))
        step = along @ (move * limit)
        error = np.abs(along) @ spread
        rise = float(spread @ np.abs(curvature) @ spread)
    moved = np.clip(unit + step, 0, 1)
    vector = sampler(moved)
    if vector is None:
        return None
    kept = _conditions(vector, entries, active)
    for _ in range(6):  # chords: the inverse stays, one evaluation each
        if not kept.size or np.all(np.abs(kept) <= scatter):
            break
        trial = moved.copy()
        trial[free] -= inverse @ kept
        trial = np.clip(trial, 0, 1)
        there = sampler(trial)
        if there is None:
            return None
        next_kept = _conditions(there, entries, active)
        if np.max(np.abs(next_kept)) >= 0.9 * np.max(np.abs(kept)):
            break
        moved, vector, kept = trial, there, next_kept
    doubt = scatter + unseen + np.abs(kept)
    error[free] += np.abs(inverse) @ doubt
    pull = np.abs(
        np.concatenate(
            [pulls.entries[list(active.entries[1:])], pulls.margins[list(active.margins)]]
        )
    )
    rise += float(pull @ doubt) + float(np.max((noise + bias)[list(active.entries)]))
    length = float(np.max(np.abs(moved - unit), initial=0.0))
    return Step(moved, error, rise, free_directions, length, least_curvature)


def _curvature(
    sampler: Values,
    unit: np.ndarray,
    along: np.ndarray,
    weights: np.ndarray,
    noise: np.ndarray,
) -> tuple[np.ndarray, float]:
    """Second derivatives of the Lagrangian along the columns of `along`, and their error."""
    count = along.shape[1]
    table = np.zeros((count, count))
    unsure = 0.0
    for row in range(count):
        for column in range(row + 1):  # mixed ones by polarisation, from the direction between
            between = along[:, row] + along[:, column]
            found = slope(sampler, unit, between / np.linalg.norm(between), noise)
            table[row, column] = table[column, row] = weights @ found.second
            unsure = max(unsure, float(np.abs(weights) @ found.second_error))
    own = np.diag(table)
    mixed = table - 0.5 * (own[:, None] + own[None, :])
    return np.where(np.eye(count, dtype=bool), table, mixed), unsure


def _conditions(vector: np.ndarray, entries: int, active: Active) -> np.ndarray:
    base = vector[active.entries[0]]
    equal = [vector[index] - base for index in active.entries[1:]]
    return np.array(equal + [vector[entries + index] for index in active.margins])
