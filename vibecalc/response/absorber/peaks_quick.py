"""Maxima of |H| from the undamped natural frequencies, where a count says that these are all.

Both natural frequencies of the undamped system have a closed form, and Newton's method from there
finds the peaks of nearly every absorber. Whether they are all is told by `peak_count`, from signs
alone. What is not told, or damped so little that it has to be looked at, is left to the slower way
by eigenvalues.
"""

from typing import NamedTuple

import numpy as np

from vibecalc.response.absorber.coefficients import Coupling, denominator
from vibecalc.response.absorber.measure import Measure, measure
from vibecalc.response.absorber.model import Transfer
from vibecalc.response.absorber.peak_count import maxima_counted
from vibecalc.response.absorber.peaks_polish import Tops, tops
from vibecalc.response.absorber.poles import landmarks
from vibecalc.response.absorber.polynomials import (
    excess_polynomials,
    stationarity,
    stationarity_size,
)

#: decay of all poles, over the upper natural frequency, from which none is too sharp to be placed
_DAMPED = 1e-6
#: share of rounding granted to the test of that
_CLEAR = 1e-12
#: error of ln u at which a start has settled
_SETTLED = 1e-9
#: excess over the floor squared below which |H|^2 itself keeps its digits
_LOW = -0.5


class QuickMaxima(NamedTuple):
    """All maxima of the rows that `told` (rows,) names.

    `looks` (rows,) counts evaluations of |H|^2 with two derivatives, of rows not told as well.
    """

    told: np.ndarray
    tops: Tops
    looks: np.ndarray


def quick_maxima(parts: Coupling, transfer: Transfer) -> QuickMaxima:
    """Maxima of all rows of `parts` (rows,) that are sure to be all there are."""
    count = len(parts.mass)
    weights = measure(parts, transfer)
    lower, upper = _first_guesses(parts)
    told, looks = _decays(parts, upper), np.zeros(count, dtype=int)
    chosen = np.flatnonzero(told)
    if not len(chosen):
        none = np.zeros(0)
        return QuickMaxima(told, Tops(chosen, none, none, none, none, none), looks)
    pair = chosen[lower[chosen] < upper[chosen]]
    rows = np.concatenate([pair, chosen])
    starts = np.square(np.concatenate([lower[pair], upper[chosen]]))
    found, taken = tops(parts, weights, rows, starts, far=True)
    looks += np.bincount(rows, taken, count).astype(int)
    # one that has not settled counts for none
    tallied = np.bincount(found.rows[found.blur <= _SETTLED], minlength=count)[chosen]
    told[chosen] &= _counted(parts, weights, chosen) == tallied
    found = Tops(*(a[told[found.rows]] for a in found))
    floor = weights.floor_squared[found.rows]
    low = np.flatnonzero(found.value < _LOW * floor)
    if len(low):
        rows = found.rows[low]
        again, taken = tops(parts, measure(parts, transfer, plain=True), rows, found.u[low])
        looks += np.bincount(rows, taken, count).astype(int)
        if np.array_equal(again.rows, rows):
            for column, new in zip(found, again, strict=True):
                column[low] = new
            found.value[low] = again.square - floor[low]
        else:
            told[rows] = False
            found = Tops(*(a[told[found.rows]] for a in found))
    return QuickMaxima(told, found, looks)


def _first_guesses(parts: Coupling) -> tuple[np.ndarray, np.ndarray]:
    """Frequency ratios near both peaks, one and the same where there is but one resonance."""
    with np.errstate(divide="ignore", invalid="ignore"):
        marks = landmarks(parts.mass, parts.mass * parts.g0 / parts.own)
    locked = parts.own == 0.0
    # without a spring the peak is between those with the secondary locked and free
    lower = np.choose(parts.shift, (marks.lower, marks.locked, marks.free))
    return lower, np.where(locked, marks.lower, marks.upper)


def _decays(parts: Coupling, upper: np.ndarray) -> np.ndarray:
    """Rows (rows,) whose poles all decay at a rate to speak of, as Routh and Hurwitz tell it."""
    moved, whole = denominator(parts), denominator(parts) > 0.0
    with np.errstate(all="ignore"):
        # D(s - decay), by Horner's rule
        decay = _DAMPED * upper
        for first in range(4):
            for place in range(3, first - 1, -1):
                moved[:, place] -= decay * moved[:, place + 1]
        d0, d1, d2, d3, d4 = moved.T
        terms = d3 * d2 * d1, d4 * d1 * d1, d3 * d3 * d0
        stable = terms[0] - terms[1] - terms[2] > _CLEAR * terms[0]
    positive = np.all((moved > 0.0) == whole, axis=-1) & np.all(whole[:, :3], axis=-1)
    decays: np.ndarray = positive & (stable | ~whole[:, 3])
    return decays


def _counted(parts: Coupling, weights: Measure, chosen: np.ndarray) -> np.ndarray:
    above, below = excess_polynomials(
        Coupling(*(a[chosen] for a in parts)), Measure(*(a[chosen] for a in weights))
    )
    return maxima_counted(stationarity(above, below), stationarity_size(above, below))
