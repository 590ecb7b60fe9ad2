"""How a key scatters: quantiles of four distributions, in SI.

Mean and deviation are those of the key itself, for the lognormal distribution too.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vibecalc.study.sweep.portable import exp, log_of_one_plus, normal_quantile

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
    width, rise, fall = upper - lower, mode - lower, upper - mode
    rising = lower + np.sqrt(shares * width * rise)
    falling = upper - np.sqrt((1.0 - shares) * width * fall)
    return np.clip(np.where(shares * width < rise, rising, falling), lower, upper)


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
