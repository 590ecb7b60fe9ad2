"""How well the speed of a summit is known, though the summit itself is flat."""

import numpy as np

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.optimisation.damper.follow import Summits, about, follow
from vibecalc.optimisation.damper.problem import Damper
from vibecalc.optimisation.damper.readings import reading_error, readings
from vibecalc.optimisation.damper.relative import System

#: change of a logarithm over which the drift of summits is looked at
_MOVED = 1e-4


def place_error(system: System, damper: Damper, seen: Summits) -> FloatArray:
    """Error (p,) of the speeds of summits of this damper, in rad/s.

    The slope that is left over the curvature, and the round-off of the slope: that of the value
    over the width of the summit. At an end of the range the speed is that end.
    """
    left = readings(system, damper, seen.speed, seen.row, seen.phase).by_speed
    noise = reading_error(system, damper, seen.speed, seen.row)
    bend = np.abs(seen.bend)
    inside = (seen.bend < 0.0) & (seen.value > 0.0)
    safe = np.where(inside, bend, 1.0)
    own = np.abs(left) / safe + noise / np.sqrt(np.where(inside, seen.value, 1.0) * safe)
    error: FloatArray = np.where(inside, own, 0.0) + 2.0 * EPSILON * seen.speed
    return error


def drift(system: System, damper: Damper, seen: Summits, step: float) -> FloatArray:
    """What the speeds of summits move (p, 3) by the logarithms of J, k and c, in rad/s.

    `step` is that of the grid of speeds on which they were found.
    """
    low, high = about(seen, system.problem.speed, step)
    moved = np.zeros((seen.row.size, 3))
    for column in range(3):
        pair = []
        for side in (_MOVED, -_MOVED):
            factor = np.ones(3)
            factor[column] += side
            beside = Damper(*(float(value) for value in factor * np.array(damper)))
            pair.append(follow(system, beside, seen.row, low, high, near=seen.phase).speed)
        moved[:, column] = (pair[0] - pair[1]) / (2.0 * _MOVED)
    return moved
