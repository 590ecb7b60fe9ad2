"""The damper that makes the worst section of a line least, and what it is worth."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.bounded import Bounded, concatenate
from vibecalc.numerics.rounding import EPSILON, FloatArray, IntArray
from vibecalc.torsion.damper_design.peaks import (
    LEVEL,
    DamperPeaks,
    Survey,
    drift,
    place_error,
    survey,
)
from vibecalc.torsion.damper_design.problem import Damper, DamperProblem, Limits, system_of
from vibecalc.torsion.damper_design.readings import map_readings, reading_error
from vibecalc.torsion.damper_design.settle import (
    BROKEN,
    Chart,
    DesignPoint,
    Stationary,
    basins,
    chart_of,
    descend,
    lenient,
    nearest_within_limits,
    settle,
    valleys,
)

# ----------------------------------------------------------------------------
# The spring and dashpot (and ring) of a damper that make the worst section of a line least.
# ----------------------------------------------------------------------------

#: corners of the bounds from which a place that keeps the limits is searched
_CORNERS = 4
#: share by which ends of descents of one optimum may differ
_AS_GOOD = 1e-3
#: readings beyond the sections
_ASKED = (("heat", "W"), ("travel", "rad"), ("travel", "rad"))


class Design(NamedTuple):
    """The tuning, and what proves it.

    `damper` (3,): ring inertia, stiffness and damping; `worst` the largest weighted half range.
    Certificate: the peaks `peaks` that hold the tuning, with their `weight` (p,) and `speed` (p,);
    two crests of one cycle are two peaks. Sections are equal, limits are met, all weights are
    positive, those of sections add up to 1, and the weighted slopes by ln J, ln k, ln c over
    `worst` cancel but for `bound_weight` (3,), the pull of bounds (positive: a larger value is
    wanted; zero if held by equal bounds), and `residual`. `curvature` over `worst` is the least
    along directions that the peaks leave free, infinite where there are none: above 0 the tuning is
    a strict local minimum. That it is the best of all rests on the map; `basin` (b, 3) are the ends
    of all descents (J, k, c), `basin_worst` (b,) their objectives, with errors how far they lie
    from where their own conditions hold.
    """

    damper: Bounded
    worst: Bounded
    peaks: DamperPeaks
    weight: Bounded
    speed: Bounded
    bound_weight: Bounded
    residual: float
    curvature: Bounded
    basin: Bounded
    basin_worst: Bounded

    @property
    def values(self) -> Damper:
        """The damper."""
        return Damper(*self.damper.value.tolist())


def design(
    problem: DamperProblem,
    limits: Limits,
    *,
    map_points: int = 15,
    speeds: int = 161,
    starts: int = 4,
) -> Design:
    """Minimise the worst weighted half range over the range of speeds and over all sections.

    `map_points` values of each variable span the map whose valleys, at most `starts`, are searched;
    `speeds` points of the range only say where to search peaks. Raises NumericalFailure for a
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
        begin += [
            nearest_within_limits(prepared, ends[0], one) for one in corners if one.over <= 0.0
        ]
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


def _rank(end: DesignPoint) -> tuple[bool, float]:
    """Places that keep the limits first, by merit; then the others, by their excess."""
    broken = end.over > BROKEN
    return broken, end.over if broken else end.merit


def _keeps_limits(prepared: Survey, ends: list[DesignPoint]) -> None:
    """Raise NumericalFailure where the least violated place found breaks a limit."""
    least = ends[0]
    if least.over <= BROKEN:
        return
    section, scale, _ = prepared.levels(least.peaks)
    worst = least.peaks.some(
        np.array([np.argmax(np.where(section, 0.0, least.peaks.value / scale))])
    )
    name, unit = _ASKED[int(worst.row[0]) - prepared.system.twist.shape[0]]
    damper = prepared.damper(least.variables)
    raise NumericalFailure(
        f"found no damper within the bounds that keeps its limits ({len(ends)} descents, no proof "
        f"that there is none): the least violated one found, k = {damper.stiffness:.6g} N m/rad "
        f"and c = {damper.damping:.6g} N m s/rad, has a {name} of {worst.value[0]:.6g} {unit} at "
        f"{worst.speed[0]:.6g} rad/s"
    )


def _record(prepared: Survey, held: Stationary, ends: list[DesignPoint]) -> Design:
    moving, values = prepared.moving, np.array(prepared.damper(held.variables.value))
    damper, pull = Bounded(values, np.zeros(3)), Bounded(np.zeros(3), np.zeros(3))
    damper.error[moving] = values[moving] * held.variables.error
    pull.value[moving], pull.error[moving] = held.bound_weight
    return Design(
        damper, held.level, held.peaks, held.weight, held.speed, pull, held.residual,
        held.curvature, *basins(prepared, held, ends),
    )  # fmt: skip


# ----------------------------------------------------------------------------
# What a tuning brings, and what errors of its parts cost.
# ----------------------------------------------------------------------------

_SHARE = 0.9
#: relative difference below which two heights count as one
_SAME_HEIGHT = 1e-9


class Performance(NamedTuple):
    """What one damper does over the range: largest readings (3,) and their speeds in rad/s.

    That is the worst weighted half range of the sections, the heat (W) and the travel (rad), each
    at its own worst speed; `section` is the worst one. Of several places of one height, as a
    tuning makes them, the first section at its lowest speed. `place` are these three peaks,
    `slope` (3, 3) what they change by the logarithms of J, k and c.
    """

    reading: Bounded
    speed: Bounded
    section: int
    slope: FloatArray
    place: DamperPeaks


def performance(
    problem: DamperProblem, damper: Damper, speeds: int = 161, tolerance: float = LEVEL
) -> Performance:
    """Worst readings of a given damper, a viscous one of stiffness 0; `tolerance` of `follow`."""
    inertia, stiffness, damping = (float(value) for value in damper)
    limits = Limits((inertia,) * 2, (stiffness,) * 2, (damping,) * 2)
    prepared = survey(problem, limits, speeds)
    sections = prepared.system.twist.shape[0]
    # heat and travel are read without a limit: what is near their highest counts
    scale, values = prepared.scale.copy(), (np.array([stiffness]), np.array([damping]))
    seen = map_readings(prepared.system, prepared.table(inertia), *values)[0].max(axis=0)
    scale[sections:] = np.maximum([seen[-3], *(2 * [np.max(seen[-2:])])], 1e-300)
    tops = prepared._replace(scale=scale).peaks(damper, _SHARE, tolerance)
    best = [
        first_of_the_highest(tops.row, tops.speed, np.where(rows, tops.value, -np.inf))
        for rows in (tops.row < sections, tops.row == sections, tops.row > sections)
    ]
    place = tops.some(np.array(best))
    error = reading_error(prepared.system, damper, place.speed, place.row, place.phase)
    return Performance(
        Bounded(place.value, error),
        Bounded(place.speed, place_error(prepared.system, damper, place)),
        int(place.row[0]),
        place.slope,
        place,
    )


def performance_of(problem: DamperProblem, tuned: Design, speeds: int = 161) -> Performance:
    """The same of the damper found, its own errors counted in all readings and their speeds.

    The worst section is flat to first order there, and has the error of the design.
    """
    achieved = performance(problem, tuned.values, speeds)
    share = relative_error(tuned)
    step = (problem.speed[1] - problem.speed[0]) / (speeds - 1)
    moved = np.abs(drift(system_of(problem), tuned.values, achieved.place, step)) @ share
    reading = achieved.reading + Bounded(np.zeros(3), np.abs(achieved.slope) @ share)
    reading = concatenate([tuned.worst[None], reading[1:]])
    return achieved._replace(reading=reading, speed=achieved.speed + Bounded(np.zeros(3), moved))


def relative_error(tuned: Design) -> FloatArray:
    """Errors (3,) of ring inertia, stiffness and damping over these; 0 of what is 0."""
    value, error = tuned.damper
    share: FloatArray = np.divide(error, value, where=value > 0.0, out=np.zeros(3))
    return share + EPSILON * (share > 0.0)


def first_of_the_highest(row: IntArray, speed: FloatArray, value: FloatArray) -> int:
    """Which of the largest `value` (p,) counts: of the lowest row, then of the lowest speed.

    Heights that agree to 1e-9 are equal, or the last bits would choose.
    """
    equal = np.flatnonzero(value >= float(np.max(value)) * (1.0 - _SAME_HEIGHT))
    return int(equal[np.lexsort((speed[equal], row[equal]))[0]])


class Mistuning(NamedTuple):
    """Factors `stiffness` (a,), `damping` (b,) on k and c, and `increase` (a, b): worst section
    over that of the tuning, 1 where nothing is lost."""

    stiffness: FloatArray
    damping: FloatArray
    increase: Bounded


def mistuning(problem: DamperProblem, tuned: Design, share: float = 0.1) -> Mistuning:
    """What spring and dashpot off by a share, each and together, do to the worst section."""
    factor = np.array([1.0 - share, 1.0, 1.0 + share])
    inertia, stiffness, damping = tuned.values
    by_stiffness = factor if stiffness > 0.0 else np.ones(1)
    increase = Bounded(np.ones((by_stiffness.size, 3)), np.zeros((by_stiffness.size, 3)))
    uncertainty = relative_error(tuned) + 2.0 * EPSILON
    for place in np.ndindex(increase.value.shape):
        a, b = float(by_stiffness[place[0]]), float(factor[place[1]])
        if a != 1.0 or b != 1.0:
            found = performance(problem, Damper(inertia, a * stiffness, b * damping))
            off = Bounded(np.zeros(()), np.abs(found.slope[0]) @ uncertainty)
            increase.value[place], increase.error[place] = (found.reading[0] + off) / tuned.worst
    return Mistuning(by_stiffness, factor, increase)


# ----------------------------------------------------------------------------
# How far a map that is read on a grid of speeds lies from the peaks between them.
# ----------------------------------------------------------------------------

#: what the worst of all places may have beyond the worst of those examined
_BEYOND = 2.0
#: of the value, for peaks that are compared with it
_SEEN = 1e-7


def chart_error(problem: DamperProblem, drawn: Chart) -> FloatArray:
    """Errors (3,) of worst section, heat and travel anywhere on the map of the first inertia.

    The peaks are followed at the corners, where rings are all but locked or free and resonances
    narrow, in the middle and where the map is highest; the largest difference there, twice.
    """
    maps = (drawn.worst[0], drawn.heat[0], drawn.travel[0])
    rows, columns = maps[0].shape
    places = {(i, j) for i in (0, rows - 1) for j in (0, columns - 1)}
    places |= {(rows // 2, columns // 2)}
    places |= {divmod(int(np.argmax(one)), columns) for one in maps}
    error = np.zeros(3)
    for i, j in sorted(places):
        damper = Damper(float(drawn.inertia[0]), float(drawn.stiffness[i]), float(drawn.damping[j]))
        try:
            achieved = performance(problem, damper, tolerance=_SEEN)
        except NumericalFailure:
            # a mode that this ring leaves undamped: no peak to compare with
            continue
        drawn_there = np.array([one[i, j] for one in maps])
        error = np.maximum(error, np.abs(achieved.reading.value - drawn_there))
    if not np.any(error):
        raise NumericalFailure("no place on the map of dampers has a peak to compare it with")
    return _BEYOND * error
