"""All search methods under one signature, so that they can stand side by side."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.augmented import Walk, augmented
from vibecalc.optimisation.evolution import differential_evolution
from vibecalc.optimisation.hooke_jeeves import hooke_jeeves
from vibecalc.optimisation.local_search import local_search
from vibecalc.optimisation.nelder_mead import nelder_mead
from vibecalc.optimisation.sampler import BudgetSpent, Evaluate, Sampler, Values
from vibecalc.optimisation.search import set_scale
from vibecalc.optimisation.stationarity import stationarity
from vibecalc.optimisation.variables import Box

#: evaluations kept back for the residual at the end, for each variable
_RESERVE = 40

Searcher = Callable[[Values, np.ndarray], Walk]


class Method(NamedTuple):
    """A search from one start, its name in words and where it is published.

    `everywhere` marks one that searches the whole cube whatever its start.
    """

    search: Searcher
    words: str
    citation: str
    everywhere: bool = False


class Found(NamedTuple):
    """Where one method ended, without any help, and what it cost.

    `variables` (n,), `objective` (its largest entry) and `margins` (m,) as `evaluate` gives them;
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
) -> Found:
    """Search with one method of `METHODS` from one start, and take its end as it is.

    Parameters
    ----------
    name : str
        Key of `METHODS`.
    evaluate, lower, upper, first, period
        As of `constrained.minimise`; lower < upper.
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
    sampler = Sampler(evaluate, box, budget + _RESERVE * (size + 1))
    vectors, _ = set_scale(sampler, start[None, :])
    if vectors[0] is None:
        why = next(iter(sampler.failures.values()))
        raise NumericalFailure(f"the start of the search cannot be evaluated: {why}")
    watched = _Watched(sampler, budget)
    watched(start)
    try:
        walk = METHODS[name].search(watched, start)
    except BudgetSpent:
        walk = Walk(watched.best, f"spent its {budget} evaluations", False)
    evaluations, failures = sampler.count, len(sampler.failures)
    vector = sampler(walk.unit)
    assert vector is not None
    margins = vector[sampler.entries :]
    return Found(
        variables=box.values(walk.unit),
        objective=float(np.max(vector[: sampler.entries])) * sampler.scale,
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


class _Watched:
    """The sampler with an end to its evaluations and a memory for the best point met."""

    def __init__(self, sampler: Sampler, budget: int):
        self._sampler = sampler
        self._budget = budget
        self.best = np.empty(0)
        self._rank = (np.inf, np.inf)

    @property
    def box(self) -> Box:
        return self._sampler.box

    @property
    def entries(self) -> int:
        return self._sampler.entries

    @property
    def smallest(self) -> float:
        return self._sampler.smallest

    def __call__(self, unit: np.ndarray) -> np.ndarray | None:
        if self._sampler.count >= self._budget and not self._sampler.knows(unit):
            raise BudgetSpent
        vector = self._sampler(unit)
        if vector is not None:
            broken = max(0.0, float(np.max(-vector[self.entries :], initial=0.0)) - 1e-6)
            rank = (broken, float(np.max(vector[: self.entries])))
            if rank < self._rank:
                self.best, self._rank = unit.copy(), rank
        return vector


def _sequential_quadratic(sampler: Values, start: np.ndarray) -> Walk:
    end = local_search(sampler, start, to_the_end=True)
    return Walk(end.unit, end.reason, end.reason == "converged")


def _hooke_jeeves(sampler: Values, start: np.ndarray) -> Walk:
    return augmented(sampler, start, hooke_jeeves)


def _nelder_mead(sampler: Values, start: np.ndarray) -> Walk:
    return augmented(sampler, start, nelder_mead)


METHODS: dict[str, Method] = {
    "sequential_quadratic": Method(
        _sequential_quadratic,
        "sequential quadratic programming",
        "Kraft 1988, DFVLR-FB 88-28; Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, "
        "ch. 12 and 18",
    ),
    "hooke_jeeves": Method(
        _hooke_jeeves,
        "Hooke and Jeeves' pattern search",
        "Hooke and Jeeves 1961, J. ACM 8, 212; limits: Lewis and Torczon 2002, SIAM J. Optim. 12",
    ),
    "nelder_mead": Method(
        _nelder_mead,
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
