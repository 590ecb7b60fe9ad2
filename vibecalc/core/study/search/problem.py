"""What all searches share: variables, counted evaluations, starting points, what they return."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Variables between bounds, scaled to the unit cube; angles that go all around.
# ----------------------------------------------------------------------------

#: share of a period that bounds may fall short of it and still hold all of it
_WHOLE = 1e-9
#: a variable whose positive bounds are further apart than this ratio is scaled by its logarithm
LOGARITHMIC_RATIO = 10.0


@dataclass(frozen=True)
class Box:
    """Bounds of n variables and the map between them and the unit cube.

    A stiffness between 1e3 and 1e6 N/m is as likely to be wanted near either end: variables with
    positive bounds a factor of 10 or more apart run logarithmically, all others linearly. Both
    ends of the unit interval give the bounds themselves, to the last bit.

    A variable that repeats itself after `period` (n,; 0: it does not) and whose bounds hold all of
    one has no bounds: the unit interval then runs through three periods, of which the middle one,
    from `lower` on, is where points are folded to (`fold`). A search that leaves it by one side
    goes on.
    """

    lower: np.ndarray
    upper: np.ndarray
    period: np.ndarray | None = None

    @property
    def around(self) -> np.ndarray:
        """(n,) whether a variable goes all around."""
        if self.period is None:
            return np.zeros(self.lower.size, dtype=bool)
        whole = self.upper - self.lower >= (1.0 - _WHOLE) * self.period
        return np.asarray((self.period > 0.0) & whole)

    def only(self, chosen: np.ndarray) -> "Box":
        """The box of some of the variables."""
        period = None if self.period is None else self.period[chosen]
        return Box(self.lower[chosen], self.upper[chosen], period)

    def start(self, unit: np.ndarray) -> np.ndarray:
        """Points spread over the unit cube as such that are spread over the bounds."""
        return np.where(self.around, (1.0 + unit) / 3.0, unit)

    def fold(self, unit: np.ndarray) -> np.ndarray:
        """The same points, with angles in the middle one of their three periods."""
        around = self.around
        if not np.any(around):
            return unit
        return np.where(around, (1.0 + self._turned(unit)) / 3.0, unit)

    def apart(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The shortest difference of two points of the unit cube, whole periods dropped."""
        difference = np.asarray(other - one)
        return np.where(self.around, difference - np.round(3.0 * difference) / 3.0, difference)

    @staticmethod
    def _turned(unit: np.ndarray) -> np.ndarray:
        """Share of a period; what rounding leaves just below a whole one is none."""
        share = (3.0 * unit) % 1.0
        return np.where(1.0 - share < 16.0 * EPSILON, 0.0, share)

    @property
    def logarithmic(self) -> np.ndarray:
        """(n,) whether a variable is scaled by its logarithm."""
        wide = (self.lower > 0) & (self.upper >= LOGARITHMIC_RATIO * self.lower)
        return np.asarray(wide & ~self.around)

    def values(self, unit: np.ndarray) -> np.ndarray:
        """Variables, (..., n), at points of the unit cube, (..., n)."""
        log = self.logarithmic
        lower = np.where(log, self.lower, 1.0)
        ratio = np.where(log, self.upper, 1.0) / lower
        linear = self.lower + (self.upper - self.lower) * unit
        inside = np.clip(np.where(log, lower * ratio**unit, linear), self.lower, self.upper)
        ends = np.where(unit <= 0, self.lower, np.where(unit >= 1, self.upper, inside))
        around = self.around
        if self.period is None or not np.any(around):
            return ends
        return np.where(around, self.lower + self.period * self._turned(unit), ends)

    def unit(self, values: np.ndarray) -> np.ndarray:
        """Points of the unit cube at the given variables; a variable without room gives 0."""
        width = self.upper - self.lower
        linear = np.where(width > 0, (values - self.lower) / np.where(width > 0, width, 1.0), 0.0)
        if self.period is not None:
            period = np.where(self.around, self.period, 1.0)
            turned = (1.0 + (values - self.lower) / period % 1.0) / 3.0
            linear = np.where(self.around, turned, linear)
        if not np.any(self.logarithmic):
            return np.clip(linear, 0.0, 1.0)
        log = self.logarithmic
        lower = np.where(log, self.lower, 1.0)
        ratio = np.where(log, self.upper, 2.0) / lower
        scaled = np.log(np.where(log, np.maximum(values, lower), lower) / lower) / np.log(ratio)
        return np.clip(np.where(log, scaled, linear), 0.0, 1.0)

    def farthest(self, values: np.ndarray) -> np.ndarray:
        """Distance (n,) of variables to the farther one of their bounds, or half a period."""
        ends = np.maximum(values - self.lower, self.upper - values)
        return ends if self.period is None else np.where(self.around, 0.5 * self.period, ends)

    def slope(self, values: np.ndarray) -> np.ndarray:
        """Derivative of the variables by the coordinates of the unit cube, (n,)."""
        log = self.logarithmic
        ratio = np.where(log, self.upper, 1.0) / np.where(log, self.lower, 1.0)
        linear = self.upper - self.lower
        if self.period is not None:
            linear = np.where(self.around, 3.0 * self.period, linear)
        return np.where(log, values * np.log(ratio), linear)


# ----------------------------------------------------------------------------
# Evaluations: counted, remembered, and with points that cannot be evaluated kept apart.
# ----------------------------------------------------------------------------

Evaluate = Callable[[np.ndarray], tuple[float, ArrayLike]]
#: absolute errors of what is evaluated at variables (n,): of objectives, then of margins
ErrorsAt = Callable[[np.ndarray], np.ndarray]
#: told of points (k, n) that are about to be evaluated, it may compute them at once
Ahead = Callable[[np.ndarray], None]

#: violation up to which a point counts as feasible, before it is refined
FEASIBLE_WITHIN = 1e-6
#: error of a scaled value of which the slope does not matter, and the step to see how it changes
KNOWN, NEARBY = 1e-10, 0.02
#: how often an error may change by itself from one side of the cube to the other
CHANGES = 4.0
#: a margin beyond this is as good as infinitely well kept
AMPLE_MARGIN = 1e6


class BudgetSpent(Exception):
    """No evaluations are left; whoever catches it works with what has been found."""


class Values(Protocol):
    """What searches and derivatives need: a vector (objective, margins) at points of the cube."""

    def __call__(self, unit: np.ndarray, /) -> np.ndarray | None: ...


def foresee(values: Values, points: Sequence[np.ndarray]) -> None:
    """Say which points (n,) are about to be asked for, to a function that can use it."""
    if isinstance(values, Sampler):
        values.ahead(points)


class Sampler:
    """The function that is searched, on the unit cube.

    A call gives the vector (objective / `scale`, margins), or None where the function raises
    NumericalFailure or gives NaN or an infinity. `count` counts true evaluations only: a point
    met again is looked up. `best` (n,) is the lowest point met, of those that break limits least.
    """

    def __init__(
        self, evaluate: Evaluate, box: Box, budget: int, ahead: Ahead | None = None,
        errors: ErrorsAt | None = None,
    ):  # fmt: skip
        self.box, self._errors = box, errors
        self.scale = 1.0
        self.count = 0
        self.failures: dict[bytes, str] = {}
        self.smallest = np.inf
        self.largest = 0.0
        self._evaluate = evaluate
        self._ahead = ahead
        self.budget = budget
        self.best = np.empty(0)
        self._size = 0
        self._rank = (np.inf, np.inf)
        self._known: dict[bytes, np.ndarray | None] = {}

    def __call__(self, unit: np.ndarray) -> np.ndarray | None:
        key = (unit + 0.0).tobytes()
        if key not in self._known:
            if self.count >= self.budget:
                raise BudgetSpent
            self.count += 1
            self._known[key] = self._fresh(key, unit)
        raw = self._known[key]
        if raw is None:
            return None
        scaled = raw.copy()
        scaled[0] /= self.scale
        return scaled

    def bias(self, unit: np.ndarray) -> np.ndarray:
        """Errors (1 + m,) of the values at a point that no comparison of values shows."""
        if self._errors is None:
            return np.zeros(self._size)
        off = np.array(self._errors(self.box.values(unit)), dtype=float)
        off[0] /= self.scale
        return np.where(np.isfinite(off), off, 0.0)

    def leaning(self, unit: np.ndarray) -> np.ndarray:
        """Slopes (1 + m, n) that errors of the values may have: they change by themselves over a
        quarter of the cube, or as those around the point do."""
        bias = self.bias(unit)
        slopes = np.repeat(CHANGES * bias[:, None], unit.size, axis=1)
        if not np.any(bias > KNOWN):
            return slopes
        for axis in range(unit.size):
            for side in (-NEARBY, NEARBY):
                near = unit.copy()
                near[axis] = np.clip(near[axis] + side, 0.0, 1.0)
                with suppress(NumericalFailure):
                    change = np.abs(self.bias(near) - bias) / NEARBY
                    slopes[:, axis] = np.maximum(slopes[:, axis], change)
        return slopes

    def ahead(self, units: Sequence[np.ndarray]) -> None:
        """Say which points (n,) are about to be asked for; nothing is counted yet."""
        if self._ahead is None:
            return
        fresh = {(unit + 0.0).tobytes(): unit for unit in units}
        left = [unit for key, unit in fresh.items() if key not in self._known][: self.left]
        if len(left) > 1:
            self._ahead(self.box.values(np.stack(left)))

    def lowest_feasible(self) -> str:
        """In words, the lowest point met that keeps all limits."""
        broken, lowest = self._rank
        if broken:
            return "no point that keeps all limits was met"
        where = self.box.values(self.best).tolist()
        return f"the lowest point met is {where} with the objective {lowest:.9g}"

    @property
    def left(self) -> int:
        """Evaluations that may still be made."""
        return self.budget - self.count

    @property
    def reserve(self) -> int:
        """Evaluations that are kept back for refining what the searches find."""
        return min(self.budget // 3, 100 + 50 * self.box.lower.size)

    def _fresh(self, key: bytes, unit: np.ndarray) -> np.ndarray | None:
        variables = self.box.values(unit)
        try:
            objective, margins = self._evaluate(variables)
        except NumericalFailure as failure:
            self.failures[key] = str(failure)
            return None
        if objective == -np.inf:
            raise NumericalFailure(
                f"the objective is minus infinity at {variables.tolist()}: there is no smallest "
                "value. Narrow the bounds of the variables or choose another objective."
            )
        margin_values = np.atleast_1d(np.asarray(margins, dtype=float)).ravel()
        vector = np.append(
            objective, np.where(margin_values == np.inf, AMPLE_MARGIN, margin_values)
        )
        if not np.all(np.isfinite(vector)):
            what = "margin of a limit" if np.isfinite(objective) else "objective"
            self.failures[key] = f"the {what} is not a finite number"
            return None
        self._size = self._size or vector.size
        if vector.size != self._size:
            raise ValueError("the number of margins changes between points")
        broken = max(0.0, float(np.max(-margin_values, initial=0.0)) - FEASIBLE_WITHIN)
        if (broken, float(objective)) < self._rank:
            self.best, self._rank = unit.copy(), (broken, float(objective))
        self.smallest = min(self.smallest, float(objective))
        self.largest = max(self.largest, abs(float(objective)))
        return vector


def squared(sampler: Values) -> Values:
    """The same search with the square of the objective: smooth where a norm is zero."""

    def values(unit: np.ndarray) -> np.ndarray | None:
        vector = sampler(unit)
        return None if vector is None else np.append(vector[0] ** 2, vector[1:])

    return values


# ----------------------------------------------------------------------------
# Starting points: a low-discrepancy sequence that is fixed here, so that it never changes.
# ----------------------------------------------------------------------------


def spread(count: int, dimension: int) -> np.ndarray:
    """Spread points evenly over the unit cube, each prefix of the sequence as well as possible.

    Parameters
    ----------
    count : int
        Number of points.
    dimension : int
        Number of coordinates.

    Returns
    -------
    points : (count, dimension) array in (0, 1)

    Notes
    -----
    Additive recurrence with the generalised golden ratio, the root of g^(d+1) = g + 1:
    point k is the fractional part of 1/2 + k (1/g, 1/g^2, ..., 1/g^d), k = 1, 2, ...
    (M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
    """
    ratio = 2.0
    for _ in range(64):  # a contraction with a factor below 1/3
        ratio = (1.0 + ratio) ** (1.0 / (dimension + 1))
    steps = ratio ** -np.arange(1.0, dimension + 1)
    return (0.5 + np.arange(1.0, count + 1)[:, None] * steps) % 1.0


# ----------------------------------------------------------------------------
# What a search returns.
# ----------------------------------------------------------------------------


CONVERGED = "converged"


class Infeasible(NumericalFailure):
    """No point within the bounds keeps all limits; `variables` (n,) come nearest, of those met."""

    def __init__(self, message: str, variables: np.ndarray, evaluations: int):
        self.variables, self.evaluations = variables, evaluations
        super().__init__(message)


class LocalEnd(NamedTuple):
    """Where one search stopped on the unit cube, and in words why."""

    unit: np.ndarray
    reason: str

    @property
    def converged(self) -> bool:
        """Whether the search ended because nothing was left to gain."""
        return self.reason == CONVERGED


class Search(NamedTuple):
    """One local search: where it began, where it ended and why it stopped there.

    `objective` is NaN only where the start itself could not be evaluated, and `end` then is the
    start. `violation` is the most negative margin at the end, as a positive number, or 0.
    """

    start: np.ndarray
    end: np.ndarray
    objective: float
    violation: float
    reason: str
    evaluations: int

    @property
    def feasible(self) -> bool:
        """Whether the end keeps all limits, as far as a search gets without being refined."""
        return self.violation <= FEASIBLE_WITHIN


class LocalOptimum(NamedTuple):
    """A distinct end point that keeps all limits, with the number of searches that ended there."""

    point: np.ndarray
    objective: float
    found_by: int


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """The best point found, how well it is known and how it was reached.

    Attributes
    ----------
    variables, variables_error : (n,) arrays
        The optimum and the absolute error of each variable. Where a continuum of points is
        equally good the error is the distance to the nearest of them.
    objective, objective_error : float
        The objective and its absolute error.
    margins : (m,) array
        As `evaluate` gave them at the optimum; those of active limits are zero to round-off.
    active_margins : tuple of int
        Margins that hold the optimum where it is.
    margin_multipliers : (m,) array
        Rise of the objective for each unit by which a margin is asked to be larger, >= 0.
    active_bounds : (n,) array
        -1 at its lower bound, +1 at its upper bound, 0 in between.
    bound_multipliers : (n,) array
        Derivative of the objective by that bound, in the units of objective and variable; 0 in
        between. It is >= 0 at a lower and <= 0 at an upper bound.
    kkt_residual : float
        What is left of the sum of gradients that should vanish, relative to their magnitudes.
    free_directions : int
        Number of directions in which the objective does not change to second order.
    method : str
        How the last digits were found: "newton", "zero", "sampled planes", "flat", "fixed" or
        "convex".
    evaluations, failures : int
        Points evaluated, and how many of them could not be.
    failure_messages : tuple of str
        The distinct messages of those, in the order met.
    """

    variables: np.ndarray
    variables_error: np.ndarray
    objective: float
    objective_error: float
    margins: np.ndarray
    active_margins: tuple[int, ...]
    margin_multipliers: np.ndarray
    active_bounds: np.ndarray
    bound_multipliers: np.ndarray
    kkt_residual: float
    free_directions: int
    method: str
    evaluations: int
    failures: int
    failure_messages: tuple[str, ...]
    history: tuple[Search, ...]
    optima: tuple[LocalOptimum, ...]
    notes: tuple[str, ...] = ()
