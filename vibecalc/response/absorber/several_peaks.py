"""Every peak of a response of several absorbers, from the stationarity polynomial."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.absorber.model import transfer_of
from vibecalc.response.absorber.peaks import SAME_HEIGHT
from vibecalc.response.absorber.several import Several
from vibecalc.response.absorber.several_polynomials import (
    Polynomial,
    added,
    several_polynomials,
    squared,
)

_POLISH = 40
#: part of a pole's size that its damping must exceed for the peak to count as finite
_DAMPED = 1e-13


class SeveralPeaks(NamedTuple):
    """Maxima of |H| by rising frequency (p,), and its limits at both ends.

    `error` is absolute, of `magnitude`. `largest` is the supremum over 0 <= x <= infinity, at
    `where`, the lowest of places of one height. `shoulder`: frequencies of poles without a peak of
    their own. `looks` counts evaluations of |H|^2 with two derivatives.
    """

    frequency: np.ndarray
    magnitude: np.ndarray
    error: np.ndarray
    at_zero: float
    at_infinity: float
    largest: float
    largest_error: float
    where: float
    shoulder: np.ndarray
    looks: int


def several_peaks(
    system: Several, excitation: str = "force", response: str = "displacement", absorber: int = 1
) -> SeveralPeaks:
    """All maxima of one system (no leading axes).

    Roots of P' Q - P Q', |H|^2 = P(u) / Q(u), by companion eigenvalues, and the poles beside them,
    are starts for Newton's method on |N / D|^2 itself, which alone decides the digits.
    Raises NumericalFailure on an undamped natural frequency, where the peak is infinite.
    """
    above, below = several_polynomials(system, transfer_of(excitation, response), absorber)
    if not np.any(above):
        none = np.zeros(0)
        return SeveralPeaks(none, none, none, 0.0, 0.0, 0.0, 0.0, 0.0, none, 0)
    above, below = _without_common_power(above, below)
    poles = _roots(below)
    bare = (np.abs(poles.real) < _DAMPED * np.abs(poles)) & (poles.imag > 0.0)
    if np.any(bare) and np.any(_relative_size(above, poles[bare]) > 1e-10):
        raise NumericalFailure(
            f"the response is infinite at x = {float(poles[bare][0].imag):.9g}, an undamped "
            "natural frequency of primary system and absorbers"
        )
    frequency, looks = _stationary(above, below, _starts(above, below, poles))
    value, error = _magnitude(above, below, frequency)
    low = float(abs(above[0]) / below[0]) if below[0] else 0.0
    excess = (len(above) - 1) - (len(below) - 1)
    high = float(abs(above[-1]) / below[-1]) if excess == 0 else (np.inf if excess > 0 else 0.0)
    heights = np.concatenate([[low], value, [high]])
    doubts = np.concatenate([[8 * UNIT_ROUNDOFF * low], error, [8 * UNIT_ROUNDOFF * min(high, 1)]])
    places = np.concatenate([[0.0], frequency, [np.inf]])
    best = int(np.argmax(heights))
    first = int(np.argmax(heights >= heights[best] * (1.0 - SAME_HEIGHT)))
    return SeveralPeaks(
        frequency, value, error, low, high, float(heights[best]), float(doubts[best]),
        float(places[first]), _shoulders(poles[~bare], frequency), looks,
    )  # fmt: skip


def _shoulders(poles: np.ndarray, peaks: np.ndarray) -> np.ndarray:
    """Poles that swing, without the one nearest to each peak."""
    size = np.sort(np.abs(poles[poles.imag > 0.0]))
    for x in peaks:
        if len(size):
            size = np.delete(size, int(np.argmin(np.abs(size - x))))
    return size


def _without_common_power(above: Polynomial, below: Polynomial) -> tuple[Polynomial, Polynomial]:
    first = min(int(np.argmax(above != 0.0)), int(np.argmax(below != 0.0)))
    return np.trim_zeros(above[first:], "b"), np.trim_zeros(below[first:], "b")


def _roots(polynomial: Polynomial) -> np.ndarray:
    """Roots, with leading coefficients that are only rounding left out."""
    size = np.max(np.abs(polynomial))
    there = np.flatnonzero(np.abs(polynomial) > 1e-300 * size)
    found: np.ndarray = np.roots(polynomial[: there[-1] + 1][::-1] / size)
    return found.astype(complex)


def _relative_size(polynomial: Polynomial, s: np.ndarray) -> np.ndarray:
    powers = np.abs(s[:, None]) ** np.arange(len(polynomial))
    value = np.polynomial.polynomial.polyval(s, polynomial)
    size: np.ndarray = np.abs(value) / (powers @ np.abs(polynomial))
    return size


def _starts(above: Polynomial, below: Polynomial, poles: np.ndarray) -> np.ndarray:
    top, bottom = squared(above), squared(below)

    def slope(p: Polynomial) -> Polynomial:
        return p[1:] * np.arange(1, len(p)) if len(p) > 1 else np.zeros(1)

    stationary = added(np.convolve(slope(top), bottom), -np.convolve(top, slope(bottom)))
    if np.any(stationary):
        u = _roots(stationary)
        u = u[(u.real > 0.0) & (np.abs(u.imag) < u.real)].real
    else:
        u = np.zeros(0)
    poles = poles[poles.imag >= 0.0]
    extra = np.concatenate([np.abs(poles), poles.imag])
    return np.concatenate([np.sqrt(u), extra[extra > 0.0]])


def polished(above: Polynomial, below: Polynomial, frequency: np.ndarray) -> tuple[np.ndarray, int]:
    """Newton's method for a maximum near each frequency, on the reciprocal of |H|^2; its looks."""
    x, looks = frequency.copy(), 0
    live = np.arange(len(x))
    with np.errstate(all="ignore"):
        for _ in range(_POLISH):
            at = x[live]
            looks += len(live)
            first, second = _slopes(above, below, at)
            step = first / np.where(first * first > second, first * first - second, np.abs(second))
            step = np.where(np.isfinite(step), np.clip(step, -0.1 * at, 0.1 * at), 0.0)
            x[live] = at + step
            # quadratic: after a step of 1e-8, or one small beside a narrower peak, only rounding
            fine = np.maximum(1e-6 / np.sqrt(np.abs(second)), 8.0 * UNIT_ROUNDOFF * at)
            near = np.abs(np.log(x[live] / frequency[live])) < 0.7
            live = live[near & (np.abs(step) > np.minimum(1e-8 * at, fine))]
            if not len(live):
                break
    return x, looks


def _slopes(above: Polynomial, below: Polynomial, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of log |H|^2 by x."""
    s = 1j * x
    top, bottom = _logarithmic(above, s), _logarithmic(below, s)
    first = -2.0 * (top[0] - bottom[0]).imag
    second = -2.0 * (top[1] - bottom[1]).real
    return first, second


def _logarithmic(polynomial: Polynomial, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivative of log p by s."""
    evaluate = np.polynomial.polynomial.polyval
    order = np.arange(len(polynomial))
    value = evaluate(s, polynomial)
    first = evaluate(s, (polynomial * order)[1:]) if len(order) > 1 else 0.0 * s
    second = evaluate(s, (polynomial * order * (order - 1))[2:]) if len(order) > 2 else 0.0 * s
    return first / value, second / value - (first / value) ** 2


def _stationary(above: Polynomial, below: Polynomial, start: np.ndarray) -> tuple[np.ndarray, int]:
    x, looks = polished(above, below, start)
    x = np.sort(x)
    with np.errstate(all="ignore"):
        first, second = _slopes(above, below, x)
        value, error = _magnitude(above, below, x)
        # the slope is no better known than the height, in units of the peak's own width
        felt = error / value
        maximum = (second < 0.0) & (np.abs(first) < (1e-7 + felt) * np.sqrt(-second))
    keep = maximum & np.isfinite(x) & (x > 0.0)
    x, width = x[keep], (1.0 + 100.0 * felt[keep]) / np.sqrt(-second[keep])
    # between two maxima the curve must come down
    twice = np.zeros(len(x), dtype=bool)
    twice[1:] = np.diff(x) < 1e-2 * width[1:]
    return x[~twice], looks + len(start)


def _magnitude(
    above: Polynomial, below: Polynomial, x: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    s = 1j * x
    evaluate = np.polynomial.polynomial.polyval
    value = np.abs(evaluate(s, above) / evaluate(s, below))
    lost = 1.0 / _relative_size(above, s) + 1.0 / _relative_size(below, s)
    return value, 4.0 * UNIT_ROUNDOFF * (len(below) + lost) * value
