"""Largest value on a grid: alone, with a parabola through the best points, or refined."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure

#: values (k,) at places (k,)
Function = Callable[[np.ndarray], np.ndarray]

#: of golden section, the share of the interval kept at each step
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


class Highest(NamedTuple):
    """The largest value, where it is, and evaluations of the function."""

    value: float
    position: float
    evaluations: int


def places_of(low: float, high: float, points: int, summit: float | None = None) -> np.ndarray:
    """Evenly spaced places from `low` to `high`, both ends included.

    With the known place of a `summit` inside, the grid is laid so that it lies a quarter of a step
    beside a point, which is how far a grid that knows nothing misses it on average: errors then
    fall from grid to grid, where they else depend on luck.
    """
    step = (high - low) / (points - 1)
    if summit is None:
        return np.linspace(low, high, points)
    first = summit - (np.floor((summit - low) / step - 0.25) + 0.25) * step
    places = first + step * np.arange(points)
    within: np.ndarray = places[(places >= low) & (places <= high)]
    return within


def grid_maximum(
    function: Function, low: float, high: float, points: int, summit: float | None = None
) -> Highest:
    """Largest value at the places of a grid, see `places_of`."""
    places = places_of(low, high, points, summit)
    values = function(places)
    best = int(np.argmax(values))
    return Highest(float(values[best]), float(places[best]), len(places))


def parabola_maximum(
    function: Function, low: float, high: float, points: int, summit: float | None = None
) -> Highest:
    """The same with a parabola through the best point and its two neighbours.

    At an end of the grid the end itself.
    """
    places = places_of(low, high, points, summit)
    values = function(places)
    best = int(np.argmax(values))
    if best in (0, len(places) - 1):
        return Highest(float(values[best]), float(places[best]), len(places))
    before, at, after = values[best - 1 : best + 2]
    bend = before - 2.0 * at + after
    share = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    value = at - 0.25 * (before - after) * share
    return Highest(float(value), float(places[best] + share * (places[1] - places[0])), len(places))


def cyclic_parabola_maximum(function: Function, period: float, points: int) -> Highest:
    """`parabola_maximum` of a periodic function over one period, where no point is an end."""
    step = period / points
    values = function(step * np.arange(points))
    best = int(np.argmax(values))
    before, at, after = values[best - 1], values[best], values[(best + 1) % points]
    bend = before - 2.0 * at + after
    share = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    value = at - 0.25 * (before - after) * share
    return Highest(float(value), float(((best + share) * step) % period), points)


def golden_maximum(function: Function, low: float, high: float, steps: int = 60) -> Highest:
    """Golden section between two places that hold one maximum between them.

    The place is found to about the square root of rounding times the width of the peak.
    """
    for _ in range(steps):
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        rising = function(np.array([left, right]))
        low, high = (low, right) if rising[0] >= rising[1] else (left, high)
    place = 0.5 * (low + high)
    return Highest(float(function(np.array([place]))[0]), place, 2 * steps + 1)


def chebyshev_maximum(
    function: Function, centre: float, half_width: float, degree: int = 12
) -> Highest:
    """The maximum of a smooth function near `centre`, from a polynomial through Chebyshev points.

    Where the polynomial's slope is zero the place keeps nearly all digits, while a search that
    compares values keeps half of them. The interval must hold one maximum inside.

    Raises
    ------
    NumericalFailure
        The polynomial has no maximum within the interval.
    """
    from numpy.polynomial import chebyshev

    nodes = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    values = function(centre + half_width * nodes)
    series = chebyshev.chebfit(nodes, values, degree)
    roots = chebyshev.chebroots(chebyshev.chebder(series))
    inside = roots[(np.abs(roots.imag) < 1e-6) & (np.abs(roots.real) <= 1.0)].real
    if not inside.size:
        raise NumericalFailure(f"no maximum within {half_width:.3g} of {centre:.9g}")
    best = inside[np.argmax(chebyshev.chebval(inside, series))]
    value = float(chebyshev.chebval(best, series))
    return Highest(value, float(centre + half_width * best), degree + 1)
