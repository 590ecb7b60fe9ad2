"""One step of the embedded pair of order 5 and 4 with its dense output, for many members at once.

The pair is that of Dormand and Prince (1980); the polynomial between the ends of a step, of fourth
degree and a local error of fifth order, is that of Shampine (1986). `runge_kutta_march` repeats
the step with a length of its own for each member.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibecalc.numerics.typing import FloatArray

#: order of the solution that is carried on; its error estimate shrinks like the length to this
ORDER = 5

FRACTION = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_STAGE = tuple(
    np.array(row)
    for row in (
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
        (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    )
)
# fifth order less fourth, over the seven rates
_ERROR = np.array((71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40))
# at the fraction s of a step of length h: y + h sum_j s^(j+1) (row j of this) @ rates
_DENSE = np.array(
    (
        (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (
            -8048581381 / 2820520608,
            0.0,
            131558114200 / 32700410799,
            -1754552775 / 470086768,
            127303824393 / 49829197408,
            -282668133 / 205662961,
            40617522 / 29380423,
        ),
        (
            8663915743 / 2820520608,
            0.0,
            -68118460800 / 10900136933,
            14199869525 / 1410260304,
            -318862633887 / 49829197408,
            2019193451 / 616988883,
            -110615467 / 29380423,
        ),
        (
            -12715105075 / 11282082432,
            0.0,
            87487479700 / 32700410799,
            -10690763975 / 1880347072,
            701980252875 / 199316789632,
            -1453857185 / 822651844,
            69997945 / 29380423,
        ),
    )
)

#: rates (b, n) of the states (b, n) at the times (b,)
Rates = Callable[[FloatArray, FloatArray], FloatArray]


class Step(NamedTuple):
    """State and rate (b, n) at the end of a step, the error (b, n) of the step, and between.

    `dense` (4, b, n): the state at the fraction s is start + sum_j dense[j] s^(j + 1).
    """

    state: FloatArray
    rate: FloatArray
    error: FloatArray
    dense: FloatArray


def step(
    rates: Rates, time: FloatArray, state: FloatArray, rate: FloatArray, length: FloatArray
) -> Step:
    """Take one step of `length` (b,) from `state` (b, n), whose rate is `rate`, at `time` (b,)."""
    shape = state.shape
    slopes = np.empty((7, *shape))
    slopes[0] = rate
    flat = slopes.reshape(7, -1)
    long = length[:, None]
    for number, row in enumerate(_STAGE, start=1):
        state_there = state + long * (row @ flat[:number]).reshape(shape)
        slopes[number] = rates(time + FRACTION[number] * length, state_there)
    error = long * (_ERROR @ flat).reshape(shape)
    dense = long * (_DENSE @ flat).reshape(4, *shape)
    return Step(state_there, slopes[6], error, dense)


def at_fraction(start: FloatArray, dense: FloatArray, fraction: FloatArray) -> FloatArray:
    """States (b, m, n) at the fractions (b, m) or (m,) of steps from `start` (b, n)."""
    s = fraction[..., None]
    a, b, c, d = dense[:, :, None, :]
    return np.asarray(start[:, None, :] + s * (a + s * (b + s * (c + s * d))))
