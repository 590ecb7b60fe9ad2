"""What all searches share: variables, counted evaluations, starting points, what they return."""

import copy
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.side_by_side import Ask
from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON

# ----------------------------------------------------------------------------
# Variables between bounds, scaled to the unit cube; angles that go all around.
# ----------------------------------------------------------------------------

#: share of a period that bounds may fall short of it and still hold all of it
_WHOLE = 1e-9
#: a variable whose positive bounds are further apart than this ratio is scaled by its logarithm
LOGARITHMIC_RATIO = 10.0


class Box:
    """Bounds of n variables and the map between them and the unit cube.

    A variable whose bounds are equal is held there and has no coordinate: the cube has k of n.

    A stiffness between 1e3 and 1e6 N/m is as likely to be wanted near either end: variables with
    positive bounds a factor of 10 or more apart run logarithmically, all others linearly. Both
    ends of the unit interval give the bounds themselves, to the last bit.

    A variable that repeats itself after `period` (n,; 0: it does not) and whose bounds hold all of
    one has no bounds (`around`): the unit interval is one period from `lower` on, and a search that
    leaves it by one side goes on at the other.
    """

    def __init__(self, lower: ArrayLike, upper: ArrayLike, period: ArrayLike = 0.0):
        self.lower, self.upper = (np.array(side, dtype=float, ndmin=1) for side in (lower, upper))
        self.moving = self.upper > self.lower
        periods = np.broadcast_to(np.asarray(period, dtype=float), self.lower.shape)
        low, high, turn = (one[self.moving] for one in (self.lower, self.upper, periods))
        self._low, self._high, self.size = low, high, low.size
        self.around = (turn > 0.0) & (high - low >= (1.0 - _WHOLE) * turn)
        self.logarithmic = (low > 0.0) & (high >= LOGARITHMIC_RATIO * low) & ~self.around
        self._width = np.where(self.around, turn, high - low)
        self._base = np.where(self.logarithmic, low, 1.0)
        self._ratio = np.where(self.logarithmic, high, self._base) / self._base

    def inside(self, unit: np.ndarray) -> np.ndarray:
        """The nearest points within the bounds, with angles as they are."""
        return np.where(self.around, unit, np.clip(unit, 0.0, 1.0))

    def fold(self, unit: np.ndarray) -> np.ndarray:
        """The same points within the cube; what rounding leaves just below a whole turn is none."""
        turned = unit % 1.0
        turned = np.where(1.0 - turned < 16.0 * EPSILON, 0.0, turned)
        return np.where(self.around, turned, self.inside(unit)) + 0.0

    def apart(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """The shortest difference of two points of the unit cube, whole periods dropped."""
        difference = np.asarray(other - one)
        return np.where(self.around, difference - np.round(difference), difference)

    def values(self, unit: np.ndarray) -> np.ndarray:
        """Variables, (..., n), at points of the unit cube, (..., k)."""
        unit = self.fold(unit)
        linear = self._low + self._width * unit
        inside = np.where(self.logarithmic, self._base * self._ratio**unit, linear)
        inside = np.clip(inside, self._low, self._high)
        inside = np.where((unit >= 1.0) & ~self.around, self._high, inside)
        return self.whole(np.where(unit <= 0.0, self._low, inside), self.lower)

    def whole(self, part: np.ndarray, held: np.ndarray) -> np.ndarray:
        """An array (..., n) of numbers (..., k) of the variables that move, and those `held`."""
        found = np.broadcast_to(held, (*part.shape[:-1], self.lower.size)).copy()
        found[..., self.moving] = part
        return found

    def unit(self, values: np.ndarray) -> np.ndarray:
        """Points of the unit cube, (..., k), at the given variables, (..., n)."""
        inner = values[..., self.moving]
        share = (inner - self._low) / self._width
        ratio = np.where(self.logarithmic, np.maximum(inner, self._low), self._base) / self._base
        logs = np.log(np.where(self.logarithmic, self._ratio, np.e))
        return self.fold(np.where(self.logarithmic, np.log(ratio) / logs, share))

    def farthest(self, values: np.ndarray) -> np.ndarray:
        """Distance (k,) of variables to the farther one of their bounds, or half a period."""
        inner = values[self.moving]
        ends = np.maximum(inner - self._low, self._high - inner)
        return np.where(self.around, 0.5 * self._width, ends)

    def slope(self, values: np.ndarray) -> np.ndarray:
        """Derivative of the variables by the coordinates of the unit cube, (k,)."""
        growth = values[self.moving] * np.log(self._ratio)
        return np.where(self.logarithmic, growth, self._width)


# ----------------------------------------------------------------------------
# Evaluations: counted, remembered, and with points that cannot be evaluated kept apart.
# ----------------------------------------------------------------------------

#: variables (n,) -> the objective or its parts (p,), of which the largest counts; for each limit
#: its margin or the margins of its entries, of which the smallest counts; and, where known,
#: absolute errors of the objective, then of each limit
Evaluate = Callable[[np.ndarray], tuple[Any, ...]]
#: told of points (j, n) that are about to be evaluated, it may compute them at once
Ahead = Callable[[np.ndarray], None]

#: violation up to which a point counts as feasible, before it is refined
FEASIBLE_WITHIN = 1e-6
#: error of a scaled value of which the slope does not matter, and the step to see how it changes
KNOWN, NEARBY = 1e-10, 0.02
#: how often an error may change by itself from one side of the cube to the other
CHANGES = 4.0
#: a margin beyond this is as good as infinitely well kept
AMPLE_MARGIN = 1e6


@dataclass(frozen=True)
class Problem:
    """A function of n variables, to be made small between bounds while margins are kept.

    Attributes
    ----------
    evaluate : callable
        `evaluate(variables (n,)) -> (objective, margins (m,), errors (1 + m,))`, the last where
        known; round-off is always counted and noise is measured. The objective is a number, or
        those of its parts (p,) of which the largest counts. A margin, made dimensionless by its
        limit, is kept where it is >= 0; it is a number, or those of all entries of the limit. The
        largest of smooth parts has kinks, so that parts and entries are better given each. A point
        that raises NumericalFailure or gives NaN or an infinity is counted and the search goes
        around it. Values have to be repeatable.
    lower, upper : (n,) arrays
        Bounds. A variable whose bounds are equal is held there.
    first : (n,) array, optional
        The first start; the middle of the bounds without it. Of equally good ends of
        searches, the nearest to it is returned.
    period : (n,) array
        After how much a variable repeats itself, as an angle does; 0 where it does not. One whose
        bounds hold a whole period has no bounds, and is counted from its lower bound on.
    ahead : callable
        Told of variables (k, n) before they are evaluated one by one.
    of_maxima : bool
        Whether the parts are maxima that come and go, as those of a curve do. Searches then go
        down their largest, and the parts serve where an optimum is refined.
    """

    evaluate: Evaluate
    lower: ArrayLike
    upper: ArrayLike
    first: ArrayLike | None = None
    period: ArrayLike = 0.0
    ahead: Ahead | None = None
    of_maxima: bool = False

    @property
    def box(self) -> Box:
        """The bounds and the unit cube."""
        return Box(self.lower, self.upper, self.period)


#: what becomes of a vector, or of its errors
Change = Callable[[np.ndarray], np.ndarray]


class Sampler:
    """The function of a problem, on the unit cube, or a view of it.

    A call gives the vector (v,) at a point (k,), `parts` of the objective over `scale`, then
    margins, or None where the function raises NumericalFailure or gives NaN or an infinity; `count`
    are evaluations, since a point met again is looked up. `entries` are the margins of each limit,
    `flat` says that the objective does not change, `notes` what a search left out.
    """

    def __init__(self, problem: Problem):
        self.box, self.scale, self.flat = problem.box, 1.0, False
        self.notes: list[str] = []
        self.failures: dict[bytes, str] = {}
        self.parts, self.entries = 1, list[int]()
        self.problem, self._whole, self._extremes = problem, 1, [np.inf, 0.0]
        self._ask: Ask | None = None
        self._spent = [0]
        self._known: dict[bytes, np.ndarray | None] = {}
        self._off: dict[bytes, np.ndarray] = {}
        self._changes: tuple[Change, Change] | None = None

    def view(self, change: Change, off: Change, parts: int = 1) -> "Sampler":
        """The same points with changed vectors, of which `parts` are the objective, and errors."""
        other = copy.copy(self)
        other._changes, other.parts = (change, off), parts
        return other

    def asking(self, ask: Ask) -> "Sampler":
        """The same points for one of several searches, which `ask` for them and count their own."""
        other = copy.copy(self)
        other._ask, other._spent = ask, [0]
        return other

    def largest_part(self, power: int = 1) -> "Sampler":
        """The objective itself, which has kinks where parts meet, or its square, and the margins.

        All parts have one error; that of a zero counts where its square is taken.
        """
        parts = self.parts
        return self.view(
            lambda v: np.append(np.max(v[:parts]) ** power, v[parts:]),
            lambda off: np.append(off[0] * (power == 1), off[parts:]),
        )

    @property
    def count(self) -> int:
        """Evaluations so far."""
        return len(self._known)

    @property
    def spent(self) -> int:
        """Those of this search."""
        return self._spent[0]

    @property
    def smallest(self) -> float:
        """Of the objectives met; of a view it is not known."""
        return self._extremes[0] if self._changes is None else -np.inf

    @property
    def largest(self) -> float:
        """Magnitude of the objectives met."""
        return self._extremes[1]

    def __call__(self, unit: np.ndarray) -> np.ndarray | None:
        unit = self.box.fold(unit)
        key = unit.tobytes()
        if key not in self._known:
            self._spent[0] += 1
            self._known[key] = self._fresh(key, unit)
        raw = self._known[key]
        if raw is None:
            return None
        scaled = raw.copy()
        scaled[: self._whole] /= self.scale
        return scaled if self._changes is None else self._changes[0](scaled)

    def bias(self, unit: np.ndarray) -> np.ndarray:
        """Errors (v,) at a point that no comparison of values shows; NumericalFailure without."""
        if self(unit) is None:
            raise NumericalFailure(self.failure(unit))
        off = self._off[self.box.fold(unit).tobytes()]
        off = np.repeat(off, [self._whole, *self.entries])
        off[: self._whole] /= self.scale
        off = np.where(np.isfinite(off), off, 0.0)
        return off if self._changes is None else self._changes[1](off)

    def leaning(self, unit: np.ndarray) -> np.ndarray:
        """Slopes (v, k) that errors of the values may have: they change by themselves over a
        quarter of the cube, or as those around the point do."""
        bias = self.bias(unit)
        slopes = np.repeat(CHANGES * bias[:, None], unit.size, axis=1)
        for step in (*np.eye(unit.size), *-np.eye(unit.size)) if np.any(bias > KNOWN) else ():
            with suppress(NumericalFailure):
                change = np.abs(self.bias(self.box.fold(unit + NEARBY * step)) - bias) / NEARBY
                slopes = np.maximum(slopes, change[:, None] * np.abs(step))
        return slopes

    def top(self, unit: np.ndarray) -> float:
        """The objective in scaled units, infinite where there is none."""
        vector = self(unit)
        return np.inf if vector is None else float(np.max(vector[: self.parts]))

    def violation(self, unit: np.ndarray) -> float:
        """The most negative margin as a positive number, or 0; infinite where there is none."""
        vector = self(unit)
        return np.inf if vector is None else float(np.max(-vector[self.parts :], initial=0.0))

    def infeasible(self, unit: np.ndarray, words: str) -> "Infeasible":
        """That no limits are kept: words with the place {at} and the {worst} margins there."""
        vector, at = self(unit), self.box.values(unit)
        assert vector is not None
        margins = self.of_limits(vector[self.parts :], np.min)
        broken = [f"margin {i} is {margins[i]:.6g}" for i in np.flatnonzero(margins < 0)]
        said = words.format(at=at.tolist(), worst=", ".join(broken))
        return Infeasible(said, at, self.count, self.violation(unit))

    def failure(self, unit: np.ndarray) -> str:
        """Why a point has no values."""
        return self.failures[self.box.fold(unit).tobytes()]

    def ahead(self, units: Sequence[np.ndarray]) -> None:
        """Say which points (k,) are about to be asked for; nothing is counted yet."""
        if self.problem.ahead is None:
            return
        fresh = {unit.tobytes(): unit for unit in map(self.box.fold, units)}
        left = [unit for key, unit in fresh.items() if key not in self._known]
        if self._ask is not None and left:
            self._ask(left)
        elif len(left) > 1:
            self.problem.ahead(self.box.values(np.stack(left)))

    def of_limits(self, margins: np.ndarray, how: Callable[[np.ndarray], float]) -> np.ndarray:
        """One number for each limit of those (m,) of the margins of its entries."""
        ends = np.cumsum(self.entries)
        return np.array([how(one) for one in np.split(margins, ends)[:-1]], dtype=float)

    def _fresh(self, key: bytes, unit: np.ndarray) -> np.ndarray | None:
        variables = self.box.values(unit)
        try:
            objective, limits, *errors = self.problem.evaluate(variables)
        except NumericalFailure as failure:
            self.failures[key] = str(failure)
            return None
        groups = [np.array(one, dtype=float).ravel() for one in (objective, *limits)]
        parts, *entries = (one.size for one in groups)
        vector = np.concatenate(groups)
        vector[parts:][vector[parts:] == np.inf] = AMPLE_MARGIN
        top = float(np.max(vector[:parts]))
        if top == -np.inf:
            raise NumericalFailure(
                f"the objective is minus infinity at {variables.tolist()}: there is no smallest "
                "value. Narrow the bounds of the variables or choose another objective."
            )
        if not np.all(np.isfinite(vector)):
            what = "margin of a limit" if np.isfinite(vector[:parts]).all() else "objective"
            self.failures[key] = f"the {what} is not a finite number"
            return None
        if not self._off:
            self.parts, self._whole, self.entries = parts, parts, entries
        if (self._whole, self.entries) != (parts, entries):
            raise ValueError("the number of margins changes between points")
        self._off[key] = np.array(errors[0] if errors else np.zeros(len(groups)), dtype=float)
        smallest, largest = self._extremes
        self._extremes[:] = min(smallest, top), max(largest, abs(top))
        return vector


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


class Infeasible(NumericalFailure):
    """No point within the bounds keeps all limits; `variables` (n,) come nearest, of those met.

    `violation` is the most negative margin there, as a positive number.
    """

    def __init__(self, message: str, variables: np.ndarray, evaluations: int, violation: float):
        self.variables, self.evaluations, self.violation = variables, evaluations, violation
        super().__init__(message)


class Search(NamedTuple):
    """One local search: where it began and where it ended.

    `objective` is infinite only where the start itself could not be evaluated, and `end` then is
    the start. `violation` is the most negative margin at the end, as a positive number, or 0.
    """

    start: np.ndarray
    end: np.ndarray
    objective: float
    violation: float
    evaluations: int

    @property
    def feasible(self) -> bool:
        """Whether the end keeps all limits, as far as a search gets without being refined."""
        return self.violation <= FEASIBLE_WITHIN


class LocalOptimum(NamedTuple):
    """A distinct local optimum that keeps all limits, with the number of searches that ended there.

    Where the objective does not change to the last digits the searches ended, it is one of many.
    """

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
        Of each limit, the smallest of its entries; those of active limits are zero to round-off.
    margin_multipliers : (m,) array
        Rise of the objective for each unit by which a margin is asked to be larger: > 0 of limits
        that hold the optimum where it is, 0 of others.
    active_bounds : (n,) array
        -1 at its lower bound, +1 at its upper bound, 0 in between.
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
    margin_multipliers: np.ndarray
    active_bounds: np.ndarray
    kkt_residual: float
    free_directions: int
    method: str
    evaluations: int
    history: tuple[Search, ...]
    optima: tuple[LocalOptimum, ...]
    failures: int = 0
    failure_messages: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
