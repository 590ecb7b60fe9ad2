"""Newton's method for the maxima of A / Q over u = x^2, each start let go once it has settled."""

from typing import NamedTuple

import numpy as np

from vibecalc.numerics.rounding import UNIT_ROUNDOFF
from vibecalc.response.absorber.coefficients import Coupling
from vibecalc.response.absorber.excess import excess
from vibecalc.response.absorber.measure import Measure

#: rounds at most; a well separated maximum settles in three to five
_ROUNDS = 12
#: longest step in ln u; of starts that may lead anywhere
_LONGEST, _FAR = 0.05, 0.2
#: a maximum farther than this from its start, in ln u, belongs to another one
REACH = 0.1
#: a start that has come so far will not end within reach
_ASTRAY = 0.14
#: maxima nearer than this, in ln u, are one
_SAME = 1e-8
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


class Tops(NamedTuple):
    """Maxima by row and rising u = x^2, all (k,).

    `value` A / Q with its error `doubt`, `square` |H|^2, and `blur`, how far ln u is off at most.
    """

    rows: np.ndarray
    u: np.ndarray
    value: np.ndarray
    doubt: np.ndarray
    square: np.ndarray
    blur: np.ndarray


def tops(
    parts: Coupling, weights: Measure, rows: np.ndarray, start: np.ndarray, far: bool = False
) -> tuple[Tops, np.ndarray]:
    """Maxima that Newton's method reaches from places `start` (k,) of rows (k,), and its looks.

    Those farther than `REACH` from their start are left out, unless `far`. Looks (k,) count
    evaluations of `slope`.
    """
    own, mine = _of_rows(parts, weights, rows)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        u, steps = polished(own, mine, start, far)
        first, second, value, doubt = slope(own, mine, u)
        # on a very sharp peak the last bit of u is felt
        short = 0.5 * np.square(first) / np.abs(second)
        last = 0.5 * np.abs(second) * (4.0 * UNIT_ROUNDOFF) ** 2
        doubt = doubt + short + last
        # what has not settled came from a pole without a peak of its own
        size = mine.floor_squared + value
        near = short < 1e-8 * size + 64.0 * last
        if not far:
            near &= np.abs(np.log(u / start)) < REACH
        blur = np.abs(first / second)
    keep = near & (second < 0.0) & np.isfinite(value)
    found = Tops(rows[keep], u[keep], value[keep], doubt[keep], size[keep], blur[keep])
    return each_once(found), steps + 1


def each_once(found: Tops) -> Tops:
    """By row and rising u; of what was found twice, the one that has settled better."""
    order = np.lexsort((found.u, found.rows))
    found = Tops(*(a[order] for a in found))
    while len(found.u) > 1:
        apart = np.diff(np.log(found.u))
        told = np.maximum(_SAME, 4.0 * (found.blur[1:] + found.blur[:-1]))
        twice = np.flatnonzero((found.rows[1:] == found.rows[:-1]) & (apart < told))
        if not len(twice):
            break
        # of each row of equal ones only the first pair, the others in the next round
        first = np.ones(len(twice), dtype=bool)
        first[1:] = np.diff(twice) > 1
        pair = twice[first]
        worse = np.where(found.blur[pair] > found.blur[pair + 1], pair, pair + 1)
        found = Tops(*(np.delete(a, worse) for a in found))
    return found


def _of_rows(parts: Coupling, weights: Measure, rows: np.ndarray) -> tuple[Coupling, Measure]:
    return Coupling(*(a[rows] for a in parts)), Measure(*(a[rows] for a in weights))


def polished(
    parts: Coupling, weights: Measure, start: np.ndarray, far: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Places u (k,) that Newton's method reaches from `start` (k,), and the steps it took (k,).

    `parts` and `weights` (k,). Each start ends by itself, so that its last bit does not depend on
    the others: where the next step, with steps that square, would be below rounding, where small
    steps no longer shrink, or well beyond `REACH`. Whether that is a maximum is for the caller to
    see. With `far` no place is out of reach, and every step goes uphill.
    """
    longest = _FAR if far else _LONGEST
    u, steps = start.copy(), np.zeros(len(start), dtype=int)
    live, before = np.arange(len(start)), np.full(len(start), np.inf)
    for _ in range(_ROUNDS):
        if not len(live):
            break
        own, mine = _of_rows(parts, weights, live)
        at = slope(own, mine, u[live])
        # the reciprocal of a resonance is nearly a parabola
        size = mine.floor_squared + at.value
        bend = at.second - 2.0 * at.first * at.first / size
        step = at.first / (-np.abs(bend) if far else bend)
        step = np.where(np.isfinite(step), np.clip(step, -longest, longest), 0.0)
        u[live] = u[live] * np.exp(-step)
        steps[live] += 1
        step = np.abs(step)
        squaring = step * np.square(step / before) <= 0.125 * UNIT_ROUNDOFF
        stuck = (step > 0.25 * before) | (step <= UNIT_ROUNDOFF)
        settled = (step <= _FINE) & (squaring | stuck)
        going = ~settled
        if not far:
            going &= np.abs(np.log(u[live] / start[live])) <= _ASTRAY
        live, before = live[going], step[going]
    return u, steps
