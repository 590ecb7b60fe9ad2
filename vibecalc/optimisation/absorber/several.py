"""Least largest response with several absorbers: from many starts to one certified optimum."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.optimisation.absorber.several_descent import Descent, descend
from vibecalc.optimisation.absorber.several_newton import Held, hold
from vibecalc.optimisation.absorber.several_problem import Problem, Rows, Travel, largest
from vibecalc.optimisation.absorber.several_starts import starts, usual_size
from vibecalc.response.absorber.model import Absorber
from vibecalc.response.absorber.peaks import peaks

#: descents that go on to the last digits, and how small their box gets before
_FINALISTS, _ROUGH, _FINE = 4, 3e-2, 1e-6
#: levels that count as the same optimum
_SAME = 1e-8
#: stiffness, in units of `usual_size`, beyond which the rigidly fastened limit is tried as well
_STIFF = 4.0


class SeveralTuning(NamedTuple):
    """The optimum, and what certifies it.

    `peak` of |H| with absolute `peak_error`; `frequency` (a,) where the active peaks stand and
    `weight` (a,) by which their slopes cancel (they add to one); `residual` the length of what is
    left of them, per relative change of a ratio. `curvature`: least second derivative of
    log |H|^2 along changes that leave the active peaks level, infinite if there are none; zero or
    close to it where the optimum is not the only one. `on_lower`, `on_upper` (q,): ratios that
    a bound holds. `travel` (limits,) reached, `travel_active`. `is_set`: the response at an end of
    the frequency range is largest (to 1e-9), so that the optimum is a set, of which one is given;
    `no_help`: the primary system alone does as well.
    `agreeing` of `starts` finalists ended here. `ratio_error` (q,) absolute. An infinite stiffness:
    that absorber does best when fastened rigidly to what it hangs on.
    """

    mass_ratio: np.ndarray
    stiffness_ratio: np.ndarray
    secondary_damping: np.ndarray
    peak: float
    peak_error: float
    ratio_error: np.ndarray
    frequency: np.ndarray
    weight: np.ndarray
    residual: float
    curvature: float
    on_lower: np.ndarray
    on_upper: np.ndarray
    travel: np.ndarray
    travel_active: np.ndarray
    is_set: bool
    no_help: bool
    agreeing: int
    starts: int
    evaluations: int


def several_tuning(
    primary_damping: float, mass_ratio: ArrayLike, parent: tuple[int, ...],
    excitation: str = "force", response: str = "displacement", *,
    share_masses: bool = False, starts: int = 0,
) -> SeveralTuning:  # fmt: skip
    """Minimise the largest |H| over k (n) and z (n), all >= 0, of n absorbers.

    Parameters
    ----------
    mass_ratio : (n,) array
    parent : n whole numbers, see `Several`, `parallel` and `series`
    share_masses : bool
        Only the sum of the mass ratios is given; how it is shared out is found too.
    starts : int
        How many of the deterministic starts are tried; 0 for 8, 12, 24 and more, as n grows.

    Raises NumericalFailure where the response grows with frequency without bound, and where no
    start ends in a point whose peaks hold each other up.

    Notes
    -----
    A minimax has no convexity here: the global optimum is as sure as the number of starts.
    """
    m = np.atleast_1d(np.asarray(mass_ratio, dtype=float))
    size = 2 * len(m) + (len(m) - 1) * share_masses
    lower, upper = np.zeros(size), np.full(size, np.inf)
    lower[2 * len(m) :], upper[2 * len(m) :] = 0.02, 0.98
    problem = Problem(
        float(primary_damping), m, tuple(parent), excitation, response, lower, upper,
        shares=share_masses,
    )  # fmt: skip
    return tuned(problem, starts or (4 + 4 * len(m) if len(m) < 3 else 8 * len(m)))


def tuned(problem: Problem, count: int) -> SeveralTuning:
    """Solve a problem with bounds and limits of travel from `count` starts."""
    scale = usual_size(problem)
    rough: list[Descent] = []
    message = ""
    for start in starts(problem, count):
        try:
            rough.append(descend(problem, start * scale, scale, _ROUGH))
        except NumericalFailure as failure:
            message = str(failure)
    if not rough:
        raise NumericalFailure(message)
    rough.sort(key=_merit)
    used = sum(one.evaluations for one in rough)
    ends: list[Descent] = []
    for one in rough[:_FINALISTS]:
        end = descend(problem, one.ratios, scale, _FINE)
        used += end.evaluations
        ends.append(end)
    ends.sort(key=_merit)
    best = ends[0]
    agreeing = sum(_merit(end) < _merit(best) + 1e-5 for end in ends)
    if largest(best.rows)[1] > 1e-7:
        factor = float(np.exp(0.5 * largest(best.rows)[1]))
        least = ""
        if len(problem.travel) == 1:
            least = f"; the least travel found is {factor * problem.travel[0].limit:.6g}"
        raise NumericalFailure(
            "no stiffness and damping within the bounds keep the spring travel within its limit: "
            f"the closest found exceeds it by the factor {factor:.6g}{least}"
        )
    still = best.rows.some(~best.rows.moves & (best.rows.kind == 0))
    level = largest(best.rows)[0]
    if len(still.level) and float(np.max(still.level)) >= level - 1e-9:
        return _set_of_optima(problem, best, agreeing, len(ends), used)
    choices: list[tuple[float, Problem, Held]] = []
    for end in ends:
        held = hold(problem, end.ratios, scale)
        if held is not None:
            used += held.evaluations
            choices.append((largest(held.rows)[0], problem, held))
            break
    choices += _fastened(problem, ends, scale)
    if choices:
        # where a finite tuning and its limit are as good, the finite one
        found, its, held = min(choices, key=lambda choice: choice[0])
        if found <= level + _SAME:
            return _certified(its, held, scale, agreeing, len(ends), used)
    raise NumericalFailure(
        f"tuning of {len(problem.mass_ratio)} absorbers: the lowest peak found, "
        f"{np.exp(0.5 * level):.9g}, is not held by its peaks; give more starts"
    )


def _fastened(
    problem: Problem, ends: list[Descent], scale: np.ndarray
) -> list[tuple[float, Problem, Held]]:
    """The limit with those absorbers rigidly fastened that the descents made very stiff."""
    n = len(problem.mass_ratio)
    tried: set[tuple[bool, ...]] = set()
    found = []
    for end in ends:
        size = end.ratios / scale
        stiff = (size[:n] > _STIFF) & np.isinf(problem.upper[:n])
        stiff |= (size[n : 2 * n] > 2.0 * _STIFF) & np.isinf(problem.upper[n : 2 * n])
        mask = tuple(bool(one) for one in stiff)
        if not any(mask) or all(mask) or mask in tried:
            continue
        tried.add(mask)
        fixed = np.concatenate([stiff, stiff, np.zeros(len(scale) - 2 * n, dtype=bool)])
        limit = problem._replace(
            locked=mask,
            lower=np.where(fixed, 0.0, problem.lower), upper=np.where(fixed, 0.0, problem.upper),
        )  # fmt: skip
        last = descend(limit, np.where(fixed, 0.0, end.ratios), scale, _FINE)
        held = hold(limit, last.ratios, scale)
        if held is not None:
            found.append((largest(held.rows)[0], limit, held))
    return found


def _merit(end: Descent) -> float:
    level, over = largest(end.rows)
    return level + 100.0 * over


def _travels(problem: Problem, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Largest travels (limits,) and which of them are at their limit."""
    over = np.array([
        float(np.max(rows.level[rows.kind == j], initial=-np.inf))
        for j in range(1, len(problem.travel) + 1)
    ])  # fmt: skip
    limit = np.array([one.limit for one in problem.travel])
    return limit * np.exp(0.5 * over), over > -1e-9


def _certified(
    problem: Problem, held: Held, scale: np.ndarray, agreeing: int, count: int, used: int
) -> SeveralTuning:
    level = largest(held.rows)[0]
    peak, n = float(np.exp(0.5 * level)), len(problem.mass_ratio)
    own = held.active & (held.rows.kind == 0)
    doubt = float(np.max(held.rows.error[own]) + np.ptp(held.rows.level[own]))
    # the step to the exact conditions is of second order in what is left of them
    curvature = held.curvature if np.isfinite(held.curvature) else 1.0
    slope = np.linalg.norm(held.rows.slope[held.active] * scale, axis=1)
    stiff = max(float(np.min(slope)), 1e-300)
    move = held.step**2 + (held.residual + 1e-14) / max(curvature, 1e-12) + doubt / stiff
    k, z = held.ratios[:n], held.ratios[n : 2 * n]
    if any(problem.locked):
        k = np.where(problem.locked, np.inf, k)
    return SeveralTuning(
        problem.masses(held.ratios), k, z, peak,
        0.5 * peak * (doubt + held.residual * move), scale * move, held.rows.frequency[own],
        held.weight[own], held.residual, held.curvature, held.on_lower, held.on_upper,
        *_travels(problem, held.rows), False, False, agreeing, count, used,
    )  # fmt: skip


def _set_of_optima(
    problem: Problem, best: Descent, agreeing: int, count: int, used: int
) -> SeveralTuning:
    level, n, size = largest(best.rows)[0], len(problem.mass_ratio), len(best.ratios)
    peak, none = float(np.exp(0.5 * level)), np.zeros(size, dtype=bool)
    bare = Absorber(problem.primary_damping, 1.0, 0.0, 0.0)
    alone = peaks(bare, problem.excitation, problem.response).largest
    no_help = bool(alone <= peak * (1.0 + 1e-9))
    return SeveralTuning(
        problem.masses(best.ratios), best.ratios[:n], best.ratios[n : 2 * n], peak, 4e-15 * peak,
        np.full(size, np.inf), np.array([]), np.array([]), 0.0, 0.0, none, none,
        *_travels(problem, best.rows), True, no_help, agreeing, count, used,
    )  # fmt: skip


__all__ = ["SeveralTuning", "Travel", "several_tuning", "tuned"]
