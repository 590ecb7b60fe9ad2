"""Minimax tuning of several absorbers, or of one within bounds, to a certified optimum."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.absorber.peaks import peaks
from vibecalc.absorber.several_peaks import several_slopes
from vibecalc.absorber.transfer import Absorber, transfer_of
from vibecalc.absorber.tuning.minimax import BALANCED, minimax
from vibecalc.absorber.tuning.minimax_steps import certify
from vibecalc.absorber.tuning.several_search import (
    Descent,
    OptimalPoint,
    Rows,
    Travel,
    TuningProblem,
    descend,
    hold,
    largest,
    starts,
    usual_size,
)
from vibecalc.errors import NumericalFailure

# ----------------------------------------------------------------------------
# Least largest response with several absorbers: from many starts to one certified optimum.
# ----------------------------------------------------------------------------

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
    parent : n whole numbers, see `Several`
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
    problem = TuningProblem(
        float(primary_damping), m, tuple(parent), excitation, response, lower, upper,
        shares=share_masses,
    )  # fmt: skip
    return tuned(problem, starts or (4 + 4 * len(m) if len(m) < 3 else 8 * len(m)))


def tuned(problem: TuningProblem, count: int) -> SeveralTuning:
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
    choices: list[tuple[float, TuningProblem, OptimalPoint]] = []
    ends = [end._replace(ratios=_in_order(problem, end.ratios)) for end in ends]
    for end in ends:
        held = hold(problem, end.ratios, scale)
        if held is not None:
            used += held.evaluations
            choices.append((largest(held.rows)[0], problem, held))
            break
    choices += _fastened(problem, ends, scale)
    if choices:
        # where a finite tuning and its limit are as good, the finite one
        best_level, its, held = min(choices, key=lambda choice: choice[0])
        if best_level <= level + _SAME:
            return _certified(its, held, scale, agreeing, len(ends), used)
    raise NumericalFailure(
        f"tuning of {len(problem.mass_ratio)} absorbers: the lowest peak found, "
        f"{np.exp(0.5 * level):.9g}, is not held by its peaks; give more starts"
    )


def _in_order(problem: TuningProblem, ratios: np.ndarray) -> np.ndarray:
    """The point (q,) with absorbers that nothing tells apart by rising stiffness."""
    count, found = len(problem.mass_ratio), ratios.copy()
    if problem.shares or problem.travel or any(problem.parent):
        return found
    apart = zip(
        problem.mass_ratio,
        *(bound[: 2 * count].reshape(2, count)[row] for bound in (problem.lower, problem.upper)
          for row in range(2)),
        strict=True,
    )  # fmt: skip
    alike: dict[tuple[float, ...], list[int]] = {}
    for place, one in enumerate(apart):
        alike.setdefault(tuple(float(value) for value in one), []).append(place)
    for places in alike.values():
        order = sorted(places, key=lambda place: ratios[place])
        for part in (0, count):
            found[[part + place for place in places]] = ratios[[part + place for place in order]]
    return found


def _fastened(
    problem: TuningProblem, ends: list[Descent], scale: np.ndarray
) -> list[tuple[float, TuningProblem, OptimalPoint]]:
    """The limit with those absorbers rigidly fastened that the descents made very stiff."""
    n = len(problem.mass_ratio)
    tried: set[tuple[bool, ...]] = set()
    choices = []
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
            choices.append((largest(held.rows)[0], limit, held))
    return choices


def _merit(end: Descent) -> float:
    level, over = largest(end.rows)
    return level + 100.0 * over


def _travels(problem: TuningProblem, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
    """Largest travels (limits,) and which of them are at their limit."""
    over = np.array([
        float(np.max(rows.level[rows.kind == j], initial=-np.inf))
        for j in range(1, len(problem.travel) + 1)
    ])  # fmt: skip
    limit = np.array([one.limit for one in problem.travel])
    return limit * np.exp(0.5 * over), over > -1e-9


def _certified(
    problem: TuningProblem,
    held: OptimalPoint,
    scale: np.ndarray,
    agreeing: int,
    count: int,
    used: int,
) -> SeveralTuning:
    level = largest(held.rows)[0]
    peak, n = float(np.exp(0.5 * level)), len(problem.mass_ratio)
    on_curve = held.active & (held.rows.kind == 0)
    uncertainty = float(np.max(held.rows.error[on_curve]) + np.ptp(held.rows.level[on_curve]))
    # the step to the exact conditions is of second order in what is left of them
    curvature = held.curvature if np.isfinite(held.curvature) else 1.0
    slope = np.linalg.norm(held.rows.slope[held.active] * scale, axis=1)
    stiff = max(float(np.min(slope)), 1e-300)
    move = held.step**2 + (held.residual + 1e-14) / max(curvature, 1e-12) + uncertainty / stiff
    k, z = held.ratios[:n], held.ratios[n : 2 * n]
    if any(problem.locked):
        k = np.where(problem.locked, np.inf, k)
    return SeveralTuning(
        problem.masses(held.ratios), k, z, peak,
        0.5 * peak * (uncertainty + held.residual * move), scale * move,
        held.rows.frequency[on_curve], held.weight[on_curve], held.residual, held.curvature,
        held.on_lower, held.on_upper, *_travels(problem, held.rows), False, False, agreeing, count,
        used,
    )  # fmt: skip


def _set_of_optima(
    problem: TuningProblem, best: Descent, agreeing: int, count: int, used: int
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

# ----------------------------------------------------------------------------
# The free optimum of one absorber in the form of several: sharp down to a threshold.
# ----------------------------------------------------------------------------


def free_optimum(problem: TuningProblem) -> SeveralTuning | None:
    """The minimax of one absorber without limits; None where two equal peaks do not hold it.

    Next to a threshold the peaks stand above the floor by less than the levels of several absorbers
    can tell; `minimax` works with that excess itself.
    """
    pair = problem.excitation, problem.response
    z1, m = problem.primary_damping, problem.mass_ratio
    try:
        best = minimax(z1, float(m[0]), *pair)
    except NumericalFailure:
        return None
    if int(best.outcome) != BALANCED:
        return None
    k, z2 = best.stiffness_ratio.reshape(1), best.secondary_damping.reshape(1)
    ratios = np.append(k, z2)
    slopes = several_slopes(problem.system(ratios), best.frequency, transfer_of(*pair))
    # along the line of equal levels, per relative change of both ratios
    slope = slopes.first[:, :2] * ratios
    apart = slope[0] - slope[1]
    along = np.array([-apart[1], apart[0]]) / max(float(np.linalg.norm(apart)), 1e-300)
    bend = np.tensordot(best.weight, slopes.second[:, :2, :2], 1) * ratios[:, None] * ratios
    none = np.zeros(2, dtype=bool)
    return SeveralTuning(
        m, k, z2, float(best.largest), float(best.largest_error),
        np.array([float(best.stiffness_error), float(best.damping_error)]), best.frequency,
        best.weight, float(certify(Absorber(z1, m[0], k[0], z2[0]), *pair).residual),
        float(along @ bend @ along), none, none, np.zeros(0), np.zeros(0, dtype=bool), False, False,
        1, 1, int(best.evaluations),
    )  # fmt: skip


# ----------------------------------------------------------------------------
# Least largest response where stiffness, damping or the travel of the spring are limited.
# ----------------------------------------------------------------------------

#: an optimum that exceeds a limit of travel by less than this keeps it
_WITHIN = 1e-9
#: what may hold an optimum
HELD_BY = (
    "least stiffness", "least damping", "largest stiffness", "largest damping", "spring travel",
)  # fmt: skip


class BoundedTuning(NamedTuple):
    """The optimum within the limits next to the one without; arrays of one entry are plain numbers.

    `tuning` as for several absorbers, with one; `travel` of the spring there (largest relative
    amplitude at its own worst frequency, in the unit of displacement of `transfer_of`),
    `free_peak` and `free_travel` of the unlimited optimum, `penalty` = peak / free_peak - 1 with
    `penalty_error`. `active`: names of the limits that hold the optimum.
    """

    tuning: SeveralTuning
    travel: float
    travel_error: float
    free_peak: float
    free_travel: float
    penalty: float
    penalty_error: float
    active: tuple[str, ...]


def bounded_tuning(
    primary_damping: float, mass_ratio: float, excitation: str = "force",
    response: str = "displacement", *, stiffness: tuple[float, float] = (0.0, np.inf),
    damping: tuple[float, float] = (0.0, np.inf), travel: float = np.inf,
) -> BoundedTuning:  # fmt: skip
    """Minimise the largest |H| over k and z2 within [low, high] each, and a largest spring travel.

    The free optimum is found first, by itself, and is the answer where it keeps the limits.
    Raises NumericalFailure where a bound is crossed over, where nothing within the bounds keeps
    the travel, and where the response grows with frequency without bound.
    """
    for name, (low, high) in (("stiffness", stiffness), ("damping", damping)):
        if not 0.0 <= low <= high:
            raise NumericalFailure(
                f"bounds of the {name} ratio, {low:.6g} to {high:.6g}, leave nothing: they must be "
                "zero or positive, and the lower not above the upper"
            )
    if not travel > 0.0:
        raise NumericalFailure(f"a largest spring travel of {travel:.6g} leaves no motion to use")
    m = np.array([float(mass_ratio)])
    bare = TuningProblem(
        float(primary_damping), m, (0,), excitation, response, np.zeros(2), np.full(2, np.inf)
    )
    free = free_optimum(bare)
    free = tuned(bare, 8) if free is None else free
    free_travel, free_uncertainty = spring_travel(primary_damping, m[0], free, excitation)
    lower = np.array([stiffness[0], damping[0]], dtype=float)
    upper = np.array([stiffness[1], damping[1]], dtype=float)
    limits = (Travel(1, float(travel)),) if np.isfinite(travel) else ()
    there = float(free.stiffness_ratio[0]), float(free.secondary_damping[0])
    if (
        keeps(there, stiffness, damping)
        and not free.is_set
        and free_travel <= travel * (1.0 + _WITHIN)
    ):
        reach = np.array([free_travel] * len(limits))
        held = free._replace(travel=reach, travel_active=reach >= travel * (1.0 - _WITHIN))
        return BoundedTuning(
            held, free_travel, free_uncertainty, free.peak, free_travel, 0.0, 4e-16,
            ("spring travel",) if np.any(held.travel_active) else (),
        )  # fmt: skip
    bounded = tuned(bare._replace(lower=lower, upper=upper, travel=limits), 8)
    reached, uncertainty = spring_travel(primary_damping, m[0], bounded, excitation)
    active = tuple(
        name
        for name, held in zip(
            HELD_BY,
            (*bounded.on_lower, *bounded.on_upper, bool(limits) and bool(bounded.travel_active[0])),
            strict=True,
        )
        if held
    )
    ratio = bounded.peak / free.peak
    return BoundedTuning(
        bounded, reached, uncertainty, free.peak, free_travel, ratio - 1.0,
        ratio * (bounded.peak_error / bounded.peak + free.peak_error / free.peak) + 4e-16,
        active,
    )  # fmt: skip


def keeps(
    ratios: tuple[float, float], stiffness: tuple[float, float], damping: tuple[float, float]
) -> bool:
    """Whether stiffness and damping ratio lie within their bounds."""
    both = zip(ratios, (stiffness, damping), strict=True)
    return all(low <= ratio <= high for ratio, (low, high) in both)


def spring_travel(
    primary_damping: float, mass_ratio: float, tuning: SeveralTuning, excitation: str
) -> tuple[float, float]:
    """Largest relative amplitude of one tuned secondary over all frequencies, and its error."""
    absorber = Absorber(
        primary_damping, mass_ratio, tuning.stiffness_ratio[0], tuning.secondary_damping[0]
    )
    found = peaks(absorber, excitation, "relative_displacement")
    return float(found.largest), float(found.largest_error)
