"""The last digits of a local optimum, by the first of three methods that succeeds."""

import numpy as np

from vibecalc.core.study.search.kinks import settle
from vibecalc.core.study.search.local_search import local_search
from vibecalc.core.study.search.newton import BALANCED, Refined, polish
from vibecalc.core.study.search.problem import Sampler, spread
from vibecalc.numerics.rounding import EPSILON

#: an objective below this share of its change over the bounds may be on its way to zero
NEAR_ZERO = 3e-2
#: an objective this small next to the largest one met is zero
ZERO = 1e-11
#: margins are kept down to this
MARGIN_WITHIN = 1e-9
MOST_RESTARTS = 3


def refine(sampler: Sampler, unit: np.ndarray, below: float = np.inf) -> Refined | None:
    """Refine the end of a local search and show that it is a local optimum, or return None.

    A norm that vanishes at its minimum has a cone there: its square is smooth and gives the zero
    to the last digit. Everything smooth goes to Newton's method (`newton.polish`), and what is
    left, hidden kinks, to sampled planes (`kinks.settle`). An end that Newton's method cannot
    hold is searched once more, and given up unless its objective is then smaller than `below`.
    """
    for _ in range(MOST_RESTARTS):
        optimum = _zero(sampler, unit) or by_newton(sampler, unit)
        if optimum is None:
            unit = local_search(sampler, unit, to_the_end=True)
            if sampler.top(unit) >= below:
                return None
            optimum = _zero(sampler, unit) or by_newton(sampler, unit) or _planes(sampler, unit)
            if optimum is not None and optimum.method == "sampled planes":
                optimum = _zero(sampler, optimum.unit) or optimum
        lower = _lower_nearby(sampler, unit, optimum)
        if lower is None:
            return optimum
        unit = local_search(sampler, lower)
    return None


def by_newton(sampler: Sampler, unit: np.ndarray) -> Refined | None:
    """A smooth local optimum near the end of a search, None where there is none or limits break."""
    return _kept(sampler, polish(sampler, unit))


def _planes(sampler: Sampler, unit: np.ndarray) -> Refined | None:
    return _kept(sampler, settle(sampler.largest_part(), unit))


def _kept(sampler: Sampler, refined: Refined | None) -> Refined | None:
    """An optimum if it keeps all margins, but for round-off."""
    keeps = refined is not None and sampler.violation(refined.unit) <= MARGIN_WITHIN
    return refined if keeps else None


def _lower_nearby(sampler: Sampler, unit: np.ndarray, optimum: Refined | None) -> np.ndarray | None:
    """A clearly lower point in the surroundings, as next to a saddle, or None."""
    margin = 1e-9
    if optimum is not None:
        pulls = np.abs(optimum.bounds[optimum.sides != 0])
        if optimum.method == "newton" and not optimum.free_directions and np.all(pulls > BALANCED):
            return None  # its curvature is known, and bounds hold it
        unit, margin = optimum.unit, 1e-9 + 2 * optimum.excess
    axes = np.eye(unit.size)
    directions = np.vstack([axes, -axes, 2 * spread(4 * unit.size, unit.size) - 1])
    near = [sampler.box.fold(unit + size * one) for one in directions for size in (1e-2, 1e-3)]
    sampler.ahead(near)
    kept = [one for one in near if sampler.violation(one) <= 0.0]
    lowest = min(kept, key=sampler.top, default=unit)
    return lowest if sampler.top(lowest) < sampler.top(unit) - margin else None


def _zero(sampler: Sampler, unit: np.ndarray) -> Refined | None:
    """A zero of an objective that is never negative and leaves it as a cone; None without one."""
    if sampler.smallest < 0 or sampler.top(unit) > NEAR_ZERO:
        return None
    largest, squared = sampler.largest / sampler.scale, sampler.largest_part(power=2)
    minimum = polish(squared, unit)
    if minimum is None:
        minimum = polish(squared, local_search(squared, unit, to_the_end=True))
    if minimum is not None:
        # what is left of the norm bends its square where nothing else does: less of it is left now
        minimum = polish(squared, minimum.unit) or minimum
    minimum = _kept(sampler, minimum)
    if minimum is None:
        return None
    objective = sampler.top(minimum.unit)
    if objective > ZERO * largest or not _is_cone(sampler, minimum.unit):
        return None
    floor = max(4 * EPSILON * largest, float(sampler.bias(minimum.unit)[0]))
    away = np.where(minimum.sides == 0, np.sqrt(2.0) * floor * minimum.reach, 0.0)
    return minimum._replace(
        error=minimum.error + away,
        excess=objective + floor,
        objective=objective,
        margins=np.zeros_like(minimum.margins),
        bounds=np.zeros_like(minimum.bounds),
        residual=objective / max(largest, 1e-300),
        method="zero",
    )


def _is_cone(sampler: Sampler, unit: np.ndarray) -> bool:
    """Whether the objective grows with the distance from its zero, not with its square."""
    steps = np.diag(np.where(unit < 0.5, 1e-4, -1e-4))
    sampler.ahead([unit + step for step in steps])
    step = max(steps, key=lambda one: sampler.top(unit + one))
    return sampler.top(unit + 2 * step) < 3 * sampler.top(unit + step)
