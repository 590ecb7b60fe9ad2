"""The values of one key along an axis: listed, spread between two ends, or drawn."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Values:
    """The values in SI that a key takes along an axis, or the law by which it is drawn.

    `of` takes positions along the axis, or shares in (0, 1) where `count` is None, as an array. No
    value is beyond the `ends`. Choices, lists, tables and switches are counted from 0: `names` are
    their labels, `contents` what a case has of all but choices. `described` is for hashes.
    """

    described: Mapping[str, Any]
    of: Callable[[np.ndarray], np.ndarray]
    ends: tuple[float, float]
    count: int | None = None
    names: tuple[str, ...] = ()
    contents: tuple[Any, ...] = ()

    def at(self, positions: np.ndarray) -> np.ndarray:
        """Values at positions along the axis."""
        return self.of(positions) + 0.0

    def drawn(self, shares: np.ndarray) -> np.ndarray:
        """Values at shares in (0, 1) of a sampling; each of a list has the same chance."""
        if self.count is None:
            return self.at(shares)
        return self.at(np.minimum((shares * self.count).astype(np.int64), self.count - 1))


def listed(values: tuple[float, ...] | tuple[str, ...], contents: tuple[Any, ...] = ()) -> Values:
    """Values as given: numbers, names of choices, or labels of `contents`."""
    names = tuple(value for value in values if isinstance(value, str))
    numbers = np.array(range(len(names)) if names else values, dtype=float)
    return Values(
        described={"values": list(contents or values)},
        of=partial(np.take, numbers),
        ends=(float(numbers.min()), float(numbers.max())),
        count=len(values),
        names=names,
        contents=contents,
    )


# ----------------------------------------------------------------------------
# From one end to another in equal steps or equal ratios, ends included.
#
# The ends are numbers as written, and a factor turns them into SI: the tenth value from 5 to 50
# (N/mm) is what a case gets that says "50 N/mm".
# ----------------------------------------------------------------------------

#: whole numbers up to here are doubles
_EXACT = 1 << 53


def spaced(start: Fraction, stop: Fraction, factor: float, spacing: str, count: int) -> Values:
    """So many values, "linear" or "log"; 0.3 is 0.3, a power of ten one."""
    ends = {"from": str(start), "to": str(stop), "factor": factor}
    between = ratios if spacing == "log" else steps
    return Values(
        described={**ends, "spacing": spacing, "points": count},
        of=partial(between, start, stop, factor, count),
        ends=(float(start) * factor, float(stop) * factor),
        count=count,
    )


def steps(
    start: Fraction, stop: Fraction, factor: float, count: int, positions: np.ndarray
) -> np.ndarray:
    """The doubles next to start + (stop - start) position / (count - 1), times the factor."""
    # (first + slope position) / below in whole numbers
    below = math.lcm(start.denominator, stop.denominator) * (count - 1)
    first, last = int(start * below), int(stop * below)
    slope = (last - first) // (count - 1)
    if max(abs(first), abs(last), below) <= _EXACT:
        # whole numbers that doubles hold: their quotient is rounded once
        return np.asarray((first + slope * positions.astype(np.int64)) / float(below) * factor)
    whole = (first + slope * position for position in positions.tolist())
    return np.array([float(Fraction(number, below)) for number in whole]) * factor


def ratios(
    start: Fraction, stop: Fraction, factor: float, count: int, positions: np.ndarray
) -> np.ndarray:
    """start (stop / start)^(position / (count - 1)) to 15 digits, and the ends themselves."""
    first, ratio = float(start), float(stop / start)
    ends = {0: first, count - 1: float(stop)}
    unique, places = np.unique(positions, return_inverse=True)
    numbers = [
        ends.get(position, float(f"{first * ratio ** (position / (count - 1)):.15g}"))
        for position in unique.tolist()
    ]
    return np.array(numbers)[places] * factor


# ----------------------------------------------------------------------------
# How a key scatters: quantiles of distributions, in SI.
#
# Mean and deviation are those of the key itself, for the lognormal distribution too.
# ----------------------------------------------------------------------------

#: kind -> the parameters it needs, in the order in which its law takes them
PARAMETERS: dict[str, tuple[str, ...]] = {
    "uniform": ("min", "max"),
    "triangular": ("min", "max", "mode"),
    "normal": ("mean", "deviation"),
    "lognormal": ("mean", "deviation"),
}
_WIDEST = 1e6


def scattered(kind: str, *parameters: float) -> Values:
    """Values drawn from a distribution; "uniform" and "log_uniform" may also fall."""
    bounded = kind not in ("normal", "lognormal")
    largest = float(np.finfo(float).max)
    least = 5e-324 if kind == "lognormal" else -largest
    return Values(
        described={"distribution": kind, "parameters": list(parameters)},
        of=partial(_QUANTILES[kind], *parameters),
        ends=(parameters[0], parameters[1]) if bounded else (least, largest),
    )


def objection(kind: str, first: float, second: float, mode: float | None = None) -> str:
    """Say what is wrong with the parameters of a distribution, or nothing."""
    if kind in ("uniform", "triangular"):
        if not first < second:
            return "min has to be below max"
        inside = mode is None or first <= mode <= second
        return "" if inside else "mode has to be between min and max"
    if second <= 0.0:
        return "deviation has to be > 0"
    if kind == "lognormal" and first <= 0.0:
        return "a lognormal key is > 0, so its mean has to be"
    if kind == "lognormal" and second > _WIDEST * first:
        return f"deviation has to be below {_WIDEST:g} times the mean"
    return ""


def _uniform(first: float, last: float, shares: np.ndarray) -> np.ndarray:
    values = first + (last - first) * shares
    return np.clip(values, min(first, last), max(first, last))


def _log_uniform(first: float, last: float, shares: np.ndarray) -> np.ndarray:
    values = first * np.exp(shares * math.log(last / first))
    return np.clip(values, min(first, last), max(first, last))


def _triangular(lower: float, upper: float, mode: float, shares: np.ndarray) -> np.ndarray:
    width, ascent, fall = upper - lower, mode - lower, upper - mode
    rising = lower + np.sqrt(shares * width * ascent)
    falling = upper - np.sqrt((1.0 - shares) * width * fall)
    return np.clip(np.where(shares * width < ascent, rising, falling), lower, upper)


def _normal(mean: float, deviation: float, shares: np.ndarray) -> np.ndarray:
    from scipy.special import ndtri  # a grid needs no scipy

    return np.asarray(mean + deviation * ndtri(shares))


def _lognormal(mean: float, deviation: float, shares: np.ndarray) -> np.ndarray:
    variance = math.log1p((deviation / mean) ** 2)
    return np.asarray(mean * np.exp(_normal(-0.5 * variance, math.sqrt(variance), shares)))


_QUANTILES: dict[str, Callable[..., np.ndarray]] = {
    "uniform": _uniform,
    "log_uniform": _log_uniform,
    "triangular": _triangular,
    "normal": _normal,
    "lognormal": _lognormal,
}
