"""A primary system with any tree of absorbers in many digits: polynomials, peaks, best tunings.

Nothing is taken from the package. A response is a quotient of polynomials in s, peaks are all roots
of the stationarity polynomial of its square, and a tuning is polished by Newton's method on the
conditions that hold it: active peaks stationary and equal, their weighted slopes zero. Derivatives
are differences with a third of the digits.
"""

import warnings
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from mpmath import matrix, mp, mpc, mpf

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


class Held(NamedTuple):
    """A tuning and what holds it: unknown ratios, places ln u and weights of its active peaks."""

    ratios: list[mpf]
    places: list[mpf]
    weights: list[mpf]
    level: mpf


def polished(
    build: Callable[[list[Any]], Tree], pair: tuple[str, str], ratios: Sequence[float],
    frequencies: Sequence[float], weights: Sequence[float],
) -> Held:  # fmt: skip
    """Newton's method on ln |H|^2: peaks stationary and equal, weighted slopes by ln ratio zero.

    `build` makes a tree of the ratios. Raises ArithmeticError where Newton does not settle.
    """
    free, count = len(ratios), len(frequencies)
    logs = [mp.log(mpf(float(r))) for r in ratios]
    places = [2 * mp.log(mpf(float(x))) for x in frequencies]
    shares = [mpf(float(w)) for w in weights]
    level = mpf(0)

    def seen(y: Any, at: list[Any]) -> Any:
        above, below = response(build([mp.exp(a) for a in at]), *pair)
        u = mp.exp(y)
        return mp.log(value_at(squared(above), u) / value_at(squared(below), u))

    step = mpf(10) ** (-mp.dps // 4)
    for _ in range(12):
        size = free + 2 * count + 1
        table, right = matrix(size, size), matrix(size, 1)
        values = [_taylor(seen, places[i], logs, step) for i in range(count)]
        if _ == 0:
            level = sum(v[0] for v in values) / count
        for i, (value, first, second) in enumerate(values):
            right[i], right[count + i] = first[0], value - level
            table[i, free + i] = second[0][0]
            for j in range(free):
                table[i, j] = second[0][1 + j]
                table[count + i, j] = first[1 + j]
                table[2 * count + j, free + i] = shares[i] * second[0][1 + j]
                table[2 * count + j, free + count + i] = first[1 + j]
                right[2 * count + j] += shares[i] * first[1 + j]
                for n in range(free):
                    table[2 * count + j, n] += shares[i] * second[1 + j][1 + n]
            table[count + i, free + i] = first[0]
            table[count + i, size - 1] = -1
            table[size - 1, free + count + i] = 1
        right[size - 1] = sum(shares) - 1
        try:
            moved = mp.lu_solve(table, right)
        except ZeroDivisionError as error:
            raise ArithmeticError("no isolated optimum") from error
        logs = [a - moved[j] for j, a in enumerate(logs)]
        places = [y - moved[free + i] for i, y in enumerate(places)]
        shares = [w - moved[free + count + i] for i, w in enumerate(shares)]
        level -= moved[size - 1]
        change = max(abs(moved[j]) for j in range(free + count))
        if change > 1:
            break
        if change < mpf(10) ** (-0.4 * mp.dps):
            return Held([mp.exp(a) for a in logs], places, shares, mp.exp(level / 2))
    raise ArithmeticError("Newton's method on the conditions of the optimum did not settle")


def optimum(
    pair: tuple[str, str], z1: float, m: float, near: Sequence[float],
    frequency: Sequence[float], weight: Sequence[float], floor: Any = 0,
) -> tuple[Any, Any, Any]:  # fmt: skip
    """k, z2 and the level above the floor of one absorber, two peaks against each other."""
    bare = tree(z1, [m], [1.0], [1.0])
    held = polished(lambda r: bare._replace(k=(r[0],), z2=(r[1],)), pair, near, frequency, weight)
    assert min(held.weights) > 0
    return held.ratios[0], held.ratios[1], held.level - floor


def _taylor(
    f: Callable[[Any, list[Any]], Any], y: Any, at: list[Any], h: Any
) -> tuple[Any, list[Any], list[list[Any]]]:
    """Value, first and second derivatives by (y, *at), from differences."""
    point = [y, *at]
    size = len(point)

    def value(*moves: tuple[int, int]) -> Any:
        moved = list(point)
        for place, sign in moves:
            moved[place] = moved[place] + sign * h
        return f(moved[0], moved[1:])

    middle = value()
    up, down = ([value((i, s)) for i in range(size)] for s in (1, -1))
    first = [(up[i] - down[i]) / (2 * h) for i in range(size)]
    second = [[mpf(0)] * size for _ in range(size)]
    for i in range(size):
        second[i][i] = (up[i] - 2 * middle + down[i]) / h**2
        for j in range(i):
            both = value((i, 1), (j, 1)) + value((i, -1), (j, -1))
            mixed = (both - up[i] - up[j] - down[i] - down[j] + 2 * middle) / (2 * h**2)
            second[i][j] = second[j][i] = mixed
    return middle, first, second
