"""The last digits of a smooth optimum: Newton's method on the conditions that hold it."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.conditions import (
    CLOSENESS,
    Active,
    Gradient,
    Pulls,
    balance,
    gradient,
    identify,
    measured_noise,
    slope,
)
from vibecalc.core.study.search.problem import Values
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# One Newton step to the conditions that hold an optimum and along what they leave free.
# ----------------------------------------------------------------------------

#: a curvature below this share of the steepest rise, or of its own noise, is none
FLAT = 1e-7


class NewtonStep(NamedTuple):
    """The point after a step, its error (n,), and by how much the objective may be too high.

    `length` is the largest change of a coordinate; `reach` (n,) the root of the diagonal of the
    inverse curvature, how far a coordinate moves where half a unit of height is spent.
    """

    unit: np.ndarray
    error: np.ndarray
    excess: float
    free_directions: int
    length: float
    reach: np.ndarray


def newton_step(
    sampler: Values,
    unit: np.ndarray,
    slopes: Gradient,
    noise: np.ndarray,
    bias: np.ndarray,
    leaning: np.ndarray,
    active: Active,
    pulls: Pulls,
) -> NewtonStep | None:
    """Step to the conditions and down the curvature of the Lagrangian; None where that fails.

    Parameters
    ----------
    sampler : Values
    unit : (n,) array
        Point of the unit cube, with derivatives `slopes`.
    noise, bias : (1 + m,) arrays
        Noise of the values, and a systematic error that a smooth method cannot see.
    leaning : (1 + m, n) array
        Slopes of that error.
    active, pulls : Active, Pulls
        What is taken to hold, and the multipliers at the point.

    Notes
    -----
    None is returned at a saddle, on a slope without curvature, and where the step leaves the
    points that can be evaluated.
    """
    free = active.sides == 0
    unit = np.where(active.sides < 0, 0.0, np.where(active.sides > 0, 1.0, unit))
    rows = [1 + index for index in active.margins]
    left, singular, right = np.linalg.svd(slopes.first[rows][:, free], full_matrices=True)
    rank = int(np.sum(singular > 1e-8 * max(float(np.max(singular, initial=0.0)), 1e-300)))
    inverse = right[:rank].T @ (left[:, :rank] / singular[:rank]).T
    along = np.zeros((unit.size, right.shape[0] - rank))
    along[free] = right[rank:].T
    weights = np.abs(pulls.weights)

    step, error, excess = np.zeros(unit.size), np.zeros(unit.size), 0.0
    free_directions, reach = 0, np.zeros(unit.size)
    if along.shape[1]:
        curvature, unsure = _curvature(sampler, unit, along, pulls.weights, noise)
        steepness = along.T @ pulls.left
        blur = np.abs(along).T @ (weights @ (slopes.error + leaning))
        values, vectors = np.linalg.eigh(curvature)
        scale = max(
            float(np.max(np.abs(values))), float(weights @ np.linalg.norm(slopes.first, axis=1))
        )
        bent = values > FLAT * scale + 2 * unsure
        if np.any(values < -(1e-4 * scale + 2 * unsure)):
            return None  # a saddle
        free_directions = int(np.sum(~bent))
        reach = np.linalg.norm(along @ (vectors[:, bent] / np.sqrt(values[bent])), axis=1)
        soft = vectors[:, bent] / values[bent]
        move = -soft @ (vectors[:, bent].T @ steepness)
        if np.max(np.abs(vectors[:, ~bent].T @ steepness), initial=0.0) > (
            1e-5 * scale + 4 * float(np.max(blur))
        ):
            return None  # still falling in a direction without curvature
        spread = np.abs(soft) @ (np.abs(vectors[:, bent]).T @ blur)
        step = along @ (move * (0.1 / max(0.1, float(np.max(np.abs(move))))))
        error = np.abs(along) @ spread
        excess = float(spread @ np.abs(curvature) @ spread)
    moved = np.clip(unit + step, 0, 1)
    vector = sampler(moved)
    if vector is None:
        return None
    for _ in range(6):  # chords: the inverse stays, one evaluation each
        if np.all(np.abs(vector[rows]) <= noise[rows]):
            break
        trial = moved.copy()
        trial[free] -= inverse @ vector[rows]
        trial = np.clip(trial, 0, 1)
        there = sampler(trial)
        if there is None:
            return None
        if np.max(np.abs(there[rows])) >= 0.9 * np.max(np.abs(vector[rows])):
            break
        moved, vector = trial, there
    uncertainty = noise[rows] + bias[rows] + np.abs(vector[rows])
    error[free] += np.abs(inverse) @ uncertainty
    excess += float(weights[rows] @ uncertainty + noise[0] + bias[0])
    length = float(np.max(np.abs(moved - unit), initial=0.0))
    return NewtonStep(moved, error, excess, free_directions, length, reach)


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
            second = slope(sampler, unit, between / np.linalg.norm(between), noise)
            table[row, column] = table[column, row] = weights @ second.second
            unsure = max(unsure, float(np.abs(weights) @ second.second_error))
    diagonal = np.diag(table)
    mixed = table - 0.5 * (diagonal[:, None] + diagonal[None, :])
    return np.where(np.eye(count, dtype=bool), table, mixed), unsure


# ----------------------------------------------------------------------------
# The last digits of a smooth optimum: Newton's method on the conditions that hold it.
# ----------------------------------------------------------------------------

ROUNDS = 12
#: sum of gradients, in scaled units, that counts as none
BALANCED = 1e-5
#: share of the last step that may still be missing after it
_SLACK = 1e-2


class PolishedOptimum(NamedTuple):
    """An optimum on the unit cube, in scaled units; `error` (n,) is of `unit`."""

    unit: np.ndarray
    error: np.ndarray
    excess: float
    active: Active
    pulls: Pulls
    free_directions: int
    reach: np.ndarray


def polish(
    sampler: Values, start: np.ndarray, bias: np.ndarray, leaning: np.ndarray
) -> PolishedOptimum | None:
    """Refine the end of a local search; None where no smooth optimum is found nearby.

    Parameters
    ----------
    sampler : Values
    start : (n,) array
        Point of the unit cube close to a local optimum.
    bias, leaning : (1 + m,) and (1 + m, n) arrays
        Errors of objective and margins, and their slopes, where the caller knows.

    Returns
    -------
    polished : PolishedOptimum or None
        `excess` bounds the distance of the objective from that of the exact optimum.

    Notes
    -----
    Conditions that hold (margins at zero, variables on bounds) are met by Newton's method with
    their pseudo-inverse; along the directions they leave, by Newton's method with the curvature
    of the Lagrangian (null-space method: J. Nocedal and S. J. Wright,
    Numerical Optimization, 2nd ed. 2006, sec. 18.3). A condition with a multiplier of the wrong
    sign is dropped, one that is violated is added.
    """
    try:
        noise = measured_noise(sampler, start)
        slopes = gradient(sampler, start, noise)
        vector = sampler(start)
        assert vector is not None
        tried: list[tuple[object, ...]] = []
        for closeness in CLOSENESS:
            active, pulls = identify(vector, slopes.first, start, closeness)
            key = (active.margins, *active.sides.tolist())
            if pulls.residual <= 0.3 and key not in tried:
                tried.append(key)
                polished = _from(sampler, start, noise, bias, leaning, slopes, active, pulls)
                if polished is not None:
                    return polished
    except NumericalFailure:
        pass
    return None


def _from(
    sampler: Values,
    start: np.ndarray,
    noise: np.ndarray,
    bias: np.ndarray,
    leaning: np.ndarray,
    slopes: Gradient,
    active: Active,
    pulls: Pulls,
) -> PolishedOptimum | None:
    """Newton steps and changes of the active set until nothing moves."""
    unit = start
    last = np.inf
    for _ in range(ROUNDS):
        if np.any(slopes.kinked & (np.abs(pulls.weights) > 1e-9)):
            return None
        step = newton_step(sampler, unit, slopes, noise, bias, leaning, active, pulls)
        if step is None or np.max(np.abs(step.unit - start)) > 0.1:
            return None
        unit = step.unit
        adjusted = _adjust(sampler, unit, noise, active)
        if adjusted is None and step.length < 1e-4:
            ratio = min(0.95, step.length / last)  # near zero, but where the optimum is singular
            if _SLACK * step.length <= np.max(step.error) or ratio > 0.3:
                dropped = _wrong_sign(pulls, slopes.first, active)
                if dropped is None:
                    missing = max(_SLACK, ratio / (1 - ratio)) * step.length
                    return _accepted(step, missing, slopes, active, pulls)
                active, last = dropped, np.inf
            else:
                last = step.length
        elif adjusted is not None:
            active, last = adjusted, np.inf
        slopes = gradient(sampler, unit, noise)
        pulls = balance(slopes.first, active)
    return None


def _accepted(
    step: NewtonStep, missing: float, slopes: Gradient, active: Active, pulls: Pulls
) -> PolishedOptimum | None:
    """The end of the iteration with all its errors, or None if the gradients do not balance."""
    blur = np.abs(pulls.weights) @ slopes.error
    if pulls.residual > BALANCED or np.max(blur) > 1e2 * BALANCED:
        return None
    # a bound that hardly pulls may be a little off the exact optimum
    weak = (active.sides != 0) & (np.abs(pulls.bounds) <= 10 * blur)
    far = np.where(active.sides == 0, missing, 0.0)
    return PolishedOptimum(
        unit=step.unit,
        error=step.error + far + np.where(weak, 10 * blur, 0.0),
        excess=step.excess + float(np.abs(pulls.left) @ far),
        active=active,
        pulls=pulls,
        free_directions=step.free_directions,
        reach=step.reach,
    )


def _adjust(sampler: Values, unit: np.ndarray, noise: np.ndarray, active: Active) -> Active | None:
    """The active set with the worst violated condition added, or None if there is none."""
    vector = sampler(unit)
    assert vector is not None
    over = -vector[1:] - 10 * noise[1:]
    over[list(active.margins)] = -1.0
    if np.max(over, initial=0.0) > 1e-12:
        return active._replace(margins=(*active.margins, int(np.argmax(over))))
    walls = (active.sides == 0) & ((unit <= 0) | (unit >= 1))
    if np.any(walls):
        return active._replace(sides=np.where(walls, np.where(unit <= 0, -1, 1), active.sides))
    return None


def _wrong_sign(pulls: Pulls, first: np.ndarray, active: Active) -> Active | None:
    """The active set without its most wrongly pulling condition, or None if all pull rightly."""
    held = np.flatnonzero(active.sides)
    pull = np.concatenate(
        [
            (pulls.margins * np.linalg.norm(first[1:], axis=1))[list(active.margins)],
            -(active.sides * pulls.bounds)[held],
        ]
    )
    if np.min(pull, initial=0.0) >= -1e-7 * max(float(np.linalg.norm(first[0])), 1e-300):
        return None
    worst = int(np.argmin(pull))
    if worst < len(active.margins):
        margins = active.margins[:worst] + active.margins[worst + 1 :]
        return active._replace(margins=margins)
    sides = active.sides.copy()
    sides[held[worst - len(active.margins)]] = 0
    return active._replace(sides=sides)
