"""The order that a pendulum keeps while it swings far: its exact period at a constant rotor speed.

The equation of the swing has the first integral C p'^2 = W^2 (A(p) - A(P)), P the largest angle.
With p = P sin u the period is

    4 / W * integral from 0 to pi/2 of sqrt(C / D) du,    D = (A(p) - A(P)) / (P^2 - p^2),

whose integrand is periodic and smooth, so that the midpoint rule converges geometrically. D is a
mean of -A'(x) / 2 x over x^2 between p^2 and P^2, which a Gauss rule takes without cancellation.
For a circle the period is 4 K(sin(P/2)) / (n W), K the complete elliptic integral, and
n(P) = n AGM(1, cos(P/2)) with Gauss's arithmetic-geometric mean, whose steps square the error.
"""

import numpy as np
from numpy.typing import ArrayLike

from vibecalc.errors import NumericalFailure
from vibecalc.numerics.gauss import gauss_rule
from vibecalc.numerics.rounding import UNIT_ROUNDOFF, WithError
from vibecalc.numerics.typing import FloatArray
from vibecalc.response.pendulum.model import Pendulum, terms
from vibecalc.response.pendulum.order import largest_swing, tuning_order

_INNER = 20
_FIRST, _MOST = 16, 4096

#: relative change from half the points at which doubling them ends
_SETTLED = 1e-13

#: below this angle the order is that of small swings to rounding, and A'(p) / p is taken here
_SMALL = 1e-7

#: so near (rad) to half a turn a mass on a circle all but stands still at the ends of its swing
_STANDS = 2e-5

#: relative difference of two numbers whose mean is the arithmetic-geometric one to rounding
_ALIKE = 1e-8

_TOO_NEAR = (
    "the period of a swing of {:.9g} rad is not found: it is too near to the end of the path"
)


def order_of_swing(pendulum: Pendulum, swing: ArrayLike) -> WithError:
    """n(P): frequency over rotor speed of free swings between -P and P (rad). Broadcasts.

    Raises NumericalFailure for swings that leave the path (its cusp, or half a turn of a circle),
    and where the swing is so near to that that the period is not found.
    """
    far = np.abs(np.asarray(swing, dtype=float))
    if np.any(far >= largest_swing(pendulum)):
        raise NumericalFailure(
            f"a swing of {float(np.max(far)):.6g} rad leaves the path, which ends at "
            f"{float(np.min(largest_swing(pendulum))):.6g} rad"
        )
    small = tuning_order(pendulum)
    if np.all(np.asarray(pendulum.path_exponent) == 0.0):
        if np.all(far <= np.pi - _STANDS):
            return _on_circle(small, far)
        raise NumericalFailure(_TOO_NEAR.format(float(np.max(far))))
    largest = np.maximum(far, _SMALL)
    points, before = _FIRST, _mean(pendulum, largest, _FIRST)
    while points < _MOST:
        points *= 2
        after = _mean(pendulum, largest, points)
        change = np.abs(after - before) / after
        if np.all(change <= _SETTLED):
            value = 1.0 / after
            error = value * (change + 40.0 * UNIT_ROUNDOFF) + small.error
            return WithError(value, error)
        before = after
    raise NumericalFailure(_TOO_NEAR.format(float(np.max(far))))


def _on_circle(small: WithError, swing: FloatArray) -> WithError:
    """n AGM(1, cos(P/2)).

    The mean grows by a smaller share than cos(P/2) does, so that roundings of P/2 and of the cosine
    come through with (P/2) tan(P/2) at most. Each step adds two roundings.
    """
    mean, root = np.ones_like(swing), np.cos(0.5 * swing)
    lost = 0.5 * swing * np.tan(0.5 * swing) * UNIT_ROUNDOFF
    steps = np.zeros_like(swing)
    # each swing ends by itself, so that its last bit does not depend on the others
    while np.any(apart := mean - root > _ALIKE * mean):
        between, product = 0.5 * (mean + root), np.sqrt(mean * root)
        mean, root = np.where(apart, between, mean), np.where(apart, product, root)
        steps = steps + apart
    # numbers so much alike are joined by one step more
    mean = 0.5 * (mean + root)
    value = small.value * mean
    error = value * (lost + (2.0 * steps + 4.0) * UNIT_ROUNDOFF) + small.error * mean
    return WithError(value, error)


def _mean(pendulum: Pendulum, largest: FloatArray, points: int) -> FloatArray:
    """Mean of sqrt(C / D) over the quarter swing: 1 / n(P)."""
    rule = gauss_rule(_INNER)
    around = (np.arange(points) + 0.5) * (0.5 * np.pi / points)
    outer = Pendulum(*(np.asarray(value, dtype=float)[..., None] for value in pendulum))
    inner = Pendulum(*(np.asarray(value)[..., None] for value in outer))
    top = largest[..., None]
    angle = top * np.sin(around)
    lost = np.square(top * np.cos(around))
    place = np.sqrt(np.square(angle)[..., None] + lost[..., None] * rule.nodes)
    fall = -terms(inner, place).carried_slope / (2.0 * place)
    share = fall @ rule.weights
    if np.any(share <= 0.0):
        raise NumericalFailure("the pendulum is not driven back on the whole of its swing")
    return np.asarray(np.mean(np.sqrt(terms(outer, angle).swing / share), axis=-1))
