"""What a tuning brings, and what errors of its parts cost."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray, IntArray
from vibecalc.optimisation.damper.design import Design
from vibecalc.optimisation.damper.follow import Summits
from vibecalc.optimisation.damper.problem import Damper, Limits, Problem
from vibecalc.optimisation.damper.readings import reading_error
from vibecalc.optimisation.damper.relative import system_of
from vibecalc.optimisation.damper.summit_place import drift, place_error
from vibecalc.optimisation.damper.survey import survey

_SHARE = 0.9
#: relative difference below which two heights count as one
_SAME_HEIGHT = 1e-9


class Performance(NamedTuple):
    """What one damper does over the range: `worst` weighted half range of the sections, the
    section and the speed (rad/s) where it is reached; `heat` (W) and `travel` (rad) at their own
    worst speeds; absolute errors. Of several places of one height, as a tuning makes them, the
    first section at its lowest speed. `place` are these three summits, `slope` (3, 3) what they
    change by the logarithms of J, k and c, `speed_error` (3,) is of their speeds."""

    worst: float
    worst_error: float
    section: int
    speed: float
    heat: float
    heat_error: float
    heat_speed: float
    travel: float
    travel_error: float
    travel_speed: float
    slope: FloatArray
    speed_error: FloatArray
    place: Summits


def performance(problem: Problem, damper: Damper, speeds: int = 161) -> Performance:
    """Worst readings of a given damper; stiffness 0 is a viscous one."""
    inertia, stiffness, damping = (float(value) for value in damper)
    limits = Limits((inertia,) * 2, (stiffness,) * 2, (damping,) * 2)
    prepared = survey(problem, limits, speeds)
    sections = prepared.system.twist.shape[0]
    # heat and travel are read without a limit: with a scale below anything they always count
    scale = prepared.scale.copy()
    scale[sections:] = 1e-300
    seen = prepared._replace(scale=scale).summits(damper, _SHARE)
    best = [
        first_of_the_highest(seen.row, seen.speed, np.where(rows, seen.value, -np.inf))
        for rows in (seen.row < sections, seen.row == sections, seen.row > sections)
    ]
    error = reading_error(prepared.system, damper, seen.speed, seen.row)[best]
    value, speed = seen.value[best], seen.speed[best]
    return Performance(
        float(value[0]), float(error[0]), int(seen.row[best[0]]), float(speed[0]),
        float(value[1]), float(error[1]), float(speed[1]),
        float(value[2]), float(error[2]), float(speed[2]), seen.slope[best],
        place_error(prepared.system, damper, seen.some(np.array(best))), seen.some(np.array(best)),
    )  # fmt: skip


def performance_of(problem: Problem, tuned: Design, speeds: int = 161) -> Performance:
    """The same of the damper found, its own errors counted in heat, travel and their speeds.

    `worst` is flat to first order there; that of the design has its own error.
    """
    seen = performance(problem, tuned.damper, speeds)
    share = relative_error(tuned)
    grown = np.abs(seen.slope) @ share
    step = (problem.speed[1] - problem.speed[0]) / (speeds - 1)
    moved = np.abs(drift(system_of(problem), tuned.damper, seen.place, step)) @ share
    return seen._replace(
        heat_error=seen.heat_error + float(grown[1]),
        travel_error=seen.travel_error + float(grown[2]),
        speed_error=seen.speed_error + moved,
    )


def relative_error(tuned: Design) -> FloatArray:
    """Errors (3,) of ring inertia, stiffness and damping over these; 0 of what is 0."""
    values = np.array(tuned.damper)
    share: FloatArray = np.divide(tuned.damper_error, values, where=values > 0.0, out=np.zeros(3))
    return share + EPSILON * (share > 0.0)


def first_of_the_highest(row: IntArray, speed: FloatArray, value: FloatArray) -> int:
    """Which of the largest `value` (p,) counts: of the lowest row, then of the lowest speed.

    Heights that agree to 1e-9 are equal, or the last bits would choose.
    """
    equal = np.flatnonzero(value >= float(np.max(value)) * (1.0 - _SAME_HEIGHT))
    return int(equal[np.lexsort((speed[equal], row[equal]))[0]])


def gain(problem: Problem, tuned: Design, other: Damper) -> tuple[float, float]:
    """Worst section of another damper over that of the design, and the error of the quotient."""
    seen = performance(problem, other)
    ratio = seen.worst / tuned.worst
    return ratio, ratio * (seen.worst_error / seen.worst + tuned.worst_error / tuned.worst)


class Mistuning(NamedTuple):
    """Factors `stiffness` (a,), `damping` (b,) on k and c, and `rise` (a, b): worst section over
    that of the tuning, 1 where nothing is lost; absolute `rise_error`."""

    stiffness: FloatArray
    damping: FloatArray
    rise: FloatArray
    rise_error: FloatArray


def mistuning(problem: Problem, tuned: Design, share: float = 0.1) -> Mistuning:
    """What spring and dashpot off by a share, each and together, do to the worst section."""
    if not 0.0 < share < 1.0:
        raise NumericalFailure("an error of spring and dashpot is a share between 0 and 1")
    factor = np.array([1.0 - share, 1.0, 1.0 + share])
    own = factor if tuned.damper.stiffness > 0.0 else np.ones(1)
    rise, error = np.ones((own.size, 3)), np.zeros((own.size, 3))
    doubt = relative_error(tuned) + 2.0 * EPSILON
    for i, a in enumerate(own):
        for j, b in enumerate(factor):
            if a != 1.0 or b != 1.0:
                inertia, stiffness, damping = tuned.damper
                seen = performance(problem, Damper(inertia, a * stiffness, b * damping))
                rise[i, j] = seen.worst / tuned.worst
                off = seen.worst_error + float(np.abs(seen.slope[0]) @ doubt)
                error[i, j] = off / tuned.worst + rise[i, j] * tuned.worst_error / tuned.worst
    return Mistuning(own, factor, rise, error)
