"""Evaluations: counted, remembered, and with points that cannot be evaluated kept apart."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.variables import Box

Evaluate = Callable[[np.ndarray], tuple[ArrayLike, ArrayLike]]

#: a margin beyond this is as good as infinitely well kept
AMPLE_MARGIN = 1e6


class BudgetSpent(Exception):
    """No evaluations are left; whoever catches it works with what has been found."""


class Values(Protocol):
    """What searches and derivatives need: a vector (entries, margins) at points of the cube."""

    @property
    def box(self) -> Box: ...

    @property
    def entries(self) -> int: ...

    def __call__(self, unit: np.ndarray) -> np.ndarray | None: ...


class Sampler:
    """The function that is searched, on the unit cube.

    A call gives the vector (entries of the objective / `scale`, margins), or None where the
    function raises NumericalFailure or gives NaN or an infinity. `count` counts true evaluations
    only: a point met again is looked up.
    """

    def __init__(self, evaluate: Evaluate, box: Box, budget: int):
        self.box = box
        self.scale = 1.0
        self.entries = 0
        self.count = 0
        self.failures: dict[bytes, str] = {}
        self.smallest = np.inf
        self.largest = 0.0
        self._evaluate = evaluate
        self._budget = budget
        self._size = 0
        self._lowest: tuple[float, np.ndarray | None] = (np.inf, None)
        self._known: dict[bytes, np.ndarray | None] = {}

    def __call__(self, unit: np.ndarray) -> np.ndarray | None:
        key = (unit + 0.0).tobytes()
        if key not in self._known:
            if self.count >= self._budget:
                raise BudgetSpent
            self.count += 1
            self._known[key] = self._fresh(key, unit)
        raw = self._known[key]
        if raw is None:
            return None
        scaled = raw.copy()
        scaled[: self.entries] /= self.scale
        return scaled

    def knows(self, unit: np.ndarray) -> bool:
        """Whether a point has been evaluated already."""
        return (unit + 0.0).tobytes() in self._known

    def lowest_kept(self) -> str:
        """In words, the lowest point met that keeps all limits."""
        lowest, where = self._lowest
        if where is None:
            return "no point that keeps all limits was met"
        return f"the lowest point met is {where.tolist()} with the objective {lowest:.9g}"

    @property
    def left(self) -> int:
        """Evaluations that may still be made."""
        return self._budget - self.count

    @property
    def reserve(self) -> int:
        """Evaluations that are kept back for refining what the searches find."""
        return min(self._budget // 3, 100 + 50 * self.box.lower.size)

    def _fresh(self, key: bytes, unit: np.ndarray) -> np.ndarray | None:
        variables = self.box.values(unit)
        try:
            objective, margins = self._evaluate(variables)
        except NumericalFailure as failure:
            self.failures[key] = str(failure)
            return None
        entries = np.atleast_1d(np.asarray(objective, dtype=float)).ravel()
        kept = np.atleast_1d(np.asarray(margins, dtype=float)).ravel()
        if np.max(entries) == -np.inf:
            raise NumericalFailure(
                f"the objective is minus infinity at {variables.tolist()}: there is no smallest "
                "value. Narrow the bounds of the variables or choose another objective."
            )
        vector = np.concatenate([entries, np.where(kept == np.inf, AMPLE_MARGIN, kept)])
        if not np.all(np.isfinite(vector)):
            what = "objective" if not np.all(np.isfinite(entries)) else "margin of a limit"
            self.failures[key] = f"the {what} is not a finite number"
            return None
        if self.entries == 0:
            self.entries = entries.size
            self._size = vector.size
        elif entries.size != self.entries or vector.size != self._size:
            raise ValueError("the number of objective entries or margins changes between points")
        if np.all(kept >= 0) and np.max(entries) < self._lowest[0]:
            self._lowest = (float(np.max(entries)), variables)
        self.smallest = min(self.smallest, float(np.max(entries)))
        self.largest = max(self.largest, float(np.max(np.abs(entries))))
        return vector


class SumOfSquares:
    """The same search with the sum of squares of the entries: smooth where a norm is zero."""

    entries = 1

    def __init__(self, values: Values):
        self.box = values.box
        self._values = values

    def __call__(self, unit: np.ndarray) -> np.ndarray | None:
        vector = self._values(unit)
        if vector is None:
            return None
        entries = self._values.entries
        return np.append(np.sum(vector[:entries] ** 2), vector[entries:])


class Violations:
    """The search for the point whose worst margin is best: margins turned into the objective."""

    def __init__(self, values: Values, margins: int):
        self.box = values.box
        self.entries = margins
        self._values = values

    def __call__(self, unit: np.ndarray) -> np.ndarray | None:
        vector = self._values(unit)
        return None if vector is None else -vector[self._values.entries :]
