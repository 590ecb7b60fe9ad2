"""Plain searches that several subjects hold their methods against."""

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# Largest value on a grid: alone, with a parabola through the best points, or refined.
# ----------------------------------------------------------------------------

#: values (k,) at places (k,)
Function = Callable[[np.ndarray], np.ndarray]

#: of golden section, the share of the interval kept at each step
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


class Highest(NamedTuple):
    """The largest value, where it is, and evaluations of the function."""

    value: float
    position: float
    evaluations: int


def places_of(low: float, high: float, points: int, peak: float | None = None) -> np.ndarray:
    """Evenly spaced places from `low` to `high`, both ends included.

    With the known place of a `peak` inside, the grid is laid so that it lies a quarter of a step
    next to a point, which is how far a grid that knows nothing misses it on average: errors then
    fall from grid to grid, where they else depend on luck.
    """
    step = (high - low) / (points - 1)
    if peak is None:
        return np.linspace(low, high, points)
    first = peak - (np.floor((peak - low) / step - 0.25) + 0.25) * step
    places = first + step * np.arange(points)
    within: np.ndarray = places[(places >= low) & (places <= high)]
    return within


def grid_maximum(
    function: Function, low: float, high: float, points: int, peak: float | None = None
) -> Highest:
    """Largest value at the places of a grid, see `places_of`."""
    places = places_of(low, high, points, peak)
    values = function(places)
    best = int(np.argmax(values))
    return Highest(float(values[best]), float(places[best]), len(places))


def parabola_maximum(
    function: Function, low: float, high: float, points: int, peak: float | None = None
) -> Highest:
    """The same with a parabola through the best point and its two neighbours.

    At an end of the grid the end itself.
    """
    places = places_of(low, high, points, peak)
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


# ----------------------------------------------------------------------------
# Searches of scipy that count what they evaluate and keep the best point that they met.
# ----------------------------------------------------------------------------

#: a point (n,) to a value to be made small
Scalar = Callable[[np.ndarray], float]
#: a point (n,) to objective and margins (m,), kept where >= 0
Limited = Callable[[np.ndarray], tuple[float, np.ndarray]]

#: a margin broken by less counts as kept, as in the searches of `optimisation`
NEARLY_KEPT = 1e-6


class Searched(NamedTuple):
    """The best point (n,) met, its value, and evaluations of the function."""

    place: np.ndarray
    value: float
    evaluations: int


def nelder_mead(function: Scalar, first: np.ndarray, tolerance: float) -> Searched:
    """`scipy.optimize.minimize`, simplex, until place and value change by less than `tolerance`.

    At most 600 evaluations: on a kink the simplex may collapse and not end.
    """
    from scipy.optimize import minimize

    kept = _Kept(function)
    options = {"xatol": tolerance, "fatol": 0.01 * tolerance, "maxfev": 600}
    minimize(kept, first, method="Nelder-Mead", options=options)
    return kept.searched()


def evolution(
    function: Scalar, bounds: list[tuple[float, float]], generations: int, seed: int = 1
) -> Searched:
    """Differential evolution of scipy, unpolished, 15 members for each variable."""
    from scipy.optimize import differential_evolution

    kept = _Kept(function)
    differential_evolution(kept, bounds, seed=seed, maxiter=generations, tol=0.0, polish=False)
    return kept.searched()


def least_ceiling(
    levels: Callable[[np.ndarray], np.ndarray], first: np.ndarray, tolerance: float
) -> Searched:
    """SLSQP of scipy on the least t that is above all `levels` (k,), the usual form of a minimax.

    A call of `levels` counts as one evaluation.
    """
    from scipy.optimize import minimize

    size = len(first)
    kept = _Kept(lambda place: float(np.max(levels(place))))

    def room(extended: np.ndarray) -> np.ndarray:
        found = levels(extended[:size])
        kept.take(extended[:size], float(np.max(found)))
        return np.asarray(extended[size] - found)

    minimize(
        lambda extended: float(extended[size]),
        np.append(first, kept(first)),
        method="SLSQP",
        constraints={"type": "ineq", "fun": room},
        options={"ftol": tolerance, "maxiter": 200},
    )
    return kept.searched()


def within_budget(
    method: str, evaluate: Limited, bounds: list[tuple[float, float]], first: np.ndarray,
    budget: int, nearly: float = NEARLY_KEPT,
) -> Searched:  # fmt: skip
    """The best point that keeps the limits after `budget` evaluations of a search of scipy.

    Parameters
    ----------
    method : "SLSQP" or "COBYLA" with constraints, "differential evolution" with a penalty of the
        size of the objective at the start for each whole unit of a broken margin.
    bounds : of the variables, all of about the same size.
    nearly : a margin broken by less counts as kept.

    Raises
    ------
    NumericalFailure
        No point met keeps the limits, or the first one has no value.
    """
    kept = _Limits(evaluate, budget, nearly)
    size = abs(kept(first)[0]) or 1.0
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore", RuntimeWarning)
            _SEARCHES[method](kept, bounds, first, size)
    except _Spent:
        pass
    return kept.searched(method)


class _Spent(Exception):
    """The budget is used up."""


class _Kept:
    """A function that counts its calls and remembers its least value."""

    def __init__(self, function: Scalar):
        self._function = function
        self._best: tuple[float, np.ndarray] = (np.inf, np.zeros(0))
        self._count = 0

    def __call__(self, place: np.ndarray) -> float:
        value = self._function(place)
        self.take(place, value)
        return value

    def take(self, place: np.ndarray, value: float) -> None:
        self._count += 1
        if value < self._best[0]:
            self._best = (value, np.array(place))

    def searched(self) -> Searched:
        if not np.isfinite(self._best[0]):
            raise NumericalFailure("no point met has a finite value")
        return Searched(self._best[1], self._best[0], self._count)


class _Limits:
    """The same with limits and a budget; a point met again is looked up."""

    def __init__(self, evaluate: Limited, budget: int, nearly: float):
        self._evaluate, self._budget, self._nearly = evaluate, budget, nearly
        self._known: dict[bytes, tuple[float, np.ndarray]] = {}
        self._margins = 0
        self._best: tuple[float, np.ndarray] = (np.inf, np.zeros(0))

    def __call__(self, place: np.ndarray) -> tuple[float, np.ndarray]:
        key = np.ascontiguousarray(place + 0.0).tobytes()
        if key not in self._known:
            if len(self._known) >= self._budget:
                raise _Spent
            self._known[key] = self._taken(np.array(place))
        return self._known[key]

    def _taken(self, place: np.ndarray) -> tuple[float, np.ndarray]:
        try:
            objective, margins = self._evaluate(place)
        except NumericalFailure:
            if not self._known:
                raise
            # as bad as nothing that has a value
            return 1e300, np.full(self._margins, -1.0)
        self._margins = len(margins)
        if np.min(margins, initial=0.0) >= -self._nearly and objective < self._best[0]:
            self._best = (objective, place)
        return objective, margins

    def searched(self, method: str) -> Searched:
        if not np.isfinite(self._best[0]):
            raise NumericalFailure(
                f"{method} met no point that keeps all limits in {len(self._known)} evaluations"
            )
        return Searched(self._best[1], self._best[0], len(self._known))


def _by_constraints(
    method: str, kept: _Limits, bounds: list[tuple[float, float]], first: np.ndarray, size: float
) -> None:
    from scipy.optimize import minimize

    rules: list[dict[str, Any]] = []
    if len(kept(first)[1]):
        rules = [{"type": "ineq", "fun": lambda place: kept(place)[1]}]
    options = {"maxiter": 100000, **({"ftol": 1e-15} if method == "SLSQP" else {"tol": 1e-12})}
    minimize(
        lambda place: kept(place)[0] / size,
        first, method=method, bounds=bounds, constraints=rules, options=options,
    )  # fmt: skip


def _by_penalty(
    kept: _Limits, bounds: list[tuple[float, float]], first: np.ndarray, size: float
) -> None:
    from scipy.optimize import differential_evolution

    def penalised(place: np.ndarray) -> float:
        objective, margins = kept(place)
        return objective / size + 10.0 * float(np.sum(np.maximum(-margins, 0.0)))

    differential_evolution(
        penalised, bounds, seed=1, maxiter=100000, tol=0.0, polish=False, x0=first, popsize=5
    )


_SEARCHES: dict[str, Callable[[_Limits, list[tuple[float, float]], np.ndarray, float], None]] = {
    "SLSQP": lambda *given: _by_constraints("SLSQP", *given),
    "COBYLA": lambda *given: _by_constraints("COBYLA", *given),
    "differential evolution": _by_penalty,
}
