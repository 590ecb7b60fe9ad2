"""The values one key takes along an axis: listed, spread between two ends, or drawn.

Values are in SI. `at` takes whole positions along the axis, `drawn` shares in (0, 1) of a
sampling; both take and return arrays (len,).
"""

from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np

from vibecalc.study.sweep.distributions import Scatter
from vibecalc.study.sweep.portable import exp, log

_DIGITS = Context(prec=40)


@dataclass(frozen=True, kw_only=True)
class Listed:
    """Values as given: numbers, or names of choices (then `at` counts them from 0)."""

    values: tuple[float, ...] | tuple[str, ...]

    @property
    def count(self) -> int | None:
        """How many values there are."""
        return len(self.values)

    @property
    def names(self) -> tuple[str, ...]:
        """The choices by position; none for numbers."""
        return tuple(value for value in self.values if isinstance(value, str))

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value; positions for choices."""
        numbers = [float(value) for value in self.values if not isinstance(value, str)]
        return (min(numbers), max(numbers)) if numbers else (0.0, len(self.values) - 1.0)

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values at positions along the axis."""
        numbers = range(len(self.values)) if self.names else self.values
        return np.asarray(np.array(numbers, dtype=float)[positions] + 0.0)

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Each value with the same chance."""
        return self.at(picked(shares, len(self.values)))

    def description(self) -> dict[str, Any]:
        """As plain values, for hashes."""
        return {"values": list(self.values)}


@dataclass(frozen=True, kw_only=True)
class Spread:
    """From `start` to `stop` in equal steps or equal ratios, ends included.

    The ends are numbers as written, and `factor` turns them into SI: the tenth value from 5 to 50
    (N/mm) is what a case gets that says "50 N/mm". Without `count` it is a range to draw from.
    """

    start: Decimal
    stop: Decimal
    factor: float
    log: bool
    count: int | None

    @property
    def names(self) -> tuple[str, ...]:
        """No choices: all values are numbers."""
        return ()

    @property
    def ends(self) -> tuple[float, float]:
        """First and last value in SI."""
        return float(self.start) * self.factor, float(self.stop) * self.factor

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values at positions along the axis, rounded once from 40 digits."""
        unique, place = np.unique(positions, return_inverse=True)
        with localcontext(_DIGITS):
            numbers = [float(self._number(int(position))) for position in unique]
        return np.array(numbers)[place] * self.factor + 0.0

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Each value with the same chance, or uniform in the number (log: in its logarithm)."""
        if self.count is not None:
            return self.at(picked(shares, self.count))
        first, last = self.ends
        if self.log:
            values = first * exp(shares * log(np.array(last / first)))
        else:
            values = first + (last - first) * shares
        return np.clip(values, min(first, last), max(first, last)) + 0.0

    def description(self) -> dict[str, Any]:
        """As plain values, for hashes; numbers as written, so that 5 and 5.0 are the same."""
        start, stop = (str(end.normalize(_DIGITS)) for end in (self.start, self.stop))
        spacing = "log" if self.log else "linear"
        ends = {"from": start, "to": stop, "factor": self.factor}
        return {**ends, "spacing": spacing, "points": self.count}

    def _number(self, position: int) -> Decimal:
        steps = (self.count or 2) - 1
        if position in (0, steps):
            return self.stop if position else self.start
        if self.log:
            return self.start * ((self.stop / self.start).ln() * position / steps).exp()
        return self.start + (self.stop - self.start) * position / steps


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """Values drawn from a distribution; they have no positions along an axis."""

    scatter: Scatter

    @property
    def count(self) -> int | None:
        """None: any number of values can be drawn."""
        return None

    @property
    def names(self) -> tuple[str, ...]:
        """No choices: all values are numbers."""
        return ()

    @property
    def ends(self) -> tuple[float, float]:
        """What no value is beyond."""
        return self.scatter.ends

    def at(self, positions: np.ndarray) -> np.ndarray:
        """A distribution is drawn from; ValueError."""
        raise ValueError("a distribution has no positions along an axis")

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """The quantiles of the distribution at these shares."""
        return self.scatter.quantile(shares) + 0.0

    def description(self) -> dict[str, Any]:
        """As plain values, for hashes."""
        return {"distribution": self.scatter.kind, "parameters": list(self.scatter.parameters)}


Course = Listed | Spread | Drawn


def picked(shares: np.ndarray, count: int) -> np.ndarray:
    """Position of one of `count` equal parts of (0, 1)."""
    return np.minimum((shares * count).astype(np.int64), count - 1)
