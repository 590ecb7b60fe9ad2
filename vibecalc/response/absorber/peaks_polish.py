"""Newton's method for the maxima of A / Q over u = x^2, each start let go once it has settled."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.absorber.coefficients import Coupling
from vibecalc.response.absorber.excess import excess
from vibecalc.response.absorber.measure import Measure

#: rounds at most; a well separated maximum settles in three to five
_ROUNDS = 12
#: longest step in ln u
_LONGEST = 0.05
#: a maximum farther than this from its start, in ln u, belongs to another one
REACH = 0.1
#: a start that has come so far will not end within reach
_ASTRAY = 0.14
#: steps below this that no longer shrink are those of rounding
_FINE = 1e-9


class Slope(NamedTuple):
    """First and second derivative of A / Q by ln u, A / Q itself and its error, each (k,)."""

    first: np.ndarray
    second: np.ndarray
    value: np.ndarray
    doubt: np.ndarray


def slope(parts: Coupling, weights: Measure, u: np.ndarray) -> Slope:
    """Derivatives by ln u, free of the cancellation that the polynomials suffer."""
    found = excess(parts, weights, u)
    a, q = found.above, found.below
    value = a[0] / q[0]
    first = (a[1] - value * q[1]) / q[0]
    second = (a[2] - 2.0 * first * q[1] - value * q[2]) / q[0]
    doubt = 8.0 * UNIT_ROUNDOFF * (found.above_size + np.abs(value) * found.below_size) / q[0]
    return Slope(u * first, u * first + u * u * second, value, doubt)


def polished(parts: Coupling, weights: Measure, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places u (k,) that Newton's method reaches from `start` (k,), and the steps it took (k,).

    `parts` and `weights` (k,). Each start ends by itself, so that its last bit does not depend on
    the others: where the next step, with steps that square, would be below rounding, where small
    steps no longer shrink, or well beyond `REACH`. Whether that is a maximum is for the caller to
    see.
    """
    u, steps = start.copy(), np.zeros(len(start), dtype=int)
    live, before = np.arange(len(start)), np.full(len(start), np.inf)
    for _ in range(_ROUNDS):
        if not len(live):
            break
        own = Coupling(*(a[live] for a in parts))
        mine = Measure(*(a[live] for a in weights))
        at = slope(own, mine, u[live])
        # the reciprocal of a resonance is nearly a parabola
        size = mine.floor_squared + at.value
        step = at.first / (at.second - 2.0 * at.first * at.first / size)
        step = np.where(np.isfinite(step), np.clip(step, -_LONGEST, _LONGEST), 0.0)
        u[live] = u[live] * np.exp(-step)
        steps[live] += 1
        step = np.abs(step)
        squaring = step * np.square(step / before) <= 0.125 * UNIT_ROUNDOFF
        stuck = (step > 0.25 * before) | (step <= UNIT_ROUNDOFF)
        settled = (step <= _FINE) & (squaring | stuck)
        gone = np.abs(np.log(u[live] / start[live])) > _ASTRAY
        going = ~(settled | gone)
        live, before = live[going], step[going]
    return u, steps
