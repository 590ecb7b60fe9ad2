"""From a coarse map of springs and dashpots downhill on the worst section."""

from itertools import product
from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import FloatArray
from vibecalc.torsion.damper_design.peaks import LEVEL, DamperPeaks, Survey, survey
from vibecalc.torsion.damper_design.problem import DamperProblem, Limits
from vibecalc.torsion.damper_design.readings import map_largest

# ----------------------------------------------------------------------------
# A coarse map over ln k and ln c (and ln J), and where its valleys are.
# ----------------------------------------------------------------------------


class Chart(NamedTuple):
    """On axes `inertia` (j,), `stiffness` (k,), `damping` (c,): arrays (j, k, c).

    `worst` largest weighted half range on the grid of speeds and cycle samples, `heat` in W and
    `travel` in rad at their worst speeds: a picture, not the values of the design.
    """

    inertia: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    worst: FloatArray
    heat: FloatArray
    travel: FloatArray


def chart(problem: DamperProblem, limits: Limits, points: int = 41, speeds: int = 161) -> Chart:
    """Map of `points` values of each of J, k and c whose bounds differ."""
    return chart_of(survey(problem, limits, speeds), points)


def chart_of(prepared: Survey, points: int) -> Chart:
    """The same from a prepared survey."""
    axes = [
        np.geomspace(low, high, points) if high > low else np.array([low])
        for low, high in prepared.bounds
    ]
    inertia, stiffness, damping = axes
    k, c = (a.ravel() for a in np.meshgrid(stiffness, damping, indexing="ij"))
    shape = (inertia.size, stiffness.size, damping.size)
    worst, heat, travel = np.empty(shape), np.empty(shape), np.empty(shape)
    for index, value in enumerate(inertia):
        responses = prepared.table(float(value))
        values = map_largest(prepared.system, responses, k, c)
        worst[index], heat[index], travel[index] = (one.reshape(shape[1:]) for one in values.T)
    return Chart(inertia, stiffness, damping, worst, heat, travel)


def valleys(prepared: Survey, chart: Chart, most: int) -> FloatArray:
    """Variables (b, v) of all local minima of the map, lowest first, at most `most`.

    Outside the limits the excess counts in units of the largest value, so that the least violated
    place is a valley too.
    """
    limits = prepared.limits
    over = np.maximum(chart.heat / limits.heat, chart.travel / limits.travel) - 1.0
    level = chart.worst
    level = np.where(over > 0.0, np.max(level) * (1.0 + over), level)
    padded = np.pad(level, 1, constant_values=np.inf)
    shape = level.shape
    lowest = np.ones(shape, dtype=bool)
    for shift in product((0, 1, 2), repeat=3):
        part = tuple(slice(s, s + n) for s, n in zip(shift, shape, strict=True))
        lowest &= level <= padded[part]
    places = np.argwhere(lowest)
    places = places[np.argsort(level[lowest], kind="stable")][:most]
    axes = (chart.inertia, chart.stiffness, chart.damping)
    values = np.stack([axes[i][places[:, i]] for i in prepared.moving], axis=-1)
    return np.log(values)


# ----------------------------------------------------------------------------
# Downhill on the worst section by linear programs in a trust region.
#
# K. Madsen, An algorithm for minimax solution of overdetermined systems of non-linear equations,
# J. Inst. Maths Applics 16 (1975) 321: every peak is taken as linear in the variables, and the
# step is as long as that has proved true.
# ----------------------------------------------------------------------------

_MOST_STEPS = 40
_SHARE = 0.85
#: of the value, for peaks on the way
_TOLERANCE = 1e-7
_SMALL = 2e-3
#: weights of a violated limit over the worst section, the next where a limit stays broken
_PENALTIES = (5.0, 100.0, 1e4)
#: excess over a limit, over that limit, above which a place breaks it
BROKEN = 1e-4
_HALVINGS = 6
#: reach of the linear program that judges an end
_LEFT = 0.1


class DesignPoint(NamedTuple):
    """Variables (v,), their peaks, and merit: worst section and violated limits (with an infinite
    penalty the excess alone); `over` the worst excess over a limit, over that limit.
    """

    variables: FloatArray
    peaks: DamperPeaks
    merit: float
    over: float


def place(
    prepared: Survey, variables: FloatArray, penalty: float = _PENALTIES[0],
    share: float = _SHARE, tolerance: float = LEVEL,
) -> DesignPoint:  # fmt: skip
    """The peaks of one damper."""
    damper = prepared.damper(variables)
    tops = prepared.peaks(damper, share, tolerance)
    section, scale, worst = prepared.levels(tops)
    over = float(np.max((tops.value / scale)[~section], initial=1.0)) - 1.0
    merit = worst + penalty * worst * over if penalty < np.inf else over
    return DesignPoint(variables, tops, merit, over)


def descend(prepared: Survey, start: FloatArray) -> DesignPoint:
    """Search from logarithms (v,) until steps of a thousandth bring nothing."""
    bounds = prepared.logarithms
    end = np.clip(start, bounds[:, 0], bounds[:, 1])
    for penalty in _PENALTIES:
        found = _descend(prepared, end, penalty)
        if found.over <= BROKEN:
            break
        end = found.variables
    if found.over > BROKEN:
        # the excess alone, and the worst section again from a place that keeps the limits
        found = _descend(prepared, end, np.inf)
        if found.over <= BROKEN:
            found = _descend(prepared, found.variables, _PENALTIES[-1])
    return place(prepared, found.variables)


def lenient(prepared: Survey, most: int) -> list[DesignPoint]:
    """Corners of the bounds by their excess over a limit, at most `most`.

    Rings that are all but locked or free turn little into heat: the map over the middle of the
    bounds may show nothing of them.
    """
    found: list[DesignPoint] = []
    for corner in product(*prepared.logarithms):
        try:
            found.append(place(prepared, np.array(corner), tolerance=_TOLERANCE))
        except NumericalFailure:
            # a locked ring may leave a mode without damping
            continue
    return sorted(found, key=lambda one: (one.over, one.merit))[:most]


def _descend(prepared: Survey, start: FloatArray, penalty: float) -> DesignPoint:
    bounds = prepared.logarithms
    here = place(prepared, start, penalty, tolerance=_TOLERANCE)
    radius = 0.4
    for _ in range(_MOST_STEPS):
        step, foreseen = _linear_program(prepared, here, radius, penalty)
        if foreseen <= 1e-5 * abs(here.merit):
            break
        beyond = np.clip(here.variables + step, bounds[:, 0], bounds[:, 1])
        there = place(prepared, beyond, penalty, tolerance=_TOLERANCE)
        if here.merit - there.merit < 0.75 * foreseen:
            # along a curved edge the linear step leaves it: come back once before judging
            reach = 0.5 * float(np.max(np.abs(step)))
            back = there.variables + _linear_program(prepared, there, reach, penalty)[0]
            back = np.clip(back, bounds[:, 0], bounds[:, 1])
            there = min(
                there, place(prepared, back, penalty, tolerance=_TOLERANCE), key=lambda p: p.merit
            )
        gained = here.merit - there.merit
        if gained > 0.75 * foreseen:
            radius = min(2.0 * radius, 1.5)
        elif gained < 0.25 * foreseen:
            radius = 0.35 * min(radius, float(np.max(np.abs(step))))
        if gained > 0.0:
            here = there
        if radius < _SMALL:
            break
    return here


def _linear_program(
    prepared: Survey, here: DesignPoint, radius: float, penalty: float
) -> tuple[FloatArray, float]:
    """Best step (v,) within the radius if all were linear, and the merit it would gain."""
    from scipy.optimize import linprog

    tops, moving = here.peaks, prepared.moving
    section, scale, worst = prepared.levels(tops)
    slope = tops.slope[:, moving] / scale[:, None]
    level = tops.value / scale
    # unknowns: step, level of the sections, excess over limits
    rows = np.hstack([slope, -section[:, None].astype(float), -(~section[:, None]).astype(float)])
    right = np.where(section, 0.0, 1.0) - level
    only_excess = penalty == np.inf
    cost = np.append(np.zeros(moving.size), [0.0, 1.0] if only_excess else [1.0, penalty])
    bounds = prepared.logarithms - here.variables[:, None]
    box = [(max(low, -radius), min(high, radius)) for low, high in bounds]
    solution = linprog(cost, rows, right, bounds=[*box, (None, None), (0.0, None)], method="highs")
    if solution.x is None:
        return np.zeros(moving.size), 0.0
    step = np.asarray(solution.x[: moving.size])
    excess = max(0.0, float(np.max(level[~section], initial=1.0)) - 1.0)
    if only_excess:
        return step, excess - float(solution.fun)
    return step, worst * (1.0 + penalty * excess - float(solution.fun))


def nearest_within_limits(prepared: Survey, broken: DesignPoint, within: DesignPoint) -> FloatArray:
    """Variables (v,) between a place that breaks a limit and one that keeps it, which still do.

    Halving the straight way in logarithms: as near to the first as a few steps tell.
    """
    bad, good = broken.variables, within.variables
    for _ in range(_HALVINGS):
        middle = 0.5 * (bad + good)
        if place(prepared, middle, tolerance=_TOLERANCE).over <= 0.0:
            good = middle
        else:
            bad = middle
    return good


def foreseen(prepared: Survey, end: DesignPoint) -> tuple[FloatArray, float]:
    """Length (v,) of the step that a linear program would still take, and what it would gain.

    What is left of a broken limit counts as if it were the objective.
    """
    penalty = np.inf if end.over > BROKEN else _PENALTIES[0]
    step, gain = _linear_program(prepared, end, _LEFT, penalty)
    worst = prepared.levels(end.peaks)[2]
    return np.abs(step) + _SMALL, abs(gain) * (worst if penalty == np.inf else 1.0) + (
        end.over * worst
    )
