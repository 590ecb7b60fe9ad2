"""The values of one key along an axis: listed, spread between two ends, or drawn."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

# ----------------------------------------------------------------------------
# How a key scatters: quantiles of four distributions, in SI.
#
# Mean and deviation are those of the key itself, for the lognormal distribution too.
# ----------------------------------------------------------------------------

#: kind -> the parameters it needs, in the order of `Scatter.parameters`
PARAMETERS: dict[str, tuple[str, ...]] = {
    "uniform": ("lower", "upper"),
    "triangular": ("lower", "upper", "mode"),
    "normal": ("mean", "deviation"),
    "lognormal": ("mean", "deviation"),
}


def _uniform(shares: np.ndarray, first: float, last: float) -> np.ndarray:
    values = first + (last - first) * shares
    return np.clip(values, min(first, last), max(first, last))


def _log_uniform(shares: np.ndarray, first: float, last: float) -> np.ndarray:
    values = first * np.exp(shares * math.log(last / first))
    return np.clip(values, min(first, last), max(first, last))


def _triangular(shares: np.ndarray, lower: float, upper: float, mode: float) -> np.ndarray:
    width, ascent, fall = upper - lower, mode - lower, upper - mode
    rising = lower + np.sqrt(shares * width * ascent)
    falling = upper - np.sqrt((1.0 - shares) * width * fall)
    return np.clip(np.where(shares * width < ascent, rising, falling), lower, upper)


def _normal(shares: np.ndarray, mean: float, deviation: float) -> np.ndarray:
    from scipy.special import ndtri  # a grid needs no scipy

    return np.asarray(mean + deviation * ndtri(shares))


def _lognormal(shares: np.ndarray, mean: float, deviation: float) -> np.ndarray:
    variance = math.log1p((deviation / mean) ** 2)
    return np.asarray(mean * np.exp(_normal(shares, -0.5 * variance, math.sqrt(variance))))


_QUANTILES: dict[str, Callable[..., np.ndarray]] = {
    "uniform": _uniform,
    "log_uniform": _log_uniform,
    "triangular": _triangular,
    "normal": _normal,
    "lognormal": _lognormal,
}

# ----------------------------------------------------------------------------
# The values one key takes along an axis: listed, spread between two ends, or drawn.
#
# Values are in SI. `at` takes whole positions along the axis, `drawn` shares in (0, 1) of a
# sampling; both take and return arrays (len,). `count` is None where any number can be drawn.
# `names` are choices by position and `contents` lists, tables and switches, which `at` counts from
# 0; no value is beyond the `ends`.
# ----------------------------------------------------------------------------

#: whole numbers up to here are doubles
_EXACT = 1 << 53
_WIDEST = 1e6


@dataclass(frozen=True, kw_only=True)
class ValueList:
    """Values as given: numbers, or names of choices.

    What is neither, as a list or a table, is set as it stands in `contents`, and `values` are
    labels of it.
    """

    values: tuple[float, ...] | tuple[str, ...]
    contents: tuple[Any, ...] = ()

    @property
    def count(self) -> int:
        """How many values there are."""
        return len(self.values)

    @property
    def names(self) -> tuple[str, ...]:
        """The choices by position; none for numbers."""
        return tuple(value for value in self.values if isinstance(value, str))

    @property
    def ends(self) -> tuple[float, float]:
        """Smallest and largest value; positions for choices."""
        numbers = self._numbers()
        return float(min(numbers)), float(max(numbers))

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values at positions along the axis."""
        return np.asarray(np.array(self._numbers(), dtype=float)[positions] + 0.0)

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Each value with the same chance."""
        return self.at(_picked(shares, self.count))

    def _numbers(self) -> Sequence[Any]:
        return range(self.count) if self.names else self.values

    def description(self) -> dict[str, Any]:
        """As plain values, for hashes."""
        return {"values": list(self.contents or self.values)}


@dataclass(frozen=True, kw_only=True)
class SpacedValues:
    """From `start` to `stop` in equal steps or equal ratios, ends included.

    The ends are numbers as written, and `factor` turns them into SI: the tenth value from 5 to 50
    (N/mm) is what a case gets that says "50 N/mm".
    """

    start: Fraction
    stop: Fraction
    factor: float
    log: bool
    count: int
    names = contents = ()

    @property
    def ends(self) -> tuple[float, float]:
        """First and last value in SI."""
        return float(self.start) * self.factor, float(self.stop) * self.factor

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values at positions along the axis: 0.3 is 0.3, a power of ten one."""
        unique, place = np.unique(positions, return_inverse=True)
        numbers = self._spaced_by_ratio(unique) if self.log else self._spaced_evenly(unique)
        return numbers[place] * self.factor + 0.0

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Each value with the same chance."""
        return self.at(_picked(shares, self.count))

    def description(self) -> dict[str, Any]:
        """As plain values, for hashes; numbers as written, so that 5 and 5.0 are the same."""
        spacing = "log" if self.log else "linear"
        ends = {"from": str(self.start), "to": str(self.stop), "factor": self.factor}
        return {**ends, "spacing": spacing, "points": self.count}

    def _spaced_evenly(self, positions: np.ndarray) -> np.ndarray:
        """The doubles next to start + (stop - start) position / (count - 1)."""
        steps = self.count - 1
        # (first + slope position) / below in whole numbers
        below = math.lcm(self.start.denominator, self.stop.denominator) * steps
        first, last = int(self.start * below), int(self.stop * below)
        slope = (last - first) // steps
        if max(abs(first), abs(last), below) <= _EXACT:
            # whole numbers that doubles hold: their quotient is rounded once
            return np.asarray((first + slope * positions.astype(np.int64)) / float(below))
        whole = (first + slope * position for position in positions.tolist())
        return np.array([float(Fraction(number, below)) for number in whole])

    def _spaced_by_ratio(self, positions: np.ndarray) -> np.ndarray:
        """start (stop / start)^(position / (count - 1)) to 15 digits, and the ends themselves."""
        steps = self.count - 1
        start, ratio = float(self.start), float(self.stop / self.start)
        ends = {0: start, steps: float(self.stop)}
        return np.array(
            [
                ends[position]
                if position in ends
                else float(f"{start * ratio ** (position / steps):.15g}")
                for position in positions.tolist()
            ]
        )


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """Values drawn from a distribution; its parameters are in SI, named as in PARAMETERS.

    A range to draw from is `uniform`, or `log_uniform`, between its first and its last value.
    """

    kind: str
    parameters: tuple[float, ...]
    count, names, contents = None, (), ()

    @property
    def ends(self) -> tuple[float, float]:
        """Two doubles that no value is beyond."""
        if self.kind in ("uniform", "log_uniform", "triangular"):
            return self.parameters[0], self.parameters[1]
        largest = float(np.finfo(float).max)
        return (5e-324 if self.kind == "lognormal" else -largest), largest

    def at(self, positions: np.ndarray) -> np.ndarray:
        """A distribution has no positions; ValueError."""
        raise ValueError("a distribution has no positions along an axis")

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Values below which the key falls with these probabilities."""
        return _QUANTILES[self.kind](shares, *self.parameters) + 0.0

    def description(self) -> dict[str, Any]:
        """As plain values, for hashes."""
        return {"distribution": self.kind, "parameters": list(self.parameters)}

    def objection(self) -> str:
        """Say what is wrong with the parameters, or nothing."""
        if self.kind in ("uniform", "triangular"):
            lower, upper, *mode = self.parameters
            if not lower < upper:
                return "lower has to be below upper"
            inside = all(lower <= value <= upper for value in mode)
            return "" if inside else "mode has to be between lower and upper"
        mean, deviation = self.parameters
        if deviation <= 0.0:
            return "deviation has to be > 0"
        if self.kind == "lognormal" and mean <= 0.0:
            return "a lognormal key is > 0, so its mean has to be"
        if self.kind == "lognormal" and deviation > _WIDEST * mean:
            return f"deviation has to be below {_WIDEST:g} times the mean"
        return ""


AxisValues = ValueList | SpacedValues | Scatter


def _picked(shares: np.ndarray, count: int) -> np.ndarray:
    """Position of one of `count` equal parts of (0, 1)."""
    return np.minimum((shares * count).astype(np.int64), count - 1)
