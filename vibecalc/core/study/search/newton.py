"""The last digits of a smooth optimum: Newton's method on the conditions that hold it."""

from contextlib import suppress
from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.derivatives import (
    CLOSENESS,
    Held,
    gradient,
    identify,
    measured_noise,
    slopes_along,
)
from vibecalc.core.study.search.problem import Box, Sampler
from vibecalc.errors import NumericalFailure

#: a curvature below this share of the steepest rise, or of its own noise, is none
FLAT = 1e-7
ROUNDS = 12
#: sum of gradients, in scaled units, that counts as none
BALANCED = 1e-5
#: share of a variable's range within which it is on its bound
ON_BOUND = 1e-12
#: share of the last step that may still be missing after it
_SLACK = 1e-2


class Refined(NamedTuple):
    """A local optimum on the unit cube, in scaled units, what holds it and how well it is known.

    `unit` and its `error` (k,); `objective` and by how much it may be too high, `excess`; `margins`
    (m,) and `bounds` (k,) are multipliers, `sides` (k,) the bounds that hold; `reach` (k,) is the
    root of the diagonal of the inverse curvature: how far a coordinate moves where half a unit of
    height is spent. `method` as of `problem.Optimum`; so many searches ended here: `found_by`.
    """

    unit: np.ndarray
    error: np.ndarray
    excess: float
    objective: float
    margins: np.ndarray
    bounds: np.ndarray
    sides: np.ndarray
    residual: float = 0.0
    free_directions: int = 0
    method: str = "newton"
    reach: np.ndarray | float = 0.0
    found_by: int = 0


def walls(box: Box, unit: np.ndarray) -> np.ndarray:
    """-1 and 1 where a point (k,) is on its lower or upper bound but for round-off, else 0."""
    sides = np.where(unit <= ON_BOUND, -1, np.where(unit >= 1 - ON_BOUND, 1, 0))
    return np.where(box.around, 0, sides)


def polish(values: Sampler, start: np.ndarray) -> Refined | None:
    """Refine the end of a local search; None where no smooth optimum is found nearby.

    Parameters
    ----------
    values : Sampler
    start : (k,) array
        Point of the unit cube close to a local optimum.

    Notes
    -----
    Parts of the objective that are as large as the largest, and limits that hold, are conditions
    on the part that weighs most. They are met by Newton's method with their pseudo-inverse; along
    the directions they leave, by Newton's method with the curvature of the Lagrangian (null-space
    method: J. Nocedal and S. J. Wright, Numerical Optimization, 2nd ed. 2006, sec. 18.3). What
    holds is asked anew in each round, among what is close; if that leads nowhere, among more.
    """
    with suppress(NumericalFailure):
        newton = _Newton(values, start)
        for closeness in CLOSENESS:
            refined = newton.refined(closeness)
            if refined is not None:
                return refined
    return None


class _Newton:
    """Newton's method from a start near an optimum."""

    def __init__(self, values: Sampler, start: np.ndarray):
        self.values, self.start, self.noise = values, start, measured_noise(values, start)
        self.bias, self.leaning = values.bias(start), values.leaning(start)

    def refined(self, closeness: float) -> Refined | None:
        """The optimum, with what is so close as what may hold it."""
        values, noise, bias = self.values, self.noise, self.bias
        box, parts, unit, last = values.box, values.parts, self.start, np.inf
        for turn in range(ROUNDS):
            slopes = gradient(values, unit, noise)
            held = identify(values, unit, slopes.first, closeness)
            weights, free = np.abs(held.weights), held.sides == 0
            if (turn == 0 and held.residual > 0.3) or np.any(slopes.kinked[weights > 0]):
                return None
            lead = int(np.argmax(held.weights[:parts]))
            rows = np.flatnonzero(weights)
            rows = rows[rows != lead]
            # what is held at zero: less the leading part, of parts
            among = np.eye(noise.size)[rows]
            among[:, lead] -= rows < parts
            inverse, along = _split(among @ slopes.first, free)
            blur = weights @ slopes.error
            tangent = self._tangent(unit, along, held, blur + weights @ self.leaning)
            if tangent is None:
                return None
            step, error, excess, free_directions, reach = tangent
            fixed = np.where(free, unit, np.where(held.sides < 0, 0.0, 1.0))
            moved = self._onto(box.fold(fixed + step), among, inverse)
            vector = None if moved is None else values(moved)
            if (
                moved is None
                or vector is None
                or np.max(np.abs(box.apart(self.start, moved))) > 0.1
            ):
                return None
            length = float(np.max(np.abs(box.apart(unit, moved)), initial=0.0))
            left = np.abs(among) @ (noise + bias) + np.abs(among @ vector)
            error = error + np.abs(inverse) @ left
            unit, ratio = moved, min(0.95, length / last)  # of steps near zero, but where singular
            if length >= 1e-4 or not (_SLACK * length <= np.max(error) or ratio > 0.3):
                last = length if length < 1e-4 else np.inf
                continue
            off = np.append(vector[:parts] - vector[lead], -vector[parts:]) - 10 * noise
            unbalanced = held.residual > BALANCED or np.max(blur) > 1e2 * BALANCED
            if unbalanced or np.max(np.where(weights > 0, 0.0, off)) > 1e-12:
                return None
            pulls = np.where(free, 0.0, held.total)
            # a bound that hardly pulls may be a little off the exact optimum
            weak = ~free & (np.abs(pulls) <= 10 * blur)
            far = np.where(free, max(_SLACK, ratio / (1 - ratio)) * length, 0.0)
            excess += float(weights[rows] @ left + noise[lead] + bias[lead])
            return Refined(
                unit=unit,
                error=error + far + np.where(weak, 10 * blur, 0.0),
                excess=excess + float(np.abs(held.total) @ far),
                objective=float(np.max(vector[:parts])),
                margins=-held.weights[parts:],
                bounds=pulls,
                sides=held.sides,
                residual=held.residual,
                free_directions=free_directions,
                reach=reach,
            )
        return None

    def _onto(self, unit: np.ndarray, among: np.ndarray, inverse: np.ndarray) -> np.ndarray | None:
        """A point where all conditions are zero: chords, whose inverse stays, one value each."""
        vector, noise = self.values(unit), np.abs(among) @ self.noise
        for _ in range(6):
            if vector is None or np.all(np.abs(among @ vector) <= noise):
                break
            trial = self.values.box.fold(unit - inverse @ (among @ vector))
            there = self.values(trial)
            if there is None:
                return None
            if np.max(np.abs(among @ there)) >= 0.9 * np.max(np.abs(among @ vector)):
                break
            unit, vector = trial, there
        return unit

    def _tangent(
        self, unit: np.ndarray, along: np.ndarray, held: Held, blur: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, float, int, np.ndarray] | None:
        """The step down the curvature of the Lagrangian along columns (k, d), gradients `blur`red.

        Step (k,) and its error, by how much the objective may be too high, free directions and
        `reach`. None at a saddle and on a slope without curvature.
        """
        count = along.shape[1]
        if not count:
            return np.zeros(unit.size), np.zeros(unit.size), 0.0, 0, np.zeros(unit.size)
        # mixed ones by polarisation, from the directions between
        pairs = np.array([(row, column) for row in range(count) for column in range(row + 1)])
        between = along.T[pairs[:, 0]] + along.T[pairs[:, 1]]
        between /= np.linalg.norm(between, axis=1)[:, None]
        bend = slopes_along(self.values, unit, between, self.noise)
        unsure = float(np.max(np.abs(held.weights) @ bend.second_error))
        table = np.zeros((count, count))
        table[tuple(pairs.T)] = table[tuple(pairs.T[::-1])] = held.weights @ bend.second
        diagonal = np.diag(table)
        mixed = table - 0.5 * (diagonal[:, None] + diagonal[None, :])
        curvature = np.where(np.eye(count, dtype=bool), table, mixed)
        steepness, blur = along.T @ held.total, np.abs(along).T @ blur
        bends, vectors = np.linalg.eigh(curvature)
        scale = max(float(np.max(np.abs(bends))), held.steepest)
        bent = bends > FLAT * scale + 2 * unsure
        falling = np.max(np.abs(vectors[:, ~bent].T @ steepness), initial=0.0)
        saddle = np.any(bends < -(1e-4 * scale + 2 * unsure))
        if saddle or falling > 1e-5 * scale + 4 * float(np.max(blur)):
            return None
        soft = vectors[:, bent] / bends[bent]
        move = -soft @ (vectors[:, bent].T @ steepness)
        spread = np.abs(soft) @ (np.abs(vectors[:, bent]).T @ blur)
        return (
            along @ (move * (0.1 / max(0.1, float(np.max(np.abs(move)))))),
            np.abs(along) @ spread,
            float(spread @ np.abs(curvature) @ spread),
            int(np.sum(~bent)),
            np.linalg.norm(along @ (vectors[:, bent] / np.sqrt(bends[bent])), axis=1),
        )


def _split(rows: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pseudo-inverse (k, c) of rows (c, k) over the `free` coordinates, and what they leave."""
    left, singular, right = np.linalg.svd(rows[:, free], full_matrices=True)
    rank = int(np.sum(singular > 1e-8 * max(float(np.max(singular, initial=0.0)), 1e-300)))
    inverse, along = np.zeros(rows.T.shape), np.zeros((free.size, right.shape[0] - rank))
    inverse[free] = right[:rank].T @ (left[:, :rank] / singular[:rank]).T
    along[free] = right[rank:].T
    return inverse, along
