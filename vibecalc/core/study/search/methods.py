"""Search methods by name: each from one start, refined by `minimise` or compared as they are."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from vibecalc.core.study.search.local_search import Searcher, local_search
from vibecalc.core.study.search.problem import (
    AMPLE_MARGIN,
    CONVERGED,
    Sampler,
    largest_part,
)

# ----------------------------------------------------------------------------
# Direct searches: by exploratory and pattern moves, and with a simplex that crawls downhill.
# ----------------------------------------------------------------------------

Scalar = Callable[[np.ndarray], float]
#: function, start (k,) on the unit cube, first and last step -> the lowest point, and whether the
#: steps have become as small as was asked for
Direct = Callable[[Scalar, np.ndarray, float, float], tuple[np.ndarray, bool]]

#: points are multiples of its inverse: sums of such numbers within the unit cube are exact
_FINEST = 2.0**52


def hooke_jeeves(
    function: Scalar, start: np.ndarray, step: float, tolerance: float
) -> tuple[np.ndarray, bool]:
    """Search the unit cube for a low value without derivatives.

    Parameters
    ----------
    function : callable
        `function(unit (k,)) -> float`; infinity where there is no value.
    start : (k,) array
        First base point.
    step, tolerance : float
        First step of the exploratory moves, in units of the cube, and largest last one.

    Returns
    -------
    point : (k,) array
        No point next to it, by the last step along an axis, is lower. On a smooth function that
        makes it nearly stationary; at a kink it may not even be that.
    converged : bool

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
    base = np.round(start * _FINEST) / _FINEST
    value, signs = function(base), np.ones(start.size)

    def explore(point: np.ndarray, lowest: float) -> tuple[np.ndarray, float]:
        for axis in range(start.size):
            for side in (signs[axis], -signs[axis]):
                trial = point.copy()
                trial[axis] = min(1.0, max(0.0, point[axis] + side * step))
                there = lowest if trial[axis] == point[axis] else function(trial)
                if there < lowest:
                    point, lowest, signs[axis] = trial, there, side
                    break
        return point, lowest

    while True:
        explored, lowest = explore(base, value)
        if lowest >= value and step <= tolerance:
            return base, True
        if lowest >= value:
            step = 0.5 * step
        while lowest < value:
            before, base, value = base, explored, lowest
            ahead = np.clip(2.0 * base - before, 0.0, 1.0)
            explored, lowest = explore(ahead, function(ahead))


MOST_RESTARTS = 20


def nelder_mead(
    function: Scalar, start: np.ndarray, step: float, tolerance: float
) -> tuple[np.ndarray, bool]:
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

    point, value, edge = start, function(start), step
    for _ in range(MOST_RESTARTS):
        edges = np.diag(np.where(point + edge <= 1.0, edge, -edge))
        found = minimize(
            function,
            point,
            method="Nelder-Mead",
            bounds=[(0.0, 1.0)] * point.size,
            options={
                "initial_simplex": point + np.vstack([np.zeros(point.size), edges]),
                "adaptive": True,
                "xatol": tolerance,
                "fatol": np.inf,
                "maxiter": 400 * point.size,
            },
        )
        gained = found.fun < value
        if gained:
            point, value = found.x, float(found.fun)
        if not gained and found.success and edge <= 10.0 * tolerance:
            return point, True
        edge = max(10.0 * tolerance, 0.1 * edge if found.success else edge)
    return point, False


# ----------------------------------------------------------------------------
# Limits for searches that know none: an augmented Lagrangian around a direct search.
# ----------------------------------------------------------------------------

FIRST_STEP = 0.125
FIRST_TOLERANCE = 1e-2
TOLERANCE = 1e-8
LARGEST_WEIGHT = 1e4
MOST_ROUNDS = 60
#: violation, or slack of a margin that has a price, that counts as none
SETTLED = 1e-7


def augmented(values: Sampler, start: np.ndarray, inner: Direct) -> tuple[np.ndarray, str]:
    """Search downhill from a start with a direct search, and keep all margins in the end.

    Notes
    -----
    A wall or an exact penalty would put a crease along each limit, on which a search along the
    axes stands still far from the optimum. Here the objective gains, for each margin, the smooth
    term w/2 max(0, p/w - margin)^2, whose price p is corrected after each round and becomes the
    multiplier. Steps shrink from round to round; the weight w grows only where the violation
    does not fall. R. M. Lewis and V. Torczon, SIAM J. Optim. 12 (2002), 1075-1089.
    """
    whole = largest_part(values)
    # an angle that goes all around has its walls half a turn away
    shift = np.where(values.box.around, start - 0.5, 0.0)

    def margins(place: np.ndarray) -> np.ndarray:
        vector = whole(place + shift)
        assert vector is not None
        return vector[1:]

    point = start - shift
    price, weight = np.zeros(margins(point).size), 1.0

    def merit(place: np.ndarray) -> float:
        vector = whole(place + shift)
        if vector is None:
            return np.inf
        short = np.maximum(0.0, price / weight - vector[1:])
        return float(vector[0] + 0.5 * weight * np.sum(short**2))

    step, tolerance, before = FIRST_STEP, FIRST_TOLERANCE, np.inf
    if price.size == 0:
        tolerance = TOLERANCE
    for _ in range(MOST_ROUNDS):
        point, converged = inner(merit, point, step, tolerance)
        left = margins(point)
        unsettled = float(np.max(np.abs(np.minimum(left, price / weight)), initial=0.0))
        if unsettled <= SETTLED and tolerance <= TOLERANCE:
            reason = CONVERGED if converged else "stopped before its steps were small"
            return values.box.fold(point + shift), reason
        price = np.maximum(0.0, price - weight * left)
        if unsettled > 0.25 * before and weight < LARGEST_WEIGHT:
            weight *= 4.0
        before = unsettled
        tolerance = max(TOLERANCE, 0.1 * tolerance)
        step = max(10.0 * tolerance, 0.2 * step)
    return values.box.fold(point + shift), "the limits did not settle"


# ----------------------------------------------------------------------------
# A population that breeds: differential evolution, for objectives with many valleys.
# ----------------------------------------------------------------------------

#: fixed, so that a case gives the same result every day
SEED = 20000301
MOST_GENERATIONS = 1000
#: spread of the objective over the population, relative to its mean or in scaled units
SPREAD = 1e-9


def differential_evolution(
    values: Sampler, start: np.ndarray | None, whole: int = 0, **options: Any
) -> tuple[np.ndarray, str]:
    """Let a population spread over the whole unit cube evolve; a start is one of its members.

    The first `whole` variables are whole numbers; `options` are scipy's. Points that break a limit
    lose against any that keep all of them, and among themselves by how far they break it. R. Storn
    and K. Price, J. Global Optim. 11 (1997), 341-359, as in scipy.
    """
    from scipy.optimize import NonlinearConstraint
    from scipy.optimize import differential_evolution as evolve

    box, places = values.box, np.arange(values.box.size)
    size = np.where(places < whole, np.round(box.upper - box.lower)[box.moving], 1.0)

    def margin(place: np.ndarray) -> float:
        broken = values.violation(place / size)
        return -min(broken, AMPLE_MARGIN)

    asked = {
        "x0": start,
        "rng": np.random.default_rng(SEED),
        "tol": SPREAD,
        "atol": SPREAD,
        "maxiter": MOST_GENERATIONS,
    }
    solution = evolve(
        lambda place: values.top(place / size),
        [(0.0, one) for one in size],
        integrality=places < whole,
        constraints=(NonlinearConstraint(margin, 0.0, np.inf),),
        polish=False,
        **(asked | options),
    )
    reason = CONVERGED if solution.success else f"stopped after {MOST_GENERATIONS} generations"
    return box.fold(solution.x / size), reason


# ----------------------------------------------------------------------------
# All search methods under one signature, so that they can stand side by side.
# ----------------------------------------------------------------------------


class Method(NamedTuple):
    """A search from one start, its name in words and where it is published.

    `everywhere` marks one that searches the whole cube whatever its start.
    """

    search: Searcher
    words: str
    citation: str
    everywhere: bool = False


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
