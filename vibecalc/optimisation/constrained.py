"""Minimise a function of bounded variables while margins are kept, from many starts."""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.choice import anywhere, choose, only_point
from vibecalc.optimisation.local_search import local_search
from vibecalc.optimisation.methods import METHODS
from vibecalc.optimisation.optimum import Infeasible, Optimum
from vibecalc.optimisation.sampler import BudgetSpent, Evaluate, Sampler
from vibecalc.optimisation.search import search_all
from vibecalc.optimisation.starts import spread
from vibecalc.optimisation.summary import summary
from vibecalc.optimisation.variables import Box


def minimise(
    evaluate: Evaluate,
    lower: ArrayLike,
    upper: ArrayLike,
    *,
    first: ArrayLike | None = None,
    starts: int | np.ndarray = 8,
    rtol: float = 1e-9,
    budget: int = 20000,
    accuracy: float = 0.0,
    method: str = "sequential_quadratic",
    period: ArrayLike = 0.0,
) -> Optimum:
    """Find the smallest objective within bounds whose margins are all at least zero.

    Parameters
    ----------
    evaluate : callable
        `evaluate(variables (n,)) -> (objective, margins (m,))`. The objective is a number or an
        array, whose largest entry counts. A margin, made dimensionless by its limit, is kept
        where it is >= 0. A point that raises NumericalFailure or gives NaN or an infinity is
        counted and the search goes around it. Values have to be repeatable.
    lower, upper : (n,) arrays
        Bounds. A variable whose bounds are equal is held there.
    first : (n,) array, optional
        The first start; the middle of the bounds without it. Of equally good ends of
        searches, the nearest to it is returned.
    starts : int or (k, n) array
        How many further starts of a fixed low-discrepancy sequence, or the starts themselves.
    rtol : float
        Error of the objective, relative to its magnitude or to its change over the bounds, above
        which a note says so.
    budget : int
        Most evaluations.
    accuracy : float
        Relative accuracy of the values themselves, where known; round-off is always counted and
        noise is measured.
    method : str
        Key of `methods.METHODS`: what searches from each start. The end is refined the same way
        whatever it is.
    period : (n,) array
        After how much a variable repeats itself, as an angle does; 0 where it does not. One whose
        bounds hold a whole period has no bounds, and is told from its lower bound on.

    Returns
    -------
    optimum : Optimum

    Raises
    ------
    Infeasible
        If no point keeps all margins.
    NumericalFailure
        If no start can be evaluated, the objective has no lower bound, or no search ends in a
        point that can be shown to be an optimum.

    Notes
    -----
    Local searches run from all starts. The best of their ends are refined by Newton's method on
    the conditions that hold them, or, on a kink, by sampled planes; that step is also what shows
    the point to be a local optimum and how well it is known. That it is the global one rests on
    the starts.
    """
    low = np.atleast_1d(np.asarray(lower, dtype=float))
    high = np.atleast_1d(np.asarray(upper, dtype=float))
    moving = high > low
    whole = Box(low, high, np.broadcast_to(np.asarray(period, dtype=float), low.shape))

    def of_moving(part: np.ndarray) -> tuple[ArrayLike, ArrayLike]:
        variables = low.copy()
        variables[moving] = part
        return evaluate(variables)

    sampler = Sampler(of_moving, whole.only(moving), budget)
    begin = np.full(low.size, 0.5) if first is None else whole.unit(np.asarray(first, dtype=float))
    if isinstance(starts, int):
        further = whole.start(spread(starts, low.size))
    else:
        further = whole.unit(starts)
    points = np.vstack([begin[None, :], further.reshape(-1, low.size)])[:, moving]
    try:
        if not np.any(moving):
            search, choice = only_point(sampler)
        else:
            chosen = METHODS[method]
            search = search_all(
                sampler,
                points,
                local_search if method == "sequential_quadratic" else chosen.search,
                most=1 if chosen.everywhere else None,
            )
            choice = (
                anywhere(sampler, search.ends)
                if search.flat
                else choose(sampler, search.ends, points[0], accuracy)
            )
    except Infeasible as failure:
        nearest = low.copy()
        nearest[moving] = failure.variables
        raise Infeasible(str(failure), nearest, failure.evaluations) from None
    except BudgetSpent:
        raise NumericalFailure(
            f"the search had spent its {budget} evaluations before an optimum was pinned down; "
            f"{sampler.lowest_kept()}. Allow more evaluations or ask for fewer starts."
        ) from None
    return summary(sampler, whole, moving, search, choice, rtol)
