"""Mean power that the dashpots and loss factors of a shaft line turn into heat."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.numerics.rounding import EPSILON
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.torsion.line import Line


class Heat(NamedTuple):
    """Mean power in W at each frequency: `element` (..., e), `ground` (..., n), `error` of both.

    `dashpot` and `loss` are the parts of `element`; `ground` is of absolute damping. Powers of
    different orders add up to the total over the cycle. `error` (...) bounds each of them.
    """

    element: FloatArray
    dashpot: FloatArray
    loss: FloatArray
    ground: FloatArray
    error: FloatArray


def heat(line: Line, frequency: ArrayLike, angle: ArrayLike, error: ArrayLike = 0.0) -> Heat:
    """From angles (..., n), 0-to-peak, with absolute errors (...) at frequencies (...) in rad/s.

    A dashpot takes w^2 c |twist|^2 / 2, a loss factor w k eta |twist|^2 / 2.
    """
    w = np.asarray(frequency, dtype=float)[..., None]
    value, doubt = np.asarray(angle), np.asarray(error, dtype=float)[..., None]
    twist = np.abs(value[..., line.first] - value[..., line.second])
    size = np.abs(value)
    dashpot = 0.5 * w**2 * line.damping * twist**2
    loss = 0.5 * w * line.stiffness * line.loss_factor * twist**2
    ground = 0.5 * w**2 * line.absolute_damping * size**2
    element = dashpot + loss
    factor = 0.5 * w * (w * line.damping + line.stiffness * np.abs(line.loss_factor))
    wrong = factor * 2.0 * doubt * (2.0 * twist + 2.0 * doubt) + 8.0 * EPSILON * np.abs(element)
    of_ground = 0.5 * w**2 * line.absolute_damping * doubt * (2.0 * size + doubt)
    of_ground = of_ground + 8.0 * EPSILON * ground
    worst = np.maximum(np.max(wrong, axis=-1, initial=0.0), np.max(of_ground, axis=-1, initial=0.0))
    return Heat(element, dashpot, loss, ground, worst)
