"""The order of convergence that a ladder shows, fitted above round-off."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vibecalc.accuracy.rung import Rung
from vibecalc.numerics.rounding import EPSILON
from vibecalc.results.accuracy_layout import ALGEBRAIC, GEOMETRIC

#: rungs count that stand this far above what the reference or round-off can tell
_CLEAR, _ROUNDINGS = 30.0, 16

#: relative errors above this say little about the order, and are left out if enough others remain
_COARSE = 0.1

#: an end of the ladder that falls with less than this order has not begun to converge, or ended
_FLAT = 0.1

_LEAST_RUNGS = 3


class Fit(NamedTuple):
    """What was fitted: `kind` is "order" (error ~ setting^+-p) or "digits" (for each step of 1).

    `value` is p, positive where finer settings have smaller errors, or the digits gained with
    each unit of the setting; `rungs` of the ladder took part.
    """

    kind: str
    value: float
    rungs: int


def fitted(rungs: Sequence[Rung], agreement: float) -> Fit | None:
    """The order shown by the rungs of one ladder, from coarse to fine; None with fewer than three.

    Least squares of log error on log setting, and, where settings grow, of log error on the
    setting itself; the one that fits better is taken. `agreement` is that of the reference: rungs
    have to be 30 times above it and above 16 roundings.
    """
    floor = _CLEAR * max(agreement, _ROUNDINGS * EPSILON)
    used = [
        (rung.setting, rung.worst_relative)
        for rung in rungs
        if rung.done and rung.setting > 0.0 and floor < rung.worst_relative < np.inf
    ]
    fine = [pair for pair in used if pair[1] <= _COARSE]
    used = _falling(fine if len(fine) >= _LEAST_RUNGS else used)
    if len(used) < _LEAST_RUNGS:
        return None
    setting, error = (np.array(column) for column in zip(*used, strict=True))
    digits = np.log10(error)
    slope, misfit = _line(np.log10(setting), digits)
    grows = setting[-1] > setting[0]
    best = Fit(ALGEBRAIC, -slope if grows else slope, len(used))
    if grows:
        steepness, other_misfit = _line(setting, digits)
        if other_misfit < misfit:
            best = Fit(GEOMETRIC, -steepness, len(used))
    return best if best.value > 0.0 else None


def _falling(pairs: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Without the flat ends: from the largest error on, as far as errors still fall."""
    if pairs:
        pairs = pairs[max(range(len(pairs)), key=lambda place: pairs[place][1]) :]
    while len(pairs) > 1 and not _falls(pairs[-2], pairs[-1]):
        pairs = pairs[:-1]
    while len(pairs) > 1 and not _falls(pairs[0], pairs[1]):
        pairs = pairs[1:]
    return pairs


def _falls(before: tuple[float, float], after: tuple[float, float]) -> bool:
    apart = abs(np.log(after[0] / before[0]))
    return bool(np.log(before[1] / after[1]) > _FLAT * apart)


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope and sum of squares of the misfit; a constant x fits nothing."""
    centred = x - x.mean()
    spread = float(centred @ centred)
    if spread == 0.0:
        return 0.0, float("inf")
    slope = float(centred @ (y - y.mean())) / spread
    rest = y - y.mean() - slope * centred
    return slope, float(rest @ rest)
