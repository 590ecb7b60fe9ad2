"""Searches of scipy that count what they evaluate and keep the best point that they met."""

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure

#: a point (n,) to a value to be made small
Function = Callable[[np.ndarray], float]
#: a point (n,) to objective and margins (m,), kept where >= 0
Limited = Callable[[np.ndarray], tuple[float, np.ndarray]]

#: a margin broken by less counts as kept, as in the searches of `optimisation`
NEARLY_KEPT = 1e-6


class Searched(NamedTuple):
    """The best point (n,) met, its value, and evaluations of the function."""

    place: np.ndarray
    value: float
    evaluations: int


def nelder_mead(function: Function, first: np.ndarray, tolerance: float) -> Searched:
    """`scipy.optimize.minimize`, simplex, until place and value change by less than `tolerance`.

    At most 600 evaluations: on a kink the simplex may collapse and not end.
    """
    from scipy.optimize import minimize

    kept = _Kept(function)
    options = {"xatol": tolerance, "fatol": 0.01 * tolerance, "maxfev": 600}
    minimize(kept, first, method="Nelder-Mead", options=options)
    return kept.searched()


def evolution(
    function: Function, bounds: list[tuple[float, float]], generations: int, seed: int = 1
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

    def __init__(self, function: Function):
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
