"""What a tuning brings, and what errors of its parts cost."""

from typing import NamedTuple

import numpy as np

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.design import Design
from vibecalc.optimisation.damper.problem import Damper, Limits, Problem
from vibecalc.optimisation.damper.readings import reading_error
from vibecalc.optimisation.damper.survey import survey

_SHARE = 0.9


class Performance(NamedTuple):
    """What one damper does over the range: `worst` weighted half range of the sections, the
    section and the speed (rad/s) where it is reached; `heat` (W) and `travel` (rad) at their own
    worst speeds; absolute errors."""

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
        int(np.argmax(np.where(rows, seen.value, -np.inf)))
        for rows in (seen.row < sections, seen.row == sections, seen.row > sections)
    ]
    error = reading_error(prepared.system, damper, seen.speed, seen.row)[best]
    value, speed = seen.value[best], seen.speed[best]
    return Performance(
        float(value[0]), float(error[0]), int(seen.row[best[0]]), float(speed[0]),
        float(value[1]), float(error[1]), float(speed[1]),
        float(value[2]), float(error[2]), float(speed[2]),
    )  # fmt: skip


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
    for i, a in enumerate(own):
        for j, b in enumerate(factor):
            if a != 1.0 or b != 1.0:
                inertia, stiffness, damping = tuned.damper
                rise[i, j], error[i, j] = gain(
                    problem, tuned, Damper(inertia, a * stiffness, b * damping)
                )
    return Mistuning(own, factor, rise, error)
