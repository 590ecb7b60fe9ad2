"""The values of one key along an axis: listed, spread between two ends, or drawn."""

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np

# ----------------------------------------------------------------------------
# Logarithm, exponential and normal quantile from operations that every platform rounds alike.
#
# The functions of a mathematical library differ between platforms in the last bit, and with them
# the values of a sweep and every hash over them. Sums, products, quotients and roots do not.
# ----------------------------------------------------------------------------

_LN2_HIGH = 0.6931471803691238  # ln 2, its last 21 bits zero: whole multiples of it are exact
_LN2_LOW = 1.9082149292705877e-10
_LN2 = 0.6931471805599453
_ROOT_HALF = 0.7071067811865476


def log(values: np.ndarray) -> np.ndarray:
    """Natural logarithm of positive numbers, any shape, to about 2 units in the last place."""
    mantissa, exponent = np.frexp(values)
    small = mantissa < _ROOT_HALF
    mantissa = np.where(small, 2.0 * mantissa, mantissa)
    exponent = exponent - small
    logarithm = _twice_artanh((mantissa - 1.0) / (mantissa + 1.0))
    return np.asarray(exponent * _LN2_HIGH + (logarithm + exponent * _LN2_LOW))


def log_of_one_plus(values: np.ndarray) -> np.ndarray:
    """Natural logarithm of 1 + values, values > -1, without loss of digits for small ones."""
    small = np.abs(values) < 0.25
    near = np.where(small, values, 0.0)
    return np.where(small, _twice_artanh(near / (2.0 + near)), log(1.0 + values))


def _twice_artanh(t: np.ndarray) -> np.ndarray:
    # |t| < 0.172, so that t^25 / 25 falls below the last bit of the sum
    square = t * t
    series = np.full_like(t, 1.0 / 23.0)
    for odd in range(21, 1, -2):
        series = series * square + 1.0 / odd
    return np.asarray(2.0 * t + 2.0 * t * square * series)


def exp(values: np.ndarray) -> np.ndarray:
    """Exponential, any shape, to about 2 units in the last place; |values| below 700."""
    whole = np.rint(values / _LN2)
    reduced = (values - whole * _LN2_HIGH) - whole * _LN2_LOW
    # |reduced| < 0.347: reduced^17 / 17! is below the last bit
    series = np.ones_like(reduced)
    for order in range(16, 1, -1):
        series = 1.0 + series * reduced / order
    return np.asarray(np.ldexp(1.0 + series * reduced, whole.astype(int)))


def normal_quantile(share: np.ndarray) -> np.ndarray:
    """Value below which a standard normal variable falls with probability `share` in (0, 1).

    Wichura 1988, Applied Statistics 37, algorithm AS 241 (PPND16): relative accuracy 1e-15.
    """
    offset = share - 0.5
    middle = np.abs(offset) <= 0.425
    square = 0.180625 - offset * offset
    result = offset * _ratio(np.where(middle, square, 0.0), _MIDDLE)
    if not np.all(middle):
        nearer = np.where(middle, 0.25, np.minimum(share, 1.0 - share))
        depth = np.sqrt(-log(nearer))
        tail = np.where(
            depth <= 5.0, _ratio(depth - 1.6, _TAIL), _ratio(np.maximum(depth, 5.0) - 5.0, _FAR)
        )
        result = np.where(middle, result, np.copysign(tail, offset))
    return np.asarray(result)


_Fraction = tuple[tuple[float, ...], tuple[float, ...]]


def _ratio(variable: np.ndarray, fraction: _Fraction) -> np.ndarray:
    above, below = (np.full_like(variable, terms[-1]) for terms in fraction)
    for upper, lower in zip(fraction[0][-2::-1], fraction[1][-2::-1], strict=True):
        above = above * variable + upper
        below = below * variable + lower
    return np.asarray(above / below)


# numerator and denominator from the constant term upwards, as published
_MIDDLE: _Fraction = (
    (3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3,
     1.3731693765509461125e4, 4.5921953931549871457e4, 6.7265770927008700853e4,
     3.3430575583588128105e4, 2.5090809287301226727e3),
    (1.0, 4.2313330701600911252e1, 6.8718700749205790830e2, 5.3941960214247511077e3,
     2.1213794301586595867e4, 3.9307895800092710610e4, 2.8729085735721942674e4,
     5.2264952788528545610e3),
)  # fmt: skip
_TAIL: _Fraction = (
    (1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0,
     3.64784832476320460504e0, 1.27045825245236838258e0, 2.41780725177450611770e-1,
     2.27238449892691845833e-2, 7.74545014278341407640e-4),
    (1.0, 2.05319162663775882187e0, 1.67638483018380384940e0, 6.89767334985100004550e-1,
     1.48103976427480074590e-1, 1.51986665636164571966e-2, 5.47593808499534494600e-4,
     1.05075007164441684324e-9),
)  # fmt: skip
_FAR: _Fraction = (
    (6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0,
     2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
     2.71155556874348757815e-5, 2.01033439929228813265e-7),
    (1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1, 1.48753612908506148525e-2,
     7.86869131145613259100e-4, 1.84631831751005468180e-5, 1.42151175831644588870e-7,
     2.04426310338993978564e-15),
)  # fmt: skip

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

_WIDEST = 1e6


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """One distribution with its parameters in SI, named as in PARAMETERS."""

    kind: str
    parameters: tuple[float, ...]

    def quantile(self, shares: np.ndarray) -> np.ndarray:
        """Values below which the key falls with these probabilities in (0, 1); same shape."""
        return _QUANTILES[self.kind](shares, *self.parameters)

    @property
    def ends(self) -> tuple[float, float]:
        """Two doubles that no value is beyond."""
        if self.kind in ("uniform", "triangular"):
            return self.parameters[0], self.parameters[1]
        largest = float(np.finfo(float).max)
        return (5e-324 if self.kind == "lognormal" else -largest), largest

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


def _uniform(shares: np.ndarray, lower: float, upper: float) -> np.ndarray:
    return np.clip(lower + (upper - lower) * shares, lower, upper)


def _triangular(shares: np.ndarray, lower: float, upper: float, mode: float) -> np.ndarray:
    width, ascent, fall = upper - lower, mode - lower, upper - mode
    rising = lower + np.sqrt(shares * width * ascent)
    falling = upper - np.sqrt((1.0 - shares) * width * fall)
    return np.clip(np.where(shares * width < ascent, rising, falling), lower, upper)


def _normal(shares: np.ndarray, mean: float, deviation: float) -> np.ndarray:
    return mean + deviation * normal_quantile(shares)


def _lognormal(shares: np.ndarray, mean: float, deviation: float) -> np.ndarray:
    variance = log_of_one_plus(np.array((deviation / mean) ** 2))
    return np.asarray(mean * exp(np.sqrt(variance) * normal_quantile(shares) - 0.5 * variance))


_QUANTILES: dict[str, Callable[..., np.ndarray]] = {
    "uniform": _uniform,
    "triangular": _triangular,
    "normal": _normal,
    "lognormal": _lognormal,
}

# ----------------------------------------------------------------------------
# The values one key takes along an axis: listed, spread between two ends, or drawn.
#
# Values are in SI. `at` takes whole positions along the axis, `drawn` shares in (0, 1) of a
# sampling; both take and return arrays (len,).
# ----------------------------------------------------------------------------

_DIGITS = Context(prec=40)


@dataclass(frozen=True, kw_only=True)
class ValueList:
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
class SpacedValues:
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
class RandomValues:
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


AxisValues = ValueList | SpacedValues | RandomValues


def picked(shares: np.ndarray, count: int) -> np.ndarray:
    """Position of one of `count` equal parts of (0, 1)."""
    return np.minimum((shares * count).astype(np.int64), count - 1)
