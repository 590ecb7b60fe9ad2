"""All search methods under one signature, so that they can stand side by side."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.core.study.search.conditions import stationarity
from vibecalc.core.study.search.local_search import local_search, set_scale
from vibecalc.core.study.search.problem import (
    CONVERGED,
    Ahead,
    Box,
    BudgetSpent,
    Evaluate,
    LocalEnd,
    Sampler,
    Values,
)
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# Direct search with exploratory and pattern moves.
# ----------------------------------------------------------------------------

Scalar = Callable[[np.ndarray], float]

#: points are multiples of its inverse: sums of such numbers within the unit cube are exact
_FINEST = 2.0**52


class Descent(NamedTuple):
    """Where a direct search stopped: point (n,) of the unit cube, value, points evaluated.

    `converged` says that the steps have become as small as was asked for.
    """

    point: np.ndarray
    value: float
    evaluations: int
    converged: bool


def hooke_jeeves(function: Scalar, start: np.ndarray, step: float, tolerance: float) -> Descent:
    """Search the unit cube for a low value without derivatives.

    Parameters
    ----------
    function : callable
        `function(unit (n,)) -> float`; infinity where there is no value. It is called once for
        each point.
    start : (n,) array
        First base point.
    step, tolerance : float
        First step of the exploratory moves, in units of the cube, and largest last one.

    Returns
    -------
    descent : Descent
        No point next to the last base, by the last step along an axis, is lower. On a
        smooth function that makes it nearly stationary; at a kink it may not even be that.

    Notes
    -----
    An exploratory move tries a step up and down each axis, the direction that helped last first,
    and keeps what is lower. While it helps, the pattern move goes on from the new base point by
    as much as it has moved, and explores there before it judges. Where nothing around the base
    is lower the step is halved. Steps that leave the cube end on its wall. All steps are powers
    of two and all points multiples of the smallest, so that a way back ends where it began, to
    the last bit: sums that round would let the search creep without end. R. Hooke and T. A.
    Jeeves, "Direct search" solution of numerical and statistical problems, J. ACM 8 (1961), 212.
    """
    step = float(2.0 ** np.round(np.log2(step)))
    start = np.round(start * _FINEST) / _FINEST
    known: dict[bytes, float] = {}

    def value_at(point: np.ndarray) -> float:
        key = (point + 0.0).tobytes()
        if key not in known:
            known[key] = function(point)
        return known[key]

    signs = np.ones(start.size)

    def explore(point: np.ndarray) -> tuple[np.ndarray, float]:
        best, lowest = point, value_at(point)
        for axis in range(start.size):
            for side in (signs[axis], -signs[axis]):
                trial = best.copy()
                trial[axis] = min(1.0, max(0.0, best[axis] + side * step))
                if trial[axis] != best[axis] and value_at(trial) < lowest:
                    best, lowest = trial, value_at(trial)
                    signs[axis] = side
                    break
        return best, lowest

    base, value = start, value_at(start)
    while True:
        explored, lowest = explore(base)
        while lowest < value:
            before, base, value = base, explored, lowest
            explored, lowest = explore(np.clip(2.0 * base - before, 0.0, 1.0))
        if explore(base)[1] < value:
            continue
        if step <= tolerance:
            return Descent(base, value, len(known), True)
        step = 0.5 * step


# ----------------------------------------------------------------------------
# Direct search with a simplex that crawls downhill.
# ----------------------------------------------------------------------------

MOST_RESTARTS = 20


def nelder_mead(function: Scalar, start: np.ndarray, step: float, tolerance: float) -> Descent:
    """Search the unit cube for a low value without derivatives.

    Parameters and result as of `hooke_jeeves`; `step` is the first edge of the simplex and
    `tolerance` the last one.

    Notes
    -----
    scipy's, with factors that follow the dimension. Corners that leave the cube are moved onto
    its wall, which may flatten the simplex: a search is begun again with a fresh, smaller one
    around its best corner until that gains nothing. J. A. Nelder and R. Mead, A simplex method
    for function minimization, Computer Journal 7 (1965), 308-313; F. Gao and L. Han, Comput.
    Optim. Appl. 51 (2012), 259-277.
    """
    from scipy.optimize import minimize

    point, value, edge, evaluations = start, function(start), step, 1
    for _ in range(MOST_RESTARTS):
        simplex = point + np.vstack(
            [np.zeros(point.size), np.diag(np.where(point + edge <= 1.0, edge, -edge))]
        )
        found = minimize(
            function,
            point,
            method="Nelder-Mead",
            bounds=[(0.0, 1.0)] * point.size,
            options={
                "initial_simplex": simplex,
                "adaptive": True,
                "xatol": tolerance,
                "fatol": np.inf,
                "maxiter": 400 * point.size,
            },
        )
        evaluations += found.nfev
        gained = found.fun < value
        if gained:
            point, value = found.x, float(found.fun)
        if not gained and found.success and edge <= 10.0 * tolerance:
            return Descent(point, value, evaluations, True)
        edge = max(10.0 * tolerance, 0.1 * edge if found.success else edge)
    return Descent(point, value, evaluations, False)


# ----------------------------------------------------------------------------
# Limits for searches that know none: an augmented Lagrangian around a direct search.
# ----------------------------------------------------------------------------

FIRST_STEP = 0.125
FIRST_TOLERANCE = 1e-2
TOLERANCE = 1e-8
FIRST_WEIGHT = 1.0
LARGEST_WEIGHT = 1e4
MOST_ROUNDS = 60
#: violation, or slack of a margin that has a price, that counts as none
SETTLED = 1e-7

Inner = Callable[[Scalar, np.ndarray, float, float], Descent]


def augmented(sampler: Values, start: np.ndarray, inner: Inner) -> LocalEnd:
    """Search downhill from a start with a direct search, and keep all margins in the end.

    Parameters
    ----------
    sampler : Values
    start : (n,) array
        Point of the unit cube at which the sampler gives values.
    inner : callable
        The direct search, as `hooke_jeeves`.

    Notes
    -----
    A wall or an exact penalty would put a crease along each limit, on which a search along the
    axes stands still far from the optimum. Here the objective gains, for each margin, the smooth
    term w/2 max(0, p/w - margin)^2, whose price p is corrected after each round and becomes the
    multiplier. Steps shrink from round to round; the weight w grows only where the violation
    does not fall. R. M. Lewis and V. Torczon, SIAM J. Optim. 12 (2002), 1075-1089.
    """
    first = sampler(start)
    assert first is not None
    price = np.zeros(first.size - 1)
    weight = FIRST_WEIGHT

    def merit(unit: np.ndarray) -> float:
        vector = sampler(unit)
        if vector is None:
            return np.inf
        short = np.maximum(0.0, price / weight - vector[1:])
        return float(vector[0] + 0.5 * weight * np.sum(short**2))

    if price.size == 0:
        descent = inner(merit, start, FIRST_STEP, TOLERANCE)
        return LocalEnd(descent.point, _words(descent.converged))
    point, step, tolerance, before = start, FIRST_STEP, FIRST_TOLERANCE, np.inf
    for _ in range(MOST_ROUNDS):
        descent = inner(merit, point, step, tolerance)
        point = descent.point
        vector = sampler(point)
        assert vector is not None
        unsettled = float(np.max(np.abs(np.minimum(vector[1:], price / weight))))
        if unsettled <= SETTLED and tolerance <= TOLERANCE:
            return LocalEnd(point, _words(descent.converged))
        price = np.maximum(0.0, price - weight * vector[1:])
        if unsettled > 0.25 * before and weight < LARGEST_WEIGHT:
            weight *= 4.0
        before = unsettled
        tolerance = max(TOLERANCE, 0.1 * tolerance)
        step = max(10.0 * tolerance, 0.2 * step)
    return LocalEnd(point, "the limits did not settle")


def _words(converged: bool) -> str:
    return CONVERGED if converged else "stopped before its steps were small"


# ----------------------------------------------------------------------------
# A population that breeds: differential evolution, for objectives with many valleys.
# ----------------------------------------------------------------------------

#: fixed, so that a case gives the same result every day
SEED = 20000301
MOST_GENERATIONS = 1000
#: spread of the objective over the population, relative to its mean or in scaled units
SPREAD = 1e-9


def differential_evolution(sampler: Values, start: np.ndarray) -> LocalEnd:
    """Let a population spread over the whole unit cube evolve; the start is one of its members.

    Points that break a limit lose against any that keep all of them, and among themselves by how
    far they break it. R. Storn and K. Price, J. Global Optim. 11 (1997), 341-359, as in scipy.
    """
    from scipy.optimize import NonlinearConstraint
    from scipy.optimize import differential_evolution as evolve

    first = sampler(start)
    assert first is not None
    margins = first.size - 1

    def objective(unit: np.ndarray) -> float:
        vector = sampler(np.clip(unit, 0.0, 1.0))
        return np.inf if vector is None else float(vector[0])

    def limit_margins(unit: np.ndarray) -> np.ndarray:
        vector = sampler(np.clip(unit, 0.0, 1.0))
        return np.full(margins, -1e6) if vector is None else vector[1:]

    solution = evolve(
        objective,
        [(0.0, 1.0)] * start.size,
        constraints=(NonlinearConstraint(limit_margins, 0.0, np.inf),) if margins else (),
        seed=np.random.default_rng(SEED),
        x0=start,
        polish=False,
        tol=SPREAD,
        atol=SPREAD,
        maxiter=MOST_GENERATIONS,
    )
    reason = CONVERGED if solution.success else f"stopped after {MOST_GENERATIONS} generations"
    return LocalEnd(np.clip(solution.x, 0.0, 1.0), reason)


# ----------------------------------------------------------------------------
# All search methods under one signature, so that they can stand side by side.
# ----------------------------------------------------------------------------

#: evaluations kept back for the residual at the end, for each variable
_RESERVE = 40

Searcher = Callable[[Values, np.ndarray], LocalEnd]


class Method(NamedTuple):
    """A search from one start, its name in words and where it is published.

    `everywhere` marks one that searches the whole cube whatever its start.
    """

    search: Searcher
    words: str
    citation: str
    everywhere: bool = False


class MethodEnd(NamedTuple):
    """Where one method ended, without any help, and what it cost.

    `variables` (n,), `objective` and `margins` (m,) as `evaluate` gives them;
    `violation` is the most negative margin as a positive number, or 0; `residual` is the distance
    from a stationary point (`stationarity`); `evaluations` counts the points of the search itself
    and `failures` those of them that have no value. `reason` says why it stopped.
    """

    variables: np.ndarray
    objective: float
    margins: np.ndarray
    violation: float
    residual: float
    evaluations: int
    failures: int
    converged: bool
    reason: str


def find(
    name: str,
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    first: ArrayLike | None = None,
    budget: int = 20000,
    period: ArrayLike = 0.0,
    ahead: Ahead | None = None,
) -> MethodEnd:
    """Search with one method of `METHODS` from one start, and take its end as it is.

    Parameters
    ----------
    name : str
        Key of `METHODS`.
    evaluate, lower, upper, first, period, ahead
        As of `minimise.minimise`; lower < upper.
    budget : int
        Most evaluations; a method that spends them gives its best point and has not converged.

    Raises
    ------
    NumericalFailure
        If the start cannot be evaluated.
    """
    low, high = (np.atleast_1d(np.asarray(side, dtype=float)) for side in (lower, upper))
    box = Box(low, high, np.broadcast_to(np.asarray(period, dtype=float), low.shape))
    size = box.lower.size
    start = np.full(size, 0.5) if first is None else box.unit(np.asarray(first, float))
    sampler = Sampler(evaluate, box, budget, ahead)
    vectors, _ = set_scale(sampler, start[None, :])
    if vectors[0] is None:
        why = next(iter(sampler.failures.values()))
        raise NumericalFailure(f"the start of the search cannot be evaluated: {why}")
    try:
        walk = METHODS[name].search(sampler, start)
    except BudgetSpent:
        walk = LocalEnd(sampler.best, f"spent its {budget} evaluations")
    evaluations, failures = sampler.count, len(sampler.failures)
    sampler.budget += _RESERVE * (size + 1)
    vector = sampler(walk.unit)
    assert vector is not None
    margins = vector[1:]
    return MethodEnd(
        variables=box.values(walk.unit),
        objective=float(vector[0]) * sampler.scale,
        margins=margins,
        violation=float(np.max(-margins, initial=0.0)),
        residual=_residual(sampler, walk.unit),
        evaluations=evaluations,
        failures=failures,
        converged=walk.converged,
        reason=walk.reason,
    )


def _residual(sampler: Sampler, unit: np.ndarray) -> float:
    try:
        return stationarity(sampler, unit)
    except BudgetSpent:
        return np.inf


METHODS: dict[str, Method] = {
    "sequential_quadratic": Method(
        partial(local_search, to_the_end=True),
        "sequential quadratic programming",
        "Kraft 1988, DFVLR-FB 88-28; Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, "
        "ch. 12 and 18",
    ),
    "hooke_jeeves": Method(
        partial(augmented, inner=hooke_jeeves),
        "Hooke and Jeeves' pattern search",
        "Hooke and Jeeves 1961, J. ACM 8, 212; limits: Lewis and Torczon 2002, SIAM J. Optim. 12",
    ),
    "nelder_mead": Method(
        partial(augmented, inner=nelder_mead),
        "Nelder and Mead's simplex search",
        "Nelder and Mead 1965, Computer Journal 7, 308; limits: Lewis and Torczon 2002, "
        "SIAM J. Optim. 12",
    ),
    "differential_evolution": Method(
        differential_evolution,
        "differential evolution",
        "Storn and Price 1997, J. Global Optim. 11, 341",
        everywhere=True,
    ),
}
