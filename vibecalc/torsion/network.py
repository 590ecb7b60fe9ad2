"""A shaft line as a network that is eliminated freedom by freedom, closed loops of shafts too."""

import heapq
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import NamedTuple, TypeAlias

import numpy as np

from vibecalc.numerics.rounding import ComplexArray, IntArray
from vibecalc.torsion.line import Line

#: of each step the reciprocal of its sum, and the share of the sum that each neighbour has
Factors: TypeAlias = list[tuple[ComplexArray, list[ComplexArray]]]


class Step(NamedTuple):
    """A freedom to eliminate, its neighbours with their edges, the edges between these after it."""

    freedom: int
    around: list[tuple[int, int]]
    fill: list[tuple[int, int, int]]


@dataclass(frozen=True)
class Network:
    """n freedoms, the edge of each element (e,), -1 for none, and the steps of elimination.

    Star to mesh: a freedom with edges k_a to its neighbours and g to ground leaves k_a g / s to
    ground at each of them and k_a k_b / s between them, s the sum of all. A tree never fills, a
    loop fills by the edge that closes it; what a soft branch adds is no difference of large values.
    """

    n: int
    edge: IntArray
    edges: int
    steps: list[Step]

    def factorised(self, ground: Sequence[ComplexArray], element: ComplexArray) -> Factors:
        """From values (...) to ground of each freedom and of each element."""
        g = list(ground)
        k: list[ComplexArray] = [np.zeros((), dtype=np.complex128)] * self.edges
        for place, value in zip(self.edge.tolist(), element, strict=True):
            if place >= 0:
                k[place] = k[place] + value
        factors: Factors = []
        for i, around, fill in self.steps:
            inverse = 1.0 / sum((k[e] for _, e in around), start=g[i])
            share = [k[e] * inverse for _, e in around]
            for (j, _), part in zip(around, share, strict=True):
                g[j] = g[j] + part * g[i]
            for p, q, e in fill:
                k[e] = k[e] + share[p] * k[around[q][1]]
            factors.append((inverse, share))
        return factors

    def solved(self, factors: Factors, load: ComplexArray) -> ComplexArray:
        """Angles (n, ...) under torques (n, ...)."""
        t: list[ComplexArray] = list(load)
        for (i, around, _), (_, share) in zip(self.steps, factors, strict=True):
            for (j, _), part in zip(around, share, strict=True):
                t[j] = t[j] + part * t[i]
        angle = np.empty_like(load)
        for (i, around, _), (inverse, share) in zip(
            reversed(self.steps), reversed(factors), strict=True
        ):
            angle[i] = t[i] * inverse
            for (j, _), part in zip(around, share, strict=True):
                angle[i] += part * angle[j]
        return angle


def network_of(line: Line) -> Network:
    """The network of a line, whatever its values."""
    return _network(line.inertia.shape[-1], tuple(line.first.tolist()), tuple(line.second.tolist()))


@lru_cache(maxsize=16)
def _network(n: int, first: tuple[int, ...], second: tuple[int, ...]) -> Network:
    """Those with the fewest neighbours are eliminated first."""
    beside: list[dict[int, int]] = [{} for _ in range(n)]
    names: dict[tuple[int, int], int] = {}

    def edge(a: int, b: int) -> int:
        number = names.setdefault((min(a, b), max(a, b)), len(names))
        beside[a][b] = beside[b][a] = number
        return number

    edges = [edge(a, b) if a != b else -1 for a, b in zip(first, second, strict=True)]
    waiting = [(len(others), i) for i, others in enumerate(beside)]
    heapq.heapify(waiting)
    left, steps = set(range(n)), list[Step]()
    while waiting:
        count, i = heapq.heappop(waiting)
        if i not in left or count != len(beside[i]):
            continue
        left.remove(i)
        around = list(beside[i].items())
        for j, _ in around:
            del beside[j][i]
        pairs = combinations(range(len(around)), 2)
        fill = [(p, q, edge(around[p][0], around[q][0])) for p, q in pairs]
        steps.append(Step(i, around, fill))
        for j, _ in around:
            heapq.heappush(waiting, (len(beside[j]), j))
    return Network(n, np.array(edges, dtype=np.int64), len(names), steps)
