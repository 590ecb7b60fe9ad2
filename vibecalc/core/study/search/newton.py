"""The last digits of a smooth optimum: Newton's method on the conditions that hold it."""

from typing import NamedTuple

import numpy as np

from vibecalc.core.study.search.derivatives import (
    CLOSENESS,
    Active,
    Pulls,
    Slope,
    about,
    balance,
    gradient,
    identify,
    measured_noise,
    slope,
)
from vibecalc.core.study.search.problem import Box, Values, View
from vibecalc.errors import NumericalFailure

#: a curvature below this share of the steepest rise, or of its own noise, is none
FLAT = 1e-7
ROUNDS = 12
#: sum of gradients, in scaled units, that counts as none
BALANCED = 1e-5
#: share of the last step that may still be missing after it
_SLACK = 1e-2


class Refined(NamedTuple):
    """A local optimum on the unit cube, in scaled units, what holds it and how well it is known.

    `unit` and its `error` (k,); `objective` and by how much it may be too high, `excess`; `margins`
    (m,) and `bounds` (k,) are multipliers, `sides` (k,) the bounds that hold; `reach` (k,) is the
    root of the diagonal of the inverse curvature: how far a coordinate moves where half a unit of
    height is spent. `method` as of `problem.Optimum`.
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
    reach: np.ndarray | None = None


def walls(box: Box, unit: np.ndarray) -> np.ndarray:
    """-1 and 1 where a point (k,) is on its lower or upper bound, else 0."""
    sides = np.where(unit <= 0, -1, np.where(unit >= 1, 1, 0))
    return np.where(box.around, 0, sides)


class _Step(NamedTuple):
    """The point after a step and its errors as of `Refined`; `length` of its largest coordinate."""

    unit: np.ndarray
    error: np.ndarray
    excess: float
    free_directions: int
    length: float
    reach: np.ndarray


def polish(
    values: Values, start: np.ndarray, bias: np.ndarray, leaning: np.ndarray
) -> Refined | None:
    """Refine the end of a local search; None where no smooth optimum is found nearby.

    Parameters
    ----------
    values : Sampler or View
    start : (k,) array
        Point of the unit cube close to a local optimum.
    bias, leaning : (v,) and (v, k) arrays
        Errors of parts and margins, and their slopes, where the caller knows.

    Notes
    -----
    Parts of the objective that are as large as the largest, and limits that hold, are conditions
    on the smooth part that leads. They are met by Newton's method with their pseudo-inverse; along
    the directions they leave, by Newton's method with the curvature of the Lagrangian (null-space
    method: J. Nocedal and S. J. Wright, Numerical Optimization, 2nd ed. 2006, sec. 18.3). A
    condition with a multiplier of the wrong sign is dropped, one that is violated is added.
    """
    try:
        noise = measured_noise(values, start)
        first = gradient(values, start, noise).first
        tried: list[tuple[object, ...]] = []
        for closeness in CLOSENESS:
            active = identify(values, start, first, closeness)
            key = (active.lead, active.margins, *active.sides.tolist())
            if key in tried:
                continue
            tried.append(key)
            refined = _Newton(values, active.lead, noise, bias, leaning).run(start, active)
            if refined is not None:
                return refined
    except NumericalFailure:
        pass
    return None


class _Newton:
    """Newton steps with one part leading and all others as margins below it."""

    def __init__(
        self, values: Values, lead: int, noise: np.ndarray, bias: np.ndarray, leaning: np.ndarray
    ):
        turned = about(lead, values.parts, noise.size)
        self.view = View(values, lambda vector: turned @ vector)
        self.others = values.parts - 1
        self.noise, self.bias = np.abs(turned) @ noise, np.abs(turned) @ bias
        self.leaning = np.abs(turned) @ leaning

    def run(self, start: np.ndarray, active: Active) -> Refined | None:
        """Newton steps and changes of the active set until nothing moves."""
        unit, last, box = start, np.inf, self.view.box
        for turn in range(ROUNDS):
            slopes = gradient(self.view, unit, self.noise)
            pulls = balance(slopes.first, active)
            if turn == 0 and pulls.residual > 0.3:
                return None
            if np.any(np.any(slopes.kinked, axis=1) & (np.abs(pulls.weights) > 1e-9)):
                return None
            step = self._step(unit, slopes, active, pulls)
            if step is None or np.max(np.abs(box.apart(start, step.unit))) > 0.1:
                return None
            unit = step.unit
            changed = self._violated(unit, active)
            if changed is None and step.length < 1e-4:
                ratio = min(0.95, step.length / last)  # near zero, but where it is singular
                if _SLACK * step.length <= np.max(step.error) or ratio > 0.3:
                    changed = _wrong_sign(pulls, slopes.first, active)
                    if changed is None:
                        missing = max(_SLACK, ratio / (1 - ratio)) * step.length
                        return self._accepted(step, missing, slopes, active, pulls)
                else:
                    last = step.length
            if changed is not None:
                active, last = changed, np.inf
        return None

    def _step(self, unit: np.ndarray, slopes: Slope, active: Active, pulls: Pulls) -> _Step | None:
        """Step to the conditions and down the curvature of the Lagrangian.

        None at a saddle, on a slope without curvature, and where the step leaves the points that
        can be evaluated.
        """
        view, noise = self.view, self.noise
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
            curvature, unsure = self._curvature(unit, along, pulls.weights)
            steepness = along.T @ pulls.left
            blur = np.abs(along).T @ (weights @ (slopes.error + self.leaning))
            bends, vectors = np.linalg.eigh(curvature)
            steepest = float(weights @ np.linalg.norm(slopes.first, axis=1))
            scale = max(float(np.max(np.abs(bends))), steepest)
            bent = bends > FLAT * scale + 2 * unsure
            if np.any(bends < -(1e-4 * scale + 2 * unsure)):
                return None  # a saddle
            falling = np.max(np.abs(vectors[:, ~bent].T @ steepness), initial=0.0)
            if falling > 1e-5 * scale + 4 * float(np.max(blur)):
                return None  # still falling in a direction without curvature
            free_directions = int(np.sum(~bent))
            reach = np.linalg.norm(along @ (vectors[:, bent] / np.sqrt(bends[bent])), axis=1)
            soft = vectors[:, bent] / bends[bent]
            move = -soft @ (vectors[:, bent].T @ steepness)
            spread = np.abs(soft) @ (np.abs(vectors[:, bent]).T @ blur)
            step = along @ (move * (0.1 / max(0.1, float(np.max(np.abs(move))))))
            error = np.abs(along) @ spread
            excess = float(spread @ np.abs(curvature) @ spread)
        moved = view.box.fold(unit + step)
        vector = view(moved)
        if vector is None:
            return None
        for _ in range(6):  # chords: the inverse stays, one evaluation each
            if np.all(np.abs(vector[rows]) <= noise[rows]):
                break
            trial = moved.copy()
            trial[free] -= inverse @ vector[rows]
            trial = view.box.fold(trial)
            there = view(trial)
            if there is None:
                return None
            if np.max(np.abs(there[rows])) >= 0.9 * np.max(np.abs(vector[rows])):
                break
            moved, vector = trial, there
        uncertainty = noise[rows] + self.bias[rows] + np.abs(vector[rows])
        error[free] += np.abs(inverse) @ uncertainty
        excess += float(weights[rows] @ uncertainty + noise[0] + self.bias[0])
        length = float(np.max(np.abs(view.box.apart(unit, moved)), initial=0.0))
        return _Step(moved, error, excess, free_directions, length, reach)

    def _curvature(
        self, unit: np.ndarray, along: np.ndarray, weights: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Second derivatives of the Lagrangian along the columns of `along`, and their error."""
        count = along.shape[1]
        table, unsure = np.zeros((count, count)), 0.0
        for row in range(count):
            for column in range(row + 1):  # mixed ones by polarisation, from the direction between
                between = along[:, row] + along[:, column]
                direction = between / np.linalg.norm(between)
                second = slope(self.view, unit, direction, self.noise)
                table[row, column] = table[column, row] = weights @ second.second
                unsure = max(unsure, float(np.abs(weights) @ second.second_error))
        diagonal = np.diag(table)
        mixed = table - 0.5 * (diagonal[:, None] + diagonal[None, :])
        return np.where(np.eye(count, dtype=bool), table, mixed), unsure

    def _violated(self, unit: np.ndarray, active: Active) -> Active | None:
        """The active set with the worst violated condition added, or None if there is none."""
        vector = self.view(unit)
        assert vector is not None
        over = -vector[1:] - 10 * self.noise[1:]
        over[list(active.margins)] = -1.0
        if np.max(over, initial=0.0) > 1e-12:
            return active._replace(margins=(*active.margins, int(np.argmax(over))))
        sides = np.where(active.sides == 0, walls(self.view.box, unit), active.sides)
        return None if np.array_equal(sides, active.sides) else active._replace(sides=sides)

    def _accepted(
        self, step: _Step, missing: float, slopes: Slope, active: Active, pulls: Pulls
    ) -> Refined | None:
        """The end of the iteration with all its errors, or None if the gradients do not balance."""
        blur = np.abs(pulls.weights) @ slopes.error
        leading = 1.0 - float(np.sum(pulls.margins[: self.others]))
        if pulls.residual > BALANCED or np.max(blur) > 1e2 * BALANCED or leading < -BALANCED:
            return None
        # a bound that hardly pulls may be a little off the exact optimum
        weak = (active.sides != 0) & (np.abs(pulls.bounds) <= 10 * blur)
        far = np.where(active.sides == 0, missing, 0.0)
        vector = self.view(step.unit)
        assert vector is not None
        return Refined(
            unit=step.unit,
            error=step.error + far + np.where(weak, 10 * blur, 0.0),
            excess=step.excess + float(np.abs(pulls.left) @ far),
            objective=float(vector[0]),
            margins=pulls.margins[self.others :],
            bounds=pulls.bounds,
            sides=active.sides,
            residual=pulls.residual,
            free_directions=step.free_directions,
            reach=step.reach,
        )


def _wrong_sign(pulls: Pulls, first: np.ndarray, active: Active) -> Active | None:
    """The active set without its most wrongly pulling condition, or None if all pull rightly."""
    held = np.flatnonzero(active.sides)
    of_margins = (pulls.margins * np.linalg.norm(first[1:], axis=1))[list(active.margins)]
    pull = np.append(of_margins, -(active.sides * pulls.bounds)[held])
    if np.min(pull, initial=0.0) >= -1e-7 * max(float(np.linalg.norm(first[0])), 1e-300):
        return None
    worst = int(np.argmin(pull))
    if worst < len(active.margins):
        margins = active.margins[:worst] + active.margins[worst + 1 :]
        return active._replace(margins=margins)
    sides = active.sides.copy()
    sides[held[worst - len(active.margins)]] = 0
    return active._replace(sides=sides)
