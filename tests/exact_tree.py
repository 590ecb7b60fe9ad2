"""A primary system with any tree of absorbers in many digits: polynomials, peaks, best tunings.

Nothing is taken from the package. A response is a quotient of polynomials in s, peaks are all roots
of the stationarity polynomial of its square, and a tuning is polished by Newton's method on the
conditions that hold it: active peaks stationary and equal, their weighted slopes zero. Derivatives
are differences with a third of the digits.
"""

import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

from mpmath import mp, mpc, mpf

Poly = list[Any]
#: response: power of s, factors 1 + 2 z1 s, for a force; base motion has one factor more
RESPONSES = {
    "displacement": (0, 0), "velocity": (1, 0), "acceleration": (2, 0), "transmitted_force": (0, 1),
    "relative_displacement": (0, 0),
}  # fmt: skip


class Tree(NamedTuple):
    """Ratios to the primary (mpf); parents as numbers, 0 the primary. k = infinity: locked."""

    z1: mpf
    m: tuple[mpf, ...]
    k: tuple[mpf, ...]
    z2: tuple[mpf, ...]
    parent: tuple[int, ...]


def tree(z1: Any, m: Any, k: Any, z2: Any, parent: Sequence[int] = (0,)) -> Tree:
    """From floats, as stored."""
    wide = [tuple(mpf(float(x)) for x in row) for row in (m, k, z2)]
    return Tree(mpf(float(z1)), *wide, tuple(parent))


def times(one: Poly, other: Poly) -> Poly:
    """Product of polynomials, lowest power first."""
    found = [mpf(0)] * (len(one) + len(other) - 1)
    for i, a in enumerate(one):
        if a != 0:
            for j, b in enumerate(other):
                found[i + j] += a * b
    return found


def plus(one: Poly, other: Poly) -> Poly:
    """Sum of polynomials."""
    size = max(len(one), len(other))
    return [
        (one[i] if i < len(one) else mpf(0)) + (other[i] if i < len(other) else mpf(0))
        for i in range(size)
    ]


def response(system: Tree, excitation: str, what: str) -> tuple[Poly, Poly]:
    """N and D in s of H, without its sign, powers of s taken out of both."""
    top, bottom = _carried(system, 0)
    siblings: Poly = [mpf(1)]
    for place in range(2, len(system.m) + 1):
        if system.parent[place - 1] == 0:
            siblings = times(siblings, _down(system, place))
    ground = [mpf(1), 2 * system.z1]
    below = plus(times(ground, bottom), times([mpf(0), mpf(0), mpf(1)], top))
    power, factors = RESPONSES[what]
    if excitation == "base" and what == "transmitted_force":
        above, power, factors = top, 2, 1
    elif what == "relative_displacement":
        above, factors = times(_top(system, 1), siblings), factors + (excitation == "base")
    else:
        above, factors = bottom, factors + (excitation == "base")
    power += 2 * (excitation == "unbalance")
    above = times([mpf(0)] * power + [mpf(1)], above)
    for _ in range(factors):
        above = times(above, ground)
    above, below = _trimmed(above), _trimmed(below)
    while len(above) > 1 and above[0] == 0 and below[0] == 0:
        above, below = above[1:], below[1:]
    return above, below


def _carried(system: Tree, place: int) -> tuple[Poly, Poly]:
    """Mass that the primary (0) or an absorber is with what hangs on it, as a quotient."""
    top, bottom = [system.m[place - 1] if place else mpf(1)], [mpf(1)]
    for child in range(place + 1, len(system.m) + 1):
        if system.parent[child - 1] == place:
            own, under = _carried(system, child)
            k, z = system.k[child - 1], system.z2[child - 1]
            up = own if mp.isinf(k) else times([k, 2 * z], own)
            down = under if mp.isinf(k) else _down(system, child)
            top, bottom = plus(times(top, down), times(up, bottom)), times(bottom, down)
    return top, bottom


def _down(system: Tree, place: int) -> Poly:
    """K B + s^2 A of an absorber whose carried mass is A / B."""
    top, bottom = _carried(system, place)
    k, z = system.k[place - 1], system.z2[place - 1]
    if mp.isinf(k):
        return bottom
    return plus(times([k, 2 * z], bottom), times([mpf(0), mpf(0), mpf(1)], top))


def _top(system: Tree, place: int) -> Poly:
    if mp.isinf(system.k[place - 1]):
        return [mpf(0)]
    return times([mpf(0), mpf(0), mpf(1)], _carried(system, place)[0])


def _trimmed(poly: Poly) -> Poly:
    size = max(abs(c) for c in poly)
    found = list(poly)
    while len(found) > 1 and abs(found[-1]) <= size * mpf(10) ** (5 - mp.dps):
        found.pop()
    return found


def value_at(poly: Poly, s: Any) -> Any:
    """Value of a polynomial."""
    found = mpf(0)
    for c in reversed(poly):
        found = found * s + c
    return found


def squared(poly: Poly) -> Poly:
    """|p(ix)|^2 as a polynomial in u = x^2."""
    even = [c * (-1) ** n for n, c in enumerate(poly[0::2])]
    odd = [c * (-1) ** n for n, c in enumerate(poly[1::2])]
    return plus(times(even, even), times([mpf(0), mpf(1)], times(odd, odd) if odd else [mpf(0)]))


class Peaks(NamedTuple):
    """Finite maxima by rising frequency, the supremum and where it is."""

    frequency: list[mpf]
    magnitude: list[mpf]
    largest: mpf
    where: mpf


def peaks(system: Tree, excitation: str, what: str) -> Peaks:
    """All maxima of |H|; infinite resonances of undamped systems count at their frequency."""
    above, below = response(system, excitation, what)
    if all(c == 0 for c in above):
        return Peaks([], [], mpf(0), mpf(0))
    p, q = _trimmed(squared(above)), _trimmed(squared(below))
    found: list[tuple[mpf, mpf]] = []
    for u in _positive_roots(_slope(p, q)):
        bottom, size = value_at(q, u), value_at([abs(c) for c in q], u)
        if bottom <= size * mpf(10) ** (-mp.dps * 0.45):
            found.append((mp.sqrt(u), mp.inf))
        elif _bends_down(p, q, u):
            found.append((mp.sqrt(u), mp.sqrt(value_at(p, u) / bottom)))
    found.sort()
    ends = [(mpf(0), mp.sqrt(p[0] / q[0]) if q[0] != 0 else mp.inf)]
    if len(p) >= len(q):
        limit = mp.sqrt(p[-1] / q[-1]) if len(p) == len(q) else mp.inf
        ends.append((mp.inf, limit))
    every = sorted([*ends, *found])
    top = max(height for _, height in every)
    # of places of one height the lowest
    where = next(x for x, height in every if height >= top * (1 - mpf(10) ** -12))
    return Peaks([x for x, _ in found], [h for _, h in found], top, where)


def _slope(p: Poly, q: Poly) -> Poly:
    def rate(poly: Poly) -> Poly:
        return [n * c for n, c in enumerate(poly)][1:] or [mpf(0)]

    one, other = times(rate(p), q), times(p, rate(q))
    scale = max(abs(c) for c in one + other)
    both = plus(one, [-c for c in other])
    while len(both) > 1 and abs(both[-1]) <= scale * mpf(10) ** (8 - mp.dps):
        both.pop()
    while len(both) > 1 and abs(both[0]) <= scale * mpf(10) ** (8 - mp.dps):
        both = both[1:]
    return both


def roots_of(poly: Poly) -> list[Any]:
    """All roots of a polynomial, lowest power first."""
    with warnings.catch_warnings():
        # the order of coefficients that is reported has no keyword in older versions
        warnings.simplefilter("ignore", DeprecationWarning)
        return list(mp.polyroots(poly[::-1], maxsteps=400, extraprec=2 * mp.prec))


def _positive_roots(poly: Poly) -> list[mpf]:
    if len(poly) < 2:
        return []
    roots = roots_of(poly)
    small = mpf(10) ** (-mp.dps * 0.4)
    real = sorted(r.real for r in map(mpc, roots) if abs(r.imag) <= small * abs(r) and r.real > 0)
    once: list[mpf] = []
    for root in real:
        if not once or root - once[-1] > small * root:
            once.append(root)
    return once


def _bends_down(p: Poly, q: Poly, u: mpf) -> bool:
    step = mpf(10) ** (-mp.dps // 5)
    at = value_at(p, u) / value_at(q, u)
    nearby = [value_at(p, v) / value_at(q, v) for v in (u * (1 - step), u * (1 + step))]
    return all(b < at for b in nearby)


def optimum(
    pair: tuple[str, str], z1: float, m: float, near: Sequence[float],
    frequency: Sequence[float], weight: Sequence[float], floor: Any = 0,
) -> tuple[Any, Any, Any]:  # fmt: skip
    """k, z2 and the level above the floor of one absorber, two peaks against each other.

    Newton's method on its conditions: both peaks stationary and equal, the weighted slopes of their
    heights by ln k and ln z2 zero. Raises ValueError where it does not settle.
    """
    bare = tree(z1, [m], [1.0], [1.0])
    step = mpf(10) ** (-mp.dps // 4)

    def height(y: Any, a: Any, b: Any) -> Any:
        """ln |H|^2 at ln u, ln k and ln z2."""
        above, below = response(bare._replace(k=(mp.exp(a),), z2=(mp.exp(b),)), *pair)
        u = mp.exp(y)
        return mp.log(value_at(squared(above), u) / value_at(squared(below), u))

    def slope(place: int, *at: Any) -> Any:
        ends = [[*at[:place], at[place] + sign * step, *at[place + 1 :]] for sign in (1, -1)]
        return (height(*ends[0]) - height(*ends[1])) / (2 * step)

    def conditions(a: Any, b: Any, low: Any, high: Any, w: Any) -> list[Any]:
        one, other = (low, a, b), (high, a, b)
        return [
            slope(0, *one), slope(0, *other), height(*one) - height(*other),
            *(w * slope(n, *one) + (1 - w) * slope(n, *other) for n in (1, 2)),
        ]  # fmt: skip

    places = [2 * mp.log(mpf(float(x))) for x in frequency]
    start = [*(mp.log(mpf(float(x))) for x in near), *places, mpf(float(weight[0]))]
    a, b, low, _, w = mp.findroot(conditions, start, tol=mpf(10) ** (-0.6 * mp.dps))
    assert 0 < w < 1
    return mp.exp(a), mp.exp(b), mp.exp(height(low, a, b) / 2) - floor
