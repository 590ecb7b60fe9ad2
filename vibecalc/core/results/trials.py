"""Trials of methods against each other: which nothing beats, which is cheapest for an error."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.core.results.layout import BETWEEN, TRIAL_DONE
from vibecalc.numerics.rounding import EPSILON

#: errors below so many roundings are not distinguished, however well the reference is known
_LEAST_ROUNDINGS = 64


def noise_of(agreement: float) -> float:
    """Relative error below which trials count as equally accurate, of a reference's agreement."""
    return max(agreement, _LEAST_ROUNDINGS * EPSILON)


class Trial(NamedTuple):
    """One method at one setting.

    `name` is that of the method, with the setting behind `BETWEEN` where there is one to choose.
    `worst_relative` is over the largest magnitude, `worst_level` in dB, `position_error` in the
    unit of the position; each is infinite where it was not measured. `seconds` is the least of the
    repeats, infinite where none was run. The front is of those that no other beats.
    """

    name: str
    setting: float
    is_default: bool
    status: int = TRIAL_DONE
    cause: str = ""
    work: float = 0.0
    worst_relative: float = math.inf
    worst_level: float = math.inf
    position_error: float = math.inf
    seconds: float = math.inf
    front_in_work: bool = False
    front_in_seconds: bool = False

    @property
    def done(self) -> bool:
        """Whether there is an error to speak of."""
        return self.status == TRIAL_DONE

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.name.partition(BETWEEN)[0]

    @property
    def shown(self) -> str:
        """The setting as it is read, empty where there is nothing to set."""
        return f"{self.setting:.6g}" if BETWEEN in self.name else ""


def on_front(trials: Sequence[Trial], noise: float, cost: str) -> list[bool]:
    """Whether none is cheaper and as accurate, or as cheap and better; never without an error.

    `cost` is "work" or "seconds"; errors below the `noise` are equal.
    """
    e = np.array([max(trial.worst_relative, noise) for trial in trials])
    c = np.array([getattr(trial, cost) for trial in trials])
    no_worse = (c[:, None] <= c) & (e[:, None] <= e) & np.isfinite(e)[:, None]
    better = no_worse & ((c[:, None] < c) | (e[:, None] < e))
    return [bool(one) for one in np.isfinite(e) & ~np.any(better, axis=0)]


def marked(trials: Sequence[Trial], noise: float) -> tuple[Trial, ...]:
    """The same with their fronts."""
    fronts = (on_front(trials, noise, cost) for cost in ("work", "seconds"))
    return tuple(
        trial._replace(front_in_work=least, front_in_seconds=fast)
        for trial, least, fast in zip(trials, *fronts, strict=True)
    )


def cheapest(trials: Sequence[Trial], target: float, cost: str) -> Trial | None:
    """The cheapest with an error of at most `target`; of equals the more accurate."""
    reaching = [trial for trial in trials if trial.done and trial.worst_relative <= target]
    return min(
        reaching, key=lambda trial: (getattr(trial, cost), trial.worst_relative), default=None
    )


def extra(trials: Sequence[Trial], noise: float, cost: str) -> float:
    """Cost of the default over the least of any as accurate: 1 on the front or without a default.

    Of several defaults the worst counts; infinite where one has no error.
    """
    worst = 1.0
    for ours in (trial for trial in trials if trial.is_default):
        best = cheapest(trials, max(ours.worst_relative, noise), cost) if ours.done else None
        if best is None:
            return math.inf
        least = getattr(best, cost)
        worst = max(worst, getattr(ours, cost) / least if least > 0.0 else 1.0)
    return worst
