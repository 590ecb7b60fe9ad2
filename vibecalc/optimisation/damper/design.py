"""The spring and dashpot (and ring) of a damper that make the worst section of a line least."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.optimisation.damper.active import Held
from vibecalc.optimisation.damper.basins import basin_errors
from vibecalc.optimisation.damper.chart import chart_of, valleys
from vibecalc.optimisation.damper.descend import BROKEN, Place, descend, lenient, on_the_way
from vibecalc.optimisation.damper.problem import Damper, Limits, Problem
from vibecalc.optimisation.damper.settle import settle
from vibecalc.optimisation.damper.survey import Survey, survey

#: corners of the bounds from which a place that keeps the limits is looked for
_CORNERS = 4
#: share by which ends of descents of one optimum may differ
_AS_GOOD = 1e-3
#: readings beyond the sections
_ASKED = (("heat", "W"), ("travel", "rad"), ("travel", "rad"))


class Design(NamedTuple):
    """The tuning, its errors, and what proves it.

    `damper` with absolute `damper_error` (inertia, stiffness, damping); `worst` the largest
    weighted half range with `worst_error`, `objective` the same plus the price of the ring.
    Certificate: `reading` (p,) (section number; e for heat, e + 1 and e + 2 for travel with the hub
    ahead and behind), `speed` (p,) in rad/s, `angle` (p, 2) of the crank at the crest and the
    trough that are read (heat has none: 0), `value` (p,) and `weight` (p,) of the summits that
    hold the tuning; two crests of one cycle are two summits. Sections are equal, limits are
    met, all weights are positive, those of sections add up to 1, and the weighted slopes by ln J,
    ln k, ln c over `worst` cancel but for `bound_weight` (3,), the pull of bounds (positive: a
    larger value is wanted; zero if held by equal bounds), and `residual`. `curvature` over
    `worst` is the least along directions that the summits leave free, infinite where there are
    none: above 0 the tuning is a strict local minimum. That it is the best of all rests on the
    map; `basin` (b, 3) are the ends of all descents (J, k, c), `basin_worst` (b,) their objectives.
    Absolute errors: `weight_error`, `bound_error`, `speed_error`, `curvature_error`; those of the
    ends, `basin_error` (b, 3) and `basin_worst_error` (b,), are how far they lie from where their
    own conditions hold.
    """

    damper: Damper
    damper_error: FloatArray
    worst: float
    worst_error: float
    objective: float
    reading: IntArray
    speed: FloatArray
    angle: FloatArray
    value: FloatArray
    weight: FloatArray
    bound_weight: FloatArray
    residual: float
    curvature: float
    basin: FloatArray
    basin_worst: FloatArray
    weight_error: FloatArray
    bound_error: FloatArray
    speed_error: FloatArray
    curvature_error: float
    basin_error: FloatArray
    basin_worst_error: FloatArray


def design(
    problem: Problem, limits: Limits, *, map_points: int = 15, speeds: int = 161, starts: int = 4
) -> Design:
    """Minimise the worst weighted half range over the range of speeds and over all sections.

    `map_points` values of each variable span the map whose valleys, at most `starts`, are searched;
    `speeds` points of the range only say where to look for summits. Raises NumericalFailure for a
    problem without meaning, limits that no damper found keeps, and a tuning that cannot be proved.
    """
    prepared = survey(problem, limits, speeds)
    return design_from(prepared, _starts(prepared, map_points, starts))


def design_from(prepared: Survey, starts: FloatArray) -> Design:
    """The same by descents from given logarithms (b, v) of the moving values."""
    ends = sorted((descend(prepared, start) for start in starts), key=_rank)
    if ends[0].over > BROKEN:
        # rings that are all but locked or free, of which the map may show nothing
        corners = lenient(prepared, _CORNERS)
        begin = [one.variables for one in corners]
        # where a limit is just met on the way there, the worst section may be far better
        begin += [on_the_way(prepared, ends[0], one) for one in corners if one.over <= 0.0]
        more = [descend(prepared, start) for start in begin]
        ends = sorted(ends + more, key=_rank)
    _keeps_limits(prepared, ends)
    held = None
    for best in ends:
        # a worse valley proves nothing of the best one
        if best.over > BROKEN or best.merit > ends[0].merit * (1.0 + _AS_GOOD):
            break
        held = settle(prepared, best)
        if held is None:
            # a descent in a curved valley may have stopped early
            held = settle(prepared, descend(prepared, best.variables))
        if held is not None:
            break
    if held is None:
        damper = prepared.damper(ends[0].variables)
        raise NumericalFailure(
            f"the search ended at k = {damper.stiffness:.6g} N m/rad, c = {damper.damping:.6g} "
            f"N m s/rad with {ends[0].merit:.6g}, where no set of speeds and limits proves an "
            "optimum; narrow the bounds or ask for a finer map"
        )
    return _record(prepared, held, ends)


def _starts(prepared: Survey, points: int, most: int) -> FloatArray:
    """Valleys of the map; with a free ring inertia the map is coarser."""
    if prepared.moving.size == 0:
        return np.zeros((1, 0))
    count = points if prepared.moving.size < 3 else max(5, points // 2)
    return valleys(prepared, chart_of(prepared, count), most)


def _rank(end: Place) -> tuple[bool, float]:
    """Places that keep the limits first, by merit; then the others, by their excess."""
    broken = end.over > BROKEN
    return broken, end.over if broken else end.merit


def _keeps_limits(prepared: Survey, ends: list[Place]) -> None:
    """Raise NumericalFailure where the least violated place found breaks a limit."""
    least = ends[0]
    if least.over <= BROKEN:
        return
    sections = prepared.system.twist.shape[0]
    asked = least.seen.row >= sections
    level = least.seen.value[asked] / prepared.scale[least.seen.row[asked]]
    index = int(np.argmax(level))
    name, unit = _ASKED[int(least.seen.row[asked][index]) - sections]
    damper = prepared.damper(least.variables)
    raise NumericalFailure(
        f"found no damper within the bounds that keeps its limits ({len(ends)} descents, no proof "
        f"that there is none): the least violated one found, k = {damper.stiffness:.6g} N m/rad "
        f"and c = {damper.damping:.6g} N m s/rad, has a {name} of "
        f"{least.seen.value[asked][index]:.6g} {unit} at {least.seen.speed[asked][index]:.6g} rad/s"
    )


def _record(prepared: Survey, held: Held, ends: list[Place]) -> Design:
    damper = prepared.damper(held.variables)
    error, pull, pull_error = np.zeros(3), np.zeros(3), np.zeros(3)
    pull_error[prepared.moving] = held.bound_error
    away, above = basin_errors(prepared, held, ends)
    error[prepared.moving] = np.array(damper)[prepared.moving] * held.variable_error
    pull[prepared.moving] = held.bound_weight
    return Design(
        damper=damper,
        damper_error=error,
        worst=held.level,
        worst_error=held.level_error,
        objective=held.level + prepared.limits.inertia_price * damper.inertia,
        reading=held.seen.row,
        speed=held.seen.speed,
        angle=np.mod(held.seen.phase, 2.0 * np.pi) * prepared.system.problem.cycle / (2.0 * np.pi),
        value=held.seen.value,
        weight=held.weight,
        bound_weight=pull,
        residual=held.residual,
        curvature=held.curvature,
        basin=np.array([prepared.damper(end.variables) for end in ends]),
        basin_worst=np.array([end.merit for end in ends]),
        weight_error=held.weight_error,
        bound_error=pull_error,
        speed_error=held.speed_error,
        curvature_error=held.curvature_error,
        basin_error=away,
        basin_worst_error=above,
    )
